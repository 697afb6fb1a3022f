//! Stages: what changes at given times.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::quantity::{Components, FormulaSection, Quantity, TableSection};
use super::{RigidSection, Surface};

/// A part of the time, and what changes at its beginning; everything else stays.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageSection {
    /// The instant in s at which it ends; that of the last stage is the last instant.
    pub until: f64,
    /// What changes on surfaces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 100))]
    pub boundary: Vec<StageBoundarySection>,
    /// What changes of the fluid in interfaces, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fluid: BTreeMap<String, StageFluidSection>,
    /// What changes of materials, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, StageMaterialSection>,
}

/// What changes on a surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageBoundarySection {
    /// Where.
    pub on: Surface,
    /// Displacement in m, by component, or free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<StageDisplacement>,
    /// Surface force in Pa; 0 takes it away.
    #[serde(default, skip_serializing_if = "Components::is_empty")]
    pub traction: Components,
    /// Pore pressure in Pa, or free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<StageQuantity>,
    /// Mass flux of the fluid in kg/m2/s, positive inwards; it takes the place of a pressure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flux: Option<Quantity>,
    /// A platen in the place of the one that was there, or free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rigid: Option<StageRigid>,
}

/// No platen any more, or another one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StageRigid {
    /// None.
    Free(FreeWord),
    /// Another one.
    Rigid(Box<RigidSection>),
}

/// All components free, or some of them changed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StageDisplacement {
    /// All.
    Free(FreeWord),
    /// Some.
    Components(Box<StageComponents>),
}

/// Not prescribed any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FreeWord {
    /// Not prescribed any more
    Free,
}

/// Components along x, y, z that change.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageComponents {
    /// Along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<StageQuantity>,
    /// Along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<StageQuantity>,
    /// Along z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<StageQuantity>,
    /// Along the outward normal of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<StageQuantity>,
}

/// Free, a number, a table over time or a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StageQuantity {
    /// Not prescribed any more.
    Free(FreeWord),
    /// The same everywhere and always.
    Number(f64),
    /// Over time.
    Table(TableSection),
    /// In space and time.
    Formula(FormulaSection),
}

/// What changes of the fluid in an interface.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageFluidSection {
    /// Its imposed pressure in Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Quantity>,
    /// Mass in kg/m2/s that is injected into the interface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub injection: Option<Quantity>,
}

/// What changes of a material.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageMaterialSection {
    /// Of its elasticity; stresses stay, and what is added to them follows from the new values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elastic: Option<StageElasticSection>,
    /// Of its pores.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub porous: Option<StagePorousSection>,
}

/// What changes of the elasticity of a material.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageElasticSection {
    /// Young's modulus in Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub young_modulus: Option<f64>,
    /// Poisson's ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 0.5))]
    pub poisson_ratio: Option<f64>,
    /// Density in kg/m3, on which gravity acts.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub density: Option<f64>,
}

/// What changes of the pores of a material.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StagePorousSection {
    /// Intrinsic permeability in m2.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub permeability: Option<f64>,
    /// Density of the saturated medium in kg/m3, on which gravity acts.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub density: Option<f64>,
}
