//! Holds a scene against a relation.

use crate::build::Built;
use crate::case::Case;
use crate::compare::Measure;
use crate::launch::{Outcome, Run, Setting, run};
use crate::relations::{Pair, Relation, pair};
use crate::scene::{Pores, Scene};

/// What came of it.
#[derive(Debug, Clone)]
pub enum Verdict {
    Held,
    /// Why it says nothing.
    Skipped(String),
    Broken(Failure),
}

#[derive(Debug, Clone)]
pub struct Failure {
    /// Values differ, in place of one of the two having failed.
    pub values: bool,
    pub words: String,
}

/// The run of the scene as it is, kept for all relations.
#[derive(Default)]
pub struct Known(Option<(Case, Outcome)>);

impl Known {
    fn outcome(&mut self, case: &Case) -> &Outcome {
        let known = self.0.take().filter(|(of, _)| of == case);
        let known = known.unwrap_or_else(|| (case.clone(), run(case, &Setting::PLAIN)));
        &self.0.insert(known).1
    }
}

/// None where the relation does not apply.
pub fn hold(relation: Relation, scene: &Scene, known: &mut Known) -> Option<Verdict> {
    let built = scene.build();
    let pair = pair(relation, scene, &built)?;
    let verdict = match relation {
        Relation::Exact => exact(&built, known),
        Relation::BelowStrength => below(&built, &pair, known),
        _ => {
            let own;
            if matches!(known.outcome(&built.case), Outcome::Ended(..)) && !relation.may_mend() {
                return Some(Verdict::Skipped("the scene itself is not solved".into()));
            }
            let base = if pair.base == built.case && !pair.base_setting.fields {
                known.outcome(&pair.base)
            } else {
                own = run(&pair.base, &pair.base_setting);
                &own
            };
            let other = run(&pair.other, &pair.setting);
            agree(relation, scene, &built, &pair, base, &other)
        }
    };
    Some(verdict)
}

fn broken(values: bool, words: String) -> Verdict {
    // A tolerance that rounding does not allow is refused with the figure, here or there.
    if !values && words.contains("rounding alone leaves") {
        return Verdict::Skipped("a tolerance below rounding".into());
    }
    Verdict::Broken(Failure { values, words })
}

/// A status and what was said.
fn ended(status: Option<i32>, words: &str) -> String {
    format!("{}: {words}", status.map_or("no status".into(), |s| format!("status {s}")))
}

/// One that no case may have.
fn never(status: Option<i32>) -> bool {
    !matches!(status, Some(2 | 3))
}

fn exact(built: &Built, known: &mut Known) -> Verdict {
    let (states, whole) = built.bars.as_ref().expect("it applies to them").states();
    if states.is_empty() {
        return Verdict::Skipped("no closed form".into());
    }
    match known.outcome(&built.case) {
        Outcome::Done(run) => {
            match Measure::of(built, built.case.tolerance).exact_differences(run, &states) {
                Some(words) => broken(true, words),
                None => Verdict::Held,
            }
        }
        Outcome::Ended(status, words) if whole || never(*status) => {
            broken(false, ended(*status, words))
        }
        Outcome::Ended(..) => Verdict::Skipped("beyond the closed form".into()),
    }
}

/// The largest share of its strength that an interface is pulled and sheared to.
fn share(case: &Case, tied: &Run) -> f64 {
    let largest = |name: String| {
        let index = tied.table.column(&name);
        index.map_or(0.0, |i| tied.table.rows.iter().filter_map(|r| r[i]).fold(0.0, f64::max))
    };
    let least = |name: String| {
        let index = tied.table.column(&name);
        index.map_or(0.0, |i| tied.table.rows.iter().filter_map(|r| r[i]).fold(0.0, f64::min))
    };
    let joints = case.joints.iter().map(|joint| {
        let shear = ["x", "y"].map(|a| {
            let name = format!("{}.shear_traction_{a}", joint.name);
            largest(format!("{name}.max")).max(-least(format!("{name}.min")))
        });
        let normal = largest(format!("{}.normal_traction.max", joint.name));
        normal.hypot(shear[0]).hypot(shear[1]) / joint.law.strength()
    });
    joints.fold(0.0, f64::max)
}

