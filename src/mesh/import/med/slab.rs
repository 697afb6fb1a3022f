//! A file in pieces, each read by itself.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;

use super::archive::{Folder, Told, open};
use super::cells::{Type, element, whole};
use super::families::{Families, read as read_families};
use super::head::step_of;
use crate::error::{Error, Result};
use crate::mesh::import::slab::{Elements, GroupSet, NodeRows, Pieces, SetOfTags};
use crate::mesh::import::{Block, Group, Kind};

/// A file of MED in pieces.
pub struct Slabs {
    nodes: Folder,
    space: usize,
    points: usize,
    types: Vec<OfType>,
    families: Families,
    /// Beginning and rows of each piece of the nodes.
    node_pieces: Vec<(usize, usize)>,
    /// Type, beginning and rows of each piece of the elements.
    element_pieces: Vec<(usize, usize, usize)>,
    said: [Vec<String>; 2],
}

/// The elements of a type.
struct OfType {
    folder: Folder,
    element: &'static Type,
    count: usize,
}

impl Slabs {
    /// Opens a file, to be read in pieces of at most `most` rows.
    ///
    /// # Errors
    /// As [`super::read`]; `Input` for groups of nodes, which are read whole only.
    pub fn open(path: &Path, most: usize) -> Result<Self> {
        let top = open(path)?;
        Self::of(&top, most).map_err(Error::Input)
    }

    fn of(top: &Folder, most: usize) -> Told<Self> {
        let mut first = Vec::new();
        let (name, space, step) = step_of(top, &mut first)?;
        let nodes = step.folder("NOE")?;
        whole(&nodes)?;
        let points = nodes.rows("COO")?;
        check_length(&nodes, "COO", points.checked_mul(space))?;
        check_lists(&nodes, points)?;
        let all = step.folder("MAI")?;
        let mut types = Vec::new();
        for name in all.members()? {
            let folder = all.folder(&name)?;
            let element = element(&name).ok_or_else(|| format!("elements of type {name}"))?;
            whole(&folder)?;
            let count = folder.rows("NOD")?;
            check_length(&folder, "NOD", count.checked_mul(element.kind.nodes()))?;
            check_lists(&folder, count)?;
            if count > 0 {
                types.push(OfType { folder, element, count });
            }
        }
        let mut last = Vec::new();
        let [families, of_nodes] = read_families(top, &name, &mut last)?;
        if of_nodes.values().any(|groups| !groups.is_empty()) {
            return Err("it has groups of nodes".into());
        }
        let cut =
            |rows: usize| (0..rows).step_by(most).map(move |from| (from, most.min(rows - from)));
        let of_type = |(place, of): (usize, &OfType)| {
            cut(of.count).map(|(from, rows)| (place, from, rows)).collect::<Vec<_>>()
        };
        let element_pieces = types.iter().enumerate().flat_map(of_type).collect();
        let (node_pieces, said) = (cut(points).collect(), [first, last]);
        Ok(Self { nodes, space, points, types, families, node_pieces, element_pieces, said })
    }

    /// The number of elements.
    pub fn rows(&self) -> u64 {
        self.types.iter().map(|of| of.count as u64).sum()
    }

    fn read_nodes(&self, (from, rows): (usize, usize)) -> Told<NodeRows> {
        let mut points = vec![[0.0; 3]; rows];
        for axis in 0..self.space {
            let begin = axis * self.points + from;
            let values = self.nodes.reals_in("COO", begin..begin + rows)?;
            for (point, x) in points.iter_mut().zip(values) {
                if !x.is_finite() {
                    return Err("a coordinate is not finite".into());
                }
                point[axis] = x;
            }
        }
        if self.nodes.has("FAM") {
            let families = self.nodes.integers_in("FAM", from..from + rows)?;
            if families.iter().any(|family| *family != 0) {
                return Err("it has nodes in families".into());
            }
        }
        check_numbers(&self.nodes, from..from + rows)?;
        let numbers = (from..from + rows).map(|node| node as u32 + 1).collect();
        Ok(NodeRows { numbers, points })
    }

    fn read_elements(
        &self,
        (place, from, rows): (usize, usize, usize),
        sets: &mut Vec<SetOfTags>,
    ) -> Told<Elements> {
        let OfType { folder, element, count } = &self.types[place];
        let (kind, width) = (element.kind, element.kind.nodes());
        check_numbers(folder, from..from + rows)?;
        let mut nodes = vec![0; width * rows];
        for (local, place) in element.order.iter().enumerate() {
            let begin = usize::from(*place) * count + from;
            for (row, node) in folder.integers_in("NOD", begin..begin + rows)?.iter().enumerate() {
                if *node < 1 || *node > self.points as i64 {
                    return Err("an element has a node that is not there".into());
                }
                nodes[row * width + local] = *node as u32;
            }
        }
        let mut known = BTreeMap::from([(0, 0)]);
        let mut of_elements = vec![0; rows];
        if folder.has("FAM") {
            let families = folder.integers_in("FAM", from..from + rows)?;
            for (set, family) in of_elements.iter_mut().zip(families) {
                *set = match known.get(&family) {
                    Some(set) => *set,
                    None => self.set(kind, family, sets)?,
                };
                known.insert(family, *set);
            }
        }
        Ok(Elements { kind, nodes, sets: of_elements })
    }

