//! Runs whose states come from a smaller model.

use std::time::Instant;

use super::{history, probes};
use crate::case::Case;
use crate::error::{Error, Result};
use crate::reduce::{
    Candidate, Certificate, Prolongation, Snapshot, are_straight, both_could_soften, narrowed,
    prove,
};
use crate::runtime::Runtime;
use crate::solve::{self, Accepted, BoundaryValueProblem, LinearChoice, Model};
use crate::timers::Timers;

/// The solution of a smaller model that serves in the place of the one asked for.
pub struct Reduced {
    prolongation: Prolongation,
    states: Vec<Snapshot>,
    /// The row of the history and what it took, for each instant.
    rows: Vec<(Vec<Option<f64>>, Accepted)>,
    unknowns: u64,
}

/// Solves a smaller model and proves that it serves; the inner error is why it is too small, in
/// words. Every rank solves it by itself, which costs less than to share it. Collective.
///
/// # Errors
/// `Numerics` when there is no such model, smaller or larger; `Stopped` on a signal, `System` when
/// PETSc fails.
pub fn serves(
    runtime: &Runtime,
    timers: &Timers,
    case: &Case,
    asked: &BoundaryValueProblem,
    candidate: &Candidate,
) -> Result<std::result::Result<(Certificate, Reduced), String>> {
    let comm = &runtime.comm;
    let started = Instant::now();
    let narrow = narrowed(case, &asked.sides);
    let solved = instants(&runtime.alone(), timers, &narrow, candidate);
    let (states, rows, unknowns) = comm.agree_alike(solved)?;
    let prolongation = candidate.prolongation();
    let mut reduced = Reduced { prolongation, states, rows, unknowns };
    let solution_seconds = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let bends = candidate.is_straight && !are_straight(candidate, &reduced.states);
    if comm.any(bends) {
        return Ok(Err("the displacements vary across the section".into()));
    }
    let proof = prove(comm, case, asked, &reduced.prolongation, &reduced.states)?;
    let (bound, tolerance) = (proof.error_bound, case.solver.tolerance);
    if bound > tolerance {
        return Ok(Err(format!(
            "without what varies across the section the error could be {bound:.1e} of the solution \
             (solver.tolerance is {tolerance:.1e})"
        )));
    }
    reduced.fill(runtime, case, asked, &proof.reactions);
    let certificate = Certificate {
        error_bound: bound,
        softening: proof.softening,
        kept: candidate.kept,
        unknowns_asked: asked.all.nodes.total * case.dim as u64,
        unknowns_solved: unknowns,
        residuals: proof.residuals,
        solution_seconds,
        proof_seconds: started.elapsed().as_secs_f64(),
    };
    Ok(Ok((certificate, reduced)))
}

type Solved = (Vec<Snapshot>, Vec<(Vec<Option<f64>>, Accepted)>, u64);

/// The states of a smaller model at all instants.
fn instants(
    alone: &Runtime,
    timers: &Timers,
    narrow: &Case,
    candidate: &Candidate,
) -> Result<Solved> {
    let comm = &alone.comm;
    let mesh = candidate.mesh();
    let choice = LinearChoice::new(narrow, &mesh.facts)?;
    let small = BoundaryValueProblem::new(comm, narrow, mesh)?;
    let mut model = solve::build(alone, timers, narrow, choice, small, Vec::new())?;
    let probes = probes::locate(comm, narrow, &model.mesh)?;
    let (mut states, mut rows) = (Vec::new(), Vec::new());
    for time in &narrow.time {
        let accepted = loop {
            if let Some(accepted) = model.stepper.advance(*time)? {
                break accepted;
            }
        };
        rows.push((history::row(narrow, &model, &probes, *time, &accepted, comm), accepted));
        states.push(Snapshot::of(&model));
    }
    let stepper = &model.stepper;
    let found = [stepper.instabilities_in_words(), stepper.bifurcations_in_words()].concat();
    if let Some(first) = found.into_iter().next() {
        let softened = softened(narrow, &model);
        return Err(Error::Numerics(match &softened[..] {
            [first, second, ..] => both_could_soften(first, second),
            _ => first,
        }));
    }
    Ok((states, rows, model.unknowns))
}

/// The names of the interfaces that are damaged at the end.
fn softened(case: &Case, model: &Model<'_>) -> Vec<String> {
    let (all, state) = (&model.stepper.problem.all, &model.stepper.problem.interfaces);
    let mut names = Vec::new();
    for (number, interface) in case.interfaces.iter().enumerate() {
        let nodes = all.secondary.iter().zip(&state.committed);
        let mut own = nodes.filter(|(rows, _)| rows.interface == number);
        if own.any(|(_, history)| interface.law.law().damage(*history) > 0.0) {
            names.push(interface.name.clone());
        }
    }
    names
}

