//! The meshes among which the search chooses, and the cases that have them.

use crate::case::sections::{AxisGrading, GradingSection};
use crate::case::{Case, Cells, ColumnSpec, ControlKind, InterfaceSpec, MeshSource, Reduce};

/// Halvings of the cells at the start, so that there are coarser meshes to compare with: in 2D and
/// in 3D.
const FIRST_LEVEL: [u32; 2] = [3, 2];

/// Of the steps of a flow that had one for each instant: the error that one may make.
const FIRST_TOLERANCE: f64 = 0.01;

/// What a mesh and its steps are made of: how often each has been halved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Along x, y, z; of the mesh of a file the refinements, along x.
    pub levels: [u32; 3],
    /// With so many halvings of the cells their ratio is doubled so often: 0 for uniform cells.
    pub growth: [u32; 3],
    /// Of the steps.
    pub steps: u32,
    /// Of the solver.
    pub tolerance: f64,
    /// Whether a smaller model has to serve.
    pub needs_smaller: bool,
}

/// All meshes for a case.
pub struct Family<'c> {
    case: &'c Case,
    /// Cells of each body along x, y, z before any halving; none for the mesh of a file.
    coarsest: Vec<[usize; 3]>,
}

impl<'c> Family<'c> {
    /// The meshes of a case; the cells that it gives are those of the start.
    pub fn of(case: &'c Case) -> Self {
        let coarsest = case.mesh.column().map(|column| coarsest(case, column));
        Self { case, coarsest: coarsest.unwrap_or_default() }
    }

    /// Whether the mesh comes from a file.
    pub fn is_of_file(&self) -> bool {
        self.coarsest.is_empty()
    }

    /// Whether steps can be halved: those of a path of dissipation are the instants.
    pub fn has_steps(&self) -> bool {
        let kind = self.case.control.as_ref().map(|control| &control.kind);
        !matches!(kind, Some(ControlKind::Dissipation(_)))
    }

    /// The first mesh.
    pub fn first(&self) -> Plan {
        let level = if self.is_of_file() { 1 } else { FIRST_LEVEL[self.case.dim - 2] };
        let levels = match (self.is_of_file(), self.case.dim) {
            (true, _) => [self.case.mesh.refine.max(1), 0, 0],
            (false, 2) => [level, 0, level],
            (false, _) => [level; 3],
        };
        let tolerance = self.case.solver.tolerance;
        // One step for each instant is no halving of any other.
        let has_one = self.case.flow.as_ref().is_some_and(|flow| flow.tolerance.is_none());
        let steps = u32::from(has_one);
        Plan { levels, growth: [0; 3], steps, tolerance, needs_smaller: false }
    }

    /// A mesh with halves of the cells along all axes.
    pub fn finer(&self, plan: &Plan) -> Plan {
        let mut finer = Plan { needs_smaller: false, ..*plan };
        self.axes().into_iter().for_each(|(axis, _)| finer.levels[axis] += 1);
        finer
    }

    /// A coarser mesh, on which the length of the steps matters as on finer ones.
    pub fn coarser(&self, plan: &Plan) -> Plan {
        if plan.needs_smaller || self.is_of_file() {
            return *plan;
        }
        Plan { levels: plan.levels.map(|level| level.saturating_sub(1)), ..*plan }
    }

    /// A finer mesh on which a smaller model may serve, which costs no more for that; none where
    /// there are no smaller ones.
    pub fn smaller(&self) -> Option<Plan> {
        let first = self.first();
        let finer = |level: u32| if level == 0 { 0 } else { level + 1 };
        let may_be = !self.is_of_file() && self.case.reduce == Reduce::Auto;
        may_be.then(|| Plan { levels: first.levels.map(finer), needs_smaller: true, ..first })
    }

    /// The axes along which cells are halved, and their names.
    pub fn axes(&self) -> Vec<(usize, &'static str)> {
        match (self.is_of_file(), self.case.dim) {
            (true, _) => vec![(0, "refine")],
            (false, 2) => vec![(0, "x"), (2, "z")],
            (false, _) => vec![(0, "x"), (1, "y"), (2, "z")],
        }
    }

    /// 2 or 3.
    pub fn dim(&self) -> usize {
        self.case.dim
    }

    /// The highest order of the cells.
    pub fn order(&self) -> usize {
        match &self.case.mesh.source {
            MeshSource::Boxes(column) => column.orders.iter().copied().max().unwrap_or(1),
            MeshSource::File(file) => 1 + usize::from(file.raise_order),
        }
    }

    /// Cells of each body along x, y, z.
    pub fn cells(&self, plan: &Plan) -> Vec<[usize; 3]> {
        let halved = |n: &[usize; 3]| [0, 1, 2].map(|axis| n[axis] << plan.levels[axis]);
        self.coarsest.iter().map(halved).collect()
    }

    /// Largest over smallest cell along an axis.
    pub fn ratio(&self, plan: &Plan, axis: usize) -> f64 {
        let cells = self.cells(plan);
        let most = cells.iter().map(|n| n[axis]).max().unwrap_or(1);
        // Both ends of a body have half of its cells.
        let to_middle = (most as f64 / 2.0).max(1.0);
        to_middle.powi(plan.growth[axis] as i32).min(1e6)
    }

