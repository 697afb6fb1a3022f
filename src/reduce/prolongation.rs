//! From the nodes of a smaller model to those of the one asked for.

use crate::element::Shape;
use crate::mesh::{CellPlace, Column, Marks, NodePlace, axes};

/// Weights of the nodes of one plane or line of the smaller model.
type Stencil = Vec<(usize, f64)>;

/// The interpolation of nodal values of a smaller model in the nodes of the one asked for, body by
/// body and axis by axis.
pub struct Prolongation {
    narrow: Column,
    wide: Column,
    /// By body and axis, for each plane of nodes of the wide column.
    stencils: Vec<[Vec<Stencil>; 3]>,
    /// By body and axis, the cell of the smaller model that each cell lies in.
    cells: Vec<[Vec<usize>; 3]>,
}

impl Prolongation {
    /// Between two lattices of one column. Local.
    pub fn new(narrow: &Column, wide: &Column) -> Self {
        let along = |body: usize, axis: usize| -> Vec<Stencil> {
            if !axes(wide.dim).contains(&axis) {
                return vec![vec![(0, 1.0)]];
            }
            let planes = 0..wide.node_extent(body)[axis];
            planes.map(|p| stencil(narrow, body, axis, wide.node_plane(body, axis, p))).collect()
        };
        let stencils =
            (0..wide.bodies()).map(|body| [0, 1, 2].map(|axis| along(body, axis))).collect();
        let inside = |body: usize, axis: usize| -> Vec<usize> {
            let middle = |k| 0.5 * (wide.plane(body, axis, k) + wide.plane(body, axis, k + 1));
            let last = narrow.extent(body)[axis] - 1;
            let upper = |k: usize| narrow.plane(body, axis, k + 1);
            let find = |k| (0..last).find(|c| middle(k) < upper(*c)).unwrap_or(last);
            (0..wide.extent(body)[axis]).map(find).collect()
        };
        let cells =
            (0..wide.bodies()).map(|body| [0, 1, 2].map(|axis| inside(body, axis))).collect();
        Self { narrow: narrow.clone(), wide: wide.clone(), stencils, cells }
    }

    /// The nodes of the smaller model, with their weights, that a node is interpolated from.
    pub fn parents(&self, name: u64, mut see: impl FnMut(usize, f64)) {
        let NodePlace { body, at } = self.wide.node_place(name);
        let [x, y, z] = &self.stencils[body];
        for (k, along_z) in &z[at[2]] {
            for (j, along_y) in &y[at[1]] {
                for (i, along_x) in &x[at[0]] {
                    let parent = self.narrow.node(NodePlace { body, at: [*i, *j, *k] });
                    see(parent as usize, along_x * along_y * along_z);
                }
            }
        }
    }

    /// Values of the nodes of the given names, `dim` numbers each.
    pub fn apply(&self, names: &[u64], values: &[[f64; 3]]) -> Vec<f64> {
        let dim = self.wide.dim;
        let mut out = Vec::with_capacity(names.len() * dim);
        for name in names {
            let mut sum = [0.0; 3];
            self.parents(*name, |parent, weight| {
                (0..3).for_each(|c| sum[c] += weight * values[parent][c]);
            });
            out.extend_from_slice(&sum[..dim]);
        }
        out
    }

    /// The cell of the smaller model that a cell lies in.
    pub fn parent_cell(&self, place: CellPlace) -> u64 {
        let [x, y, z] = &self.cells[place.body];
        let at = [x[place.at[0]], y[place.at[1]], z[place.at[2]]];
        self.narrow.cell(CellPlace { body: place.body, at })
    }

    /// The lattice of the model asked for.
    pub fn wide(&self) -> &Column {
        &self.wide
    }

    /// The lattice of the smaller model.
    pub fn narrow(&self) -> &Column {
        &self.narrow
    }

    /// The body of a node of the smaller model.
    pub fn body_of(&self, parent: usize) -> usize {
        self.narrow.node_place(parent as u64).body
    }

    /// Where a node of the smaller model lies.
    pub fn marks_of(&self, parent: usize) -> Marks {
        self.narrow.marks(parent as u64)
    }
}

/// The nodes along an axis of a body that a point is interpolated from.
fn stencil(column: &Column, body: usize, axis: usize, point: f64) -> Stencil {
    let (cells, order) = (column.extent(body)[axis], column.order(body));
    let tolerance = 1e-12 * column.size[axis];
    let upper = |k: usize| column.plane(body, axis, k + 1);
    let k = (0..cells - 1).find(|k| point <= upper(*k) + tolerance).unwrap_or(cells - 1);
    let (low, high) = (column.plane(body, axis, k), upper(k));
    let at = 2.0 * (point - low) / (high - low) - 1.0;
    // At a node its own value, to the last bit.
    let node = (0..=order).find(|n| (at + 1.0 - 2.0 * *n as f64 / order as f64).abs() < 1e-12);
    if let Some(node) = node {
        return vec![(order * k + node, 1.0)];
    }
    let shape = Shape::of(1, order);
    let mut values = [0.0; crate::element::MAX_NODES];
    shape.values([at, 0.0, 0.0], &mut values);
    let places = shape.node_points().iter().map(|p| ((p[0] + 1.0) as usize * order) / 2);
    places.zip(values).map(|(place, value)| (order * k + place, value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Case;
    use std::path::Path;

    fn column(order: usize) -> Column {
        let yaml = format!(
            "title: t\nmesh: {{order: {order}, column: {{size: [2, 3, 5], cells: [3, 2, 4]}}}}\n\
             materials: {{rock: {{elastic: {{young_modulus: 1.0, poisson_ratio: 0.0}}}}}}\n\
             interfaces: [{{name: joint, z: 2, law: {{tied: {{}}}}}}]\n\
             boundary: [{{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}]\n\
             time: {{instants: [1]}}\n"
        );
        Column::new(&Case::read(&yaml, Path::new("t.yaml"), &[]).expect("a case"))
            .expect("a column")
    }

    #[test]
    fn polynomials_of_the_cells_are_kept() {
        for (order, power, keep) in [
            (1, 1, [false; 3]),
            (1, 1, [false, false, true]),
            (2, 1, [false; 3]),
            (2, 2, [false, true, true]),
        ] {
            let wide = column(order);
            let narrow = wide.narrowed(keep);
            let prolongation = Prolongation::new(&narrow, &wide);
            let field = |body: usize, p: [f64; 3]| {
                let [x, y, z] = p.map(|x| x.powi(power));
                [x - p[2] + body as f64, y * p[0], 2.0 + z * p[1]]
            };
            let at = |c: &Column, n: u64| field(c.node_place(n).body, c.point(n));
            let values: Vec<[f64; 3]> = (0..narrow.nodes()).map(|n| at(&narrow, n)).collect();
            let names: Vec<u64> = (0..wide.nodes()).collect();
            let out = prolongation.apply(&names, &values);
            for (name, u) in names.iter().zip(out.chunks_exact(3)) {
                let exact = at(&wide, *name);
                (0..3).for_each(|c| assert!((u[c] - exact[c]).abs() < 1e-12, "{u:?} {exact:?}"));
            }
        }
    }
}
