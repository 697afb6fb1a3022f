//! Interfaces and their laws.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::input::Value;
use crate::law::LawSpec;

/// An interface.
#[derive(Debug, Clone, PartialEq)]
pub struct InterfaceSpec {
    /// Its name, the prefix of its columns in `history.csv`.
    pub name: String,
    /// Where it is.
    pub location: Location,
    /// Whether the distance of its sides in the mesh counts as a gap at the start.
    pub has_gap: bool,
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
    /// Its state at the start.
    pub initial: InterfaceInitial,
}

/// The state of an interface at the start, in space; what is not given is 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InterfaceInitial {
    /// Damage from 0 to 1.
    pub damage: Option<Value>,
    /// Distance of the lips (m).
    pub gap: Option<Value>,
    /// Width in which fluid flows and is stored where the lips are closed (m).
    pub aperture: Option<Value>,
}

/// Where an interface is.
#[derive(Debug, Clone, PartialEq)]
pub enum Location {
    /// Across the whole column, at a height in m.
    Height(f64),
    /// On a group of facets inside a mesh file.
    Group {
        /// The name of the group.
        name: String,
        /// Whether the normal is turned round.
        flip: bool,
    },
    /// Between two groups of facets of a mesh file, the lower side first.
    Between([String; 2]),
}

impl InterfaceSpec {
    /// Whether its lips slide with friction.
    pub fn has_friction(&self) -> bool {
        !self.law.law().friction().is_none()
    }

    /// Its height in m, where it crosses a column.
    pub fn height(&self) -> Option<f64> {
        match self.location {
            Location::Height(z) => Some(z),
            Location::Group { .. } | Location::Between(_) => None,
        }
    }

    /// What it starts with, in words that follow its law; empty where that is nothing.
    pub fn start_words(&self) -> String {
        let InterfaceInitial { damage, gap, aperture } = &self.initial;
        let given = [("damage", damage), ("a gap", gap), ("an aperture", aperture)];
        let given = given.iter().filter(|(_, of)| of.as_ref().is_some_and(|of| !of.is_zero()));
        let words: Vec<&str> = given.map(|(words, _)| *words).collect();
        if words.is_empty() {
            return String::new();
        }
        format!(" with {} at the start", words.join(" and "))
    }

    /// Where it is, in words that follow its name.
    pub fn place(&self) -> String {
        match &self.location {
            Location::Height(z) => format!("at z = {z} m"),
            Location::Group { name, .. } => format!("on {name}"),
            Location::Between([lower, upper]) => format!("between {lower} and {upper}"),
        }
    }
}

/// What becomes of an initial gap between two groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Gap {
    /// The distance of the two sides in the mesh counts.
    AsDrawn,
    /// The sides are taken for lying on each other.
    Closed,
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
    /// The body below: the normal of the interface points out of it.
    Lower,
    /// The body above.
    Upper,
}
