//! Geometric multigrid over nested meshes, with the interfaces on every level.
//!
//! Each level has its own cells, mortar operators and tangent: the same condensed form, with the
//! state of the interfaces brought down from the level above. All levels but the coarsest are
//! applied without a matrix; the coarsest is assembled and eliminated.

mod cycle;
mod lines;
mod spectrum;
mod transfer;

use std::rc::Rc;

use crate::assembly::{Discretization, NodeState, Pattern, Tangent, TangentOperator};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::Interpolation;
use crate::petsc::{
    LinearOperator, LinearSolver, Matrix, MultigridLevel, Petsc, Preconditioner, Smoother,
};

use cycle::{CoarsestSolver, Cycle};
pub use spectrum::largest_eigenvalue;
pub use transfer::Transfer;

/// Part of the spectrum over the diagonal that the smoother damps, from its upper end.
const DAMPED: f64 = 0.09;

/// Entries of a diagonal (N/m) that single precision holds with room on both sides.
const LEAST: f64 = 1e-15;
/// See [`LEAST`].
const MOST: f64 = 1e25;

/// Whether single precision holds the entries of an operator.
fn fits(operator: &TangentOperator) -> bool {
    (LEAST..MOST).contains(&operator.identity_entry())
}

/// A discretisation, and how its owned nodes depend on those of the next coarser level; on the
/// coarsest level they depend on none.
pub struct Level {
    /// Cells, nodes, rows.
    pub all: Rc<Discretization>,
    /// In the order of the owned nodes; of the mesh of a file of all local nodes.
    pub interpolation: Interpolation,
}

/// A coarsest level that is too large for elimination.
pub trait CoarsestLevel {
    /// Makes a symmetric positive definite preconditioner for a state of every entry of
    /// `Discretization::secondary`. Collective.
    ///
    /// # Errors
    /// Those of its parts.
    fn set_up(&mut self, comm: &Comm, all: &Discretization, state: &[NodeState]) -> Result<()>;

    /// The preconditioner, which follows each set-up. Local.
    fn preconditioner(&self) -> Rc<dyn Preconditioner>;
}

/// How the coarsest level is solved.
enum Coarsest {
    /// Not known yet.
    None,
    /// By what PETSc's options say, of an assembled matrix.
    Assembled(Box<Tangent>, Matrix),
    /// By cycles of another multigrid.
    Cycles(Box<dyn CoarsestLevel>),
}

/// The levels below the finest, coarsest first, and what joins them.
pub struct Hierarchy {
    /// Operators of all levels, the finest included.
    operators: Vec<Rc<TangentOperator>>,
    /// Matrices of the levels between the coarsest and the finest.
    matrices: Vec<Matrix>,
    /// From each level to the next finer one, as operators and for PETSc.
    transfers: Vec<(Rc<Transfer>, Matrix)>,
    coarsest: Coarsest,
    /// That it has been set up for.
    state_of_coarsest: Option<Vec<NodeState>>,
    /// Largest eigenvalue over the diagonal of the tied body, from the level above the coarsest.
    largest: Vec<f64>,
    /// The smoothers of the same levels.
    smoothers: Vec<Smoother>,
    /// The cycle of our own, where it takes the place of PETSc's.
    cycle: Option<Rc<Cycle>>,
}

