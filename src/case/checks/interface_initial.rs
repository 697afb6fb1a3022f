//! The state of interfaces at the start: cracks that are there, gaps, apertures of closed joints.

use super::checker::Checker;
use crate::case::sections::quantity::InterfaceInitialSection;
use crate::case::{InterfaceSpec, LawSpec};
use crate::error::{Error, Result, number_text};
use crate::input::Value;

/// Damage at the start below this is none: what rounding leaves of a formula. Its secant would be
/// so steep that the rounding of jumps keeps forces from their balance.
const LEAST_DAMAGE: f64 = 1e-6;

/// The state of a node of an interface at the start.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NodeStart {
    /// Damage from 0 to 1.
    pub damage: f64,
    /// Distance of the lips (m); negative where they have come into each other.
    pub gap: f64,
    /// Width in which fluid flows and is stored where the lips are closed (m).
    pub aperture: f64,
}

impl InterfaceSpec {
    /// The state at the start at a point of the interface, which is entry `index` of the case.
    ///
    /// # Errors
    /// `Input` where a formula gives what cannot be, naming entry and place.
    pub fn start_at(&self, index: usize, point: [f64; 3]) -> Result<NodeStart> {
        let initial = &self.initial;
        let at = |of: &Option<Value>| of.as_ref().map_or(0.0, |value| value.at(point, 0.0));
        let [damage, gap, aperture] = [&initial.damage, &initial.gap, &initial.aperture].map(at);
        let wrong = |key: &str, value: f64, reason: &str| {
            let [x, y, z] = point;
            let value = number_text(value);
            Err(Error::Input(format!(
                "interfaces.{index}.initial.{key}: it is {value} at ({x}, {y}, {z}) m; {reason}"
            )))
        };
        if !(0.0..=1.0).contains(&damage) {
            return wrong("damage", damage, "it must be between 0 and 1 on the whole interface");
        }
        if !gap.is_finite() {
            return wrong("gap", gap, "it must be finite on the whole interface");
        }
        if gap != 0.0 && self.law.law().strength().is_some() && damage < 1.0 {
            return wrong(
                "gap",
                gap,
                "lips that anything holds together (damage below 1) have none",
            );
        }
        if !(aperture.is_finite() && aperture >= 0.0) {
            return wrong("aperture", aperture, "it must be at least 0 on the whole interface");
        }
        let damage = if damage < LEAST_DAMAGE { 0.0 } else { damage };
        Ok(NodeStart { damage, gap, aperture })
    }

    /// Whether it holds its bodies together at the start against sliding; none where that depends
    /// on the place.
    pub fn joins_at_start(&self) -> Option<bool> {
        let law = self.law.law();
        match &self.initial.damage {
            None => Some(law.holds_sliding(0.0)),
            Some(damage) if damage.varies_in_space() => None,
            Some(damage) => Some(self.joins_with(damage.at([0.0; 3], 0.0))),
        }
    }

    /// Whether it holds its bodies together against sliding where it has a damage.
    pub fn joins_with(&self, damage: f64) -> bool {
        let law = self.law.law();
        let history = law.history_of_damage(damage).unwrap_or(0.0);
        law.holds_sliding(history) || !law.friction().is_none()
    }
}

impl Checker<'_> {
    /// Puts the state at the start of the section at `path` into an interface.
    pub(super) fn interface_initial(
        &mut self,
        path: &str,
        section: &InterfaceInitialSection,
        interface: &mut InterfaceSpec,
    ) {
        let mut value = |key: &str, of: &Option<_>| {
            let path = format!("{path}.{key}");
            of.as_ref().map(|of| self.in_space(&path, of, "a state at the start"))
        };
        interface.initial.damage = value("damage", &section.damage);
        interface.initial.gap = value("gap", &section.gap);
        interface.initial.aperture = value("aperture", &section.aperture);
        let law = &interface.law;
        if section.damage.is_some() && law.law().history_of_damage(1.0).is_none() {
            let reason = match law {
                LawSpec::Tied(_) => "is of laws that soften: tied holds for good",
                _ => "is of laws that soften: nothing holds by contact that could be damaged",
            };
            self.add(&format!("{path}.damage"), reason);
        }
        if section.gap.is_some() && matches!(law, LawSpec::Tied(_)) {
            self.add(&format!("{path}.gap"), "is of lips that can touch: tied ones are one");
        } else if section.gap.is_some()
            && law.law().strength().is_some()
            && section.damage.is_none()
        {
            let reason =
                "needs damage: 1 where the lips lie apart: nothing holds them together there";
            self.add(&format!("{path}.gap"), reason);
        } else {
            self.constants_of_initial(path, interface);
        }
        if section.aperture.is_some() && interface.film.is_none() {
            let reason = "is of an interface along which fluid flows; give it fluid: {flow: true}";
            self.add(&format!("{path}.aperture"), reason);
        }
    }

    /// Refuses numbers that cannot be; formulas are asked at the nodes.
    fn constants_of_initial(&mut self, path: &str, interface: &InterfaceSpec) {
        let initial = &interface.initial;
        let constant = |of: &Option<Value>| match of {
            Some(Value::Constant(value)) => Some(*value),
            _ => None,
        };
        let damage = constant(&initial.damage);
        if let Some(damage) = damage.filter(|damage| !(0.0..=1.0).contains(damage)) {
            let reason = format!("must be between 0 and 1, got {}", number_text(damage));
            self.add(&format!("{path}.damage"), reason);
        } else if let (Some(gap), Some(damage)) = (constant(&initial.gap), damage)
            && gap != 0.0
            && damage < 1.0
        {
            let reason = format!(
                "needs damage: 1, got {}: lips that anything holds together have none",
                number_text(damage)
            );
            self.add(&format!("{path}.gap"), reason);
        }
        if let Some(aperture) = constant(&initial.aperture).filter(|aperture| *aperture < 0.0) {
            let reason = format!("must be at least 0, got {}", number_text(aperture));
            self.add(&format!("{path}.aperture"), reason);
        }
    }
}
