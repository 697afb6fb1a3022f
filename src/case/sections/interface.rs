//! Interfaces and their laws.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::input::Value;
use crate::law::LawSpec;

/// A horizontal interface across the whole column.
#[derive(Debug, Clone, PartialEq)]
pub struct InterfaceSpec {
    /// Its name, the prefix of its columns in `history.csv`.
    pub name: String,
    /// Its height in m.
    pub z: f64,
    /// What relates traction and jump.
    pub law: LawSpec,
    /// The side that carries the multipliers; `None`: the solver's choice.
    pub secondary: Option<Side>,
    /// Pressure in Pa of the fluid between the lips.
    pub fluid_pressure: Option<Value>,
    /// Whether the pore pressure at the lips equals it.
    pub connected: bool,
    /// Fluid that flows along the interface at a pressure of its own.
    pub film: Option<FilmSpec>,
}

/// Fluid that flows along an interface.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmSpec {
    /// Mass that is injected, in kg/m2/s.
    pub injection: Option<Value>,
}

/// A side of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The body below.
    Lower,
    /// The body above.
    Upper,
}