impl Hierarchy {
    /// From the discretisations of nested meshes, coarsest first; at least one. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn new(comm: &Comm, petsc: &Petsc, levels: Vec<Level>) -> Result<Self> {
        let (mut stencils, mut operators, mut largest) = (Vec::new(), Vec::new(), Vec::new());
        for Level { all, interpolation } in levels {
            let mut diagonal = [all.cells.largest_diagonal()];
            comm.max(&mut diagonal);
            let operator = Rc::new(TangentOperator::new(all, diagonal[0]));
            if !operators.is_empty() {
                let of = if fits(&operator) {
                    largest_eigenvalue::<f32>
                } else {
                    largest_eigenvalue::<f64>
                };
                largest.push(of(comm, &operator));
            }
            operators.push(operator);
            stencils.push(interpolation);
        }
        let (mut matrices, mut transfers) = (Vec::new(), Vec::new());
        for level in 1..operators.len() {
            let (coarse, fine) = (&operators[level - 1], &operators[level]);
            let stencil = std::mem::take(&mut stencils[level]);
            let transfer = Transfer::new(Rc::clone(fine), Rc::clone(coarse), stencil);
            let transfer = Rc::new(transfer);
            let unknowns = |o: &TangentOperator| {
                let all = o.discretization();
                all.nodes.owned * all.dim
            };
            let (rows, columns) = (unknowns(fine), unknowns(coarse));
            let dim = fine.discretization().dim;
            let matrix = Matrix::shell(petsc, rows, columns, dim, transfer.clone())?;
            transfers.push((transfer, matrix));
            if level + 1 < operators.len() {
                matrices.push(Matrix::shell(petsc, rows, rows, dim, fine.clone())?);
            }
        }
        Ok(Self {
            operators,
            matrices,
            transfers,
            coarsest: Coarsest::None,
            state_of_coarsest: None,
            largest,
            smoothers: Vec::new(),
            cycle: None,
        })
    }

    /// Gives the coarsest level a matrix, to be solved as PETSc's options say. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails or memory is short.
    pub fn assemble_coarsest(&mut self, comm: &Comm, petsc: &Petsc) -> Result<()> {
        let all = self.coarsest();
        let pattern = Pattern::new(comm, all);
        let (own, other) = pattern.counts(all.nodes.first);
        let rows = all.nodes.owned * all.dim;
        let matrix = Matrix::new(petsc, rows, all.dim, &own, &other)?;
        let tangent = Tangent::new(all, pattern, self.operators[0].identity_entry());
        self.coarsest = Coarsest::Assembled(Box::new(tangent), matrix);
        Ok(())
    }

    /// The discretisation of the coarsest level, and the entry of its identity rows (N/m).
    pub fn coarsest(&self) -> &Rc<Discretization> {
        self.operators[0].discretization()
    }

    /// The entry of the identity rows of the coarsest level (N/m).
    pub fn coarsest_identity(&self) -> f64 {
        self.operators[0].identity_entry()
    }

    /// The operator of the finest level.
    pub fn finest(&self) -> &Rc<TangentOperator> {
        &self.operators[self.operators.len() - 1]
    }

    /// From each level to the next finer one, coarsest first.
    pub fn transfers(&self) -> impl Iterator<Item = &Transfer> {
        self.transfers.iter().map(|(transfer, _)| &**transfer)
    }

    /// Whether the levels serve a cycle in single precision: their entries have to fit. Collective.
    pub fn serves_in_single_precision(&self, comm: &Comm) -> bool {
        !comm.any(!self.operators.iter().all(|operator| fits(operator)))
    }

    /// A cycle of our own over the levels, whose coarsest is solved as PETSc's options under
    /// `prefix` say. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails or memory is short.
    pub fn own_cycle(
        &mut self,
        comm: &Comm,
        petsc: &Petsc,
        prefix: &str,
    ) -> Result<Rc<dyn Preconditioner>> {
        self.assemble_coarsest(comm, petsc)?;
        let Coarsest::Assembled(_, matrix) = &self.coarsest else { unreachable!("assembled") };
        let solver = LinearSolver::new(petsc, prefix, matrix)?;
        Ok(self.cycle_over(comm, CoarsestSolver::Elimination(solver)))
    }

    /// As [`Hierarchy::own_cycle`], whose coarsest level is large. Local.
    pub fn own_cycle_above(
        &mut self,
        comm: &Comm,
        coarsest: Box<dyn CoarsestLevel>,
    ) -> Rc<dyn Preconditioner> {
        let solver = CoarsestSolver::cycles(coarsest.preconditioner(), &self.operators[0]);
        self.coarsest = Coarsest::Cycles(coarsest);
        self.cycle_over(comm, solver)
    }

    fn cycle_over(&mut self, comm: &Comm, coarsest: CoarsestSolver) -> Rc<dyn Preconditioner> {
        let transfers = self.transfers.iter().map(|(transfer, _)| Rc::clone(transfer));
        let cycle = Rc::new(Cycle::new(comm, &self.operators, transfers, coarsest));
        self.cycle = Some(Rc::clone(&cycle));
        cycle
    }

    /// Tells the smoother of a level above the coarsest what to damp. Collective.
    fn damp(&self, comm: &Comm, level: usize) -> Result<()> {
        let mut coupling = [self.operators[level].strongest_pair()];
        comm.max(&mut coupling);
        let high = self.largest[level - 1] * (1.0 + coupling[0]);
        let interval = [DAMPED * high, high];
        if let Some(smoother) = self.smoothers.get(level - 1) {
            smoother.damp(interval)?;
        }
        if let Some(cycle) = &self.cycle {
            let operator = &self.operators[level];
            let all = operator.discretization();
            let mut diagonal = vec![0.0; all.nodes.owned * all.dim];
            operator.diagonal(&mut diagonal);
            cycle.damp(level, interval, &diagonal);
        }
        Ok(())
    }

    /// Takes charge of the smoothers that PETSc made of the levels.
    pub fn take_smoothers(&mut self, smoothers: Vec<Smoother>) {
        self.smoothers = smoothers;
    }

    /// The levels for PETSc, coarsest first.
    pub fn levels(&self) -> Vec<MultigridLevel<'_>> {
        let level = |number: usize| {
            let below = number.checked_sub(1);
            let interpolation = below.map(|below| &self.transfers[below].1);
            let matrix = match (below, &self.coarsest) {
                (None, Coarsest::Assembled(_, matrix)) => Some(matrix),
                (None, _) => None,
                (Some(below), _) => self.matrices.get(below),
            };
            MultigridLevel { matrix, interpolation }
        };
        (0..self.operators.len()).map(level).collect()
    }

    /// Brings the state of all local secondary nodes of the finest level to every level; `finest`
    /// is the matrix of the finest operator. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn set_state(
        &mut self,
        comm: &Comm,
        state: &[NodeState],
        finest: &mut Matrix,
    ) -> Result<()> {
        let mut state = state.to_vec();
        for level in (0..self.operators.len()).rev() {
            self.operators[level].set_state(&state);
            if level + 1 == self.operators.len() {
                // Coarser levels only precondition.
                state.iter_mut().for_each(|state| *state = state.symmetric());
            }
            if level > 0 {
                self.damp(comm, level)?;
            }
            if level == 0 {
                self.set_coarsest(comm, &state)?;
            } else {
                state = self.transfers[level - 1].0.restrict_state(&state);
            }
            if level + 1 == self.operators.len() {
                // With one level the finest matrix is not the one that is eliminated.
                finest.assemble()?;
            } else if level > 0 {
                self.matrices[level - 1].assemble()?;
            }
        }
        Ok(())
    }

    fn set_coarsest(&mut self, comm: &Comm, state: &[NodeState]) -> Result<()> {
        // Most instants of a run that does not soften have the state of the one before.
        if !comm.any(self.state_of_coarsest.as_deref() != Some(state)) {
            return Ok(());
        }
        self.state_of_coarsest = Some(state.to_vec());
        let all = self.operators[0].discretization();
        match &mut self.coarsest {
            Coarsest::None => Err(Error::Bug("a coarsest level that nothing solves".into())),
            Coarsest::Cycles(level) => level.set_up(comm, all, state),
            Coarsest::Assembled(tangent, matrix) => {
                tangent.assemble(comm, all, state, matrix)?;
                matrix.assemble()
            }
        }
    }
}
