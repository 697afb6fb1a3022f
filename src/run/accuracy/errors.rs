//! The errors of a mesh, part by part.

use super::estimate::{Part, part};
use super::plan::Plan;
use super::trial::Trials;
use crate::error::Result;

/// Quantities of interest converge at most twice as fast as displacements, with steps as implicit
/// ones do.
const HIGHEST_OVER_CELLS: f64 = 2.0;
const HIGHEST_OF_STEPS: f64 = 1.0;

/// Differences below this part of what is asked are no signs of an order.
const NOISE: f64 = 1e-3;

/// Up to this part of what is asked an error need not be trusted.
const SMALL: f64 = 0.1;

/// An error of any other value than the one at its instant is held against this part of the
/// largest one at any instant.
const OF_LARGEST: f64 = 0.01;

/// What steps and solver leave of all wanted values, found on the first mesh.
#[derive(Debug, Clone)]
pub struct Beside {
    /// By the length of the steps; none along a path of dissipation.
    pub time: Option<Vec<Part>>,
    /// By the tolerance of the solver: exact minus found.
    pub solver: Vec<f64>,
}

/// The errors of one mesh: of each part, for each wanted value.
#[derive(Debug, Clone)]
pub struct Errors {
    /// Of the cells along each axis.
    pub axes: Vec<Vec<Part>>,
    /// Of the cells along all axes together, whose errors mix where edges and corners make them.
    pub together: Vec<Part>,
    /// Of steps and solver.
    pub beside: Beside,
    /// What may be missing of each wanted value.
    pub allowed: Vec<f64>,
}

/// And against this part of the largest of its kind: forces that vanish are held against others.
const OF_KIND: f64 = 1e-4;

/// What may be missing of each of the values, which stand quantity by quantity at so many instants,
/// where those of its kind have such `scales`.
pub fn allowed(values: &[f64], scales: &[f64], instants: usize, relative: f64) -> Vec<f64> {
    let of_quantity = |values: &[f64]| -> Vec<f64> {
        let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        values.iter().map(|v| relative * v.abs().max(OF_LARGEST * largest)).collect()
    };
    let of_values = values.chunks(instants.max(1)).flat_map(of_quantity);
    let of_kinds = scales.iter().map(|scale| relative * OF_KIND * scale);
    of_values.zip(of_kinds).map(|(one, other)| one.max(other)).collect()
}

/// Errors over what is allowed; none is allowed where all values are zero.
pub fn over(missing: f64, allowed: f64) -> f64 {
    if missing == 0.0 { 0.0 } else { missing.abs() / allowed.max(f64::MIN_POSITIVE) }
}

impl Errors {
    /// The largest share of what is allowed that the cells along an axis take.
    pub fn need(&self, axis: usize) -> f64 {
        let of = self.axes[axis].iter().zip(&self.allowed);
        of.map(|(part, allowed)| over(part.missing, *allowed)).fold(0.0, f64::max)
    }

    /// The order at which the largest error of an axis falls; none where it is not known.
    pub fn order(&self, axis: usize) -> Option<f64> {
        let of = self.axes[axis].iter().zip(&self.allowed);
        let worst = of.max_by(|a, b| over(a.0.missing, *a.1).total_cmp(&over(b.0.missing, *b.1)));
        worst.and_then(|(part, _)| part.order)
    }

    /// The sum of the sizes of all parts of a value.
    pub fn size(&self, value: usize) -> f64 {
        let axes: f64 = self.axes.iter().map(|parts| parts[value].missing.abs()).sum();
        let time = self.beside.time.as_ref().map_or(0.0, |time| time[value].missing.abs());
        let cells = axes.max(self.together[value].missing.abs());
        cells + time + self.beside.solver[value].abs()
    }

    /// The largest that the cells leave, over what is allowed.
    pub fn of_cells(&self) -> f64 {
        let of = |value: usize| {
            let axes: f64 = self.axes.iter().map(|parts| parts[value].missing.abs()).sum();
            over(axes.max(self.together[value].missing.abs()), self.allowed[value])
        };
        (0..self.allowed.len()).map(of).fold(0.0, f64::max)
    }

    /// The largest of all, over what is allowed.
    pub fn largest(&self) -> f64 {
        let of = (0..self.allowed.len()).map(|value| over(self.size(value), self.allowed[value]));
        of.fold(0.0, f64::max)
    }

