//! Cells of a column that grow away from named places.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{InterfaceSpec, Material};

/// Cells that grow along the axes of a column.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GradingSection {
    /// Along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<AxisGrading>,
    /// Along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<AxisGrading>,
    /// Along z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<AxisGrading>,
}

/// Cells that grow along one axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisGrading {
    /// Where cells are small: sides of the column across the axis; along z interfaces too, and
    /// materials, which stand for both ends of their heights.
    #[schemars(length(min = 1, max = 2000))]
    pub towards: Vec<String>,
    /// The largest cell over the smallest one.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub ratio: f64,
}

/// The sides of a column across each axis, lower and upper.
pub const ENDS: [[&str; 2]; 3] = [["left", "right"], ["front", "back"], ["bottom", "top"]];

impl GradingSection {
    /// That along an axis, 0 to 2.
    pub fn along(&self, axis: usize) -> Option<&AxisGrading> {
        [&self.x, &self.y, &self.z][axis].as_ref()
    }
}

impl AxisGrading {
    /// Towards places, with the largest cell so many times the smallest.
    pub fn towards(places: impl IntoIterator<Item = impl Into<String>>, ratio: f64) -> Self {
        Self { towards: places.into_iter().map(Into::into).collect(), ratio }
    }

    /// Where the places lie along the axis (m), in a column of that length; the inner error is the
    /// number of the first one that is not known.
    ///
    /// # Errors
    /// The place in the list of a name that nothing bears.
    pub(crate) fn places(
        &self,
        axis: usize,
        length: f64,
        interfaces: &[InterfaceSpec],
        materials: &[Material],
    ) -> Result<Vec<f64>, usize> {
        let mut places = Vec::new();
        for (number, name) in self.towards.iter().enumerate() {
            if let Some(end) = ENDS[axis].iter().position(|end| end == name) {
                places.push(if end == 0 { 0.0 } else { length });
                continue;
            }
            let before = places.len();
            if axis == 2 {
                let of = interfaces.iter().filter(|interface| interface.name == *name);
                places.extend(of.filter_map(InterfaceSpec::height));
                let of = materials.iter().filter(|material| material.name == *name);
                places.extend(of.filter_map(|material| material.z).flatten());
            }
            if places.len() == before {
                return Err(number);
            }
        }
        places.sort_by(f64::total_cmp);
        places.dedup();
        Ok(places)
    }
}
