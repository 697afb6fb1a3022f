//! Flow in the pores: whether the case needs it, and what it consists of.

use super::checker::Checker;
use crate::case::InterfaceSpec;
use crate::case::sections::file::{CaseFile, Physics};
use crate::case::sections::{BoundarySpec, Form, Material, Stability, Surface};
use crate::error::number_text;
use crate::input::Value;

/// Flow of the fluid in the pores.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowSpec {
    /// Weight of the end of a step, 0.5 to 1.
    pub theta: f64,
    /// Error of the pressure that a step may make, over the largest so far; none: one step per
    /// instant.
    pub tolerance: Option<f64>,
    /// Pore pressure at the start (Pa).
    pub initial: Value,
    /// Whether the displacements at the start are in equilibrium with it, or 0.
    pub equilibrium: bool,
    /// Whether each node stores the fluid of its share of a cell by its own pressure.
    pub lumped: bool,
}

/// What the case says of pressures and fluxes.
struct Given<'a> {
    porous: Vec<&'a str>,
    initial: Option<Value>,
    /// Whether the pressure of every node is prescribed.
    known: bool,
    /// Path of the first pressure that acts on the skeleton: the prescribed one, or the reference
    /// where another one is prescribed.
    acts: Option<String>,
    /// Path of the first entry whose only result is a flow.
    flows: Option<String>,
    /// The first expectation of what only flow can give.
    expects: Option<String>,
}

impl Given<'_> {
    /// Whether the pressure acts as a load that is known beforehand, or not at all.
    fn is_load(&self) -> bool {
        !self.porous.is_empty() && self.known && self.flows.is_none()
    }
}

/// Whether a quantity is computed with flow only, or also where the pressure is a known load.
fn is_of_flow(quantity: &str) -> bool {
    let last = quantity.rsplit('.').next().unwrap_or_default();
    quantity.starts_with("mass.") || matches!(last, "flux_lower" | "flux_upper")
}

fn is_of_pressure(quantity: &str) -> bool {
    quantity.ends_with(".pressure") || quantity == "energy.fluid"
}

fn starts_in_equilibrium(file: &CaseFile) -> bool {
    file.initial.as_ref().is_some_and(|initial| initial.equilibrium)
}

/// The physics that is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PhysicsDecision {
    /// Equilibrium alone; the pore pressure is known beforehand.
    Mechanics,
    /// Equilibrium, and flow in the pores.
    HydroMechanics,
}

impl PhysicsDecision {
    /// Its name in a case file and in `report.json`.
    pub fn name(self) -> &'static str {
        match self {
            PhysicsDecision::Mechanics => "mechanics",
            PhysicsDecision::HydroMechanics => "hydro_mechanics",
        }
    }
}

