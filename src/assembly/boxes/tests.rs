//! The products with boxes against the sum over the cells.

use super::*;
use crate::bulk::{Elastic, SplitForm, Stiffness};
use crate::element::Shape;

/// A number between -0.5 and 0.5 that looks random.
fn random(i: usize) -> f64 {
    (12.9898 * i as f64).sin() * 43758.5453 % 0.5
}

/// Layers of cells above one another.
struct Grid {
    across: [usize; 2],
    /// The stiffness of each layer.
    layers: Vec<u32>,
    stiffness: Vec<Stiffness>,
}

impl Grid {
    fn new(across: [usize; 2], layers: &[u32], b_bar: bool) -> Self {
        let of = |(height, young, nu)| {
            let elastic = Elastic::new(young, nu);
            Stiffness::new(Shape::Hex8, [0.3, 0.7, height], elastic, &[0, 1, 2], b_bar)
        };
        let stiffness = [(0.4, 1.0, 0.3), (0.9, 3.0, 0.0), (0.1, 0.2, 0.49)].map(of).to_vec();
        Self { across, layers: layers.to_vec(), stiffness }
    }

    fn modal(&self, prototype: u32) -> &Modal {
        match &self.stiffness[prototype as usize].form {
            SplitForm::First(modal) => modal,
            SplitForm::Second(_) => panic!("of second order"),
        }
    }

    /// Nodes and prototype of every cell that is `kept`, the nodes by their `number`.
    fn cells(
        &self,
        kept: impl Fn([usize; 3]) -> bool,
        number: impl Fn([usize; 3]) -> u32,
    ) -> Vec<(Vec<u32>, u32)> {
        let [nx, ny] = self.across;
        let places = (0..self.layers.len())
            .flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        let corners = Shape::Hex8.node_points();
        let nodes = |at: [usize; 3]| {
            let corner = |xi: &[f64; 3]| {
                number(std::array::from_fn(|axis| at[axis] + usize::from(xi[axis] > 0.0)))
            };
            corners.iter().map(corner).collect()
        };
        places.filter(|at| kept(*at)).map(|at| (nodes(at), self.layers[at[2]])).collect()
    }

    fn nodes(&self) -> usize {
        (self.across[0] + 1) * (self.across[1] + 1) * (self.layers.len() + 1)
    }

    fn name(&self, [i, j, k]: [usize; 3]) -> usize {
        i + (self.across[0] + 1) * (j + (self.across[1] + 1) * k)
    }

    /// Forces of the cells, one by one.
    fn sum(&self, cells: &[(Vec<u32>, u32)], u: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; u.len()];
        for (nodes, prototype) in cells {
            let places =
                || nodes.iter().flat_map(|node| (0..3).map(move |c| *node as usize * 3 + c));
            let own: Vec<f64> = places().map(|place| u[place]).collect();
            let mut force = vec![0.0; own.len()];
            self.stiffness[*prototype as usize].force(&own, &mut force);
            places().zip(force).for_each(|(place, f)| sum[place] += f);
        }
        sum
    }

    /// Holds boxes and the cells beside them against the sum over all cells; the cells in boxes.
    fn check(&self, cells: &[(Vec<u32>, u32)], owned: usize) -> usize {
        let all = cells.iter().map(|(nodes, prototype)| (nodes.as_slice(), *prototype));
        let (boxes, is_in_box) = Boxes::new(all, |prototype| self.modal(prototype));
        let u: Vec<f64> = (0..3 * self.nodes()).map(random).collect();
        let exact = self.sum(cells, &u);
        let rest: Vec<(Vec<u32>, u32)> = cells
            .iter()
            .zip(&is_in_box)
            .filter(|(_, is_in)| !**is_in)
            .map(|(c, _)| c.clone())
            .collect();
        let mut found = self.sum(&rest, &u);
        let mut single: Vec<f32> = found.iter().map(|f| *f as f32).collect();
        let (first, others) = found.split_at_mut(3 * owned);
        boxes.add_forces(&u, [first, others]);
        let u: Vec<f32> = u.iter().map(|u| *u as f32).collect();
        boxes.to_single().add_forces(&u, [&mut single, &mut []]);
        let largest = exact.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        for ((exact, found), single) in exact.iter().zip(&found).zip(single) {
            assert!((exact - found).abs() < 1e-14 * largest, "{exact} {found}");
            assert!((exact - f64::from(single)).abs() < 1e-6 * largest, "{exact} {single}");
        }
        is_in_box.iter().filter(|is_in_box| **is_in_box).count()
    }
}

#[test]
fn boxes_of_any_size_give_the_sum_over_their_cells() {
    let sizes: [([usize; 2], &[u32]); 6] = [
        ([27, 1], &[2]),
        ([5, 3], &[0, 1, 1, 2]),
        ([13, 1], &[2, 2, 2, 2, 0]),
        ([8, 9], &[1, 0, 2]),
        ([3, 4], &[0, 0, 0]),
        ([17, 2], &[1]),
    ];
    for ((across, layers), b_bar) in sizes.into_iter().flat_map(|s| [(s, false), (s, true)]) {
        let grid = Grid::new(across, layers, b_bar);
        let cells = grid.cells(|_| true, |at| grid.name(at) as u32);
        for owned in [grid.nodes(), grid.nodes() / 2, 0] {
            assert_eq!(grid.check(&cells, owned), cells.len(), "{across:?} {layers:?}");
        }
    }
}

/// Parts of a grid with holes, with nodes of other ranks behind the others.
#[test]
fn what_is_no_box_is_left_over() {
    let grid = Grid::new([12, 10], &[0, 0, 1, 1, 2, 2, 0], true);
    let parts: [fn([usize; 3]) -> bool; 4] = [
        |[i, j, k]| !(i == 5 && j == 5 && k == 3),
        |[i, j, _]| i / 4 + j / 5 != 1,
        |[i, j, k]| i + j + k > 9,
        |[i, j, k]| random(i + 100 * (j + 100 * k)) < 0.3,
    ];
    let mut in_boxes = Vec::new();
    for kept in parts {
        // Nodes of even planes are ghosts.
        let mut order: Vec<usize> = (0..grid.nodes()).collect();
        order.sort_by_key(|node| ((node / 13 % 11) % 3 == 0, *node));
        let mut numbers = vec![0; order.len()];
        (0..).zip(order).for_each(|(number, node)| numbers[node] = number);
        let cells = grid.cells(kept, |at| numbers[grid.name(at)]);
        in_boxes.push(grid.check(&cells, grid.nodes() / 2) as f64 / cells.len() as f64);
    }
    assert!(in_boxes[0] > 0.8 && in_boxes[1] == 1.0, "{in_boxes:?}");
    assert!(in_boxes[2] > 0.1 && in_boxes[2] < 1.0 && in_boxes[3] < 0.5, "{in_boxes:?}");
}

/// Nodes in no order along x.
#[test]
fn boxes_without_lines_of_nodes_are_left_to_the_sweep() {
    let grid = Grid::new([6, 6], &[0; 6], false);
    let cells = grid.cells(|_| true, |at| (grid.name(at) * 5 % grid.nodes()) as u32);
    assert_eq!(grid.check(&cells, grid.nodes()), 0);
}
