//! Surfaces of the column and what is prescribed on them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::input::Value;

/// What one entry of `boundary` prescribes.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundarySpec {
    /// Where.
    pub on: Surface,
    /// Prescribed displacement components in m; `None`: free.
    pub displacement: [Option<Value>; 3],
    /// Surface forces in Pa; `None`: none.
    pub traction: [Option<Value>; 3],
    /// Prescribed pore pressure in Pa.
    pub pressure: Option<Value>,
    /// Mass flux of the fluid in kg/m2/s, positive inwards.
    pub flux: Option<Value>,
}

impl BoundarySpec {
    /// Whether a displacement component is prescribed.
    pub fn prescribes_displacement(&self) -> bool {
        self.displacement.iter().any(Option::is_some)
    }
}

/// A surface of the column, or all its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// z = 0
    Bottom,
    /// z = height
    Top,
    /// x = 0
    Left,
    /// x = length
    Right,
    /// y = 0
    Front,
    /// y = width
    Back,
    /// Every node, the inside too; for pore pressure only
    All,
}

impl Surface {
    /// Its name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Surface::Bottom => "bottom",
            Surface::Top => "top",
            Surface::Left => "left",
            Surface::Right => "right",
            Surface::Front => "front",
            Surface::Back => "back",
            Surface::All => "all",
        }
    }

    /// The axis (0, 1, 2) it is normal to and whether it is the far end; `None` for all nodes.
    pub fn axis(self) -> Option<(usize, bool)> {
        match self {
            Surface::Left => Some((0, false)),
            Surface::Right => Some((0, true)),
            Surface::Front => Some((1, false)),
            Surface::Back => Some((1, true)),
            Surface::Bottom => Some((2, false)),
            Surface::Top => Some((2, true)),
            Surface::All => None,
        }
    }
}
