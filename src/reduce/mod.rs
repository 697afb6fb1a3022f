//! A smaller model in the place of the one asked for, and the proof that nothing is lost by it
//! (docs/theory.md, section 8).
//!
//! The smaller model is solved, its states are prolonged to the mesh that was asked for, and the
//! residual of the model asked for is evaluated there. A bound of the error follows from it, and a
//! bound of the stiffness shows that nothing that was left out becomes unstable. Where a bound is
//! too large or not known, the model that was asked for is solved.

mod bound;
mod certificate;
mod forces;
mod lips;
mod narrow;
mod prolongation;
mod refusal;

use serde::Serialize;

pub use certificate::{Proof, prove};
pub use forces::are_straight;
pub use narrow::{Candidate, candidates, candidates_in, narrowed};
pub use prolongation::Prolongation;
pub use refusal::{Situation, both_could_soften, refusal};

use crate::solve::{Model, NodeResponse};

/// Why a mesh has no smaller model that is worth the while, in words.
pub const NONE_OF_USE: &str = "no smaller model is of use";

/// What became of the wish for a smaller model; part of `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reduction {
    /// Whether a smaller model was solved.
    pub applied: bool,
    /// What was left out, or why nothing could be, in words.
    pub why: String,
    /// The numbers of the proof.
    #[serde(flatten)]
    pub certificate: Option<Certificate>,
}

/// The proof that a smaller model serves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Certificate {
    /// Largest error of the displacements in the energy norm at any instant, over the largest
    /// energy norm of the displacements: a bound.
    pub error_bound: f64,
    /// What the softening interface takes of the stiffness that the column holds against it, at
    /// most: below 1 no mode can become unstable.
    pub softening: f64,
    /// Along which axes it has the cells of the model asked for.
    pub kept: [bool; 3],
    /// Unknowns of the model asked for.
    pub unknowns_asked: u64,
    /// Unknowns of the model that was solved.
    pub unknowns_solved: u64,
    /// Evaluations of the residual of the model asked for.
    pub residuals: usize,
    /// Wall-clock time of the solution (s).
    pub solution_seconds: f64,
    /// Wall-clock time of the proof (s).
    pub proof_seconds: f64,
}

impl Reduction {
    /// Nothing was left out, for a reason in words.
    pub fn none(why: String) -> Self {
        Self { applied: false, why, certificate: None }
    }

    /// What was done, for the screen.
    pub fn words(&self) -> String {
        let Some(c) = &self.certificate else { return format!("no: {}", self.why) };
        format!(
            "{}; {} of {} unknowns, error at most {:.1e}, shown by {} residual{}",
            self.why,
            c.unknowns_solved,
            c.unknowns_asked,
            c.error_bound,
            c.residuals,
            if c.residuals == 1 { "" } else { "s" }
        )
    }
}

/// An accepted state of the smaller model, by the names of its nodes.
pub struct Snapshot {
    /// Its time (s).
    pub time: f64,
    /// Displacement by component (m).
    pub displacement: Vec<[f64; 3]>,
    /// Of the secondary nodes.
    pub interface: Vec<Option<InterfaceSnapshot>>,
}

/// The state of a secondary node.
#[derive(Debug, Clone, Copy)]
pub struct InterfaceSnapshot {
    /// What its law answered.
    pub response: NodeResponse,
    /// Energy per area dissipated so far (J/m2).
    pub dissipated: f64,
}

impl Snapshot {
    /// The state that `model` has accepted, which one rank holds as a whole. Local.
    pub fn of(model: &Model<'_>) -> Self {
        let problem = &model.stepper.problem;
        let (all, dim) = (&problem.all, problem.all.dim);
        let mut displacement = vec![[0.0; 3]; all.nodes.len()];
        for (name, u) in all.nodes.names.iter().zip(problem.displacement.chunks_exact(dim)) {
            displacement[*name as usize][..dim].copy_from_slice(u);
        }
        let mut interface = vec![None; all.nodes.len()];
        let state = &problem.interfaces;
        for (index, rows) in all.secondary.iter().enumerate() {
            let (response, dissipated) = (state.response[index], state.dissipated[index]);
            let name = all.nodes.names[rows.node as usize] as usize;
            interface[name] = Some(InterfaceSnapshot { response, dissipated });
        }
        Self { time: model.stepper.time(), displacement, interface }
    }
}
