//! Checks of what acts on the mesh: values, boundary, body force.

use super::checker::Checker;
use super::results::TOTAL;
use crate::case::sections::file::{BoundarySection, CaseFile, Components};
use crate::case::sections::quantity::{Quantity, TableSection};
use crate::case::sections::{BoundarySpec, Surface};
use crate::error::number_text;
use crate::input::problems::{shortened, suggestion};
use crate::input::{Formula, Value};

const AXES: [&str; 4] = ["x", "y", "z", "normal"];

impl Checker<'_> {
    /// A value, with its table or formula checked.
    pub(super) fn value(&mut self, path: &str, quantity: &Quantity) -> Value {
        match quantity {
            Quantity::Number(number) => Value::Constant(*number),
            Quantity::Table(section) => self.table(path, section),
            Quantity::Formula(section) => match Formula::parse(&section.formula) {
                Ok(formula) => {
                    if !self.is_of_file && self.lacks(1) && formula.uses_y() {
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

    /// A table, over time or over a coordinate.
    fn table(&mut self, path: &str, section: &TableSection) -> Value {
        let (what, all) = match section.over {
            None => ("time", "the times"),
            Some(_) => ("coordinate", "the coordinates"),
        };
        for (index, pair) in section.table.windows(2).enumerate() {
            if pair[1][0] <= pair[0][0] {
                let place = format!("{path}.table.{}", index + 1);
                let (before, after) = (pair[0][0], pair[1][0]);
                self.add(&place, format!("has {what} {after} after {before}; {all} must rise"));
            }
        }
        let Some(over) = section.over else { return Value::Table(section.table.clone()) };
        let axis = over as usize;
        if self.lacks(axis) {
            let lack = self.lack();
            self.add(&format!("{path}.over"), lack);
        }
        Value::Profile(axis, section.table.clone())
    }

    pub(super) fn boundary(&mut self, file: &CaseFile) -> Vec<BoundarySpec> {
        let mut entries = Vec::new();
        for (index, section) in file.boundary.iter().enumerate() {
            let path = format!("boundary.{index}");
            let on = self.surface(&format!("{path}.on"), section);
            let mut vector =
                |key: &str, of: &Components| self.vector(&format!("{path}.{key}"), of, &on);
            let (displacement, normal_displacement) = vector("displacement", &section.displacement);
            let (traction, normal_traction) = vector("traction", &section.traction);
            let mut value = |key: &str, quantity: &Option<Quantity>| {
                quantity.as_ref().map(|quantity| self.value(&format!("{path}.{key}"), quantity))
            };
            let pressure = value("pressure", &section.pressure);
            let flux = value("flux", &section.flux);
            let mut displacement = displacement;
            let rigid = self.rigid(&path, section);
            if let Some(rigid) = &rigid {
                displacement = self.displacement_of_platen(&path, rigid, displacement);
            }
            let is_moved = !section.displacement.is_empty() || section.rigid.is_some();
            let mechanical = is_moved || !section.traction.is_empty();
            if on == Surface::All && mechanical {
                self.add(&path, "is on `all`, which can carry a pressure only");
            } else if on == Surface::All && flux.is_some() {
                self.add(&format!("{path}.flux"), "is on `all`, which is no surface");
            } else if pressure.is_some() && flux.is_some() {
                self.add(&path, "prescribes the pressure and the flux; give one of them");
            } else if !mechanical && pressure.is_none() && flux.is_none() {
                self.add(
                    &path,
                    "prescribes nothing; give displacement, traction, pressure or rigid",
                );
            }
            entries.push(BoundarySpec {
                on,
                displacement,
                normal_displacement,
                traction,
                normal_traction,
                pressure,
                flux,
                rigid,
            });
        }
        self.platens(file, &entries);
        entries
    }

    /// The surfaces that nodes are marked with: the sides of a column, or each group of a file on
    /// which something is prescribed.
    pub(super) fn surfaces(&self, boundary: &[BoundarySpec]) -> Vec<Surface> {
        if !self.is_of_file {
            return Surface::COLUMN.to_vec();
        }
        let mut surfaces: Vec<Surface> = Vec::new();
        let of_stages = self.surfaces_of_stages.iter().map(|(on, _)| self.surface_named(on));
        for on in of_stages.chain(boundary.iter().map(|entry| entry.on.clone())) {
            if on != Surface::All && !surfaces.contains(&on) {
                surfaces.push(on);
            }
        }
        surfaces
    }

    /// The surfaces that have a prescribed displacement in some stage (0), or are platens (1).
    pub(super) fn supported_in_stages(&self, kind: usize) -> Vec<Surface> {
        let supported = self.surfaces_of_stages.iter().filter(|(_, kinds)| kinds[kind]);
        supported.map(|(on, _)| self.surface_named(on)).collect()
    }

    fn surface_named(&self, on: &str) -> Surface {
        let sides = if self.is_of_file { &[] } else { &Surface::COLUMN[..] };
        let side = sides.iter().chain([&Surface::All]).find(|side| side.name() == on);
        side.cloned().unwrap_or_else(|| Surface::Group(on.to_owned()))
    }

    /// A column has six sides and no groups, a file has groups only, whatever their names.
    fn surface(&mut self, path: &str, section: &BoundarySection) -> Surface {
        let (on, name) = (&section.on, section.on.name());
        if self.is_of_file && *on != Surface::All {
            if name.is_empty() {
                self.add(path, "is empty; it must name a group of the mesh file, or be all");
            } else if name == TOTAL && (!section.displacement.is_empty() || section.rigid.is_some())
            {
                let reason = format!(
                    "cannot be `{TOTAL}` where a displacement is prescribed: {TOTAL}.reaction_x is \
                     the sum over all surfaces; rename the group"
                );
                self.add(path, reason);
            }
            return Surface::Group(name.to_owned());
        }
        if matches!(on, Surface::Group(_)) && self.sound(&["mesh"]) {
            let sides = Surface::COLUMN.iter().chain([&Surface::All]);
            let known: Vec<String> = sides.map(|side| side.name().to_owned()).collect();
            self.add(path, format!("cannot be `{}`{}", shortened(name), suggestion(name, &known)));
            self.broken.insert("boundary".to_owned());
        }
        if on.axis().is_some_and(|(axis, _)| self.lacks(axis)) {
            self.add(path, format!("`{name}` {}", self.lack()));
        }
        on.clone()
    }

    /// Components along the axes, and along the normal where that is none of them.
    fn vector(
        &mut self,
        path: &str,
        components: &Components,
        on: &Surface,
    ) -> ([Option<Value>; 3], Option<Value>) {
        let mut vector = self.components(path, components);
        let path = format!("{path}.normal");
        let normal = components.normal.as_ref().map(|normal| self.value(&path, normal));
        let (Some(value), Some((axis, is_far))) = (&normal, on.axis()) else {
            return (vector, normal);
        };
        if vector[axis].is_some() {
            let (name, axis) = (on.name(), AXES[axis]);
            let reason =
                format!("is along {axis} on `{name}`, where {axis} is given too; give one");
            self.add(&path, reason);
        }
        vector[axis] = Some(if is_far { value.clone() } else { value.negated() });
        (vector, None)
    }

    fn components(&mut self, path: &str, components: &Components) -> [Option<Value>; 3] {
        let parts = [&components.x, &components.y, &components.z];
        std::array::from_fn(|axis| {
            let (part, path) = (parts[axis].as_ref()?, format!("{path}.{}", AXES[axis]));
            if self.lacks(axis) {
                let lack = self.lack();
                self.add(&path, lack);
            }
            Some(self.value(&path, part))
        })
    }

    pub(super) fn body_force(&mut self, file: &CaseFile) -> [Value; 3] {
        if file.body_force.normal.is_some() {
            self.add("body_force.normal", "acts inside the cells, where there is no normal");
        }
        self.components("body_force", &file.body_force)
            .map(|part| part.unwrap_or(Value::Constant(0.0)))
    }

    /// Prescribed displacements that cannot agree: values that are the same everywhere on
    /// surfaces that share nodes. Values that vary in space are compared node by node later.
    pub(super) fn agreement(&mut self, boundary: &[BoundarySpec], instants: &[f64]) {
        let meet = |a: &Surface, b: &Surface| match (a.axis(), b.axis()) {
            (Some((one, _)), Some((other, _))) => a == b || one != other,
            // Groups may meet others in ways that only the mesh knows.
            _ => a == b && *a != Surface::All,
        };
        let is_own = |time: &&f64| self.end_of_stage.is_none_or(|end| **time <= end);
        let instants: Vec<f64> = instants.iter().filter(is_own).copied().collect();
        // Each value once at each instant, where it is the same in space.
        let values: Vec<[Option<Vec<f64>>; 4]> = boundary
            .iter()
            .map(|entry| {
                let [x, y, z] = &entry.displacement;
                [x, y, z, &entry.normal_displacement].map(|value| {
                    let value = value.as_ref()?;
                    let at = |time: &f64| value.at([0.0; 3], *time);
                    (!value.varies_in_space()).then(|| instants.iter().map(at).collect())
                })
            })
            .collect();
        for (index, entry) in boundary.iter().enumerate() {
            for (earlier, other) in boundary[..index].iter().enumerate() {
                if !meet(&entry.on, &other.on) {
                    continue;
                }
                for (axis, name) in AXES.iter().enumerate() {
                    let (Some(value), Some(first)) = (&values[index][axis], &values[earlier][axis])
                    else {
                        continue;
                    };
                    if axis < 3 && (entry.is_carried(axis) || other.is_carried(axis)) {
                        self.beside_platen(index, (earlier, other), name);
                        continue;
                    }
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
