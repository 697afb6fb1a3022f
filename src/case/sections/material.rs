//! Materials: isotropic linear elasticity, and the porous data that it may carry.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One material.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name in the case file.
    pub name: String,
    /// The heights in m between which it lies in a column; `None`: everywhere.
    pub z: Option<[f64; 2]>,
    /// The groups of cells of a mesh file that consist of it; none: everything.
    pub groups: Vec<String>,
    /// Young's modulus in Pa.
    pub young_modulus: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson_ratio: f64,
    /// Density in kg/m3, of a porous medium saturated; none where it is not given.
    pub density: Option<f64>,
    /// Data of the saturated porous medium.
    pub porous: Option<Porous>,
}

/// A porous medium saturated by one liquid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Porous {
    /// Biot coefficient, between the porosity and 1.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub biot: f64,
    /// Porosity, in (0, 1).
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub porosity: f64,
    /// Intrinsic permeability in m2.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub permeability: f64,
    /// Viscosity of the fluid in Pa.s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub viscosity: f64,
    /// Compressibility of the fluid in 1/Pa.
    #[schemars(extend("minimum" = 0))]
    pub fluid_compressibility: f64,
    /// Density of the fluid in kg/m3.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fluid_density: f64,
    /// Initial homogenised density in kg/m3.
    #[schemars(extend("minimum" = 0))]
    pub density: f64,
    /// Reference pore pressure in Pa.
    #[serde(default)]
    pub reference_pressure: f64,
}
