//! The state at the start: pore pressure, and the imperfection that selects a branch.

use super::checker::Checker;
use crate::case::InterfaceSpec;
use crate::case::sections::file::CaseFile;
use crate::case::sections::quantity::{Quantity, SpatialQuantity};
use crate::error::{Error, Result, number_text};
use crate::input::Value;
use crate::input::problems::suggestion;

/// An imperfection: at each point of an interface its strength and its fracture energy are
/// multiplied by a factor, so that its critical jump stays.
#[derive(Debug, Clone, PartialEq)]
pub struct Imperfection {
    /// The interface.
    pub interface: usize,
    /// The factor, in space.
    pub factor: Value,
    /// Its entry in the case.
    entry: usize,
}

impl Imperfection {
    /// The factor at a point of the interface.
    ///
    /// # Errors
    /// `Input` where it is not positive or not finite.
    pub fn at(&self, point: [f64; 3]) -> Result<f64> {
        let factor = self.factor.at(point, 0.0);
        if factor.is_finite() && factor > 0.0 {
            return Ok(factor);
        }
        let [x, y, z] = point;
        Err(Error::Input(format!(
            "initial.imperfection.{}: the factor is {factor} at ({x}, {y}, {z}) m; the formula must \
             give positive finite numbers on the whole interface",
            self.entry
        )))
    }
}

impl Checker<'_> {
    /// The imperfections, of different interfaces that have a strength.
    pub(super) fn imperfections(
        &mut self,
        file: &CaseFile,
        interfaces: &[InterfaceSpec],
    ) -> Vec<Imperfection> {
        let names: Vec<String> = interfaces.iter().map(|i| i.name.clone()).collect();
        let mut list: Vec<Imperfection> = Vec::new();
        let sections = file.initial.iter().flat_map(|initial| &initial.imperfection);
        for (entry, section) in sections.enumerate() {
            let path = format!("initial.imperfection.{entry}");
            let factor = self.factor(&format!("{path}.factor"), &section.factor);
            if !self.sound(&["interfaces"]) {
                continue;
            }
            let (of, path) = (&section.interface, format!("{path}.interface"));
            let Some(interface) = names.iter().position(|name| name == of) else {
                let hint = suggestion(of, &names);
                self.add(&path, format!("must name an interface, got `{of}`{hint}"));
                continue;
            };
            if interfaces[interface].law.law().strength().is_none() {
                self.add(&path, format!("names `{of}`, which has no strength to be multiplied"));
            }
            if list.iter().any(|other| other.interface == interface) {
                self.add(&path, format!("`{of}` has an imperfection already"));
            }
            list.push(Imperfection { interface, factor, entry });
        }
        list
    }

    fn factor(&mut self, path: &str, section: &SpatialQuantity) -> Value {
        if let SpatialQuantity::Number(number) = section
            && *number <= 0.0
        {
            self.add(path, format!("must be positive, got {}", number_text(*number)));
        }
        self.in_space(path, section, "an imperfection")
    }

    /// A value that is the same at all times; `what` it is, in words.
    pub(super) fn in_space(&mut self, path: &str, section: &SpatialQuantity, what: &str) -> Value {
        match section {
            SpatialQuantity::Number(number) => Value::Constant(*number),
            SpatialQuantity::Table(section) => {
                if section.over.is_none() {
                    let reason =
                        format!("needs `over`: x, y or z; {what} is the same at all times");
                    self.add(path, reason);
                }
                self.value(path, &Quantity::Table(section.clone()))
            }
            SpatialQuantity::Formula(section) => {
                let value = self.value(path, &Quantity::Formula(section.clone()));
                if matches!(&value, Value::Formula(formula) if formula.uses_t()) {
                    let reason = format!("uses t: {what} is the same at all times");
                    self.add(&format!("{path}.formula"), reason);
                }
                value
            }
        }
    }
}
