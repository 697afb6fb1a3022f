//! Nodes whose unknowns are not their displacements along the axes.
//!
//! At a node with a frame they are the components along its rows: two tangents, then the normal (in
//! 2D one tangent). At a node in the middle of an edge they are besides what the displacement has
//! beyond its share of the two ends': on facets of second order with three edges only so the
//! multipliers get positive weights (docs/theory.md). Cells work with displacements; everything
//! else with unknowns.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::interface::{JumpRow, JumpRows};
use crate::space::{CARTESIAN, Rotation, SHARE_OF_END};

/// A node whose unknowns are not its displacements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framed {
    /// Local number.
    pub node: u32,
    /// Directions of the unknowns, by components of the displacement.
    pub rotation: Rotation,
    /// The ends of the edge in whose middle it lies, where they have a share in it.
    pub ends: Option<[u32; 2]>,
}

/// The framed nodes of a rank.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    dim: usize,
    /// Those without ends first.
    framed: Vec<Framed>,
    /// One more than the index into `framed` of each local node, 0 where there is none.
    of_node: Vec<u32>,
}

/// Coefficients below this part of the largest are rounding.
const ROUNDING: f64 = 1e-14;

impl Frames {
    /// Of `nodes` local nodes. Ends have no ends themselves.
    pub fn new(dim: usize, nodes: usize, mut framed: Vec<Framed>) -> Self {
        framed.sort_by_key(|one| (one.ends.is_some(), one.node));
        let mut of_node = vec![0; if framed.is_empty() { 0 } else { nodes }];
        for (index, one) in framed.iter().enumerate() {
            of_node[one.node as usize] = index as u32 + 1;
        }
        Self { dim, framed, of_node }
    }

    /// Whether all unknowns are displacements.
    pub fn is_empty(&self) -> bool {
        self.framed.is_empty()
    }

    /// What is special about a local node.
    pub fn at(&self, node: u32) -> Option<&Framed> {
        let index = self.of_node.get(node as usize)?.checked_sub(1)?;
        Some(&self.framed[index as usize])
    }

    /// Whether any of these local nodes is framed.
    pub fn touch(&self, nodes: &[u32]) -> bool {
        !self.is_empty() && nodes.iter().any(|node| self.at(*node).is_some())
    }

    /// The directions of the unknowns of a local node.
    pub fn rotation(&self, node: u32) -> Rotation {
        self.at(node).map_or(CARTESIAN, |framed| framed.rotation)
    }

