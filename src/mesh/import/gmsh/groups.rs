//! Physical groups: their names, and the sets of them to which elements belong.

use std::collections::{BTreeMap, BTreeSet};

use super::super::file_mesh::Group;
use super::cursor::{Cursor, DAMAGED, shown};
use crate::error::{Error, Result};

/// A physical group: its dimension, and its number without a sign.
pub(super) type Tag = (usize, u64);

/// The names of groups.
pub(super) type Names = BTreeMap<Tag, String>;

/// Reads `$PhysicalNames`, which is text in all files.
pub(super) fn read_names(cursor: &mut Cursor, names: &mut Names) -> Result<()> {
    let count = cursor.text_count()?;
    let mut seen = BTreeMap::new();
    for _ in 0..count {
        let line = cursor.text()?;
        let Some((tag, name)) = tag_and_name(line) else {
            let what = format!(
                "expected dimension, number and \"name\", found {}",
                shown(line.as_bytes())
            );
            return Err(cursor.error(what, "the count and the lines of the section differ"));
        };
        if name.is_empty() {
            continue;
        }
        if let Some(other) = names.insert(tag, name.to_owned()) {
            let what = format!("group {} of dimension {} is `{other}` and `{name}`", tag.1, tag.0);
            return Err(cursor.error(what, "give a physical group one name"));
        }
        if let Some(other) = seen.insert((tag.0, name), tag.1) {
            return Err(cursor.error(same_name(tag.0, name, other, tag.1), RENAME));
        }
    }
    Ok(())
}

const RENAME: &str = "rename one, or give all their entities one number";

fn same_name(dim: usize, name: &str, one: u64, other: u64) -> String {
    format!("groups {one} and {other} of dimension {dim} are both called `{name}`")
}

/// Of `2 7 "top"`.
fn tag_and_name(line: &str) -> Option<(Tag, &str)> {
    let (dim, rest) = line.split_once([' ', '\t'])?;
    let (number, rest) = rest.trim_start().split_once([' ', '\t'])?;
    let name = rest.trim().strip_prefix('"')?.strip_suffix('"')?;
    let dim = dim.parse().ok().filter(|dim| *dim <= 3)?;
    let number = number.parse::<i64>().ok()?.unsigned_abs();
    Some(((dim, number), name))
}

/// The distinct sets of groups; set 0 is the empty one.
pub(super) struct Sets {
    list: Vec<Vec<Tag>>,
    places: BTreeMap<Vec<Tag>, u32>,
}

impl Sets {
    pub fn new() -> Self {
        Self { list: vec![Vec::new()], places: BTreeMap::from([(Vec::new(), 0)]) }
    }

    /// Those of a list, of which the first one is empty.
    pub fn of(list: Vec<Vec<Tag>>) -> Self {
        let places = list.iter().cloned().zip(0..).collect();
        Self { list, places }
    }

    /// All of them.
    pub fn list(&self) -> Vec<Vec<Tag>> {
        self.list.clone()
    }

    /// The number of a set, which is new or known; its groups in any order.
    pub fn place(&mut self, mut tags: Vec<Tag>) -> u32 {
        tags.sort_unstable();
        tags.dedup();
        if let Some(place) = self.places.get(&tags) {
            return *place;
        }
        // There are no more sets than elements, whose nodes have 32 bits.
        let place = self.list.len() as u32;
        self.list.push(tags.clone());
        self.places.insert(tags, place);
        place
    }

    pub fn tags(&self, place: u32) -> &[Tag] {
        self.list.get(place as usize).map_or(&[], Vec::as_slice)
    }

    /// The groups, rising in dimension and number, and the sets as indices into them. What has no
    /// name is called as its number.
    pub fn finish(self, names: &Names) -> Result<(Vec<Group>, Vec<Vec<u32>>)> {
        let used = self.list.iter().flatten().copied();
        let tags: BTreeSet<Tag> = names.keys().copied().chain(used).collect();
        let mut groups = Vec::with_capacity(tags.len());
        let mut seen = BTreeMap::new();
        for tag in &tags {
            let name = names.get(tag).cloned().unwrap_or_else(|| tag.1.to_string());
            if let Some(other) = seen.insert((tag.0, name.clone()), tag.1) {
                let what = same_name(tag.0, &name, other, tag.1);
                return Err(Error::Input(format!("$PhysicalNames: {what}; {RENAME}")));
            }
            groups.push(Group { name, dim: tag.0 });
        }
        let places: BTreeMap<Tag, u32> = tags.into_iter().zip(0..).collect();
        let indices =
            |set: &Vec<Tag>| set.iter().filter_map(|tag| places.get(tag).copied()).collect();
        Ok((groups, self.list.iter().map(indices).collect()))
    }
}

/// The set of groups of an entity of MSH 4.1, and whether its elements are to be reversed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entity {
    pub set: u32,
    pub is_reversed: bool,
}

/// The entities of MSH 4.1 by dimension and number.
pub(super) type Entities = BTreeMap<(i64, i64), Entity>;

/// Reads `$Entities`.
pub(super) fn read_entities(cursor: &mut Cursor, sets: &mut Sets) -> Result<Entities> {
    let mut entities = Entities::new();
    cursor.begin();
    let counts = [cursor.size()?, cursor.size()?, cursor.size()?, cursor.size()?];
    cursor.end()?;
    for count in counts {
        cursor.check_room(count, 10, 32, "entities")?;
    }
    for (dim, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            cursor.begin();
            let number = cursor.int()?;
            for _ in 0..if dim == 0 { 3 } else { 6 } {
                cursor.real()?;
            }
            let entity = read_physical_tags(cursor, sets, dim, number)?;
            if dim > 0 {
                let bounds = cursor.size()?;
                for _ in 0..cursor.check_room(bounds, 2, 4, "bounding entities")? {
                    cursor.int()?;
                }
            }
            cursor.end()?;
            if entities.insert((dim as i64, number), entity).is_some() {
                let what = format!("entity {number} of dimension {dim} is there twice");
                return Err(cursor.error(what, DAMAGED));
            }
        }
    }
    Ok(entities)
}

fn read_physical_tags(
    cursor: &mut Cursor,
    sets: &mut Sets,
    dim: usize,
    number: i64,
) -> Result<Entity> {
    let count = cursor.size()?;
    let count = cursor.check_room(count, 2, 4, "physical groups")?;
    let mut tags = Vec::with_capacity(count);
    let mut is_reversed = false;
    for i in 0..count {
        let tag = cursor.int()?;
        let is_negative = tag < 0 && dim > 0;
        if i > 0 && is_negative != is_reversed {
            let what = format!(
                "entity {number} of dimension {dim} belongs to one group with its sense and to \
                 another reversed"
            );
            return Err(cursor.error(what, "give its physical tags one sign"));
        }
        is_reversed = is_negative;
        tags.push((dim, tag.unsigned_abs()));
    }
    Ok(Entity { set: sets.place(tags), is_reversed })
}
