//! Surfaces and what is prescribed on them.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::rigid::RigidSpec;
use crate::input::Value;

/// What one entry of `boundary` prescribes.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundarySpec {
    /// Where.
    pub on: Surface,
    /// Prescribed displacement components along x, y, z in m; `None`: free.
    pub displacement: [Option<Value>; 3],
    /// The prescribed displacement along the outward normal in m; none in columns, where it is one
    /// of the components.
    pub normal_displacement: Option<Value>,
    /// Surface forces along x, y, z in Pa; `None`: none.
    pub traction: [Option<Value>; 3],
    /// The surface force along the outward normal in Pa, on top of the others; none in columns.
    pub normal_traction: Option<Value>,
    /// Prescribed pore pressure in Pa.
    pub pressure: Option<Value>,
    /// Mass flux of the fluid in kg/m2/s, positive inwards.
    pub flux: Option<Value>,
    /// The surface as a platen. Of components that it binds `displacement` has the value where that
    /// is one for the whole surface, else 0.
    pub rigid: Option<RigidSpec>,
}

impl BoundarySpec {
    /// Whether the displacement along an axis is that of a platen, which `displacement` does not
    /// tell.
    pub fn is_carried(&self, axis: usize) -> bool {
        self.rigid.as_ref().is_some_and(|rigid| rigid.carries(axis))
    }

    /// Whether a displacement component is prescribed.
    pub fn prescribes_displacement(&self) -> bool {
        self.displacement.iter().chain([&self.normal_displacement]).any(Option::is_some)
    }
}

/// A surface of a column, a group of a mesh file, or all nodes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
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
    /// A group of a mesh file, by its name
    #[serde(untagged)]
    Group(String),
}

/// The place of a surface in the list of its case, found once to be asked of many nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceBit {
    /// Every node.
    All,
    /// The place in `Case::surfaces`.
    Place(usize),
}

impl Surface {
    /// The sides of a column.
    pub const COLUMN: [Surface; 6] = [
        Surface::Bottom,
        Surface::Top,
        Surface::Left,
        Surface::Right,
        Surface::Front,
        Surface::Back,
    ];

    /// Its name in a case file.
    pub fn name(&self) -> &str {
        match self {
            Surface::Bottom => "bottom",
            Surface::Top => "top",
            Surface::Left => "left",
            Surface::Right => "right",
            Surface::Front => "front",
            Surface::Back => "back",
            Surface::All => "all",
            Surface::Group(name) => name,
        }
    }

    /// The axis (0, 1, 2) it is normal to and whether it is the far end; `None` for groups and all
    /// nodes.
    pub fn axis(&self) -> Option<(usize, bool)> {
        match self {
            Surface::Left => Some((0, false)),
            Surface::Right => Some((0, true)),
            Surface::Front => Some((1, false)),
            Surface::Back => Some((1, true)),
            Surface::Bottom => Some((2, false)),
            Surface::Top => Some((2, true)),
            Surface::All | Surface::Group(_) => None,
        }
    }
}

impl JsonSchema for Surface {
    fn schema_name() -> Cow<'static, str> {
        "Surface".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let sides = Surface::COLUMN.iter().chain([&Surface::All]);
        let names: Vec<&str> = sides.map(Surface::name).collect();
        json_schema!({
            "description": "A side of a column (bottom, top: along z; left, right: x; front, back: \
                            y), a group of a mesh file by its name, or all: every node, the inside \
                            too, for pore pressure only.",
            "type": "string",
            "minLength": 1,
            "examples": names,
        })
    }
}
