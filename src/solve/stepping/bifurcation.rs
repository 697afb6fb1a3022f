//! States that are not unique, and what follows from one that is not stable.

use crate::case::Case;
use crate::solve::stability::Instability;

/// Energies that differ by less than this part of what was gained, or of themselves, are the same.
const SAME_ENERGY: [f64; 2] = [1e-8, 1e-13];

/// A state that is not unique: it was reached along the mode of another, which is not stable.
#[derive(Debug, Clone, PartialEq)]
pub struct Bifurcation {
    /// The unstable state.
    pub unstable: Instability,
    /// Potential energy of the unstable state and of the one that was taken (J; 2D: per metre).
    pub energy: [f64; 2],
    /// That of the stable state in the opposite direction of the mode, where there is one.
    pub opposite: Option<f64>,
    /// Where the state that was taken has the largest jump: interface and place in words.
    pub(super) largest: (usize, String),
}

impl Bifurcation {
    /// Whether the two directions of the mode are each other's mirror image, as far as the energy
    /// tells.
    pub(super) fn is_symmetric(&self) -> bool {
        self.opposite.is_some_and(|opposite| !is_less(self.energy[1], opposite, self.energy))
    }

    /// In words.
    pub fn words(&self, case: &Case) -> String {
        let [before, after] = self.energy;
        let (interface, place) = &self.largest;
        let unit = if case.dim == 2 { "J/m" } else { "J" };
        let opposite = match self.opposite {
            Some(_) if self.is_symmetric() => {
                "its mirror image, in the opposite direction, has the same energy and is as good an \
                 answer"
                    .to_owned()
            }
            Some(energy) => {
                format!("in the opposite direction there is another, with {energy:.9e} {unit}")
            }
            None => "none was found in the opposite direction".to_owned(),
        };
        format!(
            "the state at time {} is not unique: one is not stable, its tangent has {}; taken is the \
             stable one along this mode, with the largest jump of interface {} {place} and a \
             potential energy of {after:.9e} {unit} instead of {before:.9e} {unit}; {opposite}",
            self.unstable.time,
            self.unstable.findings(case),
            case.interfaces[*interface].name,
        )
    }
}

/// Whether an energy is less than another, by more than rounding where `energies` were passed.
pub(super) fn is_less(energy: f64, than: f64, energies: [f64; 2]) -> bool {
    let [before, after] = energies;
    let [part, rounding] = SAME_ENERGY;
    energy < than - part * (before - after).abs() - rounding * before.abs().max(after.abs())
}

/// What follows from an unstable state.
pub(super) enum Consequence {
    /// It is taken, as the unstable state that it is.
    Taken,
    /// Another state at the same time has taken its place.
    Left(Box<Bifurcation>),
    /// The step is cut.
    Cut,
}
