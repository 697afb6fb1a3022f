//! Stages of a case: each is a case of its own, with its part of the time.

mod merge;

use std::collections::BTreeSet;
use std::path::Path;

use super::checks::Checker;
use super::sections::Physics;
use super::sections::file::CaseFile;
use super::{Case, InterfaceSpec, Stage, sections_of};
use crate::error::{Error, Result};
use crate::input::problems::Problems;
use crate::input::tree::{Data, Node};
use merge::{get_mut, replace, surfaces, take, trees};

/// A case with stages that is being read.
struct Reader<'a> {
    tree: &'a Node,
    path: &'a Path,
    broken: BTreeSet<String>,
    dim_of_file: Option<usize>,
    /// Of each stage, without its times.
    trees: Vec<Node>,
    ends: Vec<f64>,
    /// On which surfaces something is prescribed in any stage, whether a displacement, and whether
    /// that of a platen.
    surfaces: Vec<(String, [bool; 2])>,
}

/// The case of a tree with stages, of which `file` holds the sections; `problems` have been found
/// so far.
pub(super) fn case<'a>(
    tree: &'a Node,
    file: CaseFile,
    path: &'a Path,
    mut problems: Problems<'a>,
    broken: BTreeSet<String>,
    dim_of_file: Option<usize>,
) -> Result<Case> {
    check_ends(tree, &file, &broken, &mut problems);
    if file.control.is_some() {
        let reason = "cannot stand beside stages: the loads of a path have no time";
        problems.add(tree, "control", reason);
    }
    let trees = trees(tree, &mut problems);
    let ends = file.stages.iter().map(|stage| stage.until).collect();
    let mut prescribed: Vec<(String, [bool; 2])> = Vec::new();
    for (on, supports) in trees.iter().flat_map(surfaces) {
        match prescribed.iter_mut().find(|(other, _)| *other == on) {
            Some((_, also)) => also.iter_mut().zip(supports).for_each(|(also, it)| *also |= it),
            None => prescribed.push((on, supports)),
        }
    }
    let reader = Reader { tree, path, broken, dim_of_file, trees, ends, surfaces: prescribed };
    reader.case(file, problems)
}

/// Checks when stages end.
fn check_ends(tree: &Node, file: &CaseFile, broken: &BTreeSet<String>, problems: &mut Problems) {
    if broken.contains("time") {
        return;
    }
    let mut before = file.time.start;
    for (number, stage) in file.stages.iter().enumerate() {
        let path = format!("stages.{number}.until");
        let until = stage.until;
        if until <= before {
            let what = if number == 0 { "time.start" } else { "the end of the stage before" };
            problems.add(tree, &path, format!("must be above {what}, {before}, got {until}"));
        } else if !file.time.instants.contains(&until) {
            problems.add(tree, &path, format!("must be one of time.instants, got {until}"));
        }
        before = until;
    }
    let last = file.time.instants.last().filter(|last| **last != before);
    if let (Some(last), true) = (last, problems.is_empty()) {
        let path = format!("stages.{}.until", file.stages.len() - 1);
        let reason = format!("must be the last of time.instants, {last}, got {before}");
        problems.add(tree, &path, reason);
    }
}

impl<'a> Reader<'a> {
    /// Reads every stage; where one has pore pressures they are computed in all, so that they go
    /// on.
    fn case(mut self, mut file: CaseFile, problems: Problems<'a>) -> Result<Case> {
        let blank = problems.anew();
        let mut whole = self.whole(problems)?;
        let mut stages = self.stages(&file, &blank)?;
        let flows = |stage: &Stage| stage.case.flow.is_some();
        let has_pressure = |stage: &Stage| stage.case.has_pressure();
        let is_asked = whole.has_pressure() || stages.iter().any(has_pressure);
        if is_asked && !stages.iter().all(flows) {
            if file.physics == Physics::Mechanics {
                let mut problems = blank.anew();
                let reason = "cannot be mechanics where stages have pore pressures, which go on \
                              from one to the next; take auto or hydro_mechanics";
                problems.add(self.tree, "physics", reason);
                return Err(problems.into_error());
            }
            for tree in &mut self.trees {
                replace(tree, "physics", Data::Text("hydro_mechanics".to_owned()));
            }
            whole = self.whole(blank.anew())?;
            stages = self.stages(&file, &blank)?;
        }
        self.check_films(&stages, &blank)?;
        for stage in &mut stages {
            stage.case.output.clone_from(&whole.output);
            // What was there before does not follow what stages change.
            stage.case.initial_stress.clone_from(&whole.initial_stress);
        }
        // The sections as they were written, with the defaults that were found.
        file.title.clone_from(&whole.file.title);
        file.output.directory.clone_from(&whole.file.output.directory);
        file.physics = whole.file.physics;
        file.mesh = whole.file.mesh;
        Ok(Case { file, stages, ..whole })
    }

