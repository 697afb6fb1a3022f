//! The rows of a window of a file of Gmsh.

use super::copies::join;
use super::cursor::Cursor;
use super::elements::{read_kind, read_tags_v2};
use super::format::Version;
use super::groups::Sets;
use super::layout::{Block as Rows, Layout, Window};
use super::remarks::{orphans_of_elements, without_elements};
use super::source::Source;
use super::types;

use crate::error::{Error, Result};
use crate::mesh::import::order::reversal;
use crate::mesh::import::slab::{Elements, GroupSet, NodeRows, Pieces, SetOfTags, short};
use crate::mesh::import::{Block, Group, Kind};

/// A file of Gmsh in pieces.
pub struct Slabs<S> {
    /// Where what stands.
    pub layout: Layout,
    /// Its bytes.
    pub source: S,
}

impl<S: Source> Pieces for Slabs<S> {
    fn node_rows(&self) -> Vec<u64> {
        self.layout.nodes.iter().map(|window| window.rows).collect()
    }

    fn element_rows(&self) -> Vec<u64> {
        self.layout.elements.iter().map(|window| window.rows).collect()
    }

    fn nodes(&self, piece: usize) -> Result<NodeRows> {
        let window = &self.layout.nodes[piece];
        let Rows::Nodes(parameters) = window.block else { return Err(wrong()) };
        let mut found = NodeRows::default();
        let bytes = self.source.read(window.bytes.at, window.bytes.length as usize)?;
        let mut cursor = Cursor::within(&bytes, "$Nodes", self.layout.encoding);
        if self.layout.version == Version::V4 {
            let numbers = self.source.read(window.numbers.at, window.numbers.length as usize)?;
            let mut cursor = Cursor::within(&numbers, "$Nodes", self.layout.encoding);
            for _ in 0..window.rows {
                cursor.begin();
                found.numbers.push(short(cursor.size()?)?);
            }
            at_end(&mut cursor, numbers.len())?;
        }
        for _ in 0..window.rows {
            cursor.begin();
            if self.layout.version == Version::V2 {
                found.numbers.push(short(cursor.size()?)?);
            }
            found.points.push(cursor.point()?);
            for _ in 0..parameters {
                cursor.real()?;
            }
            cursor.end()?;
        }
        at_end(&mut cursor, bytes.len())?;
        Ok(found)
    }

    fn elements(&self, piece: usize, sets: &mut Vec<SetOfTags>) -> Result<Vec<Elements>> {
        let window = &self.layout.elements[piece];
        let bytes = self.source.read(window.bytes.at, window.bytes.length as usize)?;
        let mut cursor = Cursor::within(&bytes, "$Elements", self.layout.encoding);
        let found = read(&mut cursor, window, sets)?;
        at_end(&mut cursor, bytes.len())?;
        Ok(found)
    }

    fn sets(&self) -> Vec<SetOfTags> {
        self.layout.sets.clone()
    }

    fn groups(&self, sets: Vec<SetOfTags>) -> Result<(Vec<Group>, Vec<GroupSet>)> {
        Sets::of(sets).finish(&self.layout.names)
    }

    fn join(&self, blocks: &mut [Block], sets: &mut Vec<SetOfTags>) -> Result<()> {
        let mut known = Sets::of(std::mem::take(sets));
        for block in blocks {
            join(block, &mut known, self.layout.version == Version::V2)?;
        }
        *sets = known.list();
        Ok(())
    }

    fn remarks(&self, orphans: u64, groups: &[Group], counts: &[usize]) -> Vec<String> {
        let is_used: Vec<bool> = counts.iter().map(|count| *count > 0).collect();
        let unused = without_elements(groups, &is_used, self.layout.version);
        unused.into_iter().chain(orphans_of_elements(orphans as usize)).collect()
    }
}

fn wrong() -> Error {
    Error::Input("the rows of a window do not fit".into())
}

/// Refuses what is left of a window: its rows are not on a line each.
fn at_end(cursor: &mut Cursor, length: usize) -> Result<()> {
    cursor.begin();
    if cursor.position() == length { Ok(()) } else { Err(wrong()) }
}

/// The elements of a window, those of one kind that stand beside each other together.
fn read(cursor: &mut Cursor, window: &Window, sets: &mut Vec<SetOfTags>) -> Result<Vec<Elements>> {
    let mut found: Vec<Elements> = Vec::new();
    let mut last = None;
    let reversed = match window.block {
        Rows::Entity { kind, is_reversed: true, .. } => Some(reversal(kind)),
        _ => None,
    };
    let mut row = Vec::new();
    for _ in 0..window.rows {
        cursor.begin();
        if let Rows::Records { has_heads: true, .. } = window.block {
            let _head = (read_kind(cursor)?, cursor.size()?, cursor.size()?);
        }
        let _number = cursor.size()?;
        let (kind, set) = match window.block {
            Rows::Entity { kind, set, .. } => (kind, set),
            Rows::Nodes(_) => return Err(wrong()),
            Rows::Lines | Rows::Records { .. } => {
                let (kind, tags) = match window.block {
                    Rows::Records { kind, tags, .. } => (kind, tags),
                    _ => (read_kind(cursor)?, cursor.size()?),
                };
                let group = read_tags_v2(cursor, cursor.check_room(tags, 2, 4, "tags")?)?;
                let key = (kind.dim(), group);
                let set = match last {
                    Some((known, set)) if known == key => set,
                    _ => place(sets, key),
                };
                last = Some((key, set));
                (kind, set)
            }
        };
        row.clear();
        for _ in 0..kind.nodes() {
            row.push(short(cursor.size()?)?);
        }
        cursor.end()?;
        check_distinct(&row)?;
        if found.last().is_none_or(|last| last.kind != kind) {
            found.push(Elements { kind, nodes: Vec::new(), sets: Vec::new() });
        }
        if let Some(last) = found.last_mut() {
            add(last, &row, reversed.as_deref());
            last.sets.push(set);
        }
    }
    Ok(found)
}

/// The place of the set of one group, or of the empty one.
fn place(sets: &mut Vec<SetOfTags>, key: (usize, u64)) -> u32 {
    if key.1 == 0 {
        return 0;
    }
    let known = sets.iter().position(|set| **set == [key]);
    known.unwrap_or_else(|| {
        sets.push(vec![key]);
        sets.len() - 1
    }) as u32
}

fn check_distinct(row: &[u32]) -> Result<()> {
    let is_again = |at: usize| row[..at].contains(&row[at]);
    if (1..row.len()).any(is_again) { Err(wrong()) } else { Ok(()) }
}

fn add(to: &mut Elements, row: &[u32], reversal: Option<&[usize]>) {
    let order = types::order(to.kind);
    for place in 0..Kind::nodes(to.kind) {
        let place = reversal.map_or(place, |p| p[place]);
        to.nodes.push(row[order.map_or(place, |p| p[place])]);
    }
}