    /// The displacements of all local nodes for their unknowns (m).
    pub fn displacements<'u>(&self, unknowns: &'u [f64]) -> Cow<'u, [f64]> {
        if self.is_empty() {
            return Cow::Borrowed(unknowns);
        }
        let mut u = unknowns.to_vec();
        for framed in &self.framed {
            self.displace(framed, framed.node as usize, framed.ends, &mut u);
        }
        Cow::Owned(u)
    }

    /// Makes forces on the displacements of all local nodes those on their unknowns (N).
    pub fn fold(&self, force: &mut [f64]) {
        for framed in self.framed.iter().rev() {
            self.gather(framed, framed.node as usize, framed.ends, force);
        }
    }

    /// The unknowns of a local node for a field of displacements, given at local nodes.
    pub fn unknowns(&self, node: u32, field: impl Fn(u32) -> [f64; 3]) -> [f64; 3] {
        let mut u = field(node);
        let Some(framed) = self.at(node) else { return u };
        if let Some(ends) = framed.ends {
            let [a, b] = ends.map(&field);
            for i in 0..self.dim {
                u[i] = (u[i] - SHARE_OF_END * (a[i] + b[i])) / (1.0 - 2.0 * SHARE_OF_END);
            }
        }
        self.turned(&framed.rotation, u)
    }

    /// The transpose of [`Frames::unknowns`]: gives the forces on displacements that a force on
    /// the unknowns of a local node makes, node by node.
    pub fn spread(&self, node: u32, force: [f64; 3], mut add: impl FnMut(u32, [f64; 3])) {
        let Some(framed) = self.at(node) else { return add(node, force) };
        let mut force = self.turned_back(&framed.rotation, force);
        if let Some(ends) = framed.ends {
            force = force.map(|f| f / (1.0 - 2.0 * SHARE_OF_END));
            ends.iter().for_each(|end| add(*end, force.map(|f| -SHARE_OF_END * f)));
        }
        add(node, force);
    }

    /// Components along the rows of a rotation of a vector given along the axes.
    pub fn turned(&self, rotation: &Rotation, v: [f64; 3]) -> [f64; 3] {
        let along = |c: usize| (0..self.dim).map(|i| rotation[c][i] * v[i]).sum();
        std::array::from_fn(|c| if c < self.dim { along(c) } else { 0.0 })
    }

    /// The reverse of [`Frames::turned`].
    pub fn turned_back(&self, rotation: &Rotation, v: [f64; 3]) -> [f64; 3] {
        let along = |i: usize| (0..self.dim).map(|c| rotation[c][i] * v[c]).sum();
        std::array::from_fn(|i| if i < self.dim { along(i) } else { 0.0 })
    }

    /// Makes the stiffness of a cell, between the displacements of its local `nodes`, one between
    /// their unknowns. The ends of an edge whose middle is a node of the cell are nodes of it too.
    pub fn fold_matrix(&self, nodes: &[u32], matrix: &mut [f64]) {
        let size = nodes.len() * self.dim;
        for _ in 0..2 {
            self.fold_rows(nodes, matrix);
            transpose(matrix, size);
        }
    }

    /// Makes forces on the displacements of the local `nodes` of a cell those on their unknowns:
    /// one set of them in each row of a matrix.
    pub fn fold_rows(&self, nodes: &[u32], matrix: &mut [f64]) {
        let place = |node: u32| nodes.iter().position(|n| *n == node);
        let places: Vec<_> = self.framed_of(nodes).collect();
        for row in matrix.chunks_exact_mut(nodes.len() * self.dim) {
            for (framed, own) in places.iter().rev() {
                let ends = framed
                    .ends
                    .map(|ends| ends.map(|end| place(end).expect("an edge of the cell") as u32));
                self.gather(framed, *own, ends, row);
            }
        }
    }

    /// Jump rows whose coefficients are those of displacements, the same for all components, as
    /// rows over unknowns: each along a direction of the frame of its node.
    pub fn rows(&self, rows: JumpRows<u32>) -> JumpRows<u32> {
        if self.is_empty() {
            return rows;
        }
        let rotation = self.rotation(rows.node);
        let over_unknowns = |(c, row): (usize, &Option<JumpRow<u32>>)| {
            let (row, mut sums) = (row.as_ref()?, BTreeMap::new());
            for (unknown, a) in row.coefficients(rows.own(c)) {
                let vector = rotation[c].map(|along| a * along);
                self.add_vector(unknown / self.dim as u32, vector, &mut sums);
            }
            let own = sums.remove(&rows.own(c)).unwrap_or(0.0);
            let largest = sums.values().fold(own.abs(), |m, a| m.max(a.abs()));
            let others = sums.into_iter().filter(|(_, a)| a.abs() > ROUNDING * largest).collect();
            Some(JumpRow { weight: row.weight, own, others })
        };
        let mut of_components = rows.rows.iter().enumerate().map(over_unknowns);
        let framed = std::array::from_fn(|_| of_components.next().flatten());
        drop(of_components);
        JumpRows { rows: framed, ..rows }
    }

    /// Adds the coefficients of the unknowns in the product of a vector with the displacement of a
    /// node.
    fn add_vector(&self, node: u32, mut vector: [f64; 3], sums: &mut BTreeMap<u32, f64>) {
        if let Some(framed) = self.at(node) {
            for end in framed.ends.into_iter().flatten() {
                self.add_vector(end, vector.map(|v| SHARE_OF_END * v), sums);
            }
            if framed.ends.is_some() {
                vector = vector.map(|v| (1.0 - 2.0 * SHARE_OF_END) * v);
            }
            vector = self.turned(&framed.rotation, vector);
        }
        for (c, v) in vector.into_iter().enumerate().take(self.dim) {
            *sums.entry(node * self.dim as u32 + c as u32).or_insert(0.0) += v;
        }
    }

    /// The framed ones among the nodes of a cell with their places, those without ends first.
    fn framed_of<'f>(&'f self, nodes: &'f [u32]) -> impl Iterator<Item = (&'f Framed, usize)> {
        let of = |ends: bool| {
            let all = nodes.iter().enumerate();
            let framed = all.filter_map(|(place, node)| Some((self.at(*node)?, place)));
            framed.filter(move |(framed, _)| framed.ends.is_some() == ends)
        };
        of(false).chain(of(true))
    }

    /// Turns the unknowns of the node at a place into its displacement.
    fn displace(&self, framed: &Framed, own: usize, ends: Option<[u32; 2]>, u: &mut [f64]) {
        let dim = self.dim;
        let mut v = self.turned_back(&framed.rotation, padded(&u[own * dim..][..dim]));
        if let Some(ends) = ends {
            for (i, v) in v.iter_mut().enumerate().take(dim) {
                let of_ends: f64 = ends.iter().map(|end| u[*end as usize * dim + i]).sum();
                *v = (1.0 - 2.0 * SHARE_OF_END) * *v + SHARE_OF_END * of_ends;
            }
        }
        u[own * dim..][..dim].copy_from_slice(&v[..dim]);
    }

    /// The transpose of [`Frames::displace`].
    fn gather(&self, framed: &Framed, own: usize, ends: Option<[u32; 2]>, force: &mut [f64]) {
        let dim = self.dim;
        let mut f = padded(&force[own * dim..][..dim]);
        if let Some(ends) = ends {
            for i in 0..dim {
                ends.iter().for_each(|end| force[*end as usize * dim + i] += SHARE_OF_END * f[i]);
                f[i] *= 1.0 - 2.0 * SHARE_OF_END;
            }
        }
        let f = self.turned(&framed.rotation, f);
        force[own * dim..][..dim].copy_from_slice(&f[..dim]);
    }
}

