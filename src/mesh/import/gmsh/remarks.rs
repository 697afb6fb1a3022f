//! What is to be said of a file, in words.

use super::format::Version;
use crate::mesh::import::Group;

/// What is to be said of groups without elements.
pub(super) fn without_elements(
    groups: &[Group],
    is_used: &[bool],
    version: Version,
) -> Option<String> {
    if is_used.is_empty() || !is_used.contains(&false) {
        return None;
    }
    if version == Version::V2 && !is_used.contains(&true) {
        let words = "the file names groups, but no element belongs to one, as in MSH 2.2 with \
                     Mesh.SaveAll = 1; write it with Mesh.SaveAll = 0, or in version 4.1";
        return Some(words.to_owned());
    }
    let unused = groups.iter().zip(is_used).filter(|(_, is_used)| !**is_used);
    let names: Vec<_> =
        unused.map(|(group, _)| format!("{} (dimension {})", group.name, group.dim)).collect();
    Some(format!("groups without elements: {}", names.join(", ")))
}

/// What is to be said of so many nodes of no element.
pub(super) fn orphans_of_elements(orphans: usize) -> Option<String> {
    (orphans > 0).then(|| format!("nodes of no element, left out: {orphans}"))
}
