//! The tangent of the condensed form as an operator: applied cell by cell, no matrix.
//!
//! Where [`NodeState::jump`] says so, the unknown at a secondary component is not the displacement
//! but what it has beyond the primary side's.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use std::cell::RefCell;
use std::rc::Rc;

use mpi::datatype::traits::Equivalence;

use super::Discretization;
use super::NodeState;
use super::boxes::Scalar;
use super::friction::{friction_on_jump, spread_friction};
use super::tangent::transform_diagonal;
use crate::petsc::LinearOperator;

/// The tangent at a state of the interfaces; see [`super::Tangent`] for what it contains.
pub struct TangentOperator {
    all: Rc<Discretization>,
    /// Entry of identity rows (N/m).
    diagonal: f64,
    /// State of every entry of `Discretization::secondary`.
    state: RefCell<Vec<NodeState>>,
    /// Prescribed components of local nodes, as places in a local vector.
    prescribed: Vec<u32>,
    /// Diagonal of the cells' stiffness at local components (N/m).
    stiffness: Vec<f64>,
    /// Displacements of all local nodes, and forces at ghosts.
    work: RefCell<[Vec<f64>; 2]>,
    /// The same in single precision, once it is used.
    single: RefCell<[Vec<f32>; 2]>,
}

/// A precision in which the operator is applied. What belongs to interfaces is added up in double
/// precision and then rounded.
pub trait Precision: Scalar + Equivalence {
    /// Room for displacements of all local nodes and forces at ghosts.
    fn work(operator: &TangentOperator) -> &RefCell<[Vec<Self>; 2]>;

    /// As [`Discretization::add_forces_apart`].
    fn add_forces_apart(all: &Discretization, u: &[Self], owned: &mut [Self], ghosts: &mut [Self]);
}

impl Precision for f64 {
    fn work(operator: &TangentOperator) -> &RefCell<[Vec<f64>; 2]> {
        &operator.work
    }

    fn add_forces_apart(all: &Discretization, u: &[f64], owned: &mut [f64], ghosts: &mut [f64]) {
        all.add_forces_apart(u, owned, ghosts);
    }
}

impl Precision for f32 {
    fn work(operator: &TangentOperator) -> &RefCell<[Vec<f32>; 2]> {
        &operator.single
    }

    fn add_forces_apart(all: &Discretization, u: &[f32], owned: &mut [f32], ghosts: &mut [f32]) {
        all.add_single_forces_apart(u, owned, ghosts);
    }
}

/// Forces at owned components and at those of ghosts, which need not lie together.
struct Apart<'a, T> {
    owned: &'a mut [T],
    ghosts: &'a mut [T],
}

impl<T> Apart<'_, T> {
    fn at(&mut self, component: usize) -> &mut T {
        match component.checked_sub(self.owned.len()) {
            None => &mut self.owned[component],
            Some(ghost) => &mut self.ghosts[ghost],
        }
    }
}

impl TangentOperator {
    /// The operator with all secondary nodes stuck; `diagonal` must be the same on all ranks.
    /// Collective.
    pub fn new(all: Rc<Discretization>, diagonal: f64) -> Self {
        let dim = all.dim;
        let components = |(node, fixed): (usize, &[bool; 3])| -> Vec<u32> {
            (0..dim).filter(|c| fixed[*c]).map(|c| (node * dim + c) as u32).collect()
        };
        let prescribed = all.prescribed.iter().enumerate().flat_map(components).collect();
        let state = RefCell::new(vec![NodeState::STUCK; all.secondary.len()]);
        let size = all.nodes.len() * dim;
        let ghosts = size - all.nodes.owned * dim;
        let work = RefCell::new([vec![0.0; size], vec![0.0; ghosts]]);
        let single = RefCell::default();
        let mut stiffness = vec![0.0; size];
        all.add_diagonal(&mut stiffness);
        all.nodes.add_to_owners(&mut stiffness, dim);
        all.nodes.update_ghosts(&mut stiffness, dim);
        Self { all, diagonal, state, prescribed, stiffness, work, single }
    }

