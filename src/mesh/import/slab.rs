//! A part of a file's nodes and elements, as a rank reads it that reads no more.

use super::file_mesh::{Block, Group, Kind};
use crate::error::{Error, Result};

/// Elements of one kind beside each other in the file.
#[derive(Debug, Clone)]
pub struct Elements {
    /// What they are.
    pub kind: Kind,
    /// Numbers of nodes in the file, `kind.nodes()` for each element, in the order of VTK.
    pub nodes: Vec<u32>,
    /// The set of groups of each.
    pub sets: Vec<u32>,
}

/// Nodes beside each other in the file.
#[derive(Debug, Clone, Default)]
pub struct NodeRows {
    /// Their numbers in the file.
    pub numbers: Vec<u32>,
    /// Their coordinates, in the unit of the file.
    pub points: Vec<[f64; 3]>,
}

/// A set of groups before all sets of the file are known: dimension and number of each group.
pub type SetOfTags = Vec<(usize, u64)>;

/// A set of groups by their places.
pub type GroupSet = Vec<u32>;

/// A file that is read in pieces, each known by its number; all ranks know the same pieces.
pub trait Pieces {
    /// Rows of each piece of the nodes, in the order of the file.
    fn node_rows(&self) -> Vec<u64>;

    /// Rows of each piece of the elements, in the order of the file.
    fn element_rows(&self) -> Vec<u64>;

    /// Reads a piece of the nodes.
    ///
    /// # Errors
    /// `Input` for what is not as the format says.
    fn nodes(&self, piece: usize) -> Result<NodeRows>;

    /// Reads a piece of the elements; sets that are new go to the end of `sets`.
    ///
    /// # Errors
    /// As [`Pieces::nodes`].
    fn elements(&self, piece: usize, sets: &mut Vec<SetOfTags>) -> Result<Vec<Elements>>;

    /// The sets of groups that are known before any element is read; the first one is empty.
    fn sets(&self) -> Vec<SetOfTags>;

    /// The groups of the file, with those of these sets, and the sets as places among them.
    ///
    /// # Errors
    /// `Input` for two groups of one dimension with one name.
    fn groups(&self, sets: Vec<SetOfTags>) -> Result<(Vec<Group>, Vec<GroupSet>)>;

    /// Joins copies of elements that are no cells.
    ///
    /// # Errors
    /// `Input` for copies that are none of one element in several groups.
    fn join(&self, blocks: &mut [Block], sets: &mut Vec<SetOfTags>) -> Result<()>;

    /// The place of a kind among all, by which cells are numbered.
    fn order(&self, kind: Kind) -> usize {
        kind as usize
    }

    /// What is to be said of nodes of no element and of groups, which have so many elements.
    fn remarks(&self, orphans: u64, groups: &[Group], counts: &[usize]) -> Vec<String>;
}

/// A number of a node in the 32 bits that are kept of it.
pub(super) fn short(number: u64) -> Result<u32> {
    let is_short = |number: &u32| *number < u32::MAX;
    u32::try_from(number).ok().filter(is_short).ok_or_else(|| {
        Error::Input(format!("the number {number} of a node is larger than {}", u32::MAX - 1))
    })
}
