//! Cells of a column that grow away from named places.

use super::checker::Checker;
use crate::case::sections::file::CaseFile;
use crate::case::sections::grading::ENDS;
use crate::case::{ColumnSpec, InterfaceSpec, Material};

const AXES: [&str; 3] = ["x", "y", "z"];

impl Checker<'_> {
    /// The places must be there, and the ratio a number that cells can have.
    pub(super) fn grading(
        &mut self,
        file: &CaseFile,
        column: &ColumnSpec,
        materials: &[Material],
        interfaces: &[InterfaceSpec],
    ) {
        let section = file.mesh.column.as_ref().and_then(|column| column.grading.as_ref());
        let Some(section) = section else { return };
        let lengths = column.lengths();
        for (axis, name) in AXES.into_iter().enumerate() {
            let Some(grading) = section.along(axis) else { continue };
            let path = format!("mesh.column.grading.{name}");
            if axis == 1 && self.dim == 2 {
                self.add(&path, self.lack());
                continue;
            }
            if let Err(number) = grading.places(axis, lengths[axis], interfaces, materials) {
                let mut known: Vec<&str> = ENDS[axis].to_vec();
                if axis == 2 {
                    known.extend(interfaces.iter().map(|interface| interface.name.as_str()));
                    let layers = materials.iter().filter(|material| material.z.is_some());
                    known.extend(layers.map(|material| material.name.as_str()));
                }
                let reason = format!(
                    "cannot be `{}`; cells along {name} grow away from: {}",
                    crate::input::problems::shortened(&grading.towards[number]),
                    known.join(", ")
                );
                self.add(&format!("{path}.towards.{number}"), reason);
            }
        }
    }
}
