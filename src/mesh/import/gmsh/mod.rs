//! Mesh files of Gmsh: MSH 2.2 and 4.1, as text and binary of both orders of bytes.
//!
//! Source: the Gmsh reference manual, chapter "Gmsh file formats". Node numbers have gaps, a group
//! is a number with or without a name, and `$Periodic` joins nothing.

mod copies;
mod cursor;
mod elements;
mod format;
mod groups;
mod layout;
mod nodes;
mod remarks;
mod rows;
mod source;
mod types;

#[cfg(test)]
mod tests;

use super::file_mesh::{FileMesh, Kind};
use crate::error::Result;
use copies::{join, retain};
use cursor::Cursor;
use elements::{Blocks, UNCUT};
use format::Version;
use groups::{Entities, Names, Sets};
use nodes::Nodes;
use remarks::{orphans_of_elements, without_elements};

pub use layout::Layout;
pub use rows::Slabs;
pub use source::{OpenFile, Source};

/// Reads the bytes of a mesh file of Gmsh.
///
/// A group without a name is called as its number. Elements of dimension 0 without a group, and
/// nodes of no element, are left out. Groups of points are groups of elements: Gmsh has no others.
///
/// # Errors
///
/// With the section, and the line (text) or byte (binary) if there is one, for all that is not as
/// the format says, and for what would be misread: other versions and types of elements,
/// partitions, copies of elements, two groups of one dimension with one name.
pub fn read(bytes: &[u8]) -> Result<FileMesh> {
    let mut cursor = Cursor::new(bytes);
    let mut sections = Sections {
        version: None,
        names: Names::new(),
        sets: Sets::new(),
        entities: None,
        nodes: None,
        blocks: None,
    };
    while let Some(name) = cursor.next_section()? {
        sections.read(name, &mut cursor)?;
    }
    sections.finish(&cursor)
}

/// What was read so far.
struct Sections {
    version: Option<Version>,
    names: Names,
    sets: Sets,
    entities: Option<Entities>,
    nodes: Option<Nodes>,
    blocks: Option<Blocks>,
}

impl Sections {
    fn read(&mut self, name: &str, cursor: &mut Cursor) -> Result<()> {
        let order = "the order is $MeshFormat, $Entities (4.1), $Nodes, $Elements, each once";
        let is_again = match name {
            "MeshFormat" => self.version.is_some(),
            "Entities" => self.entities.is_some() || self.blocks.is_some(),
            "Nodes" | "ParametricNodes" => self.nodes.is_some(),
            "Elements" => self.blocks.is_some(),
            _ => false,
        };
        if is_again {
            return Err(cursor.error("the section comes twice or too late", order));
        }
        match (name, self.version) {
            ("MeshFormat", _) => self.version = Some(format::read(cursor)?),
            ("NOD" | "ELM", _) => {
                let remedy = "2.2 and 4.1 are read: write it with Mesh.MshFileVersion = 4.1";
                return Err(cursor.error("the version of the file is 1", remedy));
            }
            ("Comments", _) => return cursor.skip_section(),
            (_, None) => return Err(cursor.error("$MeshFormat does not come first", order)),
            ("PhysicalNames", _) => groups::read_names(cursor, &mut self.names)?,
            ("Entities", Some(Version::V4)) => {
                self.entities = Some(groups::read_entities(cursor, &mut self.sets)?);
            }
            ("PartitionedEntities", _) => {
                return Err(cursor.error("the mesh is cut into partitions", UNCUT));
            }
            ("Nodes", Some(version)) => self.nodes = Some(Nodes::read(cursor, version, false)?),
            ("ParametricNodes", Some(Version::V2)) => {
                self.nodes = Some(Nodes::read(cursor, Version::V2, true)?);
            }
            ("Elements", Some(version)) => {
                let Some(nodes) = &self.nodes else {
                    return Err(cursor.error("the section comes before $Nodes", order));
                };
                self.blocks = Some(match (version, &self.entities) {
                    (Version::V2, _) => elements::read_v2(cursor, nodes, &mut self.sets)?,
                    (Version::V4, Some(entities)) => elements::read_v4(cursor, nodes, entities)?,
                    (Version::V4, None) => {
                        let remedy = "its groups are unknown: write the file with Gmsh itself";
                        return Err(cursor.error("there is no $Entities before it", remedy));
                    }
                });
            }
            _ => return cursor.skip_section(),
        }
        cursor.end_section()
    }

    fn finish(mut self, cursor: &Cursor) -> Result<FileMesh> {
        let missing = |what: &str| {
            cursor.error(format!("the file has no {what}"), "mesh before it is written (Mesh 3)")
        };
        let version = self.version.ok_or_else(|| missing("$MeshFormat"))?;
        let nodes = self.nodes.ok_or_else(|| missing("$Nodes"))?;
        let mut blocks = self.blocks.ok_or_else(|| missing("$Elements"))?;
        if let Some(points) = blocks.get_mut(&Kind::Point1) {
            let dropped: Vec<_> = points.groups.iter().map(|set| *set == 0).collect();
            retain(points, &dropped);
        }
        blocks.retain(|_, block| !block.numbers.is_empty());
        if blocks.is_empty() {
            return Err(missing("elements but points without a group"));
        }
        for block in blocks.values_mut() {
            join(block, &mut self.sets, version == Version::V2)?;
        }
        let (groups, group_sets) = self.sets.finish(&self.names)?;
        let mut mesh = FileMesh {
            points: nodes.points,
            node_numbers: nodes.numbers,
            blocks: blocks.into_values().collect(),
            group_sets,
            groups,
            node_groups: Vec::new(),
            remarks: Vec::new(),
        };
        remark_on_groups(&mut mesh, version);
        drop_orphans(&mut mesh);
        Ok(mesh)
    }
}

/// Says which groups have no elements.
fn remark_on_groups(mesh: &mut FileMesh, version: Version) {
    let mut is_used = vec![false; mesh.groups.len()];
    for set in mesh.blocks.iter().flat_map(|block| &block.groups) {
        for group in mesh.group_sets.get(*set as usize).into_iter().flatten() {
            is_used[*group as usize] = true;
        }
    }
    mesh.remarks.extend(without_elements(&mesh.groups, &is_used, version));
}

/// Takes out the nodes of no element.
fn drop_orphans(mesh: &mut FileMesh) {
    let mut is_used = vec![false; mesh.points.len()];
    for node in mesh.blocks.iter().flat_map(|block| &block.nodes) {
        is_used[*node as usize] = true;
    }
    let orphans = is_used.iter().filter(|is_used| !**is_used).count();
    if orphans == 0 {
        return;
    }
    mesh.remarks.extend(orphans_of_elements(orphans));
    let mut places = vec![0; is_used.len()];
    let kept = places.iter_mut().zip(&is_used).filter(|(_, is_used)| **is_used);
    for ((place, _), index) in kept.zip(0..) {
        *place = index;
    }
    for node in mesh.blocks.iter_mut().flat_map(|block| &mut block.nodes) {
        *node = places[*node as usize];
    }
    let mut used = is_used.iter();
    mesh.points.retain(|_| used.next() == Some(&true));
    let mut used = is_used.iter();
    mesh.node_numbers.retain(|_| used.next() == Some(&true));
}
