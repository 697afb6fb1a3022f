//! The mesh, the steps and the tolerance that give wanted results as exactly as wanted, at little
//! cost (docs/accuracy.md).
//!
//! The whole case is solved on meshes that follow from each other, so that the errors of early
//! instants count in late ones. On each of them the cells are made coarser, not finer, along one
//! axis at a time: that costs a half and a quarter of the mesh instead of its double, and the
//! answer is that of the finest mesh which was paid for.

mod errors;
mod estimate;
mod plan;
mod tell;
mod trial;

use std::time::Instant;

use crate::case::Case;
use crate::case::sections::AccuracySection;
use crate::error::{Error, Result};
use crate::run::carry_out::Output;
use crate::run::session::Ended;
use crate::runtime::Runtime;
use errors::{Beside, Errors, allowed, beside, of_cells};
use plan::{Family, Plan};
use trial::Trials;

/// What the cells along each axis are to leave of what is asked, before it is shared among them.
const SHARE_OF_CELLS: f64 = 0.7;

/// Errors that fall at less than this part of the order that smooth solutions have come from edges
/// and corners, towards which cells are graded.
const SMOOTH: f64 = 0.75;

/// Most growth of the cells: their ratio is then the square of the cells from an end to the middle.
const MOST_GROWTH: u32 = 2;

/// Cells that grow cost several times as much by unknown in 3D, where multigrid takes more
/// iterations: they are worth it where even ones would have to be halved more often than this, in
/// 2D and in 3D.
const FEW_HALVINGS: [f64; 2] = [0.0, 2.0];

/// Growth of an exponent of the unknowns with which costs grow.
const COST: f64 = 1.3;

/// Most meshes at the start that cannot be solved.
const MOST_FAILURES: usize = 2;

/// Most meshes whose results are taken.
const MOST_ROUNDS: usize = 16;

/// Solves a case as exactly as it says. Collective.
///
/// # Errors
/// As those of a run.
pub fn search(
    runtime: &Runtime,
    case: &Case,
    wanted: &AccuracySection,
    started: Instant,
    output: Option<Output<'_>>,
) -> Result<Ended> {
    if output.is_some_and(|output| output.restart.is_some()) {
        let text = "a search for accuracy begins anew: take out accuracy and give the mesh it found \
                    to go on with --restart";
        return Err(Error::Input(text.to_owned()));
    }
    let family = Family::of(case);
    let trials = Trials::new(runtime, &family, case, wanted, started);
    let mut search = Search { trials, wanted, output, growing: [Growing::default(); 3] };
    tell::start(case, wanted);
    let (found, ended) = search.rounds()?;
    tell::close(runtime, case, wanted, &search.trials, found, ended, output)
}

/// What has been tried of the growth of cells along an axis.
#[derive(Debug, Clone, Copy, Default)]
struct Growing {
    /// The share of what is asked before cells grew more; none where that is judged.
    before: Option<f64>,
    /// Whether more growth has not helped.
    is_fixed: bool,
}

/// Where a search has ended.
pub struct Found {
    /// The place among the meshes of the one whose results are those of the run.
    pub base: usize,
    /// Its errors.
    pub errors: Errors,
    /// Whether all are small enough.
    pub met: bool,
    /// Why it ended, in words.
    pub why: String,
}

struct Search<'r> {
    trials: Trials<'r>,
    wanted: &'r AccuracySection,
    output: Option<Output<'r>>,
    /// By axis.
    growing: [Growing; 3],
}

