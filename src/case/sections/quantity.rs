//! Sections of a case that stand in several places, or have rules of their own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number, a table over time or over a coordinate, or a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Quantity {
    /// The same everywhere and always.
    Number(f64),
    /// Over time or over a coordinate.
    Table(TableSection),
    /// In space and time.
    Formula(FormulaSection),
}

/// Linear between, constant beyond.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableSection {
    /// Pairs of time, or of the coordinate, and value; the first ones rise.
    #[schemars(length(min = 1, max = 100_000))]
    pub table: Vec<[f64; 2]>,
    /// The coordinate; default: the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<Coordinate>,
}

/// A coordinate of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Coordinate {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

/// A formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FormulaSection {
    /// In x, y, z, t with + - * / ^, parentheses, pi, sqrt exp ln sin cos abs min max.
    pub formula: String,
}

/// Components along x, y, z; in 2D there is no y in a column, and no z on a mesh file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Components {
    /// Along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Quantity>,
    /// Along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Quantity>,
    /// Along z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<Quantity>,
    /// Along the outward normal of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<Quantity>,
}

impl Components {
    /// Whether no component is given.
    pub fn is_empty(&self) -> bool {
        [&self.x, &self.y, &self.z, &self.normal].into_iter().all(Option::is_none)
    }
}

/// Fluid in an interface.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluidSection {
    /// Its imposed pressure in Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Quantity>,
    /// Whether the pore pressure at the lips equals the imposed one.
    #[serde(default)]
    pub connected: bool,
    /// Whether it flows along the interface, with the pressure of the pores at both lips.
    #[serde(default)]
    pub flow: bool,
    /// Mass in kg/m2/s that is injected into the interface, where it then flows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub injection: Option<Quantity>,
}

/// The state at the start.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1))]
pub struct InitialSection {
    /// Pore pressure in Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Quantity>,
    /// Whether the displacements at the start are those in equilibrium with the initial pressures,
    /// the loads and the prescribed displacements, instead of 0.
    #[serde(default)]
    pub equilibrium: bool,
    /// Stresses that are there before, from whose equilibrium displacements count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress: Option<StressSection>,
    /// What makes a perfect structure imperfect, so that one of its branches is selected.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 1000))]
    pub imperfection: Vec<ImperfectionSection>,
}

/// Stresses at the start in Pa, tension positive, of porous materials the effective ones: numbers,
/// or formulas in space. What is left out is 0, or follows from `k0`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1))]
pub struct StressSection {
    /// Normal stress along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub xx: Option<Quantity>,
    /// Normal stress along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yy: Option<Quantity>,
    /// Normal stress along z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zz: Option<Quantity>,
    /// Shear stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub xy: Option<Quantity>,
    /// Shear stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yz: Option<Quantity>,
    /// Shear stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zx: Option<Quantity>,
    /// Horizontal over vertical stress; the vertical one is that of the weight above unless it is
    /// given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k0: Option<Quantity>,
}

/// The state of an interface at the start.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1))]
pub struct InterfaceInitialSection {
    /// Damage from 0 to 1, an open crack without strength.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<SpatialQuantity>,
    /// Distance of the lips in m, where nothing holds them together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<SpatialQuantity>,
    /// Width in m in which fluid flows and is stored where the lips are closed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aperture: Option<SpatialQuantity>,
}

/// An imperfection of an interface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImperfectionSection {
    /// Name of the interface.
    pub interface: String,
    /// What its strength and its fracture energy are multiplied by; the critical jump stays.
    pub factor: SpatialQuantity,
}

/// A number, a table over a coordinate, or a formula in space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SpatialQuantity {
    /// The same everywhere.
    Number(f64),
    /// Over a coordinate.
    Table(TableSection),
    /// In x, y, z.
    Formula(FormulaSection),
}

/// When checkpoints are written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckpointSection {
    /// A time, such as 10 min, or a number of instants, such as 5 instants.
    pub every: String,
}

/// When the run stops.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitsSection {
    /// Wall-clock time, as HH:MM:SS or as a number with s, min or h: a checkpoint is written and
    /// the run stops before it is over.
    pub wall: String,
}

impl From<f64> for Quantity {
    fn from(number: f64) -> Self {
        Quantity::Number(number)
    }
}

/// Pairs of time and value.
impl From<Vec<[f64; 2]>> for Quantity {
    fn from(table: Vec<[f64; 2]>) -> Self {
        Quantity::Table(TableSection { table, over: None })
    }
}

/// Pairs of time and value.
impl<const N: usize> From<[[f64; 2]; N]> for Quantity {
    fn from(table: [[f64; 2]; N]) -> Self {
        table.to_vec().into()
    }
}

/// A formula.
impl From<&str> for Quantity {
    fn from(formula: &str) -> Self {
        Quantity::Formula(FormulaSection { formula: formula.to_owned() })
    }
}

impl From<f64> for SpatialQuantity {
    fn from(number: f64) -> Self {
        SpatialQuantity::Number(number)
    }
}

/// A formula.
impl From<&str> for SpatialQuantity {
    fn from(formula: &str) -> Self {
        SpatialQuantity::Formula(FormulaSection { formula: formula.to_owned() })
    }
}
