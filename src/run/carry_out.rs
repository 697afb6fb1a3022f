//! A case from its start to its report, with or without an output directory.

use std::path::Path;
use std::time::{Duration, Instant};

use super::checkpoint::Restart;
use super::session::{Ended, Session};
use super::solution::Solution;
use super::{resources, screen};
use crate::case::{Case, Side};
use crate::error::{Error, Result};
use crate::interface::Sides;
use crate::mesh::{Lip, MeshFamily};
use crate::output::directory::OutputDirectory;
use crate::output::lock::Lock;
use crate::partition::{self, Import, Method};
use crate::reduce::Situation;
use crate::runtime::Runtime;
use crate::solve::model::held_bodies;
use crate::solve::{self, BoundaryValueProblem, Handover, LinearChoice, MULTIGRID, Model};
use crate::timers::{Phase, Timers};
use crate::{fault, signals};

/// A mesh of fewer cells per rank is not worth a level, and too few for an even partition.
const COARSEST_CELLS: u64 = 64;

/// What the checkpoint and the end of a run may take of its wall-clock time (s).
const RESERVE: f64 = 2.0;

/// Where a run writes, and how.
#[derive(Debug, Clone, Copy)]
pub struct Output<'a> {
    /// The output directory.
    pub directory: &'a Path,
    /// Whether results of another case are replaced.
    pub overwrite: bool,
    /// The checkpoint to go on from: a file, or `latest`.
    pub restart: Option<&'a str>,
    /// Whether a page with charts is written.
    pub page: bool,
}

/// Runs a case, the same on all ranks; without `output` nothing is written. The wall-clock time of
/// the case counts from `started`. Collective.
///
/// # Errors
/// What is wrong with the input, the numerics or the machine; the same on all ranks.
pub fn carry_out(
    runtime: &Runtime,
    timers: &Timers,
    case: &Case,
    started: Instant,
    output: Option<Output<'_>>,
) -> Result<Ended> {
    let comm = &runtime.comm;
    let most = |seconds: f64| Duration::from_secs_f64((seconds - RESERVE).max(0.0));
    signals::stop_at(case.wall.map(|seconds| started + most(seconds)));
    runtime.petsc.options_of_case(&case.solver.petsc_options)?;
    let resolved = case.resolved().to_string();
    let _lock = output.map(|output| Lock::take(comm, output.directory)).transpose()?;
    let family = {
        let _phase = timers.enter(Phase::Mesh);
        let ways = (Import::from_environment(), Method::from_environment());
        partition::family(comm, case, ways, solve::family, solve::divides)?
    };
    // The mesh of a file tells its dimension.
    let case = &comm.agree(case.clone().for_dimension(family.facts().dim))?;
    family.remarks.iter().for_each(|words| tracing::info!("mesh       {words}"));
    let of_mesh: Vec<String> =
        family.remarks.iter().map(|words| format!("mesh: {words}")).collect();
    let restart = match output {
        Some(Output { directory, restart: Some(word), .. }) => {
            Some(Restart::open(comm, word, directory, case)?)
        }
        Some(Output { directory, overwrite, .. }) => {
            OutputDirectory::examine(comm, directory, &resolved, overwrite)?;
            None
        }
        None => None,
    };

    let place = output.map(|output| output.directory);
    let cases = cases_of_stages(case, &family);
    let first = restart.as_ref().map_or(0, |restart| restart.state.stage);
    let way = Way { runtime, timers, place, has_stages: cases.len() > 1 };
    let (mut model, solution) = way.build(&cases[first], family, restart.is_some())?;
    model.stepper.stage = first;
    let state = restart.map(|restart| restart.resume(comm, case, &mut model)).transpose()?;
    let directory = match (output, &state) {
        (Some(Output { directory, .. }), Some(state)) => {
            let last = state.fields.last().map_or(0, |instant| instant.step);
            Some(OutputDirectory::resume(comm, directory, &resolved, last)?)
        }
        (Some(Output { directory, overwrite, .. }), None) => {
            Some(OutputDirectory::open(comm, directory, &resolved, overwrite)?)
        }
        (None, _) => None,
    };
    screen::describe(comm, case, &model, solution.reduction());
    model.stepper.remarks.splice(..0, of_mesh);
    let session = Session::new(comm, timers, case, directory, state, solution);
    way.through_stages(case, &cases, model, session, output.is_some_and(|output| output.page))
}