fn below(built: &Built, pair: &Pair, known: &mut Known) -> Verdict {
    let tied = match run(&pair.other, &pair.setting) {
        Outcome::Done(tied) => tied,
        Outcome::Ended(status, words) if never(status) => {
            return broken(false, ended(status, &words));
        }
        Outcome::Ended(_, words) => return Verdict::Skipped(format!("all tied: {words}")),
    };
    if share(&built.case, &tied) > 0.95 {
        return Verdict::Skipped("above the strength".into());
    }
    match known.outcome(&built.case) {
        Outcome::Done(run) => {
            let work: &[&str] = if run.cuts == tied.cuts { &[] } else { &["energy.external"] };
            match Measure::of(built, built.case.tolerance).differences(
                run,
                &tied,
                &pair.change,
                work,
                false,
            ) {
                Some(words) => broken(true, words),
                None => Verdict::Held,
            }
        }
        Outcome::Ended(status, words) => broken(false, ended(*status, words)),
    }
}

impl Scene {
    /// Whether a state is another one where the steps before it were others: what flows, and what
    /// is damaged while modes and places change.
    fn depends_on_steps(&self, run: &Run) -> bool {
        let damage = run.table.columns.iter().enumerate().filter(|c| c.1.ends_with("damage.max"));
        let damaged = damage.flat_map(|(i, _)| run.table.rows.iter().filter_map(move |r| r[i]));
        matches!(self.pores, Pores::Flow(_)) || self.uneven() && damaged.fold(0.0, f64::max) > 0.0
    }
}

fn agree(
    relation: Relation,
    scene: &Scene,
    built: &Built,
    pair: &Pair,
    base: &Outcome,
    other: &Outcome,
) -> Verdict {
    let (one, other) = match (base, other) {
        (Outcome::Done(one), Outcome::Done(other)) => (one, other),
        (Outcome::Ended(a, words), Outcome::Ended(b, _)) if a == b && !never(*a) => {
            let why =
                if *a == Some(2) { format!("refused: {words}") } else { "no convergence".into() };
            return Verdict::Skipped(why);
        }
        (Outcome::Done(_), Outcome::Ended(status, words)) => {
            return broken(false, format!("it alone: {}", ended(*status, words)));
        }
        (Outcome::Ended(status, words), Outcome::Done(_)) => {
            return broken(false, format!("only without it: {}", ended(*status, words)));
        }
        (Outcome::Ended(a, words), Outcome::Ended(b, theirs)) => {
            return broken(false, format!("{}; with it {}", ended(*a, words), ended(*b, theirs)));
        }
    };
    if one.doubtful || other.doubtful {
        return Verdict::Skipped("not stable or not unique".into());
    }
    if let (Relation::Reduced, Some(why)) = (relation, &other.not_reduced) {
        return Verdict::Skipped(format!("no smaller model: {why}"));
    }
    let measure = Measure::of(built, pair.base.tolerance);
    let cut = one.cuts != other.cuts || relation == Relation::Halves;
    if cut && scene.depends_on_steps(one) {
        return Verdict::Skipped("steps that were cut otherwise".into());
    }
    let skip: &[&str] = match relation {
        Relation::Opening => &["load_factor"],
        // The external work is that of the trapezoidal rule over the steps.
        _ if cut => &["energy.external"],
        _ => &[],
    };
    let found = measure.differences(one, other, &pair.change, skip, pair.common_only);
    let fields = || {
        let both = pair.setting.fields && pair.base_setting.fields;
        both.then(|| measure.fields(&one.place, &other.place)).flatten()
    };
    match found.or_else(fields) {
        Some(words) => broken(true, words),
        None => Verdict::Held,
    }
}