    /// The cells and nodes it acts on.
    pub fn discretization(&self) -> &Rc<Discretization> {
        &self.all
    }

    /// The entry of identity rows (N/m).
    pub fn identity_entry(&self) -> f64 {
        self.diagonal
    }

    /// Components of all local nodes.
    pub fn unknowns_held(&self) -> usize {
        self.all.nodes.len() * self.all.dim
    }

    /// Takes the state of every entry of `Discretization::secondary`. Local.
    pub fn set_state(&self, state: &[NodeState]) {
        self.state.borrow_mut().copy_from_slice(state);
    }

    /// Turns owned unknowns into displacements of all local nodes: zero where prescribed, without a
    /// jump at stuck components. Collective.
    pub fn expand<T: Precision>(&self, u: &mut [T]) {
        let (all, dim) = (&self.all, self.all.dim);
        for component in &self.prescribed {
            u[*component as usize] = T::ZERO;
        }
        all.nodes.update_ghosts(u, dim);
        for component in &self.prescribed {
            u[*component as usize] = T::ZERO;
        }
        // The rows contain no other component that has a row itself.
        for (rows, state) in all.secondary.iter().zip(&*self.state.borrow()) {
            for (c, row) in rows.rows[..dim].iter().enumerate() {
                let follows = state.stuck[c] || state.jump[c];
                let Some(row) = row.as_ref().filter(|_| follows) else { continue };
                let followed = row.trace_of_others(|unknown| u[unknown as usize].to_double());
                let own = &mut u[rows.own(c) as usize];
                let jump = if state.stuck[c] { 0.0 } else { own.to_double() };
                *own = T::from_double(jump - followed / row.own);
            }
        }
    }

    /// Replaces expanded displacements by jumps over their own coefficient at all local secondary
    /// nodes. Local.
    pub fn to_jumps<T: Precision>(&self, u: &mut [T]) {
        let dim = self.all.dim;
        for rows in &self.all.secondary {
            for (c, row) in rows.rows[..dim].iter().enumerate() {
                let Some(row) = row else { continue };
                let followed = row.trace_of_others(|unknown| u[unknown as usize].to_double());
                u[rows.own(c) as usize] += T::from_double(followed / row.own);
            }
        }
    }

    /// The transpose of [`TangentOperator::expand`]: local forces to those on owned unknowns, zero
    /// at identity rows. `on_jumps` acts on what [`TangentOperator::to_jumps`] gives; none counts
    /// as zero. Collective.
    pub fn fold<T: Precision>(&self, force: &mut [T], on_jumps: Option<&[T]>) {
        let (owned, ghosts) = force.split_at_mut(self.all.nodes.owned * self.all.dim);
        self.fold_apart(Apart { owned, ghosts }, on_jumps);
    }

    fn fold_apart<T: Precision>(&self, mut force: Apart<'_, T>, on_jumps: Option<&[T]>) {
        let (all, dim) = (&self.all, self.all.dim);
        for (rows, state) in all.secondary.iter().zip(&*self.state.borrow()) {
            let friction = friction_on_jump(rows, state, |own| force.at(own as usize).to_double());
            for (c, row) in rows.rows[..dim].iter().enumerate() {
                let Some(row) = row else { continue };
                let own = rows.own(c) as usize;
                // A force on a jump is one on the displacement and its reaction on the others.
                let on_jump = on_jumps.map_or(T::ZERO, |on_jumps| on_jumps[own]);
                let carried = match (state.stuck[c], state.jump[c]) {
                    (true, _) => -std::mem::take(force.at(own)).to_double(),
                    (false, jump) => {
                        let before = *force.at(own);
                        *force.at(own) += on_jump;
                        if jump { -before.to_double() } else { on_jump.to_double() }
                    }
                } / row.own;
                row.spread_to_others(carried, |unknown, f| {
                    *force.at(unknown as usize) += T::from_double(f);
                });
            }
            if let Some(friction) = friction {
                spread_friction(rows, state, friction, |unknown, f| {
                    *force.at(unknown as usize) += T::from_double(f);
                });
            }
        }
        let Apart { owned, ghosts } = force;
        all.nodes.add_ghosts_to_owners(owned, ghosts, dim);
        let size = owned.len();
        for component in self.prescribed.iter().take_while(|c| (**c as usize) < size) {
            owned[*component as usize] = T::ZERO;
        }
    }