/// The case of each stage, all with the same sides of interfaces, whatever their materials.
fn cases_of_stages(case: &Case, family: &MeshFamily) -> Vec<Case> {
    let stages = case.in_stages();
    let sides = Sides::choose(stages[0], &family.facts());
    let with_sides = |stage: &Case| {
        let mut own = stage.clone();
        for (interface, side) in own.interfaces.iter_mut().zip(&sides) {
            interface.secondary = Some(match side.secondary {
                Lip::Lower => Side::Lower,
                Lip::Upper => Side::Upper,
            });
        }
        own
    };
    if case.stages.is_empty() {
        return vec![case.clone()];
    }
    stages.into_iter().map(with_sides).collect()
}

/// How the models of a run are made.
#[derive(Clone, Copy)]
struct Way<'w> {
    runtime: &'w Runtime,
    timers: &'w Timers,
    /// The output directory.
    place: Option<&'w Path>,
    has_stages: bool,
}

impl<'w> Way<'w> {
    /// Goes through the stages that are left, from that of `model` on. Collective.
    fn through_stages(
        &self,
        case: &Case,
        cases: &'w [Case],
        mut model: Model<'w>,
        mut session: Session<'_>,
        wants_page: bool,
    ) -> Result<Ended> {
        loop {
            let number = model.stepper.stage;
            let until = cases[number].time.last().copied().unwrap_or(case.start);
            let end = case.time.partition_point(|time| *time <= until);
            let solved = session.solve(&mut model, end);
            let next = number + 1;
            if solved.is_err() || next == cases.len() {
                return session.close(self.runtime, &model, solved, wants_page);
            }
            let handed = model.stepper.hand_over();
            drop(model);
            match handed.and_then(|handed| self.next(case, &cases[next], next, handed)) {
                Ok((begun, solution)) => {
                    model = begun;
                    session.enter(solution);
                }
                Err(error) => return Err(session.leave(error)),
            }
        }
    }

    /// The model of the stage of a `number`, with its `own` case, in the state that the one before
    /// has left. Collective.
    fn next(
        &self,
        case: &Case,
        own: &'w Case,
        number: usize,
        handed: Handover,
    ) -> Result<(Model<'w>, Solution)> {
        let comm = &self.runtime.comm;
        let begun = || -> Result<(Model<'w>, Solution)> {
            let family = {
                let _phase = self.timers.enter(Phase::Mesh);
                let ways = (Import::from_environment(), Method::from_environment());
                partition::family(comm, own, ways, solve::family, solve::divides)?
            };
            let (mut model, solution) = self.build(own, family, true)?;
            model.stepper.stage = number;
            let _phase = self.timers.enter(Phase::Assembly);
            model.take_over(case, handed)?;
            Ok((model, solution))
        };
        let (from, until) = (own.start, case.stages[number].until);
        tracing::info!("stage      {} from {from} to {until}", number + 1);
        begun().map_err(|error| match error {
            Error::Input(text) => Error::Input(format!("stages.{number}: {text}")),
            other => other,
        })
    }

    /// The model that was asked for, and where its states come from. Collective.
    fn build(
        &self,
        case: &'w Case,
        mut family: MeshFamily,
        goes_on: bool,
    ) -> Result<(Model<'w>, Solution)> {
        let Self { runtime, timers, place, has_stages } = *self;
        let comm = &runtime.comm;
        fault::strike(comm, "mesh")?;
        let facts = family.facts();
        let mut choice = LinearChoice::new(case, &facts)?;
        let fewest = COARSEST_CELLS * comm.size() as u64;
        if choice.preset == MULTIGRID && !family.coarsen(fewest) {
            choice = choice.without_levels(case, &facts);
        }
        if choice.preset != MULTIGRID {
            family.leave_finest();
        }
        resources::check(comm, case, &facts, &choice, place)?;
        let mut meshes = {
            let _phase = timers.enter(Phase::Partition);
            partition::share_out(comm, family, Method::from_environment())?
        };
        fault::strike(comm, "distribute")?;
        let phase = timers.enter(Phase::Assembly);
        let finest = meshes.pop().ok_or_else(|| Error::Bug("no mesh".into()))?;
        let problem = BoundaryValueProblem::new(comm, case, finest)?;
        held_bodies::check(comm, case, &problem)?;
        drop(phase);
        let has_options = runtime.petsc.has_options();
        let unknowns = problem.all.nodes.total * case.dim as u64;
        let situation = Situation { unknowns, goes_on, has_options, has_stages };
        let solution = Solution::choose(runtime, timers, case, &problem, situation)?;
        if case.search.needs_smaller && solution.is_asked() {
            return Err(Error::Numerics(solution.reduction().why.clone()));
        }
        let _phase = timers.enter(Phase::Assembly);
        let choice = solution.linear_choice(choice);
        let model = solve::build(runtime, timers, case, choice, problem, meshes)?;
        Ok((model, solution))
    }
}
