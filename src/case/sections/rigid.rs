//! Surfaces that move as rigid bodies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::quantity::{Components, FormulaSection, Quantity, TableSection};
use crate::input::Value;

/// A platen: the named components of a surface move as those of a rigid body; the others are left
/// as they are. Rotations are small.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1))]
pub struct RigidSection {
    /// Motion along x in m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<MotionSection>,
    /// Motion along y in m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<MotionSection>,
    /// Motion along z in m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<MotionSection>,
    /// Rotation in rad about the centroid of the surface, of all axes or by axis; default: fixed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationSection>,
    /// Force in N at the centroid of the surface; in 2D in N/m.
    #[serde(default, skip_serializing_if = "Components::is_empty")]
    pub force: Components,
    /// Moment in N m about the centroid of the surface; in 2D in N.
    #[serde(default, skip_serializing_if = "Components::is_empty")]
    pub moment: Components,
}

/// How a platen moves: free, fixed, a number, a table over time or a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum MotionSection {
    /// As its load asks, or not at all.
    Word(MotionWord),
    /// The same always.
    Number(f64),
    /// Over time.
    Table(TableSection),
    /// In time.
    Formula(FormulaSection),
}

/// How a platen moves, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionWord {
    /// As its load asks
    Free,
    /// Not at all
    Fixed,
}

/// The rotations of a platen: a word for all, or by axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum RotationSection {
    /// About all axes.
    Word(MotionWord),
    /// About some of them.
    Axes(Box<AxesSection>),
}

/// Rotations by axis in rad; those left out are fixed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1))]
pub struct AxesSection {
    /// About x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<MotionSection>,
    /// About y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<MotionSection>,
    /// About z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<MotionSection>,
}

impl MotionSection {
    /// The value that is given; none of a word.
    pub(in crate::case) fn quantity(&self) -> Option<Quantity> {
        match self {
            Self::Word(_) => None,
            Self::Number(number) => Some(Quantity::Number(*number)),
            Self::Table(table) => Some(Quantity::Table(table.clone())),
            Self::Formula(formula) => Some(Quantity::Formula(formula.clone())),
        }
    }
}

impl RigidSection {
    /// Free along z, without rotation, under a force along z in N.
    pub fn pressed(force: impl Into<Quantity>) -> Self {
        Self {
            z: Some(MotionSection::Word(MotionWord::Free)),
            force: Components { z: Some(force.into()), ..Components::default() },
            ..Self::default()
        }
    }
}

/// A motion of a platen.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// As its load asks.
    Free,
    /// Not at all.
    Fixed,
    /// A value in time (m or rad).
    Given(Value),
}

/// A platen: the surface of an entry moves as a rigid body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RigidSpec {
    /// Motions along the axes; none of components that it does not bind.
    pub along: [Option<Motion>; 3],
    /// Rotations about the axes through the centroid; none of those that turn nothing it binds.
    pub about: [Option<Motion>; 3],
    /// Forces along the axes (N; 2D: N/m).
    pub force: [Option<Value>; 3],
    /// Moments about the axes through the centroid (N m; 2D: N).
    pub moment: [Option<Value>; 3],
}

impl RigidSpec {
    /// Whether the displacement along an axis is more than one value for the whole surface: it
    /// follows from a load, or differs from place to place.
    pub fn carries(&self, axis: usize) -> bool {
        let is_free = self.along[axis] == Some(Motion::Free);
        let turns = |about: usize| !matches!(self.about[about], None | Some(Motion::Fixed));
        self.along[axis].is_some() && (is_free || (0..3).any(|about| about != axis && turns(about)))
    }

    /// All values in it.
    pub fn values(&self) -> impl Iterator<Item = &Value> {
        let motions = self.along.iter().chain(&self.about).filter_map(|motion| match motion {
            Some(Motion::Given(value)) => Some(value),
            _ => None,
        });
        motions.chain(self.force.iter().chain(&self.moment).flatten())
    }
}

/// What a rotation by 1 rad about an axis makes of a lever: the part of the displacement along
/// `axis`.
pub fn turned(about: usize, axis: usize, lever: [f64; 3]) -> f64 {
    if axis == (about + 1) % 3 {
        -lever[(about + 2) % 3]
    } else if axis == (about + 2) % 3 {
        lever[(about + 1) % 3]
    } else {
        0.0
    }
}