    /// All that is missing of a value, with its sign.
    pub fn missing(&self, value: usize) -> f64 {
        let time = self.beside.time.as_ref().map_or(0.0, |time| time[value].missing);
        self.together[value].missing + time + self.beside.solver[value]
    }

    /// What the cells along all axes leave together and not one by one.
    pub fn mixed(&self, value: usize) -> f64 {
        let axes: f64 = self.axes.iter().map(|parts| parts[value].missing).sum();
        self.together[value].missing - axes
    }

    /// Whether all parts of a value that count behave as the estimate takes for granted.
    pub fn are_trusted(&self, value: usize) -> bool {
        let counts = |part: &Part| over(part.missing, self.allowed[value]) > SMALL;
        let sound = |part: &Part| part.trusted || !counts(part);
        let time = self.beside.time.as_ref().is_none_or(|time| sound(&time[value]));
        let axes = self.axes.iter().all(|parts| sound(&parts[value]));
        axes && time && sound(&self.together[value])
    }
}

/// The errors of the cells of the mesh at `base`, by meshes that are coarser along one axis each,
/// and by those that are so along all. Collective.
///
/// # Errors
/// Those of the runs, but for meshes that cannot be solved.
pub fn of_cells(
    trials: &mut Trials<'_>,
    base: usize,
    allowed: &[f64],
) -> Result<(Vec<Vec<Part>>, Vec<Part>)> {
    let (plan, highest) =
        (trials.tried[base].plan, HIGHEST_OVER_CELLS * trials.family.order() as f64);
    let reduced = trials.tried[base].reduced;
    // A smaller model of the bodies as wholes is exact along the axes that it has left out.
    let is_exact = |axis: usize| reduced.is_some_and(|(kept, _)| !kept[axis]);
    let mut axes = Vec::new();
    for (axis, name) in trials.family.axes() {
        let along: &[usize] = if is_exact(axis) { &[] } else { &[axis] };
        let coarser = coarser(trials, plan, along, name)?;
        axes.push(match along {
            [] => vec![Part::NONE; allowed.len()],
            _ => parts(trials, base, &coarser, allowed, highest),
        });
    }
    let along: Vec<usize> =
        trials.family.axes().into_iter().map(|of| of.0).filter(|axis| !is_exact(*axis)).collect();
    if along.is_empty() {
        return Ok((axes, vec![Part::NONE; allowed.len()]));
    }
    let coarser = coarser(trials, plan, &along, "all axes")?;
    let together = parts(trials, base, &coarser, allowed, highest);
    // Where those of all do not fall as they should, the sum of the axes says more.
    let better = |(value, part): (usize, Part)| {
        let sum: f64 = axes.iter().map(|parts| parts[value].missing).sum();
        let axes_are_sound = axes.iter().all(|parts: &Vec<Part>| parts[value].trusted);
        let missing = if !part.trusted && axes_are_sound { sum } else { part.missing };
        Part { missing, ..part }
    };
    let together = together.into_iter().enumerate().map(better).collect();
    Ok((axes, together))
}

/// The places of meshes with a half and a quarter of the cells along some axes. Collective.
fn coarser(trials: &mut Trials<'_>, plan: Plan, along: &[usize], name: &str) -> Result<Vec<usize>> {
    let mut coarser = Vec::new();
    let least = along.iter().map(|axis| plan.levels[*axis]).min().unwrap_or(0);
    for times in 1..=least.min(2) {
        let mut other = Plan { needs_smaller: false, ..plan };
        along.iter().for_each(|axis| other.levels[*axis] -= times);
        let word = ["half", "a quarter"][times as usize - 1];
        coarser.push(trials.solve(other, &format!("{name} with {word} of the cells"))?);
    }
    Ok(coarser)
}

/// The parts of all values from a mesh and up to two others, each halved against the next.
fn parts(
    trials: &Trials<'_>,
    finest: usize,
    coarser: &[usize],
    allowed: &[f64],
    highest: f64,
) -> Vec<Part> {
    let values = |place: Option<&usize>| place.and_then(|p| trials.tried[*p].values.as_ref());
    let Some(v0) = values(Some(&finest)) else { return vec![Part::NONE; allowed.len()] };
    let (v1, v2) = (values(coarser.first()), values(coarser.get(1)));
    let of =
        |i: usize| part(v0[i], v1.map(|v| v[i]), v2.map(|v| v[i]), highest, NOISE * allowed[i]);
    (0..allowed.len()).map(of).collect()
}

