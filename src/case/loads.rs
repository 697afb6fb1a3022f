//! Checks of what acts on the column: values, boundary, body force, pore pressure.

use super::boundary::{BoundarySpec, Surface};
use super::check::{Checker, LATER};
use super::file::{CaseFile, Components, Physics, Quantity};
use super::formula::Formula;
use super::material::Material;
use super::value::Value;
use crate::error::number_text;

const AXES: [&str; 3] = ["x", "y", "z"];

impl Checker<'_> {
    /// A value, with its table or formula checked.
    pub(super) fn value(&mut self, path: &str, quantity: &Quantity) -> Value {
        match quantity {
            Quantity::Number(number) => Value::Constant(*number),
            Quantity::Table(section) => {
                for (index, pair) in section.table.windows(2).enumerate() {
                    if pair[1][0] <= pair[0][0] {
                        let place = format!("{path}.table.{}", index + 1);
                        let reason = format!(
                            "has time {} after {}; the times must rise",
                            pair[1][0], pair[0][0]
                        );
                        self.add(&place, reason);
                    }
                }
                Value::Table(section.table.clone())
            }
            Quantity::Formula(section) => match Formula::parse(&section.formula) {
                Ok(formula) => {
                    if self.dim == 2 && formula.uses_y() && self.sound(&["mesh"]) {
                        self.add(&format!("{path}.formula"), "uses y, which 2D does not have");
                    }
                    Value::Formula(formula)
                }
                Err(reason) => {
                    self.add(&format!("{path}.formula"), format!("cannot be read: {reason}"));
                    Value::Constant(0.0)
                }
            },
        }
    }

    pub(super) fn boundary(&mut self, file: &CaseFile) -> Vec<BoundarySpec> {
        let mut entries = Vec::new();
        for (index, section) in file.boundary.iter().enumerate() {
            let path = format!("boundary.{index}");
            let on = section.on;
            let displacement =
                self.components(&format!("{path}.displacement"), &section.displacement);
            let traction = self.components(&format!("{path}.traction"), &section.traction);
            let pressure = section.pressure.as_ref().map(|pressure| {
                let value = self.value(&format!("{path}.pressure"), pressure);
                if !value.is_zero() {
                    let reason = format!("other than 0 {LATER}");
                    self.add(&format!("{path}.pressure"), reason);
                }
                value
            });
            if section.flux.is_some() {
                self.add(&format!("{path}.flux"), LATER);
            }
            if self.dim == 2 && self.sound(&["mesh"]) && on.axis().is_some_and(|(a, _)| a == 1) {
                self.add(&format!("{path}.on"), format!("`{}` does not exist in 2D", on.name()));
            }
            let mechanical = !section.displacement.is_empty() || !section.traction.is_empty();
            if on == Surface::All && mechanical {
                self.add(&path, "is on `all`, which can carry a pressure only");
            } else if !mechanical && pressure.is_none() && section.flux.is_none() {
                self.add(&path, "prescribes nothing; give displacement, traction or pressure");
            }
            entries.push(BoundarySpec { on, displacement, traction, pressure });
        }
        entries
    }

    fn components(&mut self, path: &str, components: &Components) -> [Option<Value>; 3] {
        if self.dim == 2 && components.y.is_some() && self.sound(&["mesh"]) {
            self.add(&format!("{path}.y"), "does not exist in 2D");
        }
        let parts = [&components.x, &components.y, &components.z];
        std::array::from_fn(|axis| {
            parts[axis].as_ref().map(|part| self.value(&format!("{path}.{}", AXES[axis]), part))
        })
    }

    pub(super) fn body_force(&mut self, file: &CaseFile) -> [Value; 3] {
        if let Some(gravity) = &file.gravity {
            if gravity.len() != self.dim && self.sound(&["mesh"]) {
                let reason = format!("must have {} entries, got {}", self.dim, gravity.len());
                self.add("gravity", reason);
            }
            if gravity.iter().any(|component| *component != 0.0) {
                self.add("gravity", format!("other than 0 {LATER}"));
            } else {
                self.left_out.push("Gravity is left out: it is 0.".to_owned());
            }
        }
        self.components("body_force", &file.body_force)
            .map(|part| part.unwrap_or(Value::Constant(0.0)))
    }

    /// Prescribed displacements that cannot agree: values that are the same everywhere on
    /// surfaces that share nodes. Values that vary in space are compared node by node later.
    pub(super) fn agreement(&mut self, boundary: &[BoundarySpec], instants: &[f64]) {
        let meet = |a: Surface, b: Surface| match (a.axis(), b.axis()) {
            (Some((one, _)), Some((other, _))) => a == b || one != other,
            _ => false,
        };
        // Each value once at each instant, where it is the same in space.
        let values: Vec<[Option<Vec<f64>>; 3]> = boundary
            .iter()
            .map(|entry| {
                [0, 1, 2].map(|axis| {
                    let value = entry.displacement[axis].as_ref()?;
                    let at = |time: &f64| value.at([0.0; 3], *time);
                    (!value.varies_in_space()).then(|| instants.iter().map(at).collect())
                })
            })
            .collect();
        for (index, entry) in boundary.iter().enumerate() {
            for (earlier, other) in boundary[..index].iter().enumerate() {
                if !meet(entry.on, other.on) {
                    continue;
                }
                for (axis, name) in AXES.iter().enumerate() {
                    let (Some(value), Some(first)) = (&values[index][axis], &values[earlier][axis])
                    else {
                        continue;
                    };
                    let largest =
                        value.iter().chain(first).fold(0.0, |most: f64, v| most.max(v.abs()));
                    let clash = value
                        .iter()
                        .zip(first)
                        .position(|(value, first)| (value - first).abs() > 1e-12 * largest);
                    if let Some(at) = clash {
                        let reason = format!(
                            "disagrees with boundary.{earlier} ({}): {} against {} at time {} on \
                             the nodes of both",
                            other.on.name(),
                            number_text(value[at]),
                            number_text(first[at]),
                            instants[at],
                        );
                        self.add(&format!("boundary.{index}.displacement.{name}"), reason);
                    }
                }
            }
        }
    }

    /// Whether the pore pressure can be left out: it must be known to be 0 everywhere.
    pub(super) fn pore_pressure(&mut self, file: &CaseFile, materials: &[Material]) {
        let initial = file.initial.as_ref().and_then(|initial| initial.pressure.as_ref());
        if let Some(pressure) = initial
            && !self.value("initial.pressure", pressure).is_zero()
        {
            self.add("initial.pressure", format!("other than 0 {LATER}"));
            return;
        }
        let everywhere =
            file.boundary.iter().any(|entry| entry.on == Surface::All && entry.pressure.is_some());
        let porous: Vec<&str> = materials
            .iter()
            .filter(|material| material.porous.is_some())
            .map(|material| material.name.as_str())
            .collect();
        let data = match &porous[..] {
            [] => String::new(),
            names => format!(", and the porous data of {} with it", names.join(", ")),
        };
        if everywhere {
            self.left_out.push(format!(
                "Pore pressure and flow are left out{data}: the pressure is prescribed as 0 on all \
                 nodes, so it changes nothing."
            ));
        } else if file.physics == Physics::Mechanics && !porous.is_empty() {
            self.left_out.push(format!(
                "Pore pressure and flow are left out{data}: the case asks for mechanics."
            ));
        } else if let Some(name) = porous.first() {
            let reason = format!(
                "needs the coupled model, which {LATER}; prescribe {{on: all, pressure: 0}} or \
                 choose physics: mechanics"
            );
            self.add(&format!("materials.{name}.porous"), reason);
        } else if initial.is_some() || file.boundary.iter().any(|e| e.pressure.is_some()) {
            self.left_out.push(
                "Pore pressure is left out: it is 0 wherever it is prescribed and no material is \
                 porous."
                    .to_owned(),
            );
        }
    }
}
