//! The case file as it is written: its sections, keys and forms, from which the schema is made.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::quantity::Components;
use super::quantity::{
    CheckpointSection, FluidSection, InitialSection, InterfaceInitialSection, LimitsSection,
    Quantity,
};
use super::{
    AccuracySection, Formulation, Gap, GradingSection, Porous, Reduce, RigidSection, Side,
    SolverSpec, StageSection, Surface,
};
use crate::law::LawSpec;

/// Case file of column-hpc. All units are SI; z points up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseFile {
    /// Title; default: the name of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The mesh.
    pub mesh: MeshSection,
    /// Materials by name: one, or several with `z` in a column, with `on` in a mesh file.
    #[schemars(extend("minProperties" = 1))]
    pub materials: BTreeMap<String, MaterialSection>,
    /// Interfaces; in a column with rising z.
    #[serde(default)]
    #[schemars(length(max = 1000))]
    pub interfaces: Vec<InterfaceSection>,
    /// What is prescribed on surfaces.
    #[serde(default)]
    #[schemars(length(max = 100))]
    pub boundary: Vec<BoundarySection>,
    /// Gravity in m/s2, by component; acts on `density` of the materials.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Vec<f64>>,
    /// Body force in N/m3.
    #[serde(default, skip_serializing_if = "Components::is_empty")]
    pub body_force: Components,
    /// The state at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial: Option<InitialSection>,
    /// The instants.
    pub time: TimeSection,
    /// What changes at given times; everything else stays.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 1000))]
    pub stages: Vec<StageSection>,
    /// What is computed.
    #[serde(default)]
    pub physics: Physics,
    /// Path following: what all loads are scaled by follows from the state of an interface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control: Option<ControlSection>,
    /// How it is solved.
    #[serde(default)]
    pub solver: SolverSpec,
    /// Whether a smaller model may take the place of the one asked for where it is shown to give
    /// the same.
    #[serde(default)]
    pub reduce: Reduce,
    /// Which results are wanted, and how exactly, in the place of the cells of the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySection>,
    /// What is written.
    #[serde(default)]
    pub output: OutputSection,
    /// When the run stops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitsSection>,
    /// Points whose displacement is recorded.
    #[serde(default)]
    #[schemars(length(max = 1000))]
    pub probes: Vec<ProbeSection>,
    /// Values that the results must have.
    #[serde(default)]
    #[schemars(length(max = 10_000))]
    pub expect: Vec<ExpectSection>,
}

/// The mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSection {
    /// A column that stands on z = 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<ColumnSection>,
    /// A mesh file of Gmsh (MSH 2.2 or 4.1) or SALOME (MED) instead of a column; its path is
    /// relative to the folder of the case file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Length in m of the unit of the coordinates in the file; default: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: Option<f64>,
    /// 2: cells of first order in the file become cells of second order.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2, max = 2))]
    pub raise_order: Option<u32>,
    /// Of the cells of a column; 1 (default): hex8 or quad4; 2: hex27 or quad9.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 2))]
    pub order: Option<u32>,
    /// How the cells are integrated.
    #[serde(default)]
    pub formulation: Formulation,
    /// Uniform refinements: each halves every edge; cells of second order keep their curves.
    #[serde(default)]
    #[schemars(range(max = 20))]
    pub refine: u32,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnSection {
    /// Lengths in m along x, y, z; two numbers: x and z, plane strain.
    #[schemars(length(min = 2, max = 3))]
    pub size: Vec<f64>,
    /// Cells along each axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 2, max = 3), inner(range(min = 1)))]
    pub cells: Option<Vec<u64>>,
    /// Cells of each body between interfaces, bottom to top, instead of `cells`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 1001))]
    pub bodies: Option<Vec<BodySection>>,
    /// Cells that grow away from named places.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grading: Option<GradingSection>,
}

/// A body between interfaces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodySection {
    /// Cells along each axis.
    #[schemars(length(min = 2, max = 3), inner(range(min = 1)))]
    pub cells: Vec<u64>,
    /// As mesh.order, which it overrides.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 2))]
    pub order: Option<u32>,
}

/// Names of groups of a mesh file: one, or a list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Groups {
    /// One.
    One(String),
    /// Several.
    Many(#[schemars(length(min = 1, max = 1000))] Vec<String>),
}

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialSection {
    /// The heights in m between which it lies in a column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<[f64; 2]>,
    /// The groups of cells of a mesh file that consist of it; default: everything, or the group of
    /// its name where there are several materials.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<Groups>,
    /// Isotropic linear elasticity.
    pub elastic: ElasticSection,
    /// Saturated porous medium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub porous: Option<Porous>,
}

