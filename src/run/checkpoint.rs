//! When a run writes checkpoints, and how it goes on from one.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::run_state::{FORMAT, LONGEST_CASE, RunState, parse};
use super::same_model::{difference, digest};
use crate::case::{Case, Every};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::fault;
use crate::output::checkpoint::{Checkpoint, NEWEST, Opened, candidates, write};
use crate::output::finite::refused;
use crate::output::history::Table;
use crate::output::publisher::Publisher;
use crate::output::series;
use crate::signals;
use crate::solve::{Model, State};

/// Checkpoints that nobody has asked for come at most once in so many times what one takes.
const SELDOM: u32 = 20;

/// The word for the newest checkpoint of the output directory.
const LATEST: &str = "latest";

/// What a run has done, beside its solution.
pub struct Progress<'p> {
    pub accepted: usize,
    pub counts: [u64; 2],
    pub residual_norms: &'p [f64],
    /// On rank 0.
    pub history: Option<&'p Table>,
    pub fields: &'p [series::Instant],
}

/// Decides when a checkpoint is due, and writes it.
pub struct Keeper {
    every: Every,
    last: Instant,
    instants: usize,
    /// Time of the state that was written last (s).
    written: Option<f64>,
    /// How long that took.
    cost: Duration,
}

impl Keeper {
    /// The first one is due `every` from now on.
    pub fn new(every: Every) -> Self {
        let (last, cost) = (Instant::now(), Duration::ZERO);
        Self { every, last, instants: 0, written: None, cost }
    }

    /// Takes note of an instant; whether a checkpoint is due. Collective.
    pub fn is_due(&mut self, comm: &Comm) -> bool {
        self.instants += 1;
        let asked = signals::checkpoint(comm);
        asked
            || match self.every {
                Every::Instants(count) => self.instants >= count,
                Every::Seconds(seconds) => {
                    comm.any(self.last.elapsed() >= Duration::from_secs_f64(seconds))
                }
            }
    }

    /// Whether a checkpoint may be too late when it is asked for, and takes little of the time
    /// since the last one. Collective.
    pub fn is_worth_it(&self, comm: &Comm) -> bool {
        comm.any(signals::is_hurried() && self.last.elapsed() >= SELDOM * self.cost)
    }

    /// Writes the last accepted state. Collective.
    ///
    /// # Errors
    /// `System` with the path and the reason; `Numerics` when a number of the state is not finite.
    pub fn write(
        &mut self,
        comm: &Comm,
        publisher: &mut Publisher,
        directory: &Path,
        case: &Case,
        model: &Model<'_>,
        progress: &Progress<'_>,
    ) -> Result<()> {
        let started = Instant::now();
        let all = &model.stepper.problem.all;
        let mut state = model.stepper.state()?;
        fault::strike_values(comm, "state", &mut state.nodal.values)?;
        comm.agree(check(&state, progress, model, &directory.join(NEWEST)))?;
        let bug = |cause: serde_json::Error| Error::Bug(format!("checkpoint: {cause}"));
        let run = RunState {
            format: FORMAT,
            program: format!("column-hpc {}", env!("CARGO_PKG_VERSION")),
            case: serde_json::value::to_raw_value(&case.resolved()).map_err(bug)?,
            nodes: all.nodes.total,
            secondary: comm.sum_u64(all.owned_secondary() as u64),
            mesh: digest(case, model),
            stage: model.stepper.stage,
            step: state.step,
            accepted: progress.accepted,
            counts: progress.counts,
            residual_norms: progress.residual_norms.to_vec(),
            history: progress.history.cloned().unwrap_or_default(),
            fields: progress.fields.to_vec(),
        };
        // Only the root has the history.
        let text = comm.on_root(|| serde_json::to_vec(&run).map_err(bug))?;
        let meta = String::from_utf8_lossy(&text);
        let fields = Checkpoint { meta: &meta, nodal: &state.nodal, interface: &state.interface };
        write(comm, publisher, directory, all.nodes.total, &fields)?;
        (self.last, self.instants, self.cost) = (Instant::now(), 0, started.elapsed());
        self.written = Some(run.step.time);
        Ok(())
    }

    /// Whether the state accepted at `time` has been written. Local.
    pub fn is_current(&self, time: f64) -> bool {
        self.written == Some(time)
    }
}

/// Refuses a state that is not finite somewhere. Local.
fn check(state: &State, progress: &Progress<'_>, model: &Model<'_>, file: &Path) -> Result<()> {
    let when = format!("at time {}", state.step.time);
    if let Some((what, node, value)) = state.first_not_finite() {
        let nodes = &model.stepper.problem.all.nodes;
        let point = nodes.local(node).map_or([f64::NAN; 3], |node| nodes.points[node as usize]);
        let [x, y, z] = point;
        return Err(refused(what, value, &format!("at ({x}, {y}, {z}) m {when}"), file));
    }
    let step = &state.step;
    let fluid: [f64; 7] = step.fluid.into();
    let mut numbers = [
        ("energy", &step.energy[..]),
        ("largest force or displacement", &step.scales),
        ("balance of the fluid", &fluid),
    ]
    .into_iter()
    .chain([("residual_norms", progress.residual_norms)])
    .chain([("residual_norms", std::slice::from_ref(&step.residual_norm))])
    .flat_map(|(what, values)| values.iter().map(move |value| (what, *value)));
    match numbers.find(|(_, value)| !value.is_finite()) {
        Some((what, value)) => Err(refused(what, value, &when, file)),
        None => Ok(()),
    }
}