    /// About how many unknowns a mesh has, over those of another one that had `known`.
    pub fn unknowns(&self, plan: &Plan, other: &Plan, known: u64) -> f64 {
        if self.is_of_file() {
            let finer = f64::from(plan.levels[0]) - f64::from(other.levels[0]);
            return known as f64 * (finer * self.case.dim as f64).exp2();
        }
        let nodes = |plan: &Plan| -> f64 {
            let order = self.order();
            let along = |n: usize| (order * n + 1) as f64;
            let of = |n: &[usize; 3]| {
                let y = if self.case.dim == 2 { 1.0 } else { along(n[1]) };
                along(n[0]) * y * along(n[2])
            };
            self.cells(plan).iter().map(of).sum()
        };
        known as f64 * nodes(plan) / nodes(other)
    }

    /// The case with that mesh, those steps and that tolerance.
    pub fn case(&self, plan: &Plan) -> Case {
        let mut case = self.case.clone();
        self.change(&mut case, plan);
        for stage in &mut case.stages {
            self.change(&mut stage.case, plan);
        }
        case
    }

    fn change(&self, case: &mut Case, plan: &Plan) {
        let grading = self.grading(plan);
        match &mut case.mesh.source {
            MeshSource::Boxes(column) => {
                column.cells = Cells::Bodies(self.cells(plan));
                let first = column.orders[0];
                column.orders.resize(self.coarsest.len(), first);
                column.grading = grading;
            }
            MeshSource::File(_) => case.mesh.refine = plan.levels[0],
        }
        case.solver.tolerance = plan.tolerance;
        case.search.needs_smaller = plan.needs_smaller;
        // Steps of half the length make a quarter of the error each.
        let quarters = |halvings: u32| (-2.0 * f64::from(halvings)).exp2();
        match &mut case.flow {
            Some(flow) if plan.steps > 0 => {
                flow.tolerance = Some(match flow.tolerance {
                    Some(given) => given * quarters(plan.steps),
                    None => FIRST_TOLERANCE * quarters(plan.steps - 1),
                });
            }
            Some(_) => {}
            None => case.search.stops = between(case.start, &case.time, 1 << plan.steps),
        }
    }

    fn grading(&self, plan: &Plan) -> GradingSection {
        let along = |axis: usize, places: Vec<String>| {
            let ratio = self.ratio(plan, axis);
            (ratio > 1.0).then_some(AxisGrading { towards: places, ratio })
        };
        let names = |names: [&str; 2]| names.map(str::to_owned).to_vec();
        let mut heights = names(["bottom", "top"]);
        heights.extend(self.case.interfaces.iter().map(|interface| interface.name.clone()));
        let layers = self.case.materials.iter().filter(|material| material.z.is_some());
        heights.extend(layers.map(|material| material.name.clone()));
        let y = (self.case.dim == 3).then(|| along(1, names(["front", "back"]))).flatten();
        GradingSection { x: along(0, names(["left", "right"])), y, z: along(2, heights) }
    }
}

/// The coarsest cells of each body: those that the case gives, halved as often as the first mesh
/// will be; else one across, and as many along z as changes of material ask for.
fn coarsest(case: &Case, column: &ColumnSpec) -> Vec<[usize; 3]> {
    let level = FIRST_LEVEL[case.dim - 2];
    let height = column.height();
    let heights = case.interfaces.iter().filter_map(InterfaceSpec::height);
    let ends: Vec<f64> = std::iter::once(0.0).chain(heights).chain([height]).collect();
    let given = case.sections().mesh.column.as_ref();
    let is_given = given.is_some_and(|column| column.cells.is_some() || column.bodies.is_some());
    let changes: Vec<f64> = case.materials.iter().flat_map(|m| m.z).map(|z| z[1]).collect();
    let of_body = |(body, z): (usize, &[f64])| {
        let layers = 1 + changes.iter().filter(|change| **change > z[0] && **change < z[1]).count();
        let cells = match &column.cells {
            _ if !is_given => return [1, 1, layers],
            Cells::Uniform(n) => {
                let share = n[2] as f64 * (z[1] - z[0]) / height;
                [n[0], n[1], share.round() as usize]
            }
            Cells::Bodies(list) => list[body],
        };
        let halved = |n: usize| (n >> level).max(1);
        let y = if case.dim == 2 { 1 } else { halved(cells[1]) };
        [halved(cells[0]), y, halved(cells[2]).max(layers)]
    };
    ends.windows(2).enumerate().map(of_body).collect()
}

/// The ends of `parts` steps in the place of each that leads from one instant to the next.
fn between(start: f64, instants: &[f64], parts: u32) -> Vec<f64> {
    let mut stops = Vec::new();
    let mut before = start;
    for instant in instants {
        let part = |k: u32| before + (instant - before) * (f64::from(k) / f64::from(parts));
        stops.extend((1..parts).map(part));
        before = *instant;
    }
    stops
}
