//! Families: a node or an element has one, which names any number of groups.

use std::collections::{BTreeMap, BTreeSet};

use super::archive::{Folder, Told};

/// Families by number, with the names of the groups of each.
pub type Families = BTreeMap<i64, Vec<String>>;

/// Reads the families of the elements and of the nodes of a mesh.
pub fn read(top: &Folder, mesh: &str, remarks: &mut Vec<String>) -> Told<[Families; 2]> {
    let folder = match top.find_folder("FAS")? {
        Some(all) => all.find_folder(mesh)?,
        None => None,
    };
    let Some(folder) = folder else { return Ok([Families::new(), Families::new()]) };
    let mut of = |name: &str, sign: i64| match folder.find_folder(name)? {
        Some(all) => families(&all, sign, remarks),
        None => Ok(Families::new()),
    };
    Ok([of("ELEME", -1)?, of("NOEUD", 1)?])
}

/// The families of elements, whose numbers are negative, or of nodes, whose are positive.
fn families(all: &Folder, sign: i64, remarks: &mut Vec<String>) -> Told<Families> {
    let mut found = Families::new();
    for name in all.members()? {
        let family = all.folder(&name)?;
        let number = family.attribute("NUM")?;
        if number.signum() != sign {
            let (what, sign) =
                if sign < 0 { ("elements", "negative") } else { ("nodes", "positive") };
            return Err(format!(
                "{}: its number is {number}; families of {what} have {sign} numbers",
                family.path()
            ));
        }
        let groups = match family.find_folder("GRO")? {
            Some(groups) => names(&groups, remarks)?,
            None => Vec::new(),
        };
        if found.insert(number, groups).is_some() {
            return Err(format!("{}: another family has the number {number} too", family.path()));
        }
    }
    Ok(found)
}

/// The names of the groups of a family.
fn names(groups: &Folder, remarks: &mut Vec<String>) -> Told<Vec<String>> {
    let count = groups.attribute("NBR")?;
    if count == 0 && !groups.has("NOM") {
        return Ok(Vec::new());
    }
    let path = groups.inner("NOM");
    let file = groups.names("NOM")?;
    if i64::try_from(file.len()).ok() != Some(count) {
        return Err(format!("{path}: {} names where NBR says {count}", file.len()));
    }
    let mut found = BTreeSet::new();
    for bytes in &file {
        let name = text(bytes);
        if name.is_empty() {
            remarks.push(format!("{path}: a group without a name is left out"));
            continue;
        }
        if !bytes.contains(&0) && bytes[79] != b' ' {
            let said = format!(
                "the name of the group {name} has all the 80 characters that the format holds: \
                 it may have been cut off, and groups that differ after it joined"
            );
            if !remarks.contains(&said) {
                remarks.push(said);
            }
        }
        if let Some(name) = found.replace(name) {
            return Err(format!(
                "{path}: it has the group {name} twice; if two names were cut off to the 80 \
                 characters that the format holds, give shorter ones"
            ));
        }
    }
    Ok(found.into_iter().collect())
}

/// A name that is padded by blanks, or by anything after a zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let bytes = bytes[..end].trim_ascii_end();
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        // What older programs write is Latin-1, whose numbers are those of Unicode.
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::text;

    #[test]
    fn names_end_at_blanks_or_at_a_zero() {
        assert_eq!(text(b"left side   "), "left side");
        assert_eq!(text(b"left\0\0ghost"), "left");
        assert_eq!(text(b"left  \0\0"), "left");
        assert_eq!(text("côté  ".as_bytes()), "côté");
        assert_eq!(text(b"c\xf4t\xe9 "), "côté");
        assert_eq!(text(&[b' '; 80]), "");
    }
}
