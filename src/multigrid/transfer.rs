//! Between two levels: interpolation, its transpose, and the state of the interfaces.

use std::cell::RefCell;
use std::rc::Rc;

use crate::assembly::{Discretization, NodeState, TangentOperator};
use crate::mesh::{Column, NodePlace, axes};
use crate::petsc::LinearOperator;

/// Numbers of a node's share in the state of a coarse node: marks of stuck components, weighted
/// tangent.
const WIDTH: usize = NodeState::WIDTH;

/// Multilinear interpolation from the nodes of a coarse level to those of the next finer one.
///
/// It takes displacements to displacements: unknowns are expanded on the coarse level first, and
/// what lies on an identity row of the fine level is dropped.
pub struct Transfer {
    fine: Rc<TangentOperator>,
    coarse: Rc<TangentOperator>,
    /// First entry of each owned fine node in the two lists below.
    start: Vec<u32>,
    /// Local coarse nodes.
    node: Vec<u32>,
    weight: Vec<f64>,
    work: RefCell<Vec<f64>>,
}

impl Transfer {
    /// Between operators on nested lattices. Every fine node lies in a coarse cell of this rank.
    pub fn new(
        fine: Rc<TangentOperator>,
        coarse: Rc<TangentOperator>,
        fine_column: &Column,
        coarse_column: &Column,
    ) -> Self {
        let (mut start, mut node, mut weight) = (vec![0], Vec::new(), Vec::new());
        {
            let (fine, coarse) = (fine.discretization(), coarse.discretization());
            for name in &fine.nodes.names[..fine.nodes.owned] {
                for (parent, part) in parents(fine_column, coarse_column, *name) {
                    let local = coarse.nodes.local(parent);
                    node.push(local.expect("the coarse cell around a fine node is held"));
                    weight.push(part);
                }
                start.push(node.len() as u32);
            }
        }
        let work = RefCell::new(vec![0.0; coarse.unknowns_held()]);
        Self { fine, coarse, start, node, weight, work }
    }

    fn parents(&self, fine_node: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.start[fine_node] as usize..self.start[fine_node + 1] as usize;
        let nodes = self.node[range.clone()].iter().map(|n| *n as usize);
        nodes.zip(self.weight[range].iter().copied())
    }

    /// The coarse state for a fine one, both for all local secondary nodes. A component is stuck
    /// where a fine node that depends on it is: coarse jumps then vanish where fine ones have to,
    /// and the coarse operator stays the energy of an admissible displacement. Collective.
    pub fn restrict_state(&self, fine_state: &[NodeState]) -> Vec<NodeState> {
        let (fine, coarse) = (self.fine.discretization(), self.coarse.discretization());
        let dim = fine.dim;
        let mut sums = vec![0.0; coarse.nodes.len() * WIDTH];
        for (rows, state) in fine.secondary[..fine.owned_secondary()].iter().zip(fine_state) {
            let weight = |c: usize| rows.rows[c].as_ref().map_or(0.0, |row| row.weight.sqrt());
            for (parent, part) in self.parents(rows.node as usize) {
                let sum = &mut sums[parent * WIDTH..][..WIDTH];
                for c in 0..dim {
                    sum[c] += f64::from(u8::from(state.stuck[c] && rows.rows[c].is_some()));
                    for d in 0..dim {
                        sum[3 + 3 * c + d] += part * weight(c) * weight(d) * state.tangent[c][d];
                    }
                }
            }
        }
        coarse.nodes.add_to_owners(&mut sums, WIDTH);
        coarse.nodes.update_ghosts(&mut sums, WIDTH);
        coarse.secondary.iter().map(|rows| coarse_state(coarse, rows, &sums)).collect()
    }
}

/// The state of a coarse secondary node from the sums over the fine nodes that depend on it.
fn coarse_state(
    coarse: &Discretization,
    rows: &crate::interface::JumpRows<u32>,
    sums: &[f64],
) -> NodeState {
    let mut state = NodeState::unpack(&sums[rows.node as usize * WIDTH..][..WIDTH]);
    let weight = |c: usize| rows.rows[c].as_ref().map_or(0.0, |row| row.weight.sqrt());
    for c in 0..coarse.dim {
        for d in 0..coarse.dim {
            let product = weight(c) * weight(d);
            let free = product > 0.0 && !state.stuck[c] && !state.stuck[d];
            state.tangent[c][d] = if free { state.tangent[c][d] / product } else { 0.0 };
        }
    }
    state
}

/// The nodes of the coarse lattice that a fine node depends on, with their weights.
fn parents(fine: &Column, coarse: &Column, name: u64) -> Vec<(u64, f64)> {
    let place = fine.node_place(name);
    let (low, fraction) = coarse.place_in(fine, place);
    let mut list = vec![(low, 1.0)];
    for axis in axes(fine.dim).iter().copied().filter(|axis| fraction[*axis] > 0.0) {
        for i in 0..list.len() {
            let (mut upper, weight) = list[i];
            upper[axis] += 1;
            list.push((upper, weight * fraction[axis]));
            list[i].1 = weight * (1.0 - fraction[axis]);
        }
    }
    let name = |at| coarse.node(NodePlace { body: place.body, at });
    list.into_iter().map(|(at, weight)| (name(at), weight)).collect()
}

impl LinearOperator for Transfer {
    /// Coarse unknowns to fine ones.
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let dim = self.fine.discretization().dim;
        let u = &mut *self.work.borrow_mut();
        u[..x.len()].copy_from_slice(x);
        self.coarse.expand(u);
        for (node, values) in y.chunks_exact_mut(dim).enumerate() {
            values.fill(0.0);
            for (parent, part) in self.parents(node) {
                let from = &u[parent * dim..][..dim];
                values.iter_mut().zip(from).for_each(|(v, u)| *v += part * u);
            }
        }
        self.fine.for_identity_components(|own| y[own] = 0.0);
    }

    /// Fine forces to coarse ones.
    fn multiply_transpose(&self, x: &[f64], y: &mut [f64]) {
        let dim = self.fine.discretization().dim;
        let force = &mut *self.work.borrow_mut();
        force.fill(0.0);
        let identity = self.fine.identity_marks();
        for (node, values) in x.chunks_exact(dim).enumerate() {
            let mut own = [0.0; 3];
            own[..dim].copy_from_slice(values);
            (0..dim).filter(|c| identity[node * dim + c]).for_each(|c| own[c] = 0.0);
            for (parent, part) in self.parents(node) {
                let to = &mut force[parent * dim..][..dim];
                to.iter_mut().zip(own).for_each(|(f, v)| *f += part * v);
            }
        }
        self.coarse.fold(force);
        y.copy_from_slice(&force[..y.len()]);
    }
}
