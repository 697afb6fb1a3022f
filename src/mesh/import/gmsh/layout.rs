//! Where nodes and elements stand in a file of Gmsh, found without keeping what it holds.
//!
//! Text is taken to have one row on each line, as Gmsh writes it; where it has not, the rows that
//! are read later do not fit, and the file is read the other way.

use serde::{Deserialize, Serialize};

use super::cursor::{Cursor, Encoding};
use super::elements::read_kind;
use super::format::{self, Version};
use super::groups::{self, Entities, Names, Sets, Tag};
use super::source::{Bytes, Source};
use crate::error::{Error, Result};
use crate::mesh::import::Kind;

/// No header of a block or section is longer.
const HEADER: usize = 4096;

/// Bytes of elements with heads that are looked at together.
const AT_ONCE: u64 = 1 << 22;

/// Rows beside each other, which one rank reads at once.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Window {
    pub rows: u64,
    pub bytes: Bytes,
    /// Where the numbers of nodes stand, where they stand apart.
    pub numbers: Bytes,
    pub block: Block,
}

/// What the rows of a block have in common.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum Block {
    /// Nodes, with so many parameters each.
    Nodes(u64),
    /// Elements of MSH 4.1.
    Entity { kind: Kind, set: u32, is_reversed: bool },
    /// Elements of MSH 2.2 in text.
    Lines,
    /// Elements of MSH 2.2 in binary; `has_heads` where each has its own head.
    Records { kind: Kind, tags: u64, has_heads: bool },
}

/// The layout of a file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Layout {
    pub(super) version: Version,
    pub(super) encoding: Encoding,
    pub(super) names: Names,
    pub(super) sets: Vec<Vec<Tag>>,
    pub(super) nodes: Vec<Window>,
    pub(super) elements: Vec<Window>,
}

impl Layout {
    /// The number of elements.
    pub fn rows(&self) -> u64 {
        self.elements.iter().map(|window| window.rows).sum()
    }

    /// Finds the layout of a file, in windows of at most `most` rows.
    ///
    /// # Errors
    /// `Input` for what is not as the format says, and for what can be read whole only.
    pub fn of(source: &dyn Source, most: u64) -> Result<Self> {
        let mut scan = Scan { source, at: 0, most, encoding: Encoding::Ascii };
        let mut names = Names::new();
        let (mut version, mut entities, mut sets) = (None, None, Sets::new());
        let (mut nodes, mut elements) = (None, None);
        while let Some(section) = scan.section()? {
            match (section.as_str(), version) {
                ("MeshFormat", None) => {
                    version = Some(scan.header(&section, format::read)?);
                    scan.end(&section)?;
                }
                ("Comments", _) => scan.whole(&section).map(|_| ())?,
                (_, None) => return Err(unread("$MeshFormat does not come first")),
                ("PhysicalNames", _) => {
                    let bytes = scan.whole(&section)?;
                    let mut cursor = Cursor::within(&bytes, "$PhysicalNames", scan.encoding);
                    groups::read_names(&mut cursor, &mut names)?;
                    cursor.end_section()?;
                }
                ("Entities", Some(Version::V4)) if entities.is_none() => {
                    let bytes = scan.whole(&section)?;
                    let mut cursor = Cursor::within(&bytes, "$Entities", scan.encoding);
                    entities = Some(groups::read_entities(&mut cursor, &mut sets)?);
                    cursor.end_section()?;
                }
                ("Nodes", Some(version)) if nodes.is_none() => {
                    nodes = Some(scan.nodes(version)?);
                    scan.end(&section)?;
                }
                ("Elements", Some(version)) if elements.is_none() && nodes.is_some() => {
                    elements = Some(scan.elements(version, entities.as_ref())?);
                    scan.end(&section)?;
                }
                ("ParametricNodes" | "PartitionedEntities" | "Entities" | "Nodes", _)
                | ("Elements" | "MeshFormat" | "NOD" | "ELM", _) => {
                    return Err(unread(&format!("the section ${section} is read whole only")));
                }
                _ => scan.whole(&section).map(|_| ())?,
            }
        }
        let missing = || unread("the file lacks nodes or elements");
        Ok(Self {
            version: version.ok_or_else(missing)?,
            encoding: scan.encoding,
            names,
            sets: sets.list(),
            nodes: nodes.ok_or_else(missing)?,
            elements: elements.ok_or_else(missing)?,
        })
    }
}