    /// Calls `act` with the place of every owned component whose row is the identity. Local.
    pub fn for_identity_components(&self, mut act: impl FnMut(usize)) {
        let (all, dim) = (&self.all, self.all.dim);
        let owned = all.nodes.owned * dim;
        for component in self.prescribed.iter().take_while(|c| (**c as usize) < owned) {
            act(*component as usize);
        }
        let owned_secondary = &all.secondary[..all.owned_secondary()];
        for (rows, state) in owned_secondary.iter().zip(&*self.state.borrow()) {
            for c in (0..dim).filter(|c| rows.rows[*c].is_some() && state.stuck[*c]) {
                act(rows.node as usize * dim + c);
            }
        }
    }

    /// Marks the owned components whose row is the identity. Local.
    pub fn identity_marks(&self) -> Vec<bool> {
        let mut marks = vec![false; self.all.nodes.owned * self.all.dim];
        self.for_identity_components(|own| marks[own] = true);
        marks
    }

    /// Whether the unknown of a component of an owned secondary node is its jump. Local.
    pub fn unknown_is_jump(&self, index: usize, component: usize) -> bool {
        self.state.borrow()[index].jump[component]
    }

    /// Takes jumps for unknowns where the law is stiffer than the cells; `state` belongs to the
    /// first entries of `Discretization::secondary`. Local.
    pub fn choose_unknowns<'s>(&self, state: impl Iterator<Item = &'s mut NodeState>) {
        let dim = self.all.dim;
        for (rows, state) in self.all.secondary.iter().zip(state) {
            for c in 0..dim {
                let Some(row) = &rows.rows[c] else { continue };
                let law = row.weight * row.own * row.own * state.tangent[c][c];
                let cells = self.stiffness[rows.node as usize * dim + c];
                state.jump[c] = !state.stuck[c] && law > cells;
            }
        }
    }

    /// Volume by which the normal jump at an entry of `Discretization::secondary` yields to a
    /// pressure on both lips there (m3/Pa), as far as its own cells and its law are concerned; 0
    /// where it is known. Local.
    pub fn opening_compliance(&self, index: u32) -> f64 {
        let (rows, state) = (&self.all.secondary[index as usize], self.state.borrow());
        let (normal, state) = (self.all.dim - 1, &state[index as usize]);
        let Some(row) = rows.rows[normal].as_ref().filter(|_| !state.stuck[normal]) else {
            return 0.0;
        };
        let cells =
            self.stiffness[rows.node as usize * self.all.dim + normal] / (row.own * row.own);
        let law = row.weight * state.tangent[normal][normal];
        row.weight * row.weight / (cells + law).max(0.1 * cells)
    }

    /// How strongly the law couples the unknowns of a pair of nodes, at most: the entry between
    /// them over the root of the product of their diagonals, for equal stiffness on both sides. The
    /// largest eigenvalue over the diagonal grows by no more than that. Local.
    pub fn strongest_pair(&self) -> f64 {
        let dim = self.all.dim;
        let mut strongest = 0.0_f64;
        for (rows, state) in self.all.secondary.iter().zip(&*self.state.borrow()) {
            for c in (0..dim).filter(|c| !state.stuck[*c]) {
                let Some(row) = &rows.rows[c] else { continue };
                let law = (row.weight * row.own * row.own * state.tangent[c][c]).abs();
                let law = law / self.stiffness[rows.node as usize * dim + c];
                let coupling = if state.jump[c] {
                    (2.0 * (1.0 + law)).sqrt().recip()
                } else {
                    law / (1.0 + law)
                };
                strongest = strongest.max(coupling);
            }
        }
        strongest
    }

    /// Adds the law's forces at owned secondary nodes; see `tangent::add_law` on the weights.
    fn add_law<T: Precision>(&self, u: &[T], force: &mut Apart<'_, T>) {
        let (all, dim) = (&self.all, self.all.dim);
        let owned = &all.secondary[..all.owned_secondary()];
        for (rows, state) in owned.iter().zip(&*self.state.borrow()) {
            let free = |c: usize| rows.rows[c].as_ref().filter(|_| !state.stuck[c]);
            let mut jump = [0.0; 3];
            for c in 0..dim {
                if let Some(row) = free(c) {
                    let of_row = row.trace(rows.own(c), |unknown| u[unknown as usize].to_double());
                    jump[c] = row.weight.sqrt() * of_row;
                }
            }
            for c in 0..dim {
                if let Some(row) = free(c) {
                    let traction: f64 = (0..dim).map(|d| state.tangent[c][d] * jump[d]).sum();
                    let on_row = row.weight.sqrt() * traction;
                    row.spread(rows.own(c), on_row, |unknown, f| {
                        *force.at(unknown as usize) += T::from_double(f);
                    });
                }
            }
        }
    }
}

