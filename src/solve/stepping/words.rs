//! Why a step fails, and what may lie behind it, in words.

use super::Stepper;
use crate::case::{Control, ControlKind, InterfaceSpec};
use crate::law::InterfaceLaw;
use crate::petsc::SolveReport;
use crate::solve::stability::held;

/// Interfaces by their names, as the subject of a sentence.
pub(super) fn in_words(names: &[&str]) -> String {
    match names {
        [name] => format!("interface {name}"),
        [first @ .., last] => format!("interfaces {} and {last}", first.join(", ")),
        [] => String::new(),
    }
}

impl Stepper<'_> {
    /// What may lie behind a step that fails however small it is. Collective.
    pub(super) fn advice(&self) -> String {
        if let Some(words) = self.sliding_bodies().or_else(|| self.lifted_bodies()) {
            return format!("\n{words}");
        }
        let gave_way = self.problem.convergence.interfaces_that_gave_way(self.problem.comm);
        if let Some(Control { kind: ControlKind::Opening(_), interface }) = &self.case.control {
            return format!(
                "\nwhere the opening of an interface does not grow evenly along the path, control: \
                 {{dissipation: {{of: {}, step: 0.01}}}} may follow it",
                self.case.interfaces[*interface].name
            );
        }
        if let Some(words) = self.locked_interface() {
            return format!("\n{words}");
        }
        let softens = |law: &dyn InterfaceLaw| law.strength().is_some();
        let of_cohesive = self.case.interfaces.iter().zip(&gave_way);
        let gone: Vec<&InterfaceSpec> = of_cohesive
            .filter(|(interface, gave_way)| **gave_way && softens(interface.law.law()))
            .map(|(interface, _)| interface)
            .collect();
        if gone.is_empty() || self.problem.path.is_some() {
            return String::new();
        }
        let holds: Vec<bool> = gave_way.iter().map(|gave_way| !gave_way).collect();
        let free = self.case.free_motions(&holds, &vec![false; holds.len()]);
        let names: Vec<&str> = gone.iter().map(|interface| interface.name.as_str()).collect();
        let (first, is_one, names) = (names[0], names.len() == 1, in_words(&names));
        let whole = if is_one { "gives way over its" } else { "give way over their" };
        if free.is_empty() {
            let steepest = gone.iter().filter_map(|i| i.law.law().steepest_softening());
            let steepest = steepest.fold(0.0, f64::max);
            let column = self.case.axial_stiffness().filter(|column| steepest >= *column);
            let Some(column) = column else {
                return format!("\n{names} {whole} whole area in this step");
            };
            return format!(
                "\n{names} {whole} whole area in this step: the column, with {column:.3e} Pa/m, gives \
                 back more energy than the interface takes, which softens by up to {steepest:.3e} Pa/m \
                 (snap-back): no step is small enough, but control: {{opening: {{of: {first}, equals: \
                 ...}}}} follows it"
            );
        }
        format!(
            "\n{names} {}, and without {} {}",
            if is_one {
                "ruptures: all of it softens or is broken"
            } else {
                "rupture: all of them softens or is broken"
            },
            if is_one { "it" } else { "them" },
            free.join("; ")
        )
    }

    /// That friction may lock the interface whose dissipation is followed, in words. Collective.
    fn locked_interface(&self) -> Option<String> {
        let Some(Control { kind: ControlKind::Dissipation(_), interface }) = &self.case.control
        else {
            return None;
        };
        let (problem, interface) = (&self.problem, *interface);
        let spec = &self.case.interfaces[interface];
        let mut nodes = problem.all.secondary.iter().zip(&problem.interfaces.response);
        let rubs = nodes.any(|(rows, response)| {
            let damage = spec.law.law().damage(response.history);
            rows.interface == interface && response.branch.is_closed() && damage > 0.0
        });
        (problem.comm.any(rubs) && !spec.law.law().friction().is_none()).then(|| {
            format!(
                "lips of interface {} are closed, and their friction grows with the damage: where it \
                 holds all that the loads bring, the interface locks before it is broken, and the path \
                 ends",
                spec.name
            )
        })
    }

    /// That the interfaces that broke leave a body to itself, in words, if they do. Collective.
    pub(super) fn freed_bodies(&self, time: f64) -> Option<String> {
        if let Some(words) = self.sliding_bodies() {
            return Some(format!("at time {time} {words}"));
        }
        let problem = &self.problem;
        let count = self.case.interfaces.len();
        // Of each interface: whether some point holds, whether some lips are closed, whether there
        // are points at all.
        let mut seen = vec![0.0; 3 * count];
        for (rows, response) in problem.all.secondary.iter().zip(&problem.interfaces.response) {
            let is_separated = held::is_separated(&problem.interfaces, rows.interface, response);
            let here = [!is_separated, response.branch.is_closed(), true];
            for (kind, here) in here.into_iter().enumerate() {
                if here && rows.has_multiplier() {
                    seen[kind * count + rows.interface] = 1.0;
                }
            }
        }
        problem.comm.max(&mut seen);
        let is = |kind: usize, interface: usize| seen[kind * count + interface] > 0.0;
        let holds: Vec<bool> = (0..count).map(|i| is(0, i) || !is(2, i)).collect();
        let presses: Vec<bool> = (0..count).map(|i| is(1, i)).collect();
        let gone: Vec<usize> = (0..count).filter(|i| !holds[*i] && !presses[*i]).collect();
        let free = match gone[..] {
            [] => Vec::new(),
            _ => self.case.free_motions(&holds, &presses),
        };
        if free.is_empty() {
            return self.loose_bodies(time, &gone);
        }
        Some(format!("at time {time} {}: {}", self.broken(&gone), free.join("; ")))
    }

    /// That interfaces broke as a whole, in words.
    fn broken(&self, gone: &[usize]) -> String {
        let interfaces = gone.iter().map(|i| &self.case.interfaces[*i]);
        let names: Vec<&str> =
            interfaces.clone().map(|interface| interface.name.as_str()).collect();
        let (have, their) = if names.len() == 1 { ("has", "its") } else { ("have", "their") };
        let is_cohesive = interfaces.clone().all(|i| i.law.law().strength().is_some());
        let broke = if is_cohesive { "ruptured" } else { "opened" };
        format!("{} {have} {broke} over {their} whole area", in_words(&names))
    }

    /// That what is left of interfaces that broke in part, or as a whole where they are `gone`,
    /// does not hold a body, in words, if so. Collective.
    fn loose_bodies(&self, time: f64, gone: &[usize]) -> Option<String> {
        let problem = &self.problem;
        let (all, state) = (&problem.all, &problem.interfaces);
        let mut nodes = all.secondary.iter().zip(&state.response);
        let separated = nodes.any(|(rows, r)| held::is_separated(state, rows.interface, r));
        if !problem.comm.any(separated) {
            return None;
        }
        let free = held::free_motions(problem, self.case);
        let what = match gone {
            [] => "what is left of the interfaces does not hold".to_owned(),
            _ => self.broken(gone),
        };
        (!free.is_empty()).then(|| {
            format!(
                "at time {time} {what}: {}; prescribe displacements that prevent it, or choose a law \
                 that holds",
                free.join("; ")
            )
        })
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
        let s = if negative == 1 { "" } else { "s" };
        format!("{words}; the tangent was indefinite ({negative} negative pivot{s}){place}")
    }

    /// Interface and place of the lowest node that softened in the last solve. Collective.
    fn softening_place(&self) -> Option<String> {
        let mine = self.problem.convergence.softening;
        self.place_of(mine.map(|(name, interface)| (name, interface as usize)))
    }
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn interfaces_are_named_one_by_one() {
        assert_eq!(in_words(&["a"]), "interface a");
        assert_eq!(in_words(&["a", "b"]), "interfaces a and b");
        assert_eq!(in_words(&["a", "b", "c"]), "interfaces a, b and c");
    }
}