fn unread(why: &str) -> Error {
    Error::Input(why.to_owned())
}

/// A place in a file that moves over it.
struct Scan<'s> {
    source: &'s dyn Source,
    at: u64,
    most: u64,
    encoding: Encoding,
}

impl Scan<'_> {
    /// The name of the next section.
    fn section(&mut self) -> Result<Option<String>> {
        let bytes = self.source.read(self.at, HEADER)?;
        let mut cursor = Cursor::new(&bytes);
        let name = cursor.next_section()?.map(str::to_owned);
        self.at += cursor.position() as u64;
        Ok(name)
    }

    /// What stands at the beginning of a block or section.
    fn header<T>(&mut self, section: &str, read: impl Fn(&mut Cursor) -> Result<T>) -> Result<T> {
        let bytes = self.source.read(self.at, HEADER)?;
        let mut cursor = Cursor::within(&bytes, &format!("${section}"), self.encoding);
        let header = read(&mut cursor)?;
        self.encoding = cursor.encoding();
        self.at += cursor.position() as u64;
        Ok(header)
    }

    fn end(&mut self, section: &str) -> Result<()> {
        self.header(section, |cursor| cursor.end_section())
    }

    /// The bytes of a section with its end, behind which it moves.
    fn whole(&mut self, section: &str) -> Result<Vec<u8>> {
        let end = format!("$End{section}");
        let behind = self.source.find(self.at, end.as_bytes())?;
        let behind = behind.ok_or_else(|| unread(&format!("the section has no {end}")))?;
        let bytes = self.source.read(self.at, (behind - self.at) as usize)?;
        self.at = behind;
        Ok(bytes)
    }

    /// Four numbers of a section of MSH 4.1, the first two of them: blocks and rows.
    fn counts(&mut self, section: &str) -> Result<[u64; 2]> {
        self.header(section, |cursor| {
            cursor.begin();
            let counts = [cursor.size()?, cursor.size()?];
            let _range = [cursor.size()?, cursor.size()?];
            cursor.end()?;
            Ok(counts)
        })
    }

    fn nodes(&mut self, version: Version) -> Result<Vec<Window>> {
        let mut windows = Vec::new();
        if version == Version::V2 {
            let rows = self.header("Nodes", |cursor| cursor.text_count())?;
            for (rows, bytes) in self.rows(rows, 28)? {
                let (numbers, block) = (Bytes::default(), Block::Nodes(0));
                windows.push(Window { rows, bytes, numbers, block });
            }
            return Ok(windows);
        }
        let [blocks, total] = self.counts("Nodes")?;
        let mut found = 0;
        for _ in 0..blocks {
            let (dim, is_parametric, rows) = self.header("Nodes", |cursor| {
                cursor.begin();
                let (dim, _entity, parametric) = (cursor.int()?, cursor.int()?, cursor.int()?);
                let rows = cursor.size()?;
                cursor.end()?;
                Ok((dim, parametric != 0, rows))
            })?;
            let parameters = match (is_parametric, dim) {
                (false, _) => 0,
                (true, 0..=3) => dim as u64,
                _ => return Err(unread("an entity has another dimension")),
            };
            let numbers = self.rows(rows, self.size())?;
            let points = self.rows(rows, 8 * (3 + parameters))?;
            for ((rows, numbers), (_, bytes)) in numbers.into_iter().zip(points) {
                windows.push(Window { rows, bytes, numbers, block: Block::Nodes(parameters) });
            }
            found += rows;
        }
        if found == total { Ok(windows) } else { Err(unread("other nodes than promised")) }
    }

    fn elements(&mut self, version: Version, entities: Option<&Entities>) -> Result<Vec<Window>> {
        let Some(entities) = entities else {
            return match version {
                Version::V2 => self.elements_v2(),
                Version::V4 => Err(unread("there is no $Entities")),
            };
        };
        let [blocks, total] = self.counts("Elements")?;
        let (mut windows, mut found) = (Vec::new(), 0);
        for _ in 0..blocks {
            let (kind, entity, rows) = self.header("Elements", |cursor| {
                cursor.begin();
                let (dim, number) = (cursor.int()?, cursor.int()?);
                let entity = entities.get(&(dim, number)).copied();
                let kind = read_kind(cursor)?;
                let rows = cursor.size()?;
                cursor.end()?;
                Ok((kind, entity.filter(|_| kind.dim() as i64 == dim), rows))
            })?;
            let entity = entity.ok_or_else(|| unread("an entity is missing"))?;
            let (set, is_reversed) = (entity.set, entity.is_reversed);
            let block = Block::Entity { kind, set, is_reversed };
            let numbers = Bytes::default();
            for (rows, bytes) in self.rows(rows, self.size() * (1 + kind.nodes() as u64))? {
                windows.push(Window { rows, bytes, numbers, block });
            }
            found += rows;
        }
        if found == total { Ok(windows) } else { Err(unread("other elements than promised")) }
    }

    fn elements_v2(&mut self) -> Result<Vec<Window>> {
        let total = self.header("Elements", |cursor| cursor.text_count())?;
        let (mut windows, mut left, numbers) = (Vec::new(), total, Bytes::default());
        while left > 0 {
            if self.encoding == Encoding::Ascii {
                for (rows, bytes) in self.rows(left, 0)? {
                    windows.push(Window { rows, bytes, numbers, block: Block::Lines });
                }
                return Ok(windows);
            }
            let head = self.at;
            let read =
                |cursor: &mut Cursor| Ok((read_kind(cursor)?, cursor.size()?, cursor.size()?));
            let (kind, many, tags) = self.header("Elements", read)?;
            if many == 0 || many > left {
                return Err(unread("other elements than promised"));
            }
            let bytes = tags.saturating_add(1 + kind.nodes() as u64).saturating_mul(4);
            if many == 1 {
                let window = self.heads(head, kind, tags, (bytes, left))?;
                left -= window.rows;
                windows.push(window);
                continue;
            }
            left -= many;
            let block = Block::Records { kind, tags, has_heads: false };
            for (rows, bytes) in self.rows(many, bytes)? {
                windows.push(Window { rows, bytes, numbers, block });
            }
        }
        Ok(windows)
    }

    /// Moves over elements that have the same head each, the first of which is at `head`; each has
    /// so many bytes behind it, and so many elements are left.
    fn heads(
        &mut self,
        head: u64,
        kind: Kind,
        tags: u64,
        (bytes, left): (u64, u64),
    ) -> Result<Window> {
        let stride = bytes.saturating_add(self.at - head);
        if stride > self.source.length() - head {
            return Err(unread("the file ends within a block"));
        }
        let most = left.min(self.most).min(AT_ONCE / stride).max(1);
        let found = self.source.read(head, (most * stride) as usize)?;
        let first = &found[..(self.at - head) as usize];
        let records = found.chunks_exact(stride as usize);
        let rows = records.take_while(|record| record.starts_with(first)).count() as u64;
        self.at = head + rows * stride;
        let (bytes, numbers) = (Bytes { at: head, length: rows * stride }, Bytes::default());
        Ok(Window { rows, bytes, numbers, block: Block::Records { kind, tags, has_heads: true } })
    }

    /// Bytes of a size of the format.
    fn size(&self) -> u64 {
        match self.encoding {
            Encoding::Binary { is_wide: true, .. } => 8,
            _ => 4,
        }
    }

    /// Moves over rows, each of which has so many bytes or is a line; their windows.
    fn rows(&mut self, rows: u64, bytes: u64) -> Result<Vec<(u64, Bytes)>> {
        let mut windows = Vec::new();
        if self.encoding == Encoding::Ascii {
            // Behind the header's line.
            let mut at = if rows > 0 { self.source.behind_lines(self.at, 1)? } else { self.at };
            // The lines of the block before end with their own end.
            if rows > 0 && self.source.read(self.at.saturating_sub(1), 1)? == b"\n" {
                at = self.at;
            }
            let mut left = rows;
            while left > 0 {
                let many = left.min(self.most);
                let to = self.source.behind_lines(at, many)?;
                windows.push((many, Bytes { at, length: to - at }));
                (at, left) = (to, left - many);
            }
            self.at = at;
            return Ok(windows);
        }
        let length = rows.checked_mul(bytes).and_then(|all| all.checked_add(self.at));
        let end = length.filter(|end| *end <= self.source.length());
        let end = end.ok_or_else(|| unread("the file ends within a block"))?;
        let mut left = rows;
        while left > 0 {
            let many = left.min(self.most);
            windows.push((many, Bytes { at: self.at, length: many * bytes }));
            self.at += many * bytes;
            left -= many;
        }
        self.at = end;
        Ok(windows)
    }
}
