//! Nested coarser lattices, for multigrid and for the partition.

use super::column::{Body, Column};
use super::{CellPlace, NodePlace};
use crate::mesh::axes;

/// Axes whose cells are longer than this many times the shortest edge are not coarsened: a
/// point-wise smoother does nothing along them until the others have caught up.
const LONG_EDGE: f64 = 1.5;

impl Column {
    /// The lattices from this one to the coarsest that still has `fewest` cells, coarsest first.
    pub fn hierarchy(&self, fewest: u64) -> Vec<Self> {
        let mut columns = vec![self.clone()];
        loop {
            let coarse = columns[columns.len() - 1].coarsened();
            let finer = &columns[columns.len() - 1];
            let same = coarse.nodes() >= finer.nodes();
            if same || coarse.cells() < fewest && coarse.cells() < finer.cells() {
                columns.reverse();
                return columns;
            }
            columns.push(coarse);
        }
    }

    /// The same lattice with cells of first order, whose nodes are the corners.
    pub fn of_first_order(&self) -> Self {
        let mut column = self.clone();
        column.bodies.iter_mut().for_each(|body| body.order = 1);
        column.number();
        column
    }

    /// The lattice with one cell in the place of all along the axes that are not kept, along z one
    /// for each layer of one material; of first order where no axis is kept.
    pub fn narrowed(&self, keep: [bool; 3]) -> Self {
        let mut column = self.clone();
        for body in &mut column.bodies {
            if keep == [false; 3] {
                body.order = 1;
            }
            for axis in (0..3).filter(|axis| !keep[*axis]) {
                let last = body.planes[axis].len() - 1;
                let ends = [body.planes[axis][0], body.planes[axis][last]];
                body.planes[axis] = ends.to_vec();
                if axis == 2 {
                    let changes = (1..body.layers.len())
                        .filter(|k| body.layers[*k - 1].material != body.layers[*k].material)
                        .map(|k| (k as u32) << column.refinements);
                    body.planes[2].splice(1..1, changes);
                }
            }
        }
        column.number();
        column
    }

    /// The lattice with cells of first order where some are of second; else with about twice the
    /// edges, body by body, along the axes where they are short.
    fn coarsened(&self) -> Self {
        if (0..self.bodies()).any(|b| self.order(b) > 1) {
            return self.of_first_order();
        }
        let mut column = self.clone();
        for index in 0..self.bodies() {
            let n = self.extent(index);
            let edge = |axis: usize| {
                (self.plane(index, axis, n[axis]) - self.plane(index, axis, 0)) / n[axis] as f64
            };
            let can: Vec<usize> = axes(self.dim).iter().copied().filter(|a| n[*a] > 1).collect();
            let shortest = can.iter().map(|a| edge(*a)).fold(f64::INFINITY, f64::min);
            for axis in can.into_iter().filter(|a| edge(*a) < LONG_EDGE * shortest) {
                let kept = self.kept_planes(index, axis);
                column.bodies[index].planes[axis] = kept;
            }
        }
        column.number();
        column
    }

    /// Every other plane of a body; changes of the material always stay.
    fn kept_planes(&self, index: usize, axis: usize) -> Vec<u32> {
        let body = &self.bodies[index];
        let planes = &body.planes[axis];
        let width = |k: usize| self.plane(index, axis, k + 1) - self.plane(index, axis, k);
        let material = |k: usize| if axis == 2 { self.material_of_layer(body, k) } else { 0 };
        let cells: Vec<(usize, usize)> = (0..planes.len() - 1).map(|k| (k, material(k))).collect();
        let mut kept = vec![planes[0]];
        for same in cells.chunk_by(|a, b| a.1 == b.1) {
            let widths: Vec<f64> = same.iter().map(|(k, _)| width(*k)).collect();
            let first = same[0].0;
            kept.extend(pairs(&widths).into_iter().map(|end| planes[first + end]));
        }
        kept
    }

    fn material_of_layer(&self, body: &Body, k: usize) -> usize {
        body.layers[body.planes[2][k] as usize >> self.refinements].material
    }

