//! That a load lifts bodies off contacts that alone hold them, in words.

use super::Stepper;
use super::words::in_words;
use crate::law::Branch;
use crate::solve::stability::held;

impl Stepper<'_> {
    /// That contacts are open in the state that was evaluated last and that nothing else holds a
    /// body, in words, if so. Collective.
    pub(super) fn lifted_bodies(&self) -> Option<String> {
        let problem = &self.problem;
        let (all, state) = (&problem.all, &problem.interfaces);
        let mut open = vec![0.0; self.case.interfaces.len()];
        let nodes = all.secondary.iter().zip(&state.response).zip(&state.initial);
        for ((rows, response), initial) in nodes {
            let law = state.laws[rows.interface].spec.law();
            let is_open = match response.branch {
                Branch::Open => true,
                // A crack that is there at the start is as a contact.
                Branch::Broken => !law.holds_opening(*initial),
                _ => false,
            };
            if is_open && rows.has_multiplier() {
                open[rows.interface] = 1.0;
            }
        }
        problem.comm.max(&mut open);
        let interfaces = self.case.interfaces.iter().zip(&open).filter(|(_, open)| **open > 0.0);
        let names: Vec<&str> = interfaces.map(|(interface, _)| interface.name.as_str()).collect();
        if names.is_empty() {
            return None;
        }
        let free = held::free_motions(problem, self.case);
        let (opens, them) = if names.len() == 1 { ("opens", "it") } else { ("open", "them") };
        (!free.is_empty()).then(|| {
            format!(
                "{} {opens}, and no load keeps {them} closed: {}; a contact holds a body as long as \
                 loads press it: lower the load that lifts or turns it, press it by its weight \
                 (gravity) or a traction, or prescribe displacements",
                in_words(&names),
                free.join("; ")
            )
        })
    }
}
