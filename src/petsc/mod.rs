//! The fence around PETSc: options, vectors, matrices and the nonlinear solver.
//!
//! Everything here is safe to call. PETSc is built without argument checks, so the wrappers check
//! lengths and ranges themselves. Every object keeps PETSc and MPI alive. Objects of PETSc are
//! created, used and dropped collectively unless a method says that it is local.

mod error;
pub(crate) mod ffi;
mod linear;
mod matrix;
mod multigrid;
mod options;
mod session;
mod shell;
mod snes;
mod solver;
mod vector;

pub use linear::{KspSetup, LinearFailure, LinearReason, LinearTolerance};
pub use matrix::Matrix;
pub use multigrid::{MultigridLevel, Smoother};
pub use options::refused_option;
pub use session::{Petsc, Stage};
pub use shell::{LinearOperator, Preconditioner};
pub use snes::{
    FurtherSolve, NonlinearSystem, Ran, Snes, SnesReason, SolveReport, TangentAt, TangentChange,
    Trial, Verdict,
};
pub use solver::LinearSolver;
pub use vector::{ReadView, Vector, WriteView};