    /// The cells of the finer lattice `fine` that a cell of this lattice consists of.
    pub fn children(&self, place: CellPlace, fine: &Self) -> Vec<CellPlace> {
        let ranges: [_; 3] = std::array::from_fn(|axis| {
            let ends = &self.bodies[place.body].planes[axis][place.at[axis]..];
            let planes = &fine.bodies[place.body].planes[axis];
            let at = |end: u32| planes.partition_point(|plane| *plane < end);
            at(ends[0])..at(ends[1])
        });
        let [x, y, z] = ranges;
        let body = place.body;
        let row = |j, k| x.clone().map(move |i| CellPlace { body, at: [i, j, k] });
        z.flat_map(|k| y.clone().flat_map(move |j| row(j, k).collect::<Vec<_>>())).collect()
    }

    /// Where a node of the finer lattice `fine` lies in this one, whose cells are of first order:
    /// along each axis the plane of nodes at or below it, and how far it is from there to the next
    /// one (0 to below 1).
    pub fn place_in(&self, fine: &Self, node: NodePlace) -> ([usize; 3], [f64; 3]) {
        let (mut at, mut fraction) = ([0; 3], [0.0; 3]);
        for axis in axes(self.dim).iter().copied() {
            let order = fine.order(node.body);
            let plane = fine.bodies[node.body].planes[axis][node.at[axis] / order];
            let planes = &self.bodies[node.body].planes[axis];
            at[axis] = planes.partition_point(|p| *p <= plane) - 1;
            if planes[at[axis]] != plane || !node.at[axis].is_multiple_of(order) {
                let (low, high) = (at[axis], at[axis] + 1);
                let low = self.plane(node.body, axis, low);
                let x = fine.node_plane(node.body, axis, node.at[axis]);
                fraction[axis] = (x - low) / (self.plane(node.body, axis, high) - low);
            }
        }
        (at, fraction)
    }

    /// How many cells of the finest lattice a cell consists of.
    pub fn finest_cells(&self, place: CellPlace) -> u64 {
        let planes = &self.bodies[place.body].planes;
        let cells = |axis: usize| planes[axis][place.at[axis] + 1] - planes[axis][place.at[axis]];
        (0..3).map(|axis| u64::from(cells(axis))).product()
    }

    /// Lower and upper corner of a cell in the plane of the interfaces (m).
    pub fn footprint(&self, place: CellPlace) -> ([f64; 2], [f64; 2]) {
        let corner = |upper: usize| {
            let at = |axis: usize| self.plane(place.body, axis, place.at[axis] + upper);
            [at(0), if self.dim == 2 { 0.0 } else { at(1) }]
        };
        (corner(0), corner(1))
    }
}