fn padded(values: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0))
}

fn transpose(matrix: &mut [f64], size: usize) {
    for i in 0..size {
        for j in 0..i {
            matrix.swap(i * size + j, j * size + i);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame about a general axis.
    fn rotation() -> Rotation {
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)]))
    }

    fn frames() -> Frames {
        let framed = |node, ends| Framed { node, rotation: rotation(), ends };
        Frames::new(3, 4, vec![framed(1, Some([0, 3])), framed(3, None)])
    }

    #[test]
    fn forces_do_the_same_work_on_unknowns() {
        let unknowns: Vec<f64> = (0..12).map(|i| f64::from(i * 7 % 5) - 1.5).collect();
        let force: Vec<f64> = (0..12).map(|i| f64::from(i * 5 % 7) - 2.5).collect();
        let frames = frames();
        let u = frames.displacements(&unknowns);
        assert_ne!(&*u, &unknowns[..]);
        let work: f64 = u.iter().zip(&force).map(|(u, f)| u * f).sum();
        let mut folded = force.clone();
        frames.fold(&mut folded);
        let same: f64 = unknowns.iter().zip(&folded).map(|(u, f)| u * f).sum();
        assert!((work - same).abs() < 1e-13 * work.abs(), "{work} {same}");
    }

    #[test]
    fn a_cell_has_the_same_energy_in_unknowns() {
        let (frames, nodes) = (frames(), [2_u32, 3, 1, 0]);
        let size = 12;
        let entry = |i: usize, j: usize| ((i + j) * 13 % 11) as f64 + 0.1 * (i * j) as f64;
        let matrix: Vec<f64> = (0..size * size).map(|k| entry(k / size, k % size)).collect();
        let unknowns: Vec<f64> = (0..12).map(|i| f64::from(i * 3 % 7) - 2.0).collect();
        let of_cell = |u: &[f64]| -> Vec<f64> {
            nodes.iter().flat_map(|n| u[*n as usize * 3..][..3].to_vec()).collect()
        };
        let energy = |matrix: &[f64], u: &[f64]| -> f64 {
            let row = |(row, left): (&[f64], &f64)| -> f64 {
                left * row.iter().zip(u).map(|(k, right)| k * right).sum::<f64>()
            };
            matrix.chunks_exact(size).zip(u).map(row).sum()
        };
        let exact = energy(&matrix, &of_cell(&frames.displacements(&unknowns)));
        let mut folded = matrix;
        frames.fold_matrix(&nodes, &mut folded);
        let found = energy(&folded, &of_cell(&unknowns));
        assert!((found / exact - 1.0).abs() < 1e-13, "{found} {exact}");
    }

    #[test]
    fn forces_on_unknowns_do_the_work_of_those_on_displacements() {
        let frames = frames();
        let field = |node: u32| [0.3, 1.0, -2.0].map(|a| a * f64::from(3 * node + 1));
        for node in 0..4 {
            let force = [1.5, -0.5, 2.0];
            let unknowns = frames.unknowns(node, field);
            let exact: f64 = unknowns.iter().zip(force).map(|(u, f)| u * f).sum();
            let mut work = 0.0;
            frames.spread(node, force, |of, f| {
                work += field(of).iter().zip(f).map(|(u, f)| u * f).sum::<f64>();
            });
            assert!((work - exact).abs() < 1e-13 * exact.abs(), "{work} {exact}");
        }
    }

    #[test]
    fn unknowns_of_a_field_give_it_back() {
        let frames = frames();
        let field = |node: u32| [1.0, -2.0, 0.5].map(|a| a * f64::from(node * node + 1));
        let unknowns: Vec<f64> = (0..4).flat_map(|n| frames.unknowns(n, field)).collect();
        for (node, u) in frames.displacements(&unknowns).chunks_exact(3).enumerate() {
            let exact = field(node as u32);
            assert!((0..3).all(|i| (u[i] - exact[i]).abs() < 1e-13), "{u:?} {exact:?}");
        }
    }
}
