//! What every rank knows of a file that is read in slabs.

use crate::element::Shape;
use crate::error::{Error, Result};
use crate::mesh::import::{Block, FileMesh, Group, GroupSet, Kind};
use crate::mesh::whole::{Groups, Request, materials_of_sets, middles, shape_of};

/// Cells of one kind, which have names beside each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KindRange {
    /// What they are in the file.
    pub kind: Kind,
    /// The name of the first of them.
    pub first: u32,
    /// How many there are.
    pub count: u32,
}

/// The file without its cells and their nodes.
#[derive(Debug, Clone)]
pub struct Head {
    /// 2 or 3.
    pub dim: usize,
    /// The kinds of cells, in the order of their names.
    pub kinds: Vec<KindRange>,
    /// The groups of each set.
    pub sets: Vec<GroupSet>,
    /// The groups.
    pub groups: Vec<Group>,
    /// How many elements and nodes each group has.
    pub counts: Vec<usize>,
    /// Elements below cells in groups, by names of nodes; `u32::MAX` for nodes of no cell.
    pub below: Vec<Block>,
    /// The groups of nodes, by names.
    pub node_groups: Vec<(u32, Vec<u32>)>,
    /// The number of nodes of cells.
    pub nodes: u32,
}

impl Head {
    /// The number of cells.
    pub fn cells(&self) -> u64 {
        self.kinds.iter().map(|range| u64::from(range.count)).sum()
    }

    /// For each kind whether raising gives its cells a node in the middle.
    ///
    /// # Errors
    /// As [`Head::shapes`].
    pub fn centres(&self, is_raised: bool) -> Result<Vec<bool>> {
        let shapes = self.shapes(is_raised)?;
        let is_new = |(range, shape): (&KindRange, &Shape)| {
            range.kind.nodes() != shape.nodes() && middles(*shape).centre.is_some()
        };
        Ok(self.kinds.iter().zip(&shapes).map(is_new).collect())
    }

    /// The kind of a cell.
    pub fn kind(&self, cell: u32) -> Kind {
        self.kinds[self.kind_place(cell)].kind
    }

    /// Which of the kinds that of a cell is.
    pub fn kind_place(&self, cell: u32) -> usize {
        self.kinds.partition_point(|range| range.first <= cell).saturating_sub(1)
    }

    /// The elements of groups of which `is_wanted` says so, with places of nodes in the place of
    /// names, as a file that has no cells; `points` tells where nodes are, and the last place is
    /// that of all nodes of no cell.
    pub fn file(
        &self,
        mut points: Vec<[f64; 3]>,
        place: &dyn Fn(u32) -> Option<usize>,
        is_wanted: &dyn Fn(&Group) -> bool,
    ) -> FileMesh {
        let none = points.len() as u32;
        points.push([0.0; 3]);
        let of = |name: &u32| place(*name).map_or(none, |place| place as u32);
        let blocks = self.below.iter().map(|block| {
            let mut kept = Block {
                kind: block.kind,
                nodes: Vec::new(),
                numbers: Vec::new(),
                groups: Vec::new(),
            };
            for (element, nodes) in block.nodes.chunks(block.kind.nodes()).enumerate() {
                if self.is_wanted(block.groups[element], is_wanted) {
                    kept.nodes.extend(nodes.iter().map(of));
                    kept.numbers.push(block.numbers[element]);
                    kept.groups.push(block.groups[element]);
                }
            }
            kept
        });
        let node_groups = self.node_groups.iter();
        FileMesh {
            node_numbers: vec![0; points.len()],
            blocks: blocks.collect(),
            group_sets: self.sets.clone(),
            groups: self.groups.clone(),
            node_groups: node_groups
                .filter(|(group, _)| is_wanted(&self.groups[*group as usize]))
                .map(|(group, nodes)| (*group, nodes.iter().map(of).collect()))
                .collect(),
            remarks: Vec::new(),
            points,
        }
    }

    /// Whether a set has a group that is wanted.
    pub fn is_wanted(&self, set: u32, is_wanted: &dyn Fn(&Group) -> bool) -> bool {
        self.sets[set as usize].iter().any(|group| is_wanted(&self.groups[*group as usize]))
    }

    /// The groups of such a file.
    pub(super) fn groups<'f>(&self, file: &'f FileMesh) -> Groups<'f> {
        Groups::with_counts(file, self.dim, self.counts.clone())
    }

    /// The material of each set of groups; none where there is not one.
    ///
    /// # Errors
    /// `Input` for groups that are not there.
    pub fn materials(&self, request: &Request) -> Result<Vec<Option<u32>>> {
        let file = self.file(Vec::new(), &|_| None, &|_| false);
        let of_sets = materials_of_sets(&self.groups(&file), &self.sets, &request.materials)?;
        let only = |of_set: &Vec<u32>| if let [only] = of_set[..] { Some(only) } else { None };
        Ok(of_sets.iter().map(only).collect())
    }

    /// The shapes of the kinds, once they are raised or left as they are.
    ///
    /// # Errors
    /// `Input` for kinds that have none.
    pub fn shapes(&self, is_raised: bool) -> Result<Vec<Shape>> {
        let shape = |range: &KindRange| {
            shape_of(range.kind, is_raised).map_err(|why| Error::Input(why.to_owned()))
        };
        self.kinds.iter().map(shape).collect()
    }
}
