//! Labels of cells, and which of them meet at each node.

use super::cells::Cells;
use super::homes::Homes;
use crate::comm::Comm;
use crate::error::Result;
use crate::partition::metis;

/// The labels of the cells at the nodes that this rank keeps.
pub struct AtNodes {
    start: Vec<u32>,
    labels: Vec<u32>,
}

impl AtNodes {
    /// Of cells with these labels. Collective.
    pub fn new(comm: &Comm, homes: &Homes, cells: &Cells, labels: &[u32]) -> Self {
        let mut pairs: Vec<u64> = Vec::new();
        let (mut sorted, mut labels) = (0, labels.iter());
        for chunk in &cells.chunks {
            for (cell, label) in chunk.iter().zip(&mut labels) {
                let place = |node: &u32| cells.names.place(*node).unwrap_or_default() as u64;
                pairs.extend(cell.nodes.iter().map(|node| place(node) << 32 | u64::from(*label)));
            }
            if pairs.len() > 2 * sorted {
                pairs.sort_unstable();
                pairs.dedup();
                sorted = pairs.len();
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut names = cells.names.iter().zip(0_u64..).peekable();
        let rows = pairs.iter().map(|pair| {
            while names.next_if(|(_, place)| *place < pair >> 32).is_some() {}
            (names.peek().map_or(0, |(name, _)| *name), *pair as u32)
        });
        let told = homes.send(comm, rows);
        drop(pairs);
        let own = homes.firsts[comm.rank() as usize..][..2].to_vec();
        Self::of((own[1] - own[0]) as usize, &told)
    }

    fn of(nodes: usize, told: &[(u32, u32)]) -> Self {
        let mut start = vec![0_u32; nodes + 1];
        told.iter().for_each(|(node, _)| start[*node as usize + 1] += 1);
        (0..nodes).for_each(|node| start[node + 1] += start[node]);
        let (mut next, mut labels) = (start.clone(), vec![0; start[nodes] as usize]);
        for (node, label) in told.iter() {
            labels[next[*node as usize] as usize] = *label;
            next[*node as usize] += 1;
        }
        Self { start, labels }.tidied()
    }

    /// Each label once, rising.
    fn tidied(mut self) -> Self {
        let mut end = 0;
        for node in 0..self.start.len() - 1 {
            let range = self.start[node] as usize..self.start[node + 1] as usize;
            self.labels[range.clone()].sort_unstable();
            self.start[node] = end as u32;
            for at in range.clone() {
                if at == range.start || self.labels[at] != self.labels[end - 1] {
                    self.labels[end] = self.labels[at];
                    end += 1;
                }
            }
        }
        self.labels.truncate(end);
        if let Some(last) = self.start.last_mut() {
            *last = end as u32;
        }
        self
    }

    /// Labels of another kind in the place of these.
    pub fn renamed(mut self, names: &[u32]) -> Self {
        self.labels.iter_mut().for_each(|label| *label = names[*label as usize]);
        self.tidied()
    }

    /// The labels at a node.
    pub fn at(&self, node: usize) -> &[u32] {
        &self.labels[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// The rank of each label: by METIS, on the graph of labels that meet in nodes; the more nodes,
    /// the closer. Collective.
    ///
    /// # Errors
    /// `System` when METIS fails.
    pub fn ranks(&self, comm: &Comm, work: &[f64]) -> Result<Vec<u32>> {
        let mut pairs = Vec::new();
        for node in 0..self.start.len() - 1 {
            let labels = self.at(node);
            for one in labels {
                let others = labels.iter().filter(|other| *other != one);
                pairs.extend(others.map(|other| u64::from(*one) << 32 | u64::from(*other)));
            }
        }
        pairs.sort_unstable();
        let edges: Vec<u64> =
            pairs.chunk_by(|a, b| a == b).flat_map(|same| [same[0], same.len() as u64]).collect();
        let gathered = comm.gather(&edges);
        let cut = match gathered {
            Some(edges) => cut(&edges.concat(), work, comm.size() as usize),
            None => Ok(Vec::new()),
        };
        let bytes = cut.map(|ranks| ranks.iter().flat_map(|rank| rank.to_le_bytes()).collect());
        let bytes = comm.broadcast_bytes(comm.agree(bytes)?);
        let ranks = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        Ok(ranks.collect())
    }
}

/// The part of each label.
fn cut(edges: &[u64], work: &[f64], parts: usize) -> Result<Vec<i32>> {
    if parts == 1 {
        return Ok(vec![0; work.len()]);
    }
    let mut edges: Vec<(u64, u64)> = edges.chunks_exact(2).map(|edge| (edge[0], edge[1])).collect();
    edges.sort_unstable();
    let (mut neighbours, mut weights, mut start) = (Vec::new(), Vec::new(), vec![0]);
    let mut runs = edges.chunk_by(|a, b| a.0 == b.0).peekable();
    for label in 0..work.len() as u64 {
        while let Some(same) = runs.next_if(|same| same[0].0 >> 32 == label) {
            neighbours.push(same[0].0 as u32 as i32);
            weights.push(same.iter().map(|edge| edge.1).sum::<u64>() as i32);
        }
        start.push(neighbours.len() as i32);
    }
    // Sums of all work stay within 32 bits.
    let unit = (work.iter().sum::<f64>() / 1e9).max(1.0);
    let work: Vec<i32> = work.iter().map(|work| (work / unit).max(1.0) as i32).collect();
    metis::cut(&start, &neighbours, &weights, &work, parts)
}
