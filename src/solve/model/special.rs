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

/// Which nodes carry multipliers.
pub struct Carriers<'a> {
    /// The mesh of the rank.
    pub mesh: &'a LocalMesh,
    /// Its special nodes.
    pub special: &'a [SpecialNode],
    /// The prescribed displacements.
    pub prescribed: &'a Prescribed,
}

impl Carriers<'_> {
    /// Which components of a node of the mesh, by its name, carry none. Local.
    pub fn fixed(&self, name: u64) -> [bool; 3] {
        let node = self.node(name);
        if self.is_left_out(node) { [true; 3] } else { self.prescribed(node) }
    }

    /// Whether a node carries none for another reason than that its displacement is prescribed.
    pub fn is_lost(&self, name: u64) -> bool {
        let node = self.node(name);
        let is_held = self.prescribed(node)[..self.mesh.dim()].iter().all(|fixed| *fixed);
        self.mesh.is_of_file() && self.is_left_out(node) && !is_held
    }

    fn node(&self, name: u64) -> u32 {
        self.mesh.nodes.number(name).expect("a node of the rank's own cell") as u32
    }

    fn is_left_out(&self, node: u32) -> bool {
        let at_odds = special_at(self.special, node).is_some_and(|special| special.is_at_odds);
        at_odds || self.mesh.nodes.marks[node as usize].is_junction
    }

    fn prescribed(&self, node: u32) -> [bool; 3] {
        match special_at(self.special, node) {
            Some(special) => special.fixed,
            None => self.prescribed.components_of(&self.mesh.nodes.marks[node as usize]),
        }
    }
}
