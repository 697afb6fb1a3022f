//! That bodies slide on friction alone, in words.

use super::Stepper;
use super::words::in_words;
use crate::law::Branch;
use crate::solve::stability::held;

impl Stepper<'_> {
    /// That interfaces slide with friction over their whole area in the state that was evaluated
    /// last, and that nothing else stops a body, in words, if so. Collective.
    pub(super) fn sliding_bodies(&self) -> Option<String> {
        let problem = &self.problem;
        if !self.case.has_friction() {
            return None;
        }
        let count = self.case.interfaces.len();
        let mut seen = vec![0.0; 2 * count];
        for (rows, response) in problem.all.secondary.iter().zip(&problem.interfaces.response) {
            let slides = response.branch == Branch::Sliding;
            let holds = !held::is_separated(&problem.interfaces, rows.interface, response);
            seen[rows.interface] += f64::from(u8::from(slides && rows.has_multiplier()));
            seen[count + rows.interface] += f64::from(u8::from(holds && rows.has_multiplier()));
        }
        problem.comm.sum(&mut seen);
        let slides = |index: &usize| seen[*index] > 0.0 && seen[count + index] == 0.0;
        let names = (0..count).filter(slides).map(|i| self.case.interfaces[i].name.as_str());
        let names: Vec<&str> = names.collect();
        if names.is_empty() {
            return None;
        }
        let free = held::free_motions(problem, self.case);
        let (slide, their) = if names.len() == 1 { ("slides", "its") } else { ("slide", "their") };
        (!free.is_empty()).then(|| {
            format!(
                "{} {slide} with friction over {their} whole area, and nothing else stops it: {}",
                in_words(&names),
                free.join("; ")
            )
        })
    }
}