/// Ends of the groups when neighbours of a line of cells are joined two by two; of an odd number
/// the widest that leaves pairs on both sides stays alone (near the middle, if several are).
fn pairs(widths: &[f64]) -> Vec<usize> {
    let n = widths.len();
    let mut alone = None;
    if n % 2 == 1 {
        let better = |a: usize, b: usize| {
            let from_middle = |k: usize| k.abs_diff(n / 2);
            let ratio = widths[a] / widths[b];
            ratio > 1.0 + 1e-9 || (ratio > 1.0 - 1e-9 && from_middle(a) < from_middle(b))
        };
        alone = (0..n).step_by(2).reduce(|a, b| if better(b, a) { b } else { a });
    }
    let (mut ends, mut end) = (Vec::new(), 0);
    while end < n {
        end += if alone == Some(end) { 1 } else { 2 };
        ends.push(end);
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Case;
    use std::path::Path;

    fn column(size: &str, cells: &str) -> Column {
        let yaml = format!(
            "title: t\nmesh: {{column: {{size: {size}, cells: {cells}}}}}\n\
             materials: {{rock: {{elastic: {{young_modulus: 1.0, poisson_ratio: 0.0}}}}}}\n\
             boundary:\n  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}\n\
             time: {{instants: [1.0]}}\noutput: {{directory: out}}\n"
        );
        let case = Case::read(&yaml, Path::new("t.yaml"), &[]).expect("a case");
        Column::new(&case).expect("a column")
    }

    fn extents(columns: &[Column]) -> Vec<[usize; 3]> {
        columns.iter().map(|c| c.extent(0)).collect()
    }

    #[test]
    fn one_cell_of_an_odd_number_stays_alone() {
        assert_eq!(pairs(&[1.0; 6]), [2, 4, 6]);
        assert_eq!(pairs(&[1.0; 5]), [2, 3, 5]);
        assert_eq!(pairs(&[1.0, 1.0, 1.0, 1.0, 2.0]), [2, 4, 5]);
        assert_eq!(pairs(&[1.0]), [1]);
    }

    #[test]
    fn long_edges_wait_for_the_short_ones() {
        let isotropic = column("[1, 1, 5]", "[8, 8, 40]").hierarchy(30);
        assert_eq!(extents(&isotropic), [[2, 2, 10], [4, 4, 20], [8, 8, 40]]);
        let slender = column("[1, 1, 5]", "[8, 8, 320]").hierarchy(1000);
        assert_eq!(extents(&slender), [[8, 8, 40], [8, 8, 80], [8, 8, 160], [8, 8, 320]]);
        let flat = column("[1, 1, 5]", "[16, 16, 20]").hierarchy(64);
        assert_eq!(extents(&flat), [[4, 4, 10], [4, 4, 20], [8, 8, 20], [16, 16, 20]][1..]);
        let odd = column("[1, 1, 5]", "[25, 25, 125]").hierarchy(100);
        assert_eq!(extents(&odd).last(), Some(&[25, 25, 125]));
        assert_eq!(extents(&odd)[0], [4, 4, 16]);
    }

    #[test]
    fn a_narrowed_lattice_keeps_what_it_is_told_and_the_materials() {
        let wide = column("[1, 1, 5]", "[4, 3, 10]");
        let extent = |keep| wide.narrowed(keep).extent(0);
        assert_eq!(extent([false; 3]), [1, 1, 1]);
        assert_eq!(extent([false, false, true]), [1, 1, 10]);
        assert_eq!(extent([true, false, true]), [4, 1, 10]);
        let yaml = "title: t\nmesh: {column: {size: [1, 4], cells: [2, 8]}, refine: 1, order: 2}\n\
             materials: {a: {z: [0, 1], elastic: {young_modulus: 1.0, poisson_ratio: 0.0}}, \
             b: {z: [1, 4], elastic: {young_modulus: 2.0, poisson_ratio: 0.0}}}\n\
             boundary:\n  - {on: bottom, displacement: {x: 0, z: 0}}\n\
             time: {instants: [1.0]}\noutput: {directory: out}\n";
        let case = Case::read(yaml, Path::new("t.yaml"), &[]).expect("a case");
        let narrow = Column::new(&case).expect("a column").narrowed([false; 3]);
        assert_eq!((narrow.extent(0), narrow.order(0)), ([1, 1, 2], 1));
        assert_eq!(narrow.plane(0, 2, 1), 1.0);
        let size = |k| narrow.cell_size(CellPlace { body: 0, at: [0, 0, k] });
        assert_eq!([size(0), size(1)], [([1.0, 1.0, 1.0], 0), ([1.0, 1.0, 3.0], 1)]);
    }

    /// Cells that grow along x and z.
    const GROWING: &str = ", grading: {x: {towards: [left], ratio: 6}, \
                           z: {towards: [bottom, top], ratio: 9}}";

    #[test]
    fn the_children_of_all_cells_are_all_cells() {
        let even = column("[1, 1, 5]", "[5, 7, 33]").hierarchy(10);
        let grown = column("[1, 1, 5]", &format!("[5, 7, 33]{GROWING}")).hierarchy(10);
        for pair in even.windows(2).chain(grown.windows(2)) {
            let (coarse, fine) = (&pair[0], &pair[1]);
            let mut cells: Vec<u64> = (0..coarse.cells())
                .flat_map(|c| coarse.children(coarse.cell_place(c), fine))
                .map(|place| fine.cell(place))
                .collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..fine.cells()).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_coarse_node_lies_on_itself_and_a_new_one_between() {
        for cells in ["[5, 4, 10]".to_owned(), format!("[5, 4, 10]{GROWING}")] {
            let columns = column("[1, 1, 5]", &cells).hierarchy(10);
            lies_between(&columns[columns.len() - 2], &columns[columns.len() - 1]);
        }
    }

    fn lies_between(coarse: &Column, fine: &Column) {
        for node in 0..fine.nodes() {
            let place = fine.node_place(node);
            let (at, fraction) = coarse.place_in(fine, place);
            let point = fine.point(node);
            for axis in 0..3 {
                let low = coarse.plane(0, axis, at[axis]);
                let x = if fraction[axis] == 0.0 {
                    low
                } else {
                    low + fraction[axis] * (coarse.plane(0, axis, at[axis] + 1) - low)
                };
                assert!((x - point[axis]).abs() < 1e-14);
            }
        }
    }
}
