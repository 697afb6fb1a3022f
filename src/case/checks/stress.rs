//! Stresses that are there before anything is loaded or moved.

use super::checker::Checker;
use crate::case::Material;
use crate::case::sections::file::CaseFile;
use crate::case::sections::quantity::{Quantity, StressSection};
use crate::error::number_text;
use crate::input::Value;

/// The keys of the components, in the order of stresses in field files.
const NAMES: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

/// Stresses at the start (Pa), tension positive; of porous materials the effective ones.
#[derive(Debug, Clone, PartialEq)]
pub struct StressSpec {
    /// When they are there (s).
    pub start: f64,
    /// xx, yy, zz, xy, yz, zx: those that are given.
    pub components: [Option<Value>; 6],
    /// What gives the normal ones that are not given; without it they are 0.
    pub at_rest: Option<AtRest>,
}

/// Ground at rest: the horizontal normal stresses follow from the vertical one, and that one from
/// the weight above unless it is given.
#[derive(Debug, Clone, PartialEq)]
pub struct AtRest {
    /// Horizontal over vertical stress.
    pub ratio: Value,
    /// The vertical axis.
    pub vertical: usize,
    /// The density of each material at the start (kg/m3).
    pub densities: Vec<f64>,
}

impl Checker<'_> {
    /// The stresses at the start, if there are any.
    pub(super) fn initial_stress(
        &mut self,
        file: &CaseFile,
        materials: &[Material],
    ) -> Option<StressSpec> {
        let section = file.initial.as_ref()?.stress.as_ref()?;
        let StressSection { xx, yy, zz, xy, yz, zx, k0 } = section;
        let given = [xx, yy, zz, xy, yz, zx];
        let components: [Option<Value>; 6] = std::array::from_fn(|i| {
            let path = format!("initial.stress.{}", NAMES[i]);
            let value = self.at_start(&path, given[i].as_ref()?);
            if i >= 3 && [i - 3, (i - 2) % 3].iter().any(|axis| self.lacks(*axis)) {
                let lack = self.lack();
                self.add(&path, lack);
            }
            Some(value)
        });
        if file.control.is_some() {
            let reason = "cannot stand beside control, which scales the loads that they balance";
            self.add("initial.stress", reason);
        }
        let at_rest = k0.as_ref().map(|k0| self.at_rest(file, k0, &components, materials));
        Some(StressSpec { start: file.time.start, components, at_rest })
    }

    /// A value that does not depend on time.
    fn at_start(&mut self, path: &str, quantity: &Quantity) -> Value {
        let value = self.value(path, quantity);
        match &value {
            Value::Table(_) => {
                let reason = "is of the start alone: give a number, a formula in x, y, z, or say \
                              what coordinate the table is `over`";
                self.add(path, reason);
            }
            Value::Formula(formula) if formula.uses_t() => {
                self.add(&format!("{path}.formula"), "uses t, but it is of the start alone");
            }
            _ => {}
        }
        value
    }

    fn at_rest(
        &mut self,
        file: &CaseFile,
        k0: &Quantity,
        components: &[Option<Value>; 6],
        materials: &[Material],
    ) -> AtRest {
        const PATH: &str = "initial.stress.k0";
        let ratio = self.at_start(PATH, k0);
        if let Value::Constant(ratio) = ratio
            && ratio < 0.0
        {
            self.add(PATH, format!("must not be negative, got {}", number_text(ratio)));
        }
        let gravity = self.by_axis(file.gravity.as_deref().unwrap_or_default());
        let pulls: Vec<usize> = (0..3).filter(|axis| gravity[*axis] != 0.0).collect();
        let upright = self.axes.last().copied().unwrap_or(2);
        let vertical = pulls.first().copied().unwrap_or(upright);
        let horizontal = (0..3).filter(|axis| *axis != vertical);
        if pulls.len() > 1 {
            self.add(PATH, "needs gravity along one axis, which is then the vertical");
        } else if components[vertical].is_none() && pulls.is_empty() {
            let name = NAMES[vertical];
            let reason =
                format!("needs the vertical stress: that of gravity, or initial.stress.{name}");
            self.add(PATH, reason);
        } else if horizontal.clone().all(|axis| components[axis].is_some()) {
            self.add(PATH, "has nothing to give: all horizontal stresses are given");
        } else if components[vertical].is_none() && self.is_of_file {
            self.one_density(PATH, NAMES[vertical], materials);
        }
        let densities = materials.iter().map(|m| m.density.unwrap_or(0.0)).collect();
        AtRest { ratio, vertical, densities }
    }

    /// What lies above a point of a mesh file is known where it all weighs the same.
    fn one_density(&mut self, path: &str, vertical: &str, materials: &[Material]) {
        let Some(first) = materials.first() else { return };
        if let Some(other) = materials.iter().find(|m| m.density != first.density) {
            let reason = format!(
                "takes the weight above from one density, but {} and {} differ in theirs: in a mesh \
                 file give the vertical stress, initial.stress.{vertical}, as a formula beside k0",
                first.name, other.name
            );
            self.add(path, reason);
        }
    }
}
