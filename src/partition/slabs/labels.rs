//! Labels of cells, and which of them meet at each node.

use std::collections::BTreeMap;

use super::cells::Cells;
use super::homes::Homes;
use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::whole::FACING;
use crate::partition::metis;

/// The labels of the cells at the nodes that this rank keeps.
pub struct AtNodes {
    start: Vec<u32>,
    labels: Vec<u32>,
}

impl AtNodes {
    /// Of cells with these labels. Collective.
    pub fn new(comm: &Comm, homes: &Homes, cells: &Cells, labels: &[u32]) -> Self {
        let own = homes.firsts[comm.rank() as usize..][..2].to_vec();
        let (mut told, mut sorted): (Vec<u64>, usize) = (Vec::new(), 0);
        let (mut chunks, mut labels) = (cells.chunks.iter(), labels.iter());
        for _ in 0..comm.max_u64(cells.chunks.len() as u64) {
            let mut pairs: Vec<u64> = Vec::new();
            for (cell, label) in
                chunks.next().iter().flat_map(|chunk| chunk.iter()).zip(&mut labels)
            {
                let pair = |node: &u32| u64::from(*node) << 32 | u64::from(*label);
                pairs.extend(cell.nodes.iter().map(pair));
            }
            pairs.sort_unstable();
            pairs.dedup();
            let rows = pairs.iter().map(|pair| ((pair >> 32) as u32, *pair as u32));
            let more = homes.send(comm, rows);
            told.extend(
                more.iter().map(|(node, label)| u64::from(*node) << 32 | u64::from(*label)),
            );
            if told.len() > 2 * sorted {
                told.sort_unstable();
                told.dedup();
                sorted = told.len();
            }
        }
        told.sort_unstable();
        told.dedup();
        Self::of((own[1] - own[0]) as usize, &told)
    }

    /// Of pairs of a node and a label, rising.
    fn of(nodes: usize, told: &[u64]) -> Self {
        let mut start = vec![0_u32; nodes + 1];
        told.iter().for_each(|pair| start[(pair >> 32) as usize + 1] += 1);
        (0..nodes).for_each(|node| start[node + 1] += start[node]);
        Self { start, labels: told.iter().map(|pair| *pair as u32).collect() }
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
    /// the closer, and closest where cells face each other across an interface. Collective.
    ///
    /// # Arguments
    /// * `facing`: the labels of cells that face each other, on the root
    ///
    /// # Errors
    /// `System` when METIS fails.
    pub fn ranks(&self, comm: &Comm, work: &[f64], facing: &[[u32; 2]]) -> Result<Vec<u32>> {
        let mut counts: BTreeMap<u64, u64> = BTreeMap::new();
        for node in 0..self.start.len() - 1 {
            let labels = self.at(node);
            for one in labels {
                for other in labels.iter().filter(|other| *other != one) {
                    *counts.entry(u64::from(*one) << 32 | u64::from(*other)).or_default() += 1;
                }
            }
        }
        let edges: Vec<u64> = counts.iter().flat_map(|(edge, count)| [*edge, *count]).collect();
        let gathered = comm.gather(&edges);
        let cut = match gathered {
            Some(edges) => cut(&edges.concat(), facing, work, comm.size() as usize),
            None => Ok(Vec::new()),
        };
        let bytes = cut.map(|ranks| ranks.iter().flat_map(|rank| rank.to_le_bytes()).collect());
        let bytes = comm.broadcast_bytes(comm.agree(bytes)?);
        let ranks = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        Ok(ranks.collect())
    }
}

/// The part of each label.
fn cut(edges: &[u64], facing: &[[u32; 2]], work: &[f64], parts: usize) -> Result<Vec<i32>> {
    if parts == 1 {
        return Ok(vec![0; work.len()]);
    }
    let mut edges: Vec<(u64, u64)> = edges.chunks_exact(2).map(|edge| (edge[0], edge[1])).collect();
    for [one, other] in facing.iter().filter(|[one, other]| one != other) {
        let both = [[one, other], [other, one]];
        let edge = |[a, b]: [&u32; 2]| (u64::from(*a) << 32 | u64::from(*b), FACING as u64);
        edges.extend(both.map(edge));
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows of four labels each, which share no nodes: without the pairs that face each other
    /// either row is a part, with them the halves of both.
    #[test]
    fn what_faces_each_other_stays_together() {
        let edge = |one: u64, other: u64| [one << 32 | other, 2, other << 32 | one, 2];
        let edges: Vec<u64> = [0, 1, 2, 4, 5, 6].iter().flat_map(|i| edge(*i, i + 1)).collect();
        let part = |facing: &[[u32; 2]]| cut(&edges, facing, &[1.0; 8], 2).expect("a graph");
        let apart = part(&[]);
        assert!(apart[..4].iter().all(|part| *part == apart[0]), "{apart:?}");
        let facing: Vec<[u32; 2]> = (0..4).flat_map(|i| [[i, i + 4]; 3]).collect();
        let together = part(&facing);
        assert_eq!(together[..4], together[4..], "{together:?}");
        assert_ne!(together[0], together[3]);
    }
}