impl TangentOperator {
    /// The product with owned unknowns and what `beside` adds: it sees the displacements of all
    /// local nodes and adds forces at them, not summed. Collective.
    pub fn multiply_beside(
        &self,
        x: &[f64],
        y: &mut [f64],
        beside: impl FnOnce(&[f64], &mut [f64]),
    ) {
        let (mut force, owned) = (vec![0.0; self.unknowns_held()], y.len());
        self.product(x, y, |u, apart| {
            beside(u, &mut force);
            let (own, ghosts) = force.split_at(owned);
            apart.owned.iter_mut().zip(own).for_each(|(y, f)| *y += f);
            apart.ghosts.iter_mut().zip(ghosts).for_each(|(y, f)| *y += f);
        });
    }

    fn product<T: Precision>(
        &self,
        x: &[T],
        y: &mut [T],
        beside: impl FnOnce(&[T], &mut Apart<'_, T>),
    ) {
        let (all, owned) = (&self.all, y.len());
        let [u, ghosts] = &mut *T::work(self).borrow_mut();
        u.resize(self.unknowns_held(), T::ZERO);
        ghosts.resize(self.unknowns_held() - owned, T::ZERO);
        u[..owned].copy_from_slice(x);
        self.expand(u);
        y.fill(T::ZERO);
        ghosts.fill(T::ZERO);
        T::add_forces_apart(all, u, y, ghosts);
        let mut force = Apart { owned: &mut *y, ghosts };
        self.add_law(u, &mut force);
        beside(u, &mut force);
        self.fold_apart(force, None);
        let identity = T::from_double(self.diagonal);
        self.for_identity_components(|own| y[own] = identity * x[own]);
    }

    /// As [`LinearOperator::multiply`] in either precision. Collective.
    pub fn multiply_in<T: Precision>(&self, x: &[T], y: &mut [T]) {
        self.product(x, y, |_, _| {});
    }
}

impl LinearOperator for TangentOperator {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        self.product(x, y, |_, _| {});
    }

    fn diagonal(&self, d: &mut [f64]) {
        let (all, state) = (&self.all, self.state.borrow());
        let mut change = vec![0.0; all.nodes.len() * all.dim];
        transform_diagonal(all, &state, &mut change);
        all.nodes.add_to_owners(&mut change, all.dim);
        for ((d, stiffness), change) in d.iter_mut().zip(&self.stiffness).zip(change) {
            *d = stiffness + change;
        }
        drop(state);
        self.for_identity_components(|own| d[own] = self.diagonal);
    }
}
