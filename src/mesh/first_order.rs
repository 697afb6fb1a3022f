//! The mesh of a file with cells of first order in the place of those of second order, as the level
//! of multigrid below it.

use super::{Interpolation, LocalMesh};
use crate::element::MAX_NODES;

/// Values of the basis below this are rounding.
const ROUNDING: f64 = 1e-14;

impl LocalMesh {
    /// The same cells with straight edges, and their corners as only nodes. The names stay. Local.
    pub fn of_first_order(&self) -> Self {
        let mut mesh = self.corners();
        mesh.prototypes.iter_mut().for_each(|like| like.shape = like.shape.corners());
        mesh.facts.order = 1;
        for lip in mesh.facts.interfaces.iter_mut().flatten() {
            (lip.order, lip.has_shares) = (1, false);
        }
        let of_names = |number: u32| self.nodes.names[number as usize];
        mesh.directions = self.directions.renumbered(|number| mesh.nodes.number(of_names(number)));
        mesh.directions.middles.clear();
        mesh
    }

    /// How nodes of these cells depend on their corners; nodes of other cells depend on none.
    pub(super) fn by_corners(&self, names: &[u64]) -> Interpolation {
        let mut rows: Vec<Vec<(u64, f64)>> = vec![Vec::new(); self.nodes.names.len()];
        for cell in 0..self.cells.len() {
            let (shape, nodes) = (self.shape(cell), self.cell_nodes(cell));
            let corners = shape.corners();
            for (node, xi) in nodes.iter().zip(shape.node_points()) {
                let row = &mut rows[*node as usize];
                if row.is_empty() {
                    let mut values = [0.0; MAX_NODES];
                    corners.values(*xi, &mut values);
                    let all = nodes[..corners.nodes()].iter().zip(values);
                    let all = all.filter(|(_, value)| value.abs() > ROUNDING);
                    row.extend(all.map(|(node, v)| (self.nodes.names[*node as usize], v)));
                }
            }
        }
        Interpolation::from_rows(&rows).of(names.iter().map(|name| self.nodes.number(*name)))
    }
}