/// What steps and solver may leave of what is asked.
const SHARE_OF_STEPS: f64 = 0.25;
const SHARE_OF_SOLVER: f64 = 0.05;

/// Halvings of the steps that are tried.
const MOST_HALVINGS: usize = 7;

/// Tolerances of the solver that are tried.
const TIGHTER: f64 = 1e-2;
const TIGHTEST: f64 = 1e-13;

/// Steps of such a length and a tolerance of the solver that leave little, found on the mesh of
/// `plan`, which gets them. Collective.
///
/// # Errors
/// As [`of_cells`].
pub fn beside(
    trials: &mut Trials<'_>,
    plan: &mut Plan,
    base: usize,
    relative: f64,
) -> Result<Beside> {
    let solver = of_solver(trials, plan, base, relative, SHARE_OF_SOLVER)?;
    let time = if trials.has_steps() {
        Some(of_steps(trials, plan, relative, SHARE_OF_STEPS)?)
    } else {
        None
    };
    Ok(Beside { time, solver })
}

/// What the tolerance of the solver leaves, which is made tighter until that is little. Collective.
fn of_solver(
    trials: &mut Trials<'_>,
    plan: &mut Plan,
    base: usize,
    relative: f64,
    share: f64,
) -> Result<Vec<f64>> {
    let mut solver = vec![0.0; trials.wanted().len()];
    let Some(mut values) = trials.tried[base].values.clone() else { return Ok(solver) };
    let allowed = allowed(&values, &trials.tried[base].scales, trials.instants(), relative);
    while plan.tolerance > TIGHTEST {
        let tighter = Plan { tolerance: (TIGHTER * plan.tolerance).max(TIGHTEST), ..*plan };
        let place = trials.solve(tighter, "tighter tolerance")?;
        let Some(better) = trials.tried[place].values.clone() else { break };
        solver = better.iter().zip(&values).map(|(better, value)| better - value).collect();
        let of = solver.iter().zip(&allowed).map(|(d, allowed)| over(*d, *allowed));
        if of.fold(0.0, f64::max) <= share {
            break;
        }
        (plan.tolerance, values) = (tighter.tolerance, better);
    }
    Ok(solver)
}

/// What the length of the steps leaves, which are halved until that is little. The errors of all
/// lengths are seen from the shortest one. Collective.
fn of_steps(
    trials: &mut Trials<'_>,
    plan: &mut Plan,
    relative: f64,
    share: f64,
) -> Result<Vec<Part>> {
    let coarse = trials.family.coarser(plan);
    let mut levels = vec![trials.solve(coarse, "steps")?];
    let first = plan.steps;
    loop {
        let finer = Plan { steps: first + levels.len() as u32, ..coarse };
        let place = trials.solve(finer, "half of the steps")?;
        levels.push(place);
        let Some(found) = &trials.tried[place].values else {
            return Ok(vec![Part { trusted: false, ..Part::NONE }; trials.wanted().len()]);
        };
        let scales = &trials.tried[place].scales;
        let allowed = allowed(found, scales, trials.instants(), relative);
        let backwards: Vec<usize> = levels[..levels.len() - 1].iter().rev().copied().collect();
        let last = parts(trials, place, &backwards, &allowed, HIGHEST_OF_STEPS);
        let of_level = |level: usize| -> Vec<Part> {
            let own = trials.tried[levels[level]].values.as_ref();
            let rest = |i: usize| own.map_or(0.0, |own| found[i] - own[i]);
            let of = |(i, part): (usize, &Part)| Part { missing: part.missing + rest(i), ..*part };
            last.iter().enumerate().map(of).collect()
        };
        let size = |parts: &[Part]| {
            let of = parts.iter().zip(&allowed).map(|(part, a)| over(part.missing, *a));
            of.fold(0.0, f64::max)
        };
        let serves = (0..levels.len()).find(|level| size(&of_level(*level)) <= share);
        let level = serves.unwrap_or(levels.len() - 1);
        if serves.is_some() || levels.len() > MOST_HALVINGS {
            plan.steps = first + level as u32;
            return Ok(of_level(level));
        }
    }
}
