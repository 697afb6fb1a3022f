//! The tangent in blocks, preconditioned by smoothed aggregation.

use std::cell::RefCell;
use std::rc::Rc;

use crate::aggregation::Aggregation;
use crate::assembly::{Discretization, NodeState, Pattern, Tangent};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::multigrid::CoarsestLevel;
use crate::petsc::{LinearOperator, Matrix, Petsc, Preconditioner};
use crate::solve::model::near_null_space::motions_of_nodes;
use crate::sparse::BlockMatrix;

/// The matrix with what fills it and what preconditions it.
pub struct BlockTangent {
    tangent: Tangent,
    matrix: Rc<Product>,
    cycle: Rc<Cycle>,
    axes: &'static [usize],
    /// Whether elimination has taken the place of the preconditioner.
    is_eliminated: bool,
}

/// The matrix as the solver sees it.
struct Product(RefCell<BlockMatrix>);

impl LinearOperator for Product {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        self.0.borrow().multiply(x, y);
    }

    fn diagonal(&self, d: &mut [f64]) {
        self.0.borrow().diagonal(d);
    }
}

/// The preconditioner, which is there from the first set-up on.
#[derive(Default)]
struct Cycle(RefCell<Option<Aggregation>>);

impl Preconditioner for Cycle {
    fn apply(&self, r: &[f64], z: &mut [f64]) -> Result<()> {
        match &*self.0.borrow() {
            Some(cycle) => cycle.apply(r, z),
            None => Err(Error::Bug("a preconditioner before its set-up".into())),
        }
    }
}

impl BlockTangent {
    /// A tangent of zeros, whose identity rows get `diagonal`. Collective.
    ///
    /// # Errors
    /// `Bug` when an exchange does not fit.
    pub fn new(
        comm: &Comm,
        all: &Discretization,
        axes: &'static [usize],
        diagonal: f64,
    ) -> Result<Self> {
        let pattern = Pattern::new(comm, all);
        let matrix = BlockMatrix::new(comm, all.dim, all.nodes.owned, |node| pattern.row(node))?;
        let matrix = Rc::new(Product(RefCell::new(matrix)));
        let tangent = Tangent::new(all, pattern, diagonal);
        Ok(Self { tangent, matrix, cycle: Rc::default(), axes, is_eliminated: false })
    }

    /// A matrix of PETSc with the entries. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails or memory is short.
    pub fn copy(&self, comm: &Comm, petsc: &Petsc) -> Result<Matrix> {
        let mut copy = self.matrix.0.borrow().empty_copy(petsc)?;
        self.write(comm, &mut copy)?;
        Ok(copy)
    }

    /// Writes the entries into such a matrix. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn write(&self, comm: &Comm, copy: &mut Matrix) -> Result<()> {
        self.matrix.0.borrow().write(comm, copy)
    }

    /// Elimination has taken over: from now on there is no preconditioner to set up. Local.
    pub fn leave_to_elimination(&mut self) {
        self.is_eliminated = true;
        self.cycle.0.replace(None);
    }

    /// The matrix for the solver. Local.
    pub fn operator(&self) -> Rc<dyn LinearOperator> {
        self.matrix.clone()
    }

    /// The preconditioner for the solver. Local.
    pub fn preconditioner(&self) -> Rc<dyn Preconditioner> {
        self.cycle.clone()
    }

    /// Sets the values for a state of every entry of `all.secondary`. Collective.
    ///
    /// # Errors
    /// `Bug` for a value outside the graph; on all ranks.
    pub fn assemble(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        state: &[NodeState],
    ) -> Result<()> {
        self.tangent.assemble(comm, all, state, &mut *self.matrix.0.borrow_mut())
    }
}

impl CoarsestLevel for BlockTangent {
    fn set_up(&mut self, comm: &Comm, all: &Discretization, state: &[NodeState]) -> Result<()> {
        BlockTangent::set_up(self, comm, all, state)
    }

    fn preconditioner(&self) -> Rc<dyn Preconditioner> {
        BlockTangent::preconditioner(self)
    }
}

impl BlockTangent {
    /// Sets up the preconditioner for a state, stiffened where it softens; the values are to be set
    /// afterwards. Collective.
    ///
    /// # Errors
    /// `Bug` when an exchange does not fit.
    pub fn set_up(&mut self, comm: &Comm, all: &Discretization, state: &[NodeState]) -> Result<()> {
        // The old one goes first: there is memory for one.
        self.cycle.0.replace(None);
        if self.is_eliminated {
            return Ok(());
        }
        let state: Vec<_> = state.iter().map(NodeState::stiffened).collect();
        self.assemble(comm, all, &state)?;
        let motions = motions_of_nodes(comm, self.axes, all, &state);
        let cycle = Aggregation::new(comm, &self.matrix.0.borrow(), motions)?;
        tracing::debug!("  aggregation: levels of {:?} nodes", cycle.sizes());
        self.cycle.0.replace(Some(cycle));
        Ok(())
    }
}