    /// The set of a family; that of one without groups is empty.
    fn set(&self, kind: Kind, family: i64, sets: &mut Vec<SetOfTags>) -> Told<u32> {
        let groups = self.families.get(&family).ok_or("a family is not told")?;
        let set: SetOfTags = match groups.is_empty() {
            true => Vec::new(),
            false => vec![(kind.dim(), family.unsigned_abs())],
        };
        let place = sets.iter().position(|other| *other == set).unwrap_or(sets.len());
        if place == sets.len() {
            sets.push(set);
        }
        Ok(place as u32)
    }

    /// The names of the groups of a set.
    fn names(&self, set: &SetOfTags) -> Vec<(usize, String)> {
        let names = |(dim, family): &(usize, u64)| {
            let groups = self.families.get(&-(*family as i64)).into_iter().flatten();
            groups.map(|name| (*dim, name.clone())).collect::<Vec<_>>()
        };
        set.iter().flat_map(names).collect()
    }
}

/// Refuses numbers and families that are not one for each node or element.
fn check_lists(folder: &Folder, count: usize) -> Told<()> {
    let mut there = ["NUM", "FAM"].into_iter().filter(|name| folder.has(name));
    there.try_for_each(|name| check_length(folder, name, Some(count)))
}

/// Refuses numbers that are negative.
fn check_numbers(folder: &Folder, rows: Range<usize>) -> Told<()> {
    let is_wrong = folder.has("NUM") && folder.integers_in("NUM", rows)?.iter().any(|n| *n < 0);
    if is_wrong { Err(format!("{}: it is negative", folder.inner("NUM"))) } else { Ok(()) }
}

/// Refuses lists of another length.
fn check_length(folder: &Folder, name: &str, wanted: Option<usize>) -> Told<()> {
    let length = folder.length(name)?;
    if wanted == Some(length) && length < u32::MAX as usize {
        return Ok(());
    }
    Err(format!("{}: it has {length} entries", folder.inner(name)))
}

impl Pieces for Slabs {
    fn node_rows(&self) -> Vec<u64> {
        self.node_pieces.iter().map(|(_, rows)| *rows as u64).collect()
    }

    fn element_rows(&self) -> Vec<u64> {
        self.element_pieces.iter().map(|(_, _, rows)| *rows as u64).collect()
    }

    fn nodes(&self, piece: usize) -> Result<NodeRows> {
        self.read_nodes(self.node_pieces[piece]).map_err(Error::Input)
    }

    fn elements(&self, piece: usize, sets: &mut Vec<SetOfTags>) -> Result<Vec<Elements>> {
        let read = self.read_elements(self.element_pieces[piece], sets);
        read.map(|elements| vec![elements]).map_err(Error::Input)
    }

    fn sets(&self) -> Vec<SetOfTags> {
        vec![Vec::new()]
    }

    fn groups(&self, sets: Vec<SetOfTags>) -> Result<(Vec<Group>, Vec<GroupSet>)> {
        let of_sets: Vec<Vec<(usize, String)>> = sets.iter().map(|set| self.names(set)).collect();
        let all: BTreeSet<&(usize, String)> = of_sets.iter().flatten().collect();
        let places: BTreeMap<&(usize, String), u32> = all.iter().copied().zip(0..).collect();
        let of_set = |names: &Vec<(usize, String)>| names.iter().map(|name| places[name]).collect();
        let of_sets = of_sets.iter().map(of_set).collect();
        let groups = all.into_iter().map(|(dim, name)| Group { name: name.clone(), dim: *dim });
        Ok((groups.collect(), of_sets))
    }

    fn join(&self, _: &mut [Block], _: &mut Vec<SetOfTags>) -> Result<()> {
        Ok(())
    }

    fn remarks(&self, orphans: u64, groups: &[Group], _: &[usize]) -> Vec<String> {
        let [mut said, last] = self.said.clone();
        if orphans > 0 {
            said.push(format!(
                "nodes that no element uses are left out: {orphans} of {}",
                self.points
            ));
        }
        said.extend(last);
        let is_used = |name: &&String| groups.iter().any(|group| group.name == **name);
        let all: BTreeSet<&String> = self.families.values().flatten().collect();
        let empty: Vec<&str> =
            all.into_iter().filter(|name| !is_used(name)).map(String::as_str).collect();
        if !empty.is_empty() {
            let list = empty.join(", ");
            said.push(format!("groups without elements and nodes are left out: {list}"));
        }
        said
    }

    fn order(&self, kind: Kind) -> usize {
        let place = self.types.iter().position(|of| of.element.kind == kind);
        place.unwrap_or(self.types.len())
    }
}