    /// The case with all its instants, as it is in the first stage.
    fn whole(&self, problems: Problems<'a>) -> Result<Case> {
        self.checked(&self.trees[0], problems)
    }

    fn checked(&self, tree: &Node, problems: Problems<'_>) -> Result<Case> {
        let file = sections_of(tree, &self.broken, self.path)?;
        let mut checker = Checker::new(tree, problems, self.broken.clone(), self.dim_of_file);
        checker.surfaces_of_stages.clone_from(&self.surfaces);
        checker.end_of_stage = self.ends.first().copied();
        checker.case(file, self.path)
    }

    /// The case of each stage: its part of the time, and nothing that is told of all.
    fn stages(&self, file: &CaseFile, blank: &Problems<'a>) -> Result<Vec<Stage>> {
        let mut found = Vec::new();
        let mut complaints: Vec<String> = Vec::new();
        let mut start = file.time.start;
        for (number, (tree, until)) in self.trees.iter().zip(&self.ends).enumerate() {
            let mut tree = tree.clone();
            let own = file.time.instants.iter().filter(|time| start < **time && **time <= *until);
            part_of_time(&mut tree, start, own.copied());
            ["expect", "probes"].iter().for_each(|key| drop(take(&mut tree, key)));
            if let Some(output) = get_mut(&mut tree, "output") {
                take(output, "fields");
            }
            if let (Some(initial), true) = (get_mut(&mut tree, "initial"), number > 0) {
                ["equilibrium", "stress"].iter().for_each(|key| drop(take(initial, key)));
            }
            let problems = blank.within(&format!("stages.{number}"));
            let file = sections_of(&tree, &self.broken, self.path)?;
            let mut checker = Checker::new(&tree, problems, self.broken.clone(), self.dim_of_file);
            checker.surfaces_of_stages.clone_from(&self.surfaces);
            match checker.case(file, self.path) {
                Ok(case) => found.push(Stage { until: *until, case }),
                Err(error) => complaints.push(error.to_string()),
            }
            start = *until;
        }
        if complaints.is_empty() { Ok(found) } else { Err(Error::Input(complaints.join("\n"))) }
    }

    /// What flows in interfaces does so from the start.
    fn check_films(&self, stages: &[Stage], blank: &Problems<'a>) -> Result<()> {
        let mut problems = blank.anew();
        let kind = |i: &InterfaceSpec| (i.film.is_some(), i.connected);
        for (number, stage) in stages.iter().enumerate().skip(1) {
            let before = stages[0].case.interfaces.iter();
            for (first, now) in before.zip(&stage.case.interfaces) {
                if kind(first) != kind(now) {
                    let path = format!("stages.{number}.fluid.{}", now.name);
                    let reason = "lets fluid flow in an interface in which none flowed in the \
                                  first stage; give the interface fluid: {flow: true}";
                    problems.add(self.tree, &path, reason);
                }
            }
        }
        if problems.is_empty() { Ok(()) } else { Err(problems.into_error()) }
    }
}

/// Gives a tree its part of the time.
fn part_of_time(tree: &mut Node, start: f64, instants: impl Iterator<Item = f64>) {
    let Some(time) = get_mut(tree, "time") else { return };
    let origin = time.origin;
    let node = |time| Node { data: Data::Number(time), origin };
    replace(time, "start", Data::Number(start));
    replace(time, "instants", Data::List(instants.map(node).collect()));
}
