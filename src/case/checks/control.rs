//! Path following: what the load factor follows from.

use super::checker::Checker;
use crate::case::sections::file::{CaseFile, ControlSection};
use crate::case::sections::{Form, Stability};
use crate::case::{InterfaceSpec, LawSpec};
use crate::input::Value;
use crate::input::problems::suggestion;

/// The quantity that is prescribed in place of the size of the loads.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// The interface it belongs to.
    pub interface: usize,
    /// Which it is.
    pub kind: ControlKind,
}

/// A quantity of an interface.
#[derive(Debug, Clone, PartialEq)]
pub enum ControlKind {
    /// The mean normal jump (m), over time; the loads are those of the time.
    Opening(Value),
    /// The dissipated part of the energy, which takes the place of the time; the loads are those
    /// of the given time.
    Dissipation(f64),
}

/// The instants of a case, and where it starts.
pub(super) struct Instants {
    pub start: f64,
    pub times: Vec<f64>,
}

impl Control {
    /// What the quantity is to be at `time`.
    pub fn target(&self, time: f64) -> f64 {
        match &self.kind {
            ControlKind::Opening(value) => value.at([0.0; 3], time),
            ControlKind::Dissipation(_) => time,
        }
    }

    /// The time of the loads.
    pub fn load_time(&self, time: f64) -> f64 {
        match self.kind {
            ControlKind::Opening(_) => time,
            ControlKind::Dissipation(load_time) => load_time,
        }
    }

    /// The quantity in words.
    pub fn words(&self, interfaces: &[InterfaceSpec]) -> String {
        let name = &interfaces[self.interface].name;
        match self.kind {
            ControlKind::Opening(_) => format!("the mean opening of {name}"),
            ControlKind::Dissipation(_) => format!("the dissipation of {name}"),
        }
    }
}

impl Checker<'_> {
    /// Refuses what cannot stand beside control.
    fn beside_control(&mut self, file: &CaseFile, interfaces: &[InterfaceSpec]) {
        if file.solver.form == Form::SaddlePoint {
            self.add("control", "needs solver.form: condensed");
        }
        if file.solver.stability == Stability::Follow {
            let reason = "follow cannot stand beside control: a path goes through states that are \
                          not stable";
            self.add("solver.stability", reason);
        }
        let has_cohesion = |i: &InterfaceSpec| matches!(&i.law, LawSpec::Contact(contact) if contact.cohesion > 0.0);
        if let Some(bound) = interfaces.iter().position(has_cohesion) {
            let reason = "cannot stand beside control: a path starts at loads that are scaled in \
                          proportion, and cohesion does not grow with them";
            self.add(&format!("interfaces.{bound}.law.contact.cohesion"), reason);
        }
        if let Some(fluid) = interfaces.iter().position(|i| i.fluid_pressure.is_some()) {
            let reason = "cannot stand beside control: the load factor does not scale it";
            self.add(&format!("interfaces.{fluid}.fluid"), reason);
        }
    }

    /// The control, and the instants: with dissipation its values.
    pub(super) fn control(
        &mut self,
        file: &CaseFile,
        interfaces: &[InterfaceSpec],
        instants: Instants,
    ) -> (Option<Control>, Instants) {
        let Some(section) = &file.control else { return (None, instants) };
        let (of, path) = match section {
            ControlSection::Opening(opening) => (&opening.of, "control.opening"),
            ControlSection::Dissipation(dissipation) => (&dissipation.of, "control.dissipation"),
        };
        self.beside_control(file, interfaces);
        let Some(interface) = interfaces.iter().position(|i| i.name == *of) else {
            let names: Vec<String> = interfaces.iter().map(|i| i.name.clone()).collect();
            let hint = suggestion(of, &names);
            self.add(&format!("{path}.of"), format!("must name an interface, got `{of}`{hint}"));
            return (None, instants);
        };
        if interfaces[interface].law.law().strength().is_none() {
            let reason = format!("names `{of}`, which has no strength to be followed beyond");
            self.add(&format!("{path}.of"), reason);
        }
        let damage = &interfaces[interface].initial.damage;
        if matches!(damage, Some(Value::Constant(damage)) if *damage == 1.0) {
            let reason = format!("names `{of}`, which is broken from the start");
            self.add(&format!("{path}.of"), reason);
        }
        let by_dissipation = matches!(section, ControlSection::Dissipation(_));
        if by_dissipation && !interfaces[interface].law.law().history_is_size_of_jump() {
            let reason = format!(
                "names `{of}`, whose modes differ in strength or energy: what is dissipated is no \
                 measure of its path; take control.opening"
            );
            self.add(&format!("{path}.of"), reason);
        }
        match section {
            ControlSection::Opening(opening) => {
                let equals = self.value("control.opening.equals", &opening.equals);
                let kind = ControlKind::Opening(equals);
                (Some(Control { interface, kind }), instants)
            }
            ControlSection::Dissipation(dissipation) => {
                let load_time = instants.times.last().copied().unwrap_or(instants.start);
                let kind = ControlKind::Dissipation(load_time);
                let steps = (1.0 / dissipation.step - 1e-9).ceil().max(1.0);
                // Where the steps fill 1, their multiples are as one writes them.
                let even = (1.0 / dissipation.step - steps).abs() < 1e-9;
                let value = |k: f64| if even { k / steps } else { (k * dissipation.step).min(1.0) };
                // The first value is 0: the state in which something is about to give way.
                let times = (0..=steps as usize).map(|k| value(k as f64)).collect();
                let instants = Instants { start: -dissipation.step, times };
                (Some(Control { interface, kind }), instants)
            }
        }
    }
}