impl Reduced {
    /// Why the model asked for has no linear solver, in words.
    pub fn why_no_solver(&self) -> String {
        format!("the {} unknowns of the smaller model are eliminated", self.unknowns)
    }

    /// Completes the rows of the history by what vanishes where the smaller model has no node, and
    /// by the reactions, the forces in the interfaces and their areas of the nodes of the model
    /// asked for. Collective.
    fn fill(
        &mut self,
        runtime: &Runtime,
        case: &Case,
        asked: &BoundaryValueProblem,
        reactions: &[Vec<[f64; 3]>],
    ) {
        let all = &asked.all;
        let mut has = vec![0.0; 3 * case.interfaces.len()];
        for rows in &all.secondary[..all.owned_secondary()] {
            for c in (0..case.dim).filter(|c| rows.rows[*c].is_some()) {
                has[3 * rows.interface + c] = 1.0;
            }
        }
        runtime.comm.max(&mut has);
        let mut totals = Vec::with_capacity(self.states.len());
        for state in &self.states {
            let traction = |index: usize| self.traction(state, all.name_and_interface(index).0);
            totals.push(history::totals(case, all, traction));
        }
        let mut flat: Vec<f64> = totals.concat().concat();
        runtime.comm.sum(&mut flat);
        let per_state = case.interfaces.len();
        let sums = flat.as_chunks::<4>().0;
        for (number, ((row, _), reactions)) in self.rows.iter_mut().zip(reactions).enumerate() {
            let totals = &sums[number * per_state..][..per_state];
            history::fill(case, row, |interface, c| has[3 * interface + c] > 0.0, totals);
            history::put_reactions(case, row, reactions);
        }
    }

    /// The traction that the states give a secondary node of the model asked for (Pa). Local.
    fn traction(&self, state: &Snapshot, name: u64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        self.prolongation.parents(name, |parent, weight| {
            if let Some(parent) = &state.interface[parent] {
                let own = parent.response.bulk_traction;
                (0..3).for_each(|c| sum[c] += weight * own[c]);
            }
        });
        sum
    }

    /// What took the state of an instant, by its place in the list, and its row of the history.
    /// Local.
    pub fn instant(&self, number: usize) -> (Accepted, Vec<Option<f64>>) {
        let (row, accepted) = &self.rows[number];
        (*accepted, row.clone())
    }

    /// Gives the fields of `model` the values of an instant. Local.
    pub fn show(&self, model: &mut Model<'_>, number: usize) {
        let state = &self.states[number];
        let problem = &mut model.stepper.problem;
        let all = &problem.all;
        problem.displacement = self.prolongation.apply(&all.nodes.names, &state.displacement);
        for (index, response) in problem.interfaces.response.iter_mut().enumerate() {
            let rows = &all.secondary[index];
            let name = all.nodes.names[rows.node as usize];
            let mut heaviest = 0.0;
            self.prolongation.parents(name, |parent, weight| {
                let Some(parent) = state.interface[parent].filter(|_| weight > heaviest) else {
                    return;
                };
                (heaviest, *response) = (weight, parent.response);
            });
            response.bulk_traction = self.traction(state, name);
        }
    }

    /// Makes the state of an instant the accepted one of `model`, so that a checkpoint can be
    /// written. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn adopt(&self, model: &mut Model<'_>, number: usize) -> Result<()> {
        if let Some(before) = number.checked_sub(1) {
            let state = &self.states[before];
            let problem = &mut model.stepper.problem;
            for index in 0..problem.interfaces.committed.len() {
                let node = problem.all.secondary[index].node as usize;
                let name = problem.all.nodes.names[node];
                let mut heaviest = 0.0;
                self.prolongation.parents(name, |parent, weight| {
                    let Some(parent) = state.interface[parent].filter(|_| weight > heaviest) else {
                        return;
                    };
                    heaviest = weight;
                    problem.interfaces.committed[index] = parent.response.history;
                    problem.interfaces.dissipated[index] = parent.dissipated;
                });
            }
        }
        let (accepted, state) = (&self.rows[number].1, &self.states[number]);
        let nodes = &model.stepper.problem.all.nodes;
        let u = self.prolongation.apply(&nodes.names[..nodes.owned], &state.displacement);
        model.stepper.adopt(state.time, &u, accepted)
    }
}