impl Checker<'_> {
    /// What is computed, the flow if it is, and whether a pressure acts as a load without it.
    pub(super) fn physics(
        &mut self,
        file: &CaseFile,
        materials: &[Material],
        interfaces: &[InterfaceSpec],
        boundary: &[BoundarySpec],
    ) -> (PhysicsDecision, Option<FlowSpec>, bool) {
        let given = self.given(file, materials, interfaces, boundary);
        let theta = file.time.theta.unwrap_or(1.0);
        if !(0.5..=1.0).contains(&theta) {
            let reason = format!("must lie in [0.5, 1], got {}", number_text(theta));
            self.add("time.theta", reason);
        }
        self.gravity(file, materials);
        if !self.sound(&["physics", "materials", "boundary", "initial", "interfaces"]) {
            return (PhysicsDecision::Mechanics, None, false);
        }
        let needs_flow = match file.physics {
            Physics::HydroMechanics => true,
            Physics::Mechanics => false,
            Physics::Auto => {
                // With a tolerance steps are as long as the error of the pressure allows.
                let asked = given.expects.is_some() || file.time.tolerance.is_some();
                !given.porous.is_empty() && (asked || !given.is_load())
            }
        };
        if !needs_flow {
            let acting = given.acts.as_ref().filter(|_| given.is_load());
            match acting {
                Some(path) => self.take_as_load(file, materials, &given, path),
                None => self.leave_out(file, &given),
            }
            return (PhysicsDecision::Mechanics, None, acting.is_some());
        }
        if given.porous.is_empty() {
            self.add("physics", "hydro_mechanics needs a material with porous data");
        }
        self.pressures_on_pores(materials, boundary);
        self.one_fluid(materials);
        self.beside_flow(file);
        let initial = given.initial.unwrap_or(Value::Constant(0.0));
        let (tolerance, lumped) = (file.time.tolerance, file.solver.lumped_storage);
        let equilibrium = starts_in_equilibrium(file);
        let flow = FlowSpec { theta, tolerance, initial, equilibrium, lumped };
        (PhysicsDecision::HydroMechanics, Some(flow), false)
    }

    fn given<'a>(
        &mut self,
        file: &CaseFile,
        materials: &'a [Material],
        interfaces: &[InterfaceSpec],
        boundary: &[BoundarySpec],
    ) -> Given<'a> {
        let porous = materials.iter().filter(|material| material.porous.is_some());
        let porous = porous.map(|material| material.name.as_str()).collect();
        let initial = file.initial.as_ref().and_then(|initial| initial.pressure.as_ref());
        let initial = initial.map(|pressure| self.value("initial.pressure", pressure));
        let is_known = |b: &BoundarySpec| b.on == Surface::All && b.pressure.is_some();
        let known = boundary.iter().any(is_known);
        let (mut acts, mut flows) = (None, None);
        for (index, entry) in boundary.iter().enumerate() {
            if entry.pressure.as_ref().is_some_and(|value| !value.is_zero()) {
                acts.get_or_insert_with(|| format!("boundary.{index}.pressure"));
            }
            if entry.flux.as_ref().is_some_and(|value| !value.is_zero()) {
                flows.get_or_insert_with(|| format!("boundary.{index}.flux"));
            }
        }
        for (index, interface) in interfaces.iter().enumerate() {
            if interface.connected {
                flows.get_or_insert_with(|| format!("interfaces.{index}.fluid.connected"));
            }
            if interface.film.is_some() {
                flows.get_or_insert_with(|| format!("interfaces.{index}.fluid"));
            }
        }
        // Where all pressures are prescribed it only tells how much fluid comes in first.
        if !known && initial.as_ref().is_some_and(|initial| !initial.is_zero()) {
            flows.get_or_insert_with(|| "initial.pressure".to_owned());
        }
        let reference = |m: &&Material| {
            m.porous.as_ref().is_some_and(|porous| porous.reference_pressure != 0.0)
        };
        if let Some(material) = materials.iter().find(reference).filter(|_| known) {
            let path = format!("materials.{}.porous.reference_pressure", material.name);
            acts.get_or_insert(path);
        }
        let only =
            |quantity: &str| is_of_flow(quantity) || acts.is_none() && is_of_pressure(quantity);
        let expects = file.expect.iter().map(|e| e.quantity.as_str()).find(|q| only(q));
        let expects = expects.map(str::to_owned);
        Given { porous, initial, known, acts, flows, expects }
    }

    /// Says why the pore pressure is left out, or refuses to.
    fn leave_out(&mut self, file: &CaseFile, given: &Given<'_>) {
        let has_stress = file.initial.as_ref().is_some_and(|initial| initial.stress.is_some());
        if starts_in_equilibrium(file) && !has_stress {
            let reason = "needs a pore pressure that is computed (materials.NAME.porous and \
                          physics: hydro_mechanics); without one a run starts undeformed";
            self.add("initial.equilibrium", reason);
        }
        if let Some(path) = given.acts.as_ref().or(given.flows.as_ref()) {
            let reason = if given.porous.is_empty() {
                "acts on pores, but no material is porous (materials.NAME.porous)"
            } else {
                "needs physics: hydro_mechanics or auto"
            };
            self.add(path, reason);
            return;
        }
        let data = match &given.porous[..] {
            [] => String::new(),
            names => format!(", and the porous data of {} with it", names.join(", ")),
        };
        if given.known {
            self.left_out.push(format!(
                "Pore pressure and flow are left out{data}: the pressure is prescribed as 0 on all \
                 nodes, so it changes nothing."
            ));
        } else if file.physics == Physics::Mechanics && !given.porous.is_empty() {
            self.left_out.push(format!(
                "Pore pressure and flow are left out{data}: the case asks for mechanics."
            ));
        } else if given.initial.is_some() || file.boundary.iter().any(|e| e.pressure.is_some()) {
            self.left_out.push(
                "Pore pressure is left out: it is 0 wherever it is prescribed and no material is \
                 porous."
                    .to_owned(),
            );
        }
    }

    /// Says that the pressure acts as a load, and what is left out then.
    fn take_as_load(
        &mut self,
        file: &CaseFile,
        materials: &[Material],
        given: &Given<'_>,
        path: &str,
    ) {
        self.one_fluid(materials);
        if file.control.is_some() {
            self.add("control", format!("does not scale the pore pressure ({path})"));
        }
        self.left_out.push(format!(
            "Flow is left out, and with it the fluid's mass, its flux and the porosity of {} in \
             history and fields: the pressure is prescribed on all nodes, so it acts as a load, \
             biot times what it is above the reference pressure; physics: hydro_mechanics gives them.",
            given.porous.join(", ")
        ));
    }

    /// Pressures and fluxes act where there are pores.
    fn pressures_on_pores(&mut self, materials: &[Material], boundary: &[BoundarySpec]) {
        for (index, entry) in boundary.iter().enumerate() {
            let acting = [("pressure", &entry.pressure), ("flux", &entry.flux)];
            let Some((key, _)) = acting.iter().find(|(_, value)| value.is_some()) else { continue };
            let touched = match entry.on {
                Surface::Bottom => &materials[..1.min(materials.len())],
                Surface::Top => &materials[materials.len().saturating_sub(1)..],
                _ => materials,
            };
            if !touched.is_empty() && touched.iter().all(|material| material.porous.is_none()) {
                let names: Vec<&str> = touched.iter().map(|m| m.name.as_str()).collect();
                let reason = format!(
                    "acts on {}, which has no porous data (materials.{}.porous)",
                    names.join(", "),
                    names[0]
                );
                self.add(&format!("boundary.{index}.{key}"), reason);
            }
        }
    }

    /// One fluid fills all pores.
    fn one_fluid(&mut self, materials: &[Material]) {
        let mut all = materials.iter().filter_map(|m| Some((m, m.porous.as_ref()?)));
        let Some((first, one)) = all.next() else { return };
        for (material, other) in all {
            let pairs = [
                ("fluid_density", one.fluid_density, other.fluid_density),
                ("fluid_compressibility", one.fluid_compressibility, other.fluid_compressibility),
                ("reference_pressure", one.reference_pressure, other.reference_pressure),
            ];
            for (key, a, b) in pairs.iter().filter(|(_, a, b)| a != b) {
                let reason = format!(
                    "is {}, but {} in {}: one fluid fills all pores",
                    number_text(*b),
                    number_text(*a),
                    first.name
                );
                self.add(&format!("materials.{}.porous.{key}", material.name), reason);
            }
        }
    }

    /// What cannot stand beside flow.
    fn beside_flow(&mut self, file: &CaseFile) {
        if file.control.is_some() {
            self.add("control", "cannot stand beside flow, which depends on time");
        }
        if file.solver.form == Form::SaddlePoint {
            self.add("solver.form", "saddle_point knows no pore pressure; take condensed");
        }
        match file.solver.stability {
            Stability::Warn | Stability::Stop | Stability::Follow => {
                let reason =
                    "must be auto or off with flow: states with flow have no energy to test";
                self.add("solver.stability", reason);
            }
            Stability::Auto => self.left_out.push(
                "The test of stability is left out: states with flow have no energy to test."
                    .to_owned(),
            ),
            Stability::Off => {}
        }
    }

    /// Gravity acts on the density of the materials.
    fn gravity(&mut self, file: &CaseFile, materials: &[Material]) {
        let Some(gravity) = &file.gravity else { return };
        if gravity.len() != self.dim && self.knows_dimension && self.sound(&["mesh"]) {
            let reason = format!("must have {} entries, got {}", self.dim, gravity.len());
            self.add("gravity", reason);
        }
        if gravity.iter().all(|component| *component == 0.0) {
            self.left_out.push("Gravity is left out: it is 0.".to_owned());
            return;
        }
        for material in materials.iter().filter(|material| material.density.is_none()) {
            let reason = "is missing: gravity acts on it (of a saturated medium on porous.density)";
            self.add(&format!("materials.{}.elastic.density", material.name), reason);
        }
    }
}
