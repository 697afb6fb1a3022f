//! Between two levels: interpolation, its transpose, and the state of the interfaces.

use std::cell::RefCell;
use std::rc::Rc;

use super::lines::Lines;
use crate::assembly::{Discretization, NodeState, Precision, TangentOperator};
use crate::mesh::Interpolation;
use crate::petsc::LinearOperator;

/// Numbers of a node's share in the state of a coarse node: marks of stuck components, weighted
/// tangent.
const WIDTH: usize = NodeState::WIDTH;

/// Interpolation from the nodes of a coarse level to those of the next finer one: multilinear in
/// lattices, by the basis of the parent in refined meshes of files.
///
/// It takes displacements to displacements and jumps to jumps: unknowns are expanded on the coarse
/// level first, and what lies on an identity row of the fine level is dropped. Where nodes have
/// frames, vectors are interpolated along the axes.
pub struct Transfer {
    fine: Rc<TangentOperator>,
    coarse: Rc<TangentOperator>,
    parents: Parents,
    work: RefCell<[Vec<f64>; 2]>,
    /// Of the size of the owned fine unknowns.
    residual: RefCell<Vec<f64>>,
}

/// The coarse nodes that each fine node depends on.
enum Parents {
    /// Of owned nodes of a lattice.
    Lines(Lines),
    /// Of all local nodes of the mesh of a file; vectors are interpolated along the axes.
    Lists(Lists),
}

/// First entry of each fine node, local coarse nodes and their parts.
struct Lists {
    start: Vec<u32>,
    node: Vec<u32>,
    weight: Vec<f64>,
}

impl Lists {
    fn of(&self, fine_node: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.start[fine_node] as usize..self.start[fine_node + 1] as usize;
        let nodes = self.node[range.clone()].iter().map(|n| *n as usize);
        nodes.zip(self.weight[range].iter().copied())
    }
}

impl Transfer {
    /// Between operators on nested meshes. Every fine node lies in a coarse cell of this rank.
    pub fn new(
        fine: Rc<TangentOperator>,
        coarse: Rc<TangentOperator>,
        interpolation: Interpolation,
    ) -> Self {
        let held = "the coarse cell around a fine node is held";
        let local = |name| coarse.discretization().nodes.local(name).expect(held);
        let parents = if interpolation.is_of_file {
            let Interpolation { start, names, weights, .. } = interpolation;
            let node = names.into_iter().map(local).collect();
            Parents::Lists(Lists { start, node, weight: weights })
        } else {
            Parents::Lines(Lines::new(&interpolation, local))
        };
        let zero = vec![0.0; coarse.unknowns_held()];
        let work = RefCell::new([zero.clone(), zero]);
        let residual = {
            let fine = fine.discretization();
            RefCell::new(vec![0.0; fine.nodes.owned * fine.dim])
        };
        Self { fine, coarse, parents, work, residual }
    }

    /// Owned unknowns of the fine and of the coarse level.
    pub fn unknowns(&self) -> [usize; 2] {
        [&self.fine, &self.coarse].map(|level| {
            let all = level.discretization();
            all.nodes.owned * all.dim
        })
    }

    /// Interpolates the values of a fine node.
    fn gather<T: Precision>(&self, fine_node: usize, coarse: &[T], values: &mut [T]) {
        let dim = values.len();
        values.fill(T::ZERO);
        self.for_parents(fine_node, |parent, part| {
            let (from, part) = (&coarse[parent * dim..][..dim], T::from_double(part));
            values.iter_mut().zip(from).for_each(|(v, u)| *v += part * *u);
        });
    }

    /// The transpose of `gather`.
    fn scatter<T: Precision>(&self, fine_node: usize, values: &[T], coarse: &mut [T]) {
        let dim = values.len();
        self.for_parents(fine_node, |parent, part| {
            let (to, part) = (&mut coarse[parent * dim..][..dim], T::from_double(part));
            to.iter_mut().zip(values).for_each(|(f, v)| *f += part * *v);
        });
    }

    /// Interpolates displacements along the axes of all local coarse nodes to a fine node.
    fn vector(&self, fine_node: u32, coarse: &[f64]) -> [f64; 3] {
        let mut values = [0.0; 3];
        let dim = self.coarse.discretization().dim;
        self.gather(fine_node as usize, coarse, &mut values[..dim]);
        values
    }

    /// The jumps of coarse secondary nodes along the axes; zero at all others, such as tips.
    fn jumps_along_axes(&self, u: &[f64]) -> Vec<f64> {
        let coarse = self.coarse.discretization();
        let mut jumps = vec![0.0; u.len()];
        for rows in &coarse.secondary {
            for c in (0..coarse.dim).filter(|c| rows.rows[*c].is_some()) {
                let own = rows.own(c) as usize;
                jumps[own] = u[own];
            }
        }
        coarse.frames.displacements(&jumps).into_owned()
    }

