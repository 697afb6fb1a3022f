//! Checks of what acts on the column: values, boundary, body force.

use super::checker::Checker;
use crate::case::sections::file::{CaseFile, Components};
use crate::case::sections::quantity::Quantity;
use crate::case::sections::{BoundarySpec, Surface};
use crate::error::number_text;
use crate::input::{Formula, Value};

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
            let mut value = |key: &str, quantity: &Option<Quantity>| {
                quantity.as_ref().map(|quantity| self.value(&format!("{path}.{key}"), quantity))
            };
            let pressure = value("pressure", &section.pressure);
            let flux = value("flux", &section.flux);
            if self.dim == 2 && self.sound(&["mesh"]) && on.axis().is_some_and(|(a, _)| a == 1) {
                self.add(&format!("{path}.on"), format!("`{}` does not exist in 2D", on.name()));
            }
            let mechanical = !section.displacement.is_empty() || !section.traction.is_empty();
            if on == Surface::All && mechanical {
                self.add(&path, "is on `all`, which can carry a pressure only");
            } else if on == Surface::All && flux.is_some() {
                self.add(&format!("{path}.flux"), "is on `all`, which is no surface");
            } else if pressure.is_some() && flux.is_some() {
                self.add(&path, "prescribes the pressure and the flux; give one of them");
            } else if !mechanical && pressure.is_none() && flux.is_none() {
                self.add(&path, "prescribes nothing; give displacement, traction or pressure");
            }
            entries.push(BoundarySpec { on, displacement, traction, pressure, flux });
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
}
