//! One mesh after the other, solved from the start to the end.

use std::time::Instant;

use tracing::subscriber::{NoSubscriber, with_default};

use super::plan::{Family, Plan};
use crate::case::Case;
use crate::case::sections::{AccuracyInstants, AccuracySection, AccuracyWord};
use crate::error::{Error, Result};
use crate::output::history::Table;
use crate::report::Report;
use crate::run::carry_out::{Output, carry_out};
use crate::run::session::Ended;
use crate::runtime::Runtime;
use crate::timers::Timers;

/// A mesh that was tried.
pub struct Tried {
    /// What it is made of.
    pub plan: Plan,
    /// What it was tried for.
    pub purpose: String,
    /// The quantities at the instants, quantity by quantity; none where it was not solved.
    pub values: Option<Vec<f64>>,
    /// The largest size of anything of the same kind, for each of them.
    pub scales: Vec<f64>,
    /// Its unknowns.
    pub unknowns: u64,
    /// Wall-clock time in s times ranks.
    pub core_seconds: f64,
    /// Whether something made its states doubtful: no resolution, no stability, no uniqueness.
    pub is_doubtful: bool,
    /// Where a smaller model gave the states: along which axes it had the cells of the mesh, and
    /// the bound of its error over the solution.
    pub reduced: Option<([bool; 3], f64)>,
}

/// Solves meshes, each once.
pub struct Trials<'r> {
    runtime: &'r Runtime,
    /// The meshes.
    pub family: &'r Family<'r>,
    started: Instant,
    /// The wanted columns of the history.
    of: Vec<String>,
    /// The wanted instants (s).
    at: Vec<f64>,
    /// In their order.
    pub tried: Vec<Tried>,
}

impl<'r> Trials<'r> {
    /// None yet.
    pub fn new(
        runtime: &'r Runtime,
        family: &'r Family<'r>,
        case: &Case,
        wanted: &AccuracySection,
        started: Instant,
    ) -> Self {
        let at = match &wanted.at {
            AccuracyInstants::Word(AccuracyWord::All) => case.time.clone(),
            AccuracyInstants::Word(AccuracyWord::Last) => {
                case.time.last().copied().into_iter().collect()
            }
            AccuracyInstants::Times(times) => times.clone(),
        };
        Self { runtime, family, started, of: wanted.of.clone(), at, tried: Vec::new() }
    }

    /// What is wanted, quantity by quantity: its column and its instant.
    pub fn wanted(&self) -> Vec<(&str, f64)> {
        self.of.iter().flat_map(|of| self.at.iter().map(|at| (of.as_str(), *at))).collect()
    }

    /// How many instants are wanted.
    pub fn instants(&self) -> usize {
        self.at.len()
    }

    /// Whether steps can be halved: those of a path of dissipation are the instants.
    pub fn has_steps(&self) -> bool {
        self.family.has_steps()
    }

    /// The place among those tried of a mesh that is solved now, if it has not been. Collective.
    ///
    /// # Errors
    /// All but that a mesh cannot be solved.
    pub fn solve(&mut self, plan: Plan, purpose: &str) -> Result<usize> {
        if let Some(place) = self.tried.iter().position(|tried| tried.plan == plan) {
            return Ok(place);
        }
        match self.run(plan, purpose, None) {
            Ok(_) => {}
            Err(Error::Numerics(_)) => self.tried.push(Tried {
                plan,
                purpose: purpose.to_owned(),
                values: None,
                scales: Vec::new(),
                unknowns: 0,
                core_seconds: 0.0,
                is_doubtful: true,
                reduced: None,
            }),
            Err(error) => return Err(error),
        }
        Ok(self.tried.len() - 1)
    }

    /// Solves a mesh, and writes its results where they are wanted. Collective.
    ///
    /// # Errors
    /// As those of a run.
    pub fn run(&mut self, plan: Plan, purpose: &str, output: Option<Output<'_>>) -> Result<Ended> {
        let comm = &self.runtime.comm;
        let (case, timers, started) = (self.family.case(&plan), Timers::new(), Instant::now());
        let silent = NoSubscriber::default();
        let ended =
            with_default(silent, || carry_out(self.runtime, &timers, &case, self.started, output))?;
        let mut seconds = [started.elapsed().as_secs_f64()];
        comm.max(&mut seconds);
        let mut told = [0.0; 7];
        let count = self.of.len() * self.at.len();
        let mut values = vec![0.0; 2 * count];
        if let Some((report, history)) = &ended.told {
            told = summary(report);
            values = self.values(history);
        }
        let known: Vec<u8> = told.iter().chain(&values).flat_map(|x| x.to_le_bytes()).collect();
        let known = comm.broadcast_bytes(known);
        let known: Vec<f64> =
            known.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let is_kept = [1, 2, 3].map(|axis| known[axis] > 0.0);
        self.tried.push(Tried {
            plan,
            purpose: purpose.to_owned(),
            values: Some(known[told.len()..][..count].to_vec()),
            scales: known[told.len() + count..].to_vec(),
            unknowns: known[0] as u64,
            core_seconds: seconds[0] * f64::from(comm.size()),
            is_doubtful: known[6] > 0.0,
            reduced: (known[4] > 0.0).then_some((is_kept, known[5])),
        });
        Ok(ended)
    }

    /// What is wanted out of a history, 0 where there is no value; then the largest size of
    /// anything of the same kind. Local.
    fn values(&self, history: &Table) -> Vec<f64> {
        let time = history.column("time");
        let value = |(of, at): (&str, f64)| {
            let row = history.rows.iter().rfind(|row| time.and_then(|time| row[time]) == Some(at));
            row.and_then(|row| row[history.column(of)?]).unwrap_or(0.0)
        };
        let scale = |(of, _): (&str, f64)| {
            let alike =
                (0..history.columns.len()).filter(|c| kind(&history.columns[*c]) == kind(of));
            let sizes = alike.flat_map(|c| history.rows.iter().filter_map(move |row| row[c]));
            sizes.fold(0.0_f64, |most, size| most.max(size.abs()))
        };
        let wanted = self.wanted();
        let scales: Vec<f64> = wanted.iter().map(|of| scale(*of)).collect();
        wanted.into_iter().map(value).chain(scales).collect()
    }
}

/// What a column has in common with those that it may be held against: tractions with tractions.
fn kind(column: &str) -> &str {
    const KINDS: [&str; 13] = [
        "traction",
        "jump",
        "sliding",
        "slip",
        "damage",
        "pressure",
        "force",
        "flux",
        "reaction",
        "moment",
        "displacement",
        "rotation",
        "energy",
    ];
    let found = KINDS.into_iter().find(|kind| column.contains(kind));
    match found {
        Some("sliding" | "slip") => "jump",
        Some("force") => "reaction",
        Some(kind) => kind,
        None => column,
    }
}

/// Unknowns, the axes along which a smaller model kept the cells, whether there is one, the bound
/// of its error, and whether the states are doubtful.
fn summary(report: &Report) -> [f64; 7] {
    let of = report.reduction.certificate.as_ref().filter(|_| report.reduction.applied);
    let kept = of.map_or([true; 3], |certificate| certificate.kept).map(f64::from);
    let unknowns = of.map_or(report.unknowns, |certificate| certificate.unknowns_solved);
    let is_doubtful = report.has_doubts();
    let (has, bound) = (f64::from(of.is_some()), of.map_or(0.0, |of| of.error_bound));
    [unknowns as f64, kept[0], kept[1], kept[2], has, bound, f64::from(is_doubtful)]
}