    /// [`LinearOperator::multiply`] with vectors along the axes.
    fn multiply_along_axes(&self, u: &mut [f64], y: &mut [f64]) {
        let (fine, coarse) = (self.fine.discretization(), self.coarse.discretization());
        let dim = fine.dim;
        let displacements = coarse.frames.displacements(u);
        for (node, values) in (0..).zip(y.chunks_exact_mut(dim)) {
            let of_node = fine.frames.unknowns(node, |node| self.vector(node, &displacements));
            values.copy_from_slice(&of_node[..dim]);
        }
        drop(displacements);
        self.coarse.to_jumps(u);
        let jumps = self.jumps_along_axes(u);
        for (index, rows) in fine.secondary[..fine.owned_secondary()].iter().enumerate() {
            let jump = fine.frames.unknowns(rows.node, |node| self.vector(node, &jumps));
            for c in (0..dim).filter(|c| self.fine.unknown_is_jump(index, *c)) {
                y[rows.own(c) as usize] = jump[c];
            }
        }
    }

    /// The transpose of `multiply_along_axes`, from fine forces `r` without those on jumps to
    /// coarse ones.
    fn spread_along_axes(&self, r: &mut [f64], force: &mut [f64], on_jumps: &mut [f64]) {
        let (fine, coarse) = (self.fine.discretization(), self.coarse.discretization());
        let dim = fine.dim;
        let spread = |node: u32, on_node: [f64; 3], to: &mut [f64]| {
            fine.frames.spread(node, on_node, |node, f| {
                self.scatter(node as usize, &f[..dim], to);
            });
        };
        for (index, rows) in fine.secondary[..fine.owned_secondary()].iter().enumerate() {
            let mut jump = [0.0; 3];
            for c in (0..dim).filter(|c| self.fine.unknown_is_jump(index, *c)) {
                jump[c] = std::mem::take(&mut r[rows.own(c) as usize]);
            }
            if jump != [0.0; 3] {
                spread(rows.node, jump, on_jumps);
            }
        }
        for (node, values) in (0..).zip(r.chunks_exact(dim)) {
            let mut on_node = [0.0; 3];
            on_node[..dim].copy_from_slice(values);
            spread(node, on_node, force);
        }
        coarse.frames.fold(on_jumps);
        coarse.frames.fold(force);
    }

    /// Calls `act` with the coarse nodes that a fine node depends on, and their parts.
    fn for_parents(&self, fine_node: usize, mut act: impl FnMut(usize, f64)) {
        match &self.parents {
            Parents::Lines(lines) => {
                lines.parents(fine_node).for_each(|(node, part)| act(node, part))
            }
            Parents::Lists(lists) => lists.of(fine_node).for_each(|(node, part)| act(node, part)),
        }
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
            self.for_parents(rows.node as usize, |parent, part| {
                let sum = &mut sums[parent * WIDTH..][..WIDTH];
                for c in 0..dim {
                    sum[c] += f64::from(u8::from(state.stuck[c] && rows.rows[c].is_some()));
                    for d in 0..dim {
                        sum[3 + 3 * c + d] += part * weight(c) * weight(d) * state.tangent[c][d];
                    }
                }
            });
        }
        coarse.nodes.add_to_owners(&mut sums, WIDTH);
        coarse.nodes.update_ghosts(&mut sums, WIDTH);
        let mut state: Vec<NodeState> =
            coarse.secondary.iter().map(|rows| coarse_state(coarse, rows, &sums)).collect();
        self.coarse.choose_unknowns(state.iter_mut());
        state
    }
}

/// The state of a coarse secondary node from the sums over the fine nodes that depend on it.
fn coarse_state(
    coarse: &Discretization,
    rows: &crate::interface::JumpRows<u32>,
    sums: &[f64],
) -> NodeState {
    let sums = &sums[rows.node as usize * WIDTH..][..WIDTH];
    let weight = |c: usize| rows.rows[c].as_ref().map_or(0.0, |row| row.weight.sqrt());
    let mut state = NodeState { stuck: [0, 1, 2].map(|c| sums[c] != 0.0), ..NodeState::STUCK };
    for c in 0..coarse.dim {
        for d in 0..coarse.dim {
            let product = weight(c) * weight(d);
            if product > 0.0 && !state.stuck[c] && !state.stuck[d] {
                state.tangent[c][d] = sums[3 + 3 * c + d] / product;
            }
        }
    }
    state
}

impl Transfer {
    /// Interpolates the values of all owned fine nodes.
    fn gather_all<T: Precision>(&self, coarse: &[T], fine: &mut [T]) {
        let dim = self.fine.discretization().dim;
        if let Parents::Lines(lines) = &self.parents {
            return lines.interpolate(dim, coarse, fine);
        }
        for (node, values) in fine.chunks_exact_mut(dim).enumerate() {
            self.gather(node, coarse, values);
        }
    }

