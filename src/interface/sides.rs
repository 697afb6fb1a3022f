//! Which side of an interface carries the multipliers.

use crate::case::{Case, Side};
use crate::mesh::{CellPlace, Column, Facets};

/// The two sides of one interface.
#[derive(Debug, Clone, Copy)]
pub struct Sides {
    /// The side that carries the multipliers.
    pub secondary: Facets,
    /// The other side.
    pub primary: Facets,
}

impl Sides {
    /// The sides of every interface: the secondary one as the case says, else the softer side,
    /// else the one with more nodes, else the upper one.
    ///
    /// A stiff and coarse secondary side makes the condensed matrix harder for multigrid.
    pub fn choose(case: &Case, column: &Column) -> Vec<Self> {
        let choose = |(index, interface): (usize, &crate::case::InterfaceSpec)| {
            let lower = Facets { body: index, upper: true };
            let upper = Facets { body: index + 1, upper: false };
            let about = |face: Facets| {
                let (size, material) = column.cell_size(column.facet_cell(face, [0, 0]));
                let order = column.order(face.body) as f64;
                let nodal = size[0] * size[1] / order.powi(column.dim as i32 - 1);
                (case.materials[material].young_modulus, nodal)
            };
            let (below, above) = (about(lower), about(upper));
            let lower_is_softer_or_finer =
                below.0 < above.0 || (below.0 == above.0 && below.1 < above.1 * (1.0 - 1e-9));
            match interface.secondary {
                Some(Side::Lower) => Self { secondary: lower, primary: upper },
                None if lower_is_softer_or_finer => Self { secondary: lower, primary: upper },
                _ => Self { secondary: upper, primary: lower },
            }
        };
        case.interfaces.iter().enumerate().map(choose).collect()
    }

    /// Sign of the secondary displacement in the jump (upper minus lower).
    pub fn sign(&self) -> f64 {
        if self.secondary.upper { -1.0 } else { 1.0 }
    }

    /// Whether a node lies on the secondary side.
    pub fn is_secondary(&self, column: &Column, node: u64) -> bool {
        column.is_on(self.secondary, node)
    }

    /// Whether a cell has a facet on the secondary side.
    pub fn cell_is_secondary(&self, column: &Column, place: CellPlace) -> bool {
        column.facet_cell(self.secondary, [place.at[0], place.at[1]]) == place
    }

    /// The cells of the primary side that face a cell of the secondary side.
    pub fn facing_cells(&self, column: &Column, place: CellPlace) -> Vec<u64> {
        let nodes = column.facet_nodes(self.secondary, [place.at[0], place.at[1]]);
        let corners = nodes.iter().map(|n| column.point(*n));
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in corners {
            for axis in 0..2 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        let facing = column.facets_over(self.primary, low, high).into_iter();
        facing.map(|at| column.cell(column.facet_cell(self.primary, at))).collect()
    }
}
