//! The elements of a file.

use std::collections::BTreeMap;

use super::super::file_mesh::{Block, Kind};
use super::super::order::reversal;
use super::cursor::{Cursor, DAMAGED, REWRITE};
use super::groups::{Entities, Sets};
use super::nodes::Nodes;
use super::types;
use crate::error::Result;

/// Elements by kind.
pub(super) type Blocks = BTreeMap<Kind, Block>;

/// What is to be known to read one element after the other.
struct Reader<'r> {
    nodes: &'r Nodes,
    blocks: Blocks,
    /// The nodes of an element in the order of the file.
    element: Vec<u32>,
}

/// Reads `$Elements` of MSH 2.2.
pub(super) fn read_v2(cursor: &mut Cursor, nodes: &Nodes, sets: &mut Sets) -> Result<Blocks> {
    let mut reader = Reader::new(nodes);
    let count = cursor.text_count()?;
    // Number, type, number of tags and one node; binary files have the second and third for many.
    let count = cursor.check_room(count, 8, 8, "elements")?;
    let mut left = count;
    let mut last = None;
    while left > 0 {
        cursor.begin();
        let (mut number, mut many) = (0, 1);
        if cursor.is_ascii() {
            number = cursor.size()?;
        }
        let kind = read_kind(cursor)?;
        if !cursor.is_ascii() {
            many = cursor.size()?;
            if many == 0 || many > left as u64 {
                let what =
                    format!("{many} elements follow, {left} of the {count} promised are left");
                return Err(cursor.error(what, REWRITE));
            }
        }
        let tags = cursor.size()?;
        let tags = cursor.check_room(tags, 2, 4, "tags")?;
        for _ in 0..many {
            if !cursor.is_ascii() {
                number = cursor.size()?;
            }
            let group = read_tags_v2(cursor, tags)?;
            let key = (kind.dim(), group);
            let set = match last {
                Some((known, set)) if known == key => set,
                _ if group == 0 => 0,
                _ => sets.place(vec![key]),
            };
            last = Some((key, set));
            reader.read(cursor, kind, number, set, None)?;
            cursor.end()?;
            left -= 1;
        }
    }
    Ok(reader.blocks)
}

/// The tags of an element of MSH 2.2: the physical group (0 if none), the entity, the partitions.
/// Its orientation is already that of the group.
pub(super) fn read_tags_v2(cursor: &mut Cursor, tags: usize) -> Result<u64> {
    let mut group = 0;
    for i in 0..tags {
        let tag = cursor.int()?;
        if i == 0 {
            group = tag.unsigned_abs();
        } else if i == 2 && tag != 0 {
            return Err(cursor.error("the mesh is cut into partitions", UNCUT));
        }
    }
    Ok(group)
}

/// What to do with a mesh in parts.
pub(super) const UNCUT: &str = "write it before it is partitioned: that is done here";

/// Reads `$Elements` of MSH 4.1.
pub(super) fn read_v4(cursor: &mut Cursor, nodes: &Nodes, entities: &Entities) -> Result<Blocks> {
    let mut reader = Reader::new(nodes);
    cursor.begin();
    let [blocks, total, ..] = [cursor.size()?, cursor.size()?, cursor.size()?, cursor.size()?];
    cursor.end()?;
    cursor.check_room(blocks, 8, 16, "blocks of elements")?;
    let total = cursor.check_room(total, 4, 8, "elements")? as u64;
    let mut found = 0;
    for _ in 0..blocks {
        cursor.begin();
        let (dim, number) = (cursor.int()?, cursor.int()?);
        let Some(entity) = entities.get(&(dim, number)) else {
            let what = format!("$Entities has no entity {number} of dimension {dim}");
            return Err(
                cursor.error(what, "its groups are unknown: write the file with Gmsh itself")
            );
        };
        let kind = read_kind(cursor)?;
        if kind.dim() as i64 != dim {
            let what = format!("a {} belongs to an entity of dimension {dim}", kind.name());
            return Err(cursor.error(what, REWRITE));
        }
        let count = cursor.size()?;
        cursor.end()?;
        let nodes = kind.nodes();
        let count = cursor.check_room(count, 2 + 2 * nodes, 4 + 4 * nodes, "elements")?;
        let reversal = entity.is_reversed.then(|| reversal(kind));
        for _ in 0..count {
            cursor.begin();
            let number = cursor.size()?;
            reader.read(cursor, kind, number, entity.set, reversal.as_deref())?;
            cursor.end()?;
        }
        found += count as u64;
    }
    if found != total {
        let what = format!("{total} elements are promised, the blocks have {found}");
        return Err(cursor.error(what, REWRITE));
    }
    Ok(reader.blocks)
}

pub(super) fn read_kind(cursor: &mut Cursor) -> Result<Kind> {
    let number = cursor.int()?;
    types::kind(number).ok_or_else(|| {
        let name = types::foreign_name(number);
        let what = format!("elements of type {number} ({name}) are not read");
        cursor.error(what, "Mesh.ElementOrder = 1 or 2 makes elements that are")
    })
}

impl<'r> Reader<'r> {
    fn new(nodes: &'r Nodes) -> Self {
        Self { nodes, blocks: Blocks::new(), element: Vec::new() }
    }

    /// Reads the nodes of an element.
    fn read(
        &mut self,
        cursor: &mut Cursor,
        kind: Kind,
        number: u64,
        set: u32,
        reversal: Option<&[usize]>,
    ) -> Result<()> {
        self.element.clear();
        for _ in 0..kind.nodes() {
            let node = cursor.size()?;
            let Some(index) = self.nodes.index_of(node) else {
                let what = format!("element {number} has node {node}, which $Nodes has not");
                return Err(cursor.error(what, DAMAGED));
            };
            if self.element.contains(&index) {
                let what = format!("element {number} ({}) has node {node} twice", kind.name());
                return Err(cursor.error(what, "give it distinct nodes, or leave it out"));
            }
            self.element.push(index);
        }
        let empty = || Block { kind, nodes: Vec::new(), numbers: Vec::new(), groups: Vec::new() };
        let block = self.blocks.entry(kind).or_insert_with(empty);
        let order = types::order(kind);
        for place in 0..kind.nodes() {
            let place = reversal.map_or(place, |p| p[place]);
            let place = order.map_or(place, |p| p[place]);
            block.nodes.push(self.element[place]);
        }
        block.numbers.push(number);
        block.groups.push(set);
        Ok(())
    }
}
