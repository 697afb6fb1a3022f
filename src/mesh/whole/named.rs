//! What a file holds beside its cells, with the nodes of the cells.

use super::cells::{Cells, NONE};
use crate::mesh::import::{Block, FileMesh, Group};

/// The elements of lower dimension than the cells and the groups of nodes. Indices of nodes are
/// those of the cells; what lies on no cell is left out.
#[derive(Debug, Clone)]
pub struct Named {
    /// Elements that have nodes of cells only.
    pub below: Vec<Block>,
    /// The numbers of the nodes in the file, for messages; nodes made later have none.
    pub node_numbers: Vec<u64>,
    /// The groups of nodes.
    pub node_groups: Vec<(u32, Vec<u32>)>,
    groups: Vec<Group>,
}

impl Named {
    /// Of a file and the cells that were taken out of it.
    pub fn new(file: &FileMesh, cells: &Cells) -> Self {
        let dim = cells.dim();
        let name = |node: &u32| cells.names[*node as usize];
        let is_of_cells = |nodes: &[u32]| nodes.iter().all(|node| name(node) != NONE);
        let mut below: Vec<Block> = Vec::new();
        for block in file.blocks.iter().filter(|block| block.kind.dim() < dim) {
            let (mut nodes, mut numbers, mut groups) = (Vec::new(), Vec::new(), Vec::new());
            for (index, element) in block.nodes.chunks(block.kind.nodes()).enumerate() {
                if is_of_cells(element) {
                    nodes.extend(element.iter().map(name));
                    numbers.push(block.numbers[index]);
                    groups.push(block.groups[index]);
                }
            }
            below.push(Block { kind: block.kind, nodes, numbers, groups });
        }
        let named = cells.names.iter().zip(&file.node_numbers);
        let node_numbers = named.filter(|(name, _)| **name != NONE).map(|(_, number)| *number);
        let node_groups = file.node_groups.iter().map(|(group, nodes)| {
            (*group, nodes.iter().map(name).filter(|node| *node != NONE).collect())
        });
        Self {
            below,
            node_numbers: node_numbers.collect(),
            node_groups: node_groups.collect(),
            groups: file.groups.clone(),
        }
    }

    /// A file with these elements beside cells all of whose points are nodes of them. Positions are
    /// in metres.
    pub fn file(&self, cells: &Cells) -> FileMesh {
        FileMesh {
            points: cells.points.clone(),
            node_numbers: self.node_numbers.clone(),
            blocks: self.below.clone(),
            group_sets: cells.group_sets.clone(),
            groups: self.groups.clone(),
            node_groups: self.node_groups.clone(),
            remarks: Vec::new(),
        }
    }

    /// Other elements; of the nodes those that `number` gives a new one.
    pub fn renumbered(&self, below: Vec<Block>, number: &[u32]) -> Self {
        let all = number.iter().zip(&self.node_numbers);
        let node_numbers = all.filter(|(new, _)| **new != NONE).map(|(_, number)| *number);
        let new = |node: &u32| number[*node as usize];
        let node_groups = self.node_groups.iter().map(|(group, nodes)| {
            (*group, nodes.iter().map(new).filter(|node| *node != NONE).collect())
        });
        Self {
            below,
            node_numbers: node_numbers.collect(),
            node_groups: node_groups.collect(),
            groups: self.groups.clone(),
        }
    }
}