/// A checkpoint that a run goes on from.
pub struct Restart {
    path: PathBuf,
    /// Those to fall back to.
    older: Vec<PathBuf>,
    opened: Opened,
    /// What it holds beside fields.
    pub state: RunState,
}

impl Restart {
    /// Opens the checkpoint that `--restart` names. Collective.
    ///
    /// # Errors
    /// `Input` when there is none, none is whole, or the case differs in more than how it is solved
    /// and what is written.
    pub fn open(comm: &Comm, word: &str, directory: &Path, case: &Case) -> Result<Self> {
        let mut found = if word == LATEST {
            let list = if comm.is_root() { candidates(directory) } else { Ok(Vec::new()) };
            let list = comm.agree(list)?;
            let text = |path: &PathBuf| path.to_string_lossy().into_owned();
            let names: Vec<String> = list.iter().map(text).collect();
            let names = comm.broadcast_bytes(names.join("\n").into_bytes());
            String::from_utf8_lossy(&names).lines().map(PathBuf::from).collect()
        } else {
            vec![PathBuf::from(word)]
        };
        found.reverse();
        Self::next(comm, found, case)
    }

    /// The last of `found` that is whole; it has to be of the case.
    fn next(comm: &Comm, mut found: Vec<PathBuf>, case: &Case) -> Result<Self> {
        loop {
            let Some(path) = found.pop() else {
                return Err(Error::Bug("a restart without a file".into()));
            };
            let opened = Opened::new(comm, &path, longest_description(case)).and_then(|opened| {
                let state = parse(&path, &opened.meta)?;
                Ok((opened, state))
            });
            match opened {
                Ok((opened, state)) => match difference(&state, case) {
                    None => return Ok(Self { path, older: found, opened, state }),
                    Some(words) => {
                        let file = path.display();
                        return Err(Error::Input(format!("cannot go on from {file}: {words}")));
                    }
                },
                Err(error) if found.is_empty() || matches!(error, Error::System(_)) => {
                    return Err(error);
                }
                Err(error) => tracing::warn!("warning: {error}; the checkpoint before it is taken"),
            }
        }
    }

    /// Makes the state that of `model`; falls back to an older checkpoint where fields are damaged.
    /// Collective.
    ///
    /// # Errors
    /// `Input` when none has whole fields of this mesh.
    pub fn resume(self, comm: &Comm, case: &Case, model: &mut Model<'_>) -> Result<RunState> {
        let Self { path, older, opened, state } = self;
        if let (Some(file), Some(before)) = (case.mesh.file(), &state.mesh)
            && Some(before) != digest(case, model).as_ref()
        {
            return Err(Error::Input(format!(
                "cannot go on from {}: it is of another mesh than {} holds now: points, cells or \
                 groups differ; a run goes on with the same model only",
                path.display(),
                file.path.display()
            )));
        }
        let all = &model.stepper.problem.all;
        let secondary = comm.sum_u64(all.owned_secondary() as u64);
        let fields = if (state.nodes, state.secondary) == (all.nodes.total, secondary) {
            let widths = [model.stepper.nodal_width(), model.stepper.interface_width()];
            opened.fields(comm, all.nodes.total, secondary, widths)
        } else {
            Err(Error::Input(format!(
                "cannot go on from {}: it is of a mesh with {} nodes, {} on interfaces, not {} and {}",
                path.display(),
                state.nodes,
                state.secondary,
                all.nodes.total,
                secondary
            )))
        };
        match fields {
            Ok([nodal, interface]) => {
                model.resume(case, state.step.clone(), &nodal, &interface)?;
                tracing::info!(
                    "restart    from {} at time {}, written by {}",
                    path.display(),
                    state.step.time,
                    state.program
                );
                Ok(state)
            }
            Err(error) if older.is_empty() => Err(error),
            Err(error) => {
                let next = Self::next(comm, older, case)?;
                if next.state.stage != model.stepper.stage {
                    let file = next.path.display();
                    return Err(Error::Input(format!(
                        "{error}; the one before it is of an earlier stage: go on from it with \
                         --restart {file}"
                    )));
                }
                tracing::warn!("warning: {error}; the checkpoint before it is taken");
                next.resume(comm, case, model)
            }
        }
    }
}

/// More than the description of a checkpoint of a case has (bytes), so that another file is refused
/// before it is read.
fn longest_description(case: &Case) -> usize {
    // Numbers are written with up to 24 characters, and states that are not stable in a few lines.
    let rows = case.time.len() * (4096 + 32 * case.columns().len());
    2 * LONGEST_CASE + rows
}
