//! The graph of the tangent: exact, and the same for every state of the interfaces.

use super::Discretization;
use crate::comm::Comm;
use crate::space::Nodes;
use std::ops::Range;

/// Block columns of the owned block rows.
pub struct Pattern {
    start: Vec<u32>,
    columns: Vec<i32>,
    /// Owned nodes whose rows depend on the state of an interface.
    pub interface_rows: Vec<u32>,
    /// Whether each local node's row depends on the state of an interface.
    pub is_interface_row: Vec<bool>,
}

impl Pattern {
    /// Collective: rows of ghosts are sent to their owners.
    pub fn new(comm: &Comm, all: &Discretization) -> Self {
        let nodes = &all.nodes;
        let lists = local_columns(all);
        let mut start = vec![0u32];
        let mut columns = Vec::new();
        for list in merge_to_owners(comm, nodes, &nodes.numbers, nodes.first, lists) {
            columns.extend(list);
            start.push(columns.len() as u32);
        }
        let is_interface_row = interface_rows(all);
        let interface_rows =
            (0..nodes.owned as u32).filter(|n| is_interface_row[*n as usize]).collect();
        Self { start, columns, interface_rows, is_interface_row }
    }

    /// Block columns of an owned block row, rising.
    pub fn row(&self, node: usize) -> &[i32] {
        &self.columns[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// Blocks per owned block row whose column is owned, and is not.
    pub fn counts(&self, first_owned: i32) -> (Vec<i32>, Vec<i32>) {
        let owned = self.start.len() - 1;
        let own = first_owned..first_owned + owned as i32;
        count_blocks((0..owned).map(|node| self.row(node)), own)
    }

    /// Forgets the columns, which only the creation of the matrix needs.
    pub fn forget_columns(&mut self) {
        (self.start, self.columns) = (Vec::new(), Vec::new());
    }
}

/// Gives the owners the lists of ghosts' rows: the columns of each owned row, rising. `numbers` are
/// those of the local nodes' rows, `first` that of the first owned one. Collective.
pub(super) fn merge_to_owners(
    comm: &Comm,
    nodes: &Nodes,
    numbers: &[i32],
    first: i32,
    mut lists: Vec<Vec<i32>>,
) -> Vec<Vec<i32>> {
    let mut outgoing: Vec<Vec<i32>> = vec![Vec::new(); comm.size() as usize];
    for (ghost, columns) in lists.iter().enumerate().skip(nodes.owned) {
        let rank = nodes.ghost_owners[ghost - nodes.owned];
        outgoing[rank].extend([numbers[ghost], columns.len() as i32]);
        outgoing[rank].extend(columns);
    }
    lists.truncate(nodes.owned);
    for list in comm.exchange(&outgoing) {
        let mut rest = list.as_slice();
        while let [row, n, tail @ ..] = rest {
            let (columns, tail) = tail.split_at(*n as usize);
            lists[(row - first) as usize].extend(columns);
            rest = tail;
        }
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    lists
}

/// Columns per row that lie in `own`, and that do not.
pub(super) fn count_blocks<'r>(
    rows: impl Iterator<Item = &'r [i32]>,
    own: Range<i32>,
) -> (Vec<i32>, Vec<i32>) {
    rows.map(|row| {
        let inside = row.iter().filter(|c| own.contains(c)).count() as i32;
        (inside, row.len() as i32 - inside)
    })
    .unzip()
}

/// Block columns that this rank's cells contribute to each local node's row.
fn local_columns(all: &Discretization) -> Vec<Vec<i32>> {
    let mut lists: Vec<Vec<i32>> = vec![Vec::new(); all.nodes.len()];
    let mut coupled = Vec::new();
    for cell in 0..all.cells.len() {
        all.coupled_nodes(cell, &mut coupled);
        for row in &coupled {
            let list = &mut lists[*row as usize];
            list.extend(coupled.iter().map(|c| all.nodes.numbers[*c as usize]));
            // Keeps the lists short while they grow.
            if list.len() > 256 {
                list.sort_unstable();
                list.dedup();
            }
        }
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
        list.shrink_to_fit();
    }
    lists
}

/// Marks the local nodes that a cell of the interface layer couples. Collective.
fn interface_rows(all: &Discretization) -> Vec<bool> {
    let mut mark = vec![0.0; all.nodes.len()];
    let mut coupled = Vec::new();
    for cell in all.cells.layer() {
        all.coupled_nodes(*cell as usize, &mut coupled);
        coupled.iter().for_each(|n| mark[*n as usize] = 1.0);
    }
    all.nodes.add_to_owners(&mut mark, 1);
    all.nodes.update_ghosts(&mut mark, 1);
    mark.into_iter().map(|m| m > 0.0).collect()
}