    /// The transpose of `gather_all`, added.
    fn scatter_all<T: Precision>(&self, fine: &[T], coarse: &mut [T]) {
        let dim = self.fine.discretization().dim;
        if let Parents::Lines(lines) = &self.parents {
            return lines.add_transposed(dim, fine, coarse);
        }
        for (node, values) in fine.chunks_exact(dim).enumerate() {
            self.scatter(node, values, coarse);
        }
    }

    /// Coarse unknowns to fine ones. Collective.
    pub fn prolong<T: Precision>(&self, x: &[T], y: &mut [T], u: &mut [T]) {
        let fine = self.fine.discretization();
        let dim = fine.dim;
        if self.is_of_file() {
            let ([u, _], fine) = (&mut *self.work.borrow_mut(), &mut *self.residual.borrow_mut());
            u.iter_mut().zip(x).for_each(|(u, x)| *u = x.to_double());
            self.prolong_along_axes(u, fine);
            return y.iter_mut().zip(fine).for_each(|(y, u)| *y = T::from_double(*u));
        }
        u[..x.len()].copy_from_slice(x);
        self.coarse.expand(u);
        self.gather_all(u, y);
        self.coarse.to_jumps(u);
        for (index, rows) in fine.secondary[..fine.owned_secondary()].iter().enumerate() {
            let (node, mut jump) = (rows.node as usize, [T::ZERO; 3]);
            self.gather(node, u, &mut jump[..dim]);
            for c in (0..dim).filter(|c| self.fine.unknown_is_jump(index, *c)) {
                y[node * dim + c] = jump[c];
            }
        }
        self.fine.for_identity_components(|own| y[own] = T::ZERO);
    }

    /// Fine forces to coarse ones; the former are used up. Collective.
    pub fn restrict<T: Precision>(&self, r: &mut [T], y: &mut [T], room: &mut [Vec<T>; 2]) {
        let fine = self.fine.discretization();
        let dim = fine.dim;
        if self.is_of_file() {
            let fine = &mut *self.residual.borrow_mut();
            fine.iter_mut().zip(&*r).for_each(|(fine, r)| *fine = r.to_double());
            let [force, on_jumps] = &mut *self.work.borrow_mut();
            self.restrict_along_axes(fine, force, on_jumps);
            return y.iter_mut().zip(force).for_each(|(y, f)| *y = T::from_double(*f));
        }
        let [force, on_jumps] = room;
        force.fill(T::ZERO);
        on_jumps.fill(T::ZERO);
        self.fine.for_identity_components(|own| r[own] = T::ZERO);
        for (index, rows) in fine.secondary[..fine.owned_secondary()].iter().enumerate() {
            let (node, mut jump) = (rows.node as usize, [T::ZERO; 3]);
            for c in (0..dim).filter(|c| self.fine.unknown_is_jump(index, *c)) {
                jump[c] = std::mem::take(&mut r[node * dim + c]);
            }
            self.scatter(node, &jump[..dim], on_jumps);
        }
        self.scatter_all(r, force);
        self.coarse.fold(force, Some(on_jumps));
        y.copy_from_slice(&force[..y.len()]);
    }

    /// Whether it is one between meshes of a file.
    pub fn is_of_file(&self) -> bool {
        matches!(self.parents, Parents::Lists(_))
    }

    /// Unknowns of all local coarse nodes.
    pub fn coarse_unknowns_held(&self) -> usize {
        self.coarse.unknowns_held()
    }
}

impl Transfer {
    /// Coarse unknowns, which have room for ghosts, to fine ones between meshes of a file.
    /// Collective.
    fn prolong_along_axes(&self, u: &mut [f64], y: &mut [f64]) {
        self.coarse.expand(u);
        self.multiply_along_axes(u, y);
        self.fine.for_identity_components(|own| y[own] = 0.0);
    }

    /// Fine forces, which are used up, to coarse ones between meshes of a file. Collective.
    fn restrict_along_axes(&self, r: &mut [f64], force: &mut [f64], on_jumps: &mut [f64]) {
        force.fill(0.0);
        on_jumps.fill(0.0);
        self.fine.for_identity_components(|own| r[own] = 0.0);
        self.spread_along_axes(r, force, on_jumps);
        self.coarse.fold(force, Some(on_jumps));
    }
}

impl LinearOperator for Transfer {
    /// Coarse unknowns to fine ones.
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let [u, _] = &mut *self.work.borrow_mut();
        if !self.is_of_file() {
            return self.prolong(x, y, u);
        }
        u[..x.len()].copy_from_slice(x);
        self.prolong_along_axes(u, y);
    }

    /// Fine forces to coarse ones.
    fn multiply_transpose(&self, x: &[f64], y: &mut [f64]) {
        let room = &mut *self.work.borrow_mut();
        let r = &mut *self.residual.borrow_mut();
        r.copy_from_slice(x);
        if !self.is_of_file() {
            return self.restrict(r, y, room);
        }
        let [force, on_jumps] = room;
        self.restrict_along_axes(r, force, on_jumps);
        y.copy_from_slice(&force[..y.len()]);
    }
}
