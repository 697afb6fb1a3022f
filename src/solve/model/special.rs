//! The nodes of a rank's mesh with unknowns of their own kind.

use crate::case::Case;
use crate::interface::Sides;
use crate::mesh::{Lip, LocalMesh};
use crate::space::{Prescribed, SpecialNode, special_nodes};

/// Those of the rank, by rising number in its mesh. Local.
pub fn special_of(
    case: &Case,
    mesh: &LocalMesh,
    sides: &[Sides],
    prescribed: &Prescribed,
) -> Vec<SpecialNode> {
    debug_assert_eq!(case.interfaces.len(), sides.len());
    let secondary: Vec<Lip> = sides.iter().map(|side| side.secondary).collect();
    special_nodes(mesh, &secondary, prescribed)
}

/// The one at a node of the mesh.
pub fn special_at(special: &[SpecialNode], node: u32) -> Option<&SpecialNode> {
    let place = special.binary_search_by_key(&node, |special| special.node).ok()?;
    Some(&special[place])
}
