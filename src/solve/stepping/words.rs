//! Why a step fails, and what may lie behind it, in words.

use super::Stepper;
use crate::error::{Error, Result};
use crate::petsc::SolveReport;
use crate::solve::held;

impl Stepper<'_> {
    /// What may lie behind a step that fails however small it is. Collective.
    pub(super) fn advice(&self) -> String {
        let gave_way = self.problem.convergence.interfaces_that_gave_way(self.problem.comm);
        let names: Vec<&str> = self
            .case
            .interfaces
            .iter()
            .zip(&gave_way)
            .filter(|(_, gave_way)| **gave_way)
            .map(|(interface, _)| interface.name.as_str())
            .collect();
        if names.is_empty() || self.problem.path.is_some() {
            return String::new();
        }
        let holds: Vec<bool> = gave_way.iter().map(|gave_way| !gave_way).collect();
        let free = self.case.free_motions(&holds);
        let first = names[0];
        let names = names.join(" and ");
        if free.is_empty() {
            return format!(
                "\ninterface {names} gives way over its whole area in this step: if the column \
                 gives back more energy than the interface takes (snap-back), no step is small \
                 enough, but control: {{opening: {{of: {first}, equals: ...}}}} follows it; otherwise a \
                 larger augmentation may help"
            );
        }
        format!(
            "\ninterface {names} ruptures: all of it softens or is broken, and without it {}",
            free.join("; ")
        )
    }

    /// Ends the run when the interfaces that broke leave a body to itself.
    pub(super) fn refuse_freed_bodies(&self, time: f64) -> Result<()> {
        let problem = &self.problem;
        let mut holds = vec![0.0; self.case.interfaces.len()];
        let mut nodes = vec![0.0; holds.len()];
        for (rows, response) in problem.all.secondary.iter().zip(&problem.interfaces.response) {
            if rows.has_multiplier() {
                nodes[rows.interface] = 1.0;
                if !held::is_separated(&problem.interfaces, rows.interface, response) {
                    holds[rows.interface] = 1.0;
                }
            }
        }
        problem.comm.max(&mut holds);
        problem.comm.max(&mut nodes);
        let holds: Vec<bool> =
            holds.iter().zip(&nodes).map(|(h, n)| *h > 0.0 || *n == 0.0).collect();
        if holds.iter().all(|holds| *holds) {
            return self.refuse_loose_bodies(time);
        }
        let free = self.case.free_motions(&holds);
        if free.is_empty() {
            return self.refuse_loose_bodies(time);
        }
        let broken = self.case.interfaces.iter().zip(&holds).filter(|(_, holds)| !**holds);
        let names: Vec<&str> = broken.map(|(interface, _)| interface.name.as_str()).collect();
        Err(Error::Numerics(format!(
            "at time {time} interface {} has ruptured over its whole area: {}",
            names.join(" and "),
            free.join("; ")
        )))
    }

    /// Ends the run when what is left of interfaces that broke in part does not hold a body. Collective.
    fn refuse_loose_bodies(&self, time: f64) -> Result<()> {
        let problem = &self.problem;
        let (all, state) = (&problem.all, &problem.interfaces);
        let mut nodes = all.secondary.iter().zip(&state.response);
        let separated = nodes.any(|(rows, r)| held::is_separated(state, rows.interface, r));
        if !problem.comm.any(separated) {
            return Ok(());
        }
        let column = problem.convergence.column();
        let free = held::free_motions(problem.comm, self.case, column, all, state);
        if free.is_empty() {
            return Ok(());
        }
        Err(Error::Numerics(format!(
            "at time {time} what is left of the interfaces does not hold: {}; prescribe displacements that \
             prevent it, or choose a law that holds",
            free.join("; ")
        )))
    }

    /// Why a solve failed, in words. Collective.
    pub(super) fn reason(&self, report: &SolveReport) -> String {
        let problem = &self.problem;
        let words = match (&problem.convergence.failure, &report.failing_linear) {
            (Some(words), _) => words.clone(),
            (None, Some(linear)) => format!("the linear solver failed: {}", linear.words),
            (None, None) => match problem.convergence.broken_place(problem.comm) {
                Some(place) => format!("{} ({place})", report.reason),
                None => report.reason.to_string(),
            },
        };
        // L D L^T goes through an indefinite tangent without a word; its pivots tell.
        let place = self.softening_place();
        let negative = report.negative_pivots.unwrap_or(0);
        if negative == 0 {
            return words;
        }
        let place = place.map_or_else(String::new, |place| format!("; {place} softened"));
        format!("{words}; the tangent was indefinite ({negative} negative pivots){place}")
    }

    /// Interface and place of the lowest node that softened in the last solve. Collective.
    fn softening_place(&self) -> Option<String> {
        let mine = self.problem.convergence.softening;
        // The maximum of the complements is the minimum.
        let lowest =
            u64::MAX - self.problem.comm.max_u64(u64::MAX - mine.map_or(u64::MAX, |m| m.0));
        if lowest == u64::MAX {
            return None;
        }
        let interface = mine.filter(|m| m.0 == lowest).map_or(0, |m| m.1);
        let interface = self.problem.comm.max_u64(interface) as usize;
        let at = self.problem.convergence.at(lowest);
        Some(format!("interface {} {at}", self.case.interfaces[interface].name))
    }
}