impl Search<'_> {
    /// Mesh after mesh. Collective.
    fn rounds(&mut self) -> Result<(Found, Ended)> {
        let (mut plan, first) = self.start()?;
        let beside = beside(&mut self.trials, &mut plan, first, self.wanted.relative)?;
        let mut best: Option<(Found, Ended)> = None;
        let mut failures = 0;
        for _ in 0..MOST_ROUNDS {
            let output = self.output.map(|output| Output {
                overwrite: output.overwrite || best.is_some(),
                page: false,
                ..output
            });
            let ended = match (self.trials.run(plan, "base", output), best) {
                (Ok(ended), _) => ended,
                (Err(error @ (Error::Numerics(_) | Error::Input(_))), Some((found, _))) => {
                    return self.again(found, &error);
                }
                // What softens may have no solution on coarse cells alone.
                (Err(Error::Numerics(_)), None) if failures < MOST_FAILURES => {
                    failures += 1;
                    best = None;
                    plan = self.trials.family.finer(&plan);
                    continue;
                }
                (Err(error), _) => return Err(error),
            };
            let base = self.trials.tried.len() - 1;
            let errors = self.errors(base, &beside)?;
            let met = errors.largest() <= 1.0;
            tell::mesh(&self.trials, base, &errors);
            let why = "every estimate is within what was asked".to_owned();
            let mut found = Found { base, errors, met, why };
            if met {
                return Ok((found, ended));
            }
            if found.errors.of_cells() <= SHARE_OF_CELLS {
                found.why = "steps and solver leave more than was asked".to_owned();
                return Ok((found, ended));
            }
            let next = self.next(plan, &found.errors);
            if let Some(why) = self.beyond(&next, base) {
                found.why = why;
                return Ok((found, ended));
            }
            best = Some((found, ended));
            plan = next;
        }
        let (mut found, ended) =
            best.ok_or_else(|| Error::Bug("no mesh in a search for accuracy".into()))?;
        found.why = format!("{MOST_ROUNDS} meshes did not suffice");
        Ok((found, ended))
    }

    /// The first mesh: one on which a smaller model serves, if there is such. Collective.
    fn start(&mut self) -> Result<(Plan, usize)> {
        if let Some(plan) = self.trials.family.smaller() {
            let place = self.trials.solve(plan, "a smaller model")?;
            if self.trials.tried[place].values.is_some() {
                return Ok((plan, place));
            }
        }
        let plan = self.trials.family.first();
        Ok((plan, self.trials.solve(plan, "start")?))
    }

    /// The results of the best mesh once more, after a finer one that could not be solved.
    fn again(&mut self, mut found: Found, error: &Error) -> Result<(Found, Ended)> {
        let plan = self.trials.tried[found.base].plan;
        let output = self.output.map(|output| Output { overwrite: true, page: false, ..output });
        let ended = self.trials.run(plan, "base, again", output)?;
        found.why = format!("the next mesh could not be solved: {error}");
        Ok((found, ended))
    }

    /// The errors of a mesh. Collective.
    fn errors(&mut self, base: usize, beside: &Beside) -> Result<Errors> {
        let values = self.trials.tried[base].values.clone().unwrap_or_default();
        let (scales, relative) = (&self.trials.tried[base].scales, self.wanted.relative);
        let allowed = allowed(&values, scales, self.trials.instants(), relative);
        let (axes, together) = of_cells(&mut self.trials, base, &allowed)?;
        let mut beside = beside.clone();
        if let Some((_, bound)) = self.trials.tried[base].reduced {
            // The bound has no sign.
            let of = beside.solver.iter_mut().zip(&values);
            of.for_each(|(solver, value)| *solver = solver.abs() + bound * value.abs());
        }
        Ok(Errors { axes, together, beside, allowed })
    }

    /// The mesh after one with such errors: finer along the axes that take more than their share.
    fn next(&mut self, plan: Plan, errors: &Errors) -> Plan {
        let axes = self.trials.family.axes();
        let needs: Vec<f64> = (0..axes.len()).map(|number| errors.need(number)).collect();
        let counts = needs.iter().filter(|need| **need > 0.0).count().max(1);
        let share = SHARE_OF_CELLS / counts as f64;
        let most = needs.iter().copied().fold(0.0, f64::max);
        let smooth = 2.0 * SMOOTH * self.trials.family.order() as f64;
        let mut next = Plan { needs_smaller: false, ..plan };
        for (number, (axis, _)) in axes.into_iter().enumerate() {
            let need = needs[number];
            self.judge_growth(axis, need, &mut next);
            if need <= share && need < most {
                continue;
            }
            next.levels[axis] += 1;
            let order = errors.order(number);
            let is_rough = order.is_none_or(|order| order < smooth);
            let halvings = (need / share).max(1.0).log2() / order.unwrap_or(1.0);
            let family = self.trials.family;
            let is_worth_it = halvings >= FEW_HALVINGS[family.dim() - 2];
            let growing = &mut self.growing[axis];
            let may_grow = !family.is_of_file() && !growing.is_fixed && is_worth_it;
            if is_rough && may_grow && next.growth[axis] < MOST_GROWTH {
                next.growth[axis] += 1;
                growing.before = Some(need);
            }
        }
        next
    }

    /// Takes back growth that has made the error of an axis larger.
    fn judge_growth(&mut self, axis: usize, need: f64, next: &mut Plan) {
        let growing = &mut self.growing[axis];
        if growing.before.take().is_some_and(|before| need > before) {
            next.growth[axis] -= 1;
            growing.is_fixed = true;
        }
    }

    /// Why a mesh is beyond the budget, in words.
    fn beyond(&self, next: &Plan, base: usize) -> Option<String> {
        let tried = &self.trials.tried[base];
        let unknowns = self.trials.family.unknowns(next, &tried.plan, tried.unknowns.max(1));
        let most = self.wanted.budget.unknowns;
        if unknowns > most as f64 {
            return Some(format!(
                "the next mesh would have about {unknowns:.0} unknowns, the budget is {most}"
            ));
        }
        let spent: f64 = self.trials.tried.iter().map(|tried| tried.core_seconds).sum();
        let growth = (unknowns / tried.unknowns.max(1) as f64).powf(COST);
        let expected = spent + growth * tried.core_seconds;
        let budget = self.wanted.budget.core_seconds.filter(|budget| expected > *budget)?;
        Some(format!(
            "{spent:.1} core-seconds are spent, and the next mesh would make them about \
             {expected:.1}; the budget is {budget}"
        ))
    }
}