/// Isotropic linear elasticity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticSection {
    /// Young's modulus in Pa.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub young_modulus: f64,
    /// Poisson's ratio.
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 0.5))]
    pub poisson_ratio: f64,
    /// Density in kg/m3, on which gravity acts; of porous materials it stands in their own data.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub density: Option<f64>,
    /// Thermal expansion in 1/K (other than 0: refused).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thermal_expansion: Option<f64>,
}

/// An interface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InterfaceSection {
    /// Its name.
    pub name: String,
    /// Its height in m, in a column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
    /// A group of facets inside a mesh file, along which the mesh is cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Turns the normal of the interface on a group, which else is that of the group's facets.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub flip: bool,
    /// Two groups of facets of a mesh file that share no nodes: the lower side, then the upper one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<[String; 2]>,
    /// What becomes of an initial gap between the two groups of a contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// What relates traction and jump.
    pub law: LawSpec,
    /// The side that carries the multipliers; default: the solver's choice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub secondary: Option<Side>,
    /// Fluid between the lips.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<FluidSection>,
    /// Its state at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial: Option<InterfaceInitialSection>,
}

/// What is prescribed on a surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundarySection {
    /// Where.
    pub on: Surface,
    /// Displacement in m; a component left out is free.
    #[serde(default, skip_serializing_if = "Components::is_empty")]
    pub displacement: Components,
    /// Surface force in Pa.
    #[serde(default, skip_serializing_if = "Components::is_empty")]
    pub traction: Components,
    /// Pore pressure in Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Quantity>,
    /// Mass flux of the fluid in kg/m2/s, positive inwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flux: Option<Quantity>,
    /// A platen: one motion for the whole surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rigid: Option<RigidSection>,
}

/// The instants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeSection {
    /// Times in s, rising; ranges stand for theirs.
    #[serde(deserialize_with = "super::instants::read")]
    #[schemars(with = "super::instants::InstantsSection")]
    pub instants: Vec<f64>,
    /// The time in s of the state at the start.
    #[serde(default)]
    pub start: f64,
    /// Weight of the end of each step of the flow, 0.5 to 1; default: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta: Option<f64>,
    /// Error that one step may make: of the pore pressure over the largest so far, of the traction
    /// of interfaces over their strength, of the work over the energy. Steps are as long as that
    /// allows. Default: one step per instant.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub tolerance: Option<f64>,
}

/// What the load factor follows from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ControlSection {
    /// The mean normal jump of an interface is given.
    Opening(OpeningSection),
    /// The dissipated part of the energy of an interface grows step by step until it is broken; it
    /// takes the place of the time, and the loads are those of the last instant.
    Dissipation(DissipationSection),
}

/// The mean normal jump of an interface is given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OpeningSection {
    /// Name of the interface.
    pub of: String,
    /// Its mean normal jump in m, over time.
    pub equals: Quantity,
}

/// The dissipated part of the energy of an interface grows step by step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DissipationSection {
    /// Name of the interface.
    pub of: String,
    /// How much of it a step may dissipate, of fracture energy times area.
    #[schemars(extend("minimum" = 1e-4, "maximum" = 1))]
    pub step: f64,
}

/// What is computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Physics {
    /// What the case needs
    #[default]
    Auto,
    /// Equilibrium
    Mechanics,
    /// Equilibrium and flow
    HydroMechanics,
}

/// What is written.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputSection {
    /// The output directory; default: results/ and the name of the case file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<String>,
    /// The instants of the field files.
    #[serde(default)]
    pub fields: FieldsSection,
    /// How often a checkpoint is written; default: every 10 min.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoint: Option<CheckpointSection>,
}

/// The instants of the field files: a word, or a list of instants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FieldsSection {
    /// A word.
    Word(FieldsWord),
    /// Instants.
    Times(#[schemars(length(max = 10_000))] Vec<f64>),
}

impl Default for FieldsSection {
    fn default() -> Self {
        FieldsSection::Word(FieldsWord::All)
    }
}

/// Every instant or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldsWord {
    /// Every instant
    All,
    /// Never
    None,
}

/// A point whose displacement is recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeSection {
    /// Its name.
    pub name: String,
    /// Its place in m: x, y, z, or in 2D x, z in a column and x, y on a mesh file.
    #[schemars(length(min = 2, max = 3))]
    pub at: Vec<f64>,
}

/// A value that the results must have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectSection {
    /// A column of history.csv; without `.min`, `.max` it stands for both.
    pub quantity: String,
    /// One of the instants.
    pub at: f64,
    /// The expected value.
    pub equals: f64,
    /// Allowed error over |equals|.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub relative: Option<f64>,
    /// Allowed error.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub absolute: Option<f64>,
}
