//! Things found by the set of their nodes, without hashing and in the same order on every machine.

/// A thing below one lowest node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry<const R: usize> {
    /// The other nodes, rising, then `u32::MAX`.
    pub rest: [u32; R],
    /// The number of the thing.
    pub id: u32,
}

/// Numbers of things by their nodes: one bucket for each lowest node, sorted inside. Takes linear
/// time, as long as few things share a node.
pub struct Buckets<const R: usize> {
    start: Vec<u32>,
    entries: Vec<Entry<R>>,
}

impl<const R: usize> Buckets<R> {
    /// Of things given as lowest node and entry, which are gone through twice.
    pub fn new<I>(nodes: usize, things: impl Fn() -> I) -> Self
    where
        I: Iterator<Item = (u32, Entry<R>)>,
    {
        let mut start = vec![0_u32; nodes + 1];
        for (first, _) in things() {
            start[first as usize + 1] += 1;
        }
        for i in 0..nodes {
            start[i + 1] += start[i];
        }
        let none = Entry { rest: [u32::MAX; R], id: u32::MAX };
        let mut entries = vec![none; start[nodes] as usize];
        let mut next = start.clone();
        for (first, entry) in things() {
            let place = &mut next[first as usize];
            entries[*place as usize] = entry;
            *place += 1;
        }
        for node in 0..nodes {
            entries[start[node] as usize..start[node + 1] as usize].sort_unstable();
        }
        Self { start, entries }
    }

    /// The things of each set of nodes, with its lowest node; the sets rise.
    pub fn runs(&self) -> impl Iterator<Item = (u32, &[Entry<R>])> {
        let bucket = |node: usize| self.bucket(node as u32);
        let of = move |node: usize| {
            let runs = bucket(node).chunk_by(|a, b| a.rest == b.rest);
            runs.map(move |run| (node as u32, run))
        };
        (0..self.start.len() - 1).flat_map(of)
    }

    /// The things of one set of nodes.
    pub fn find(&self, first: u32, rest: [u32; R]) -> &[Entry<R>] {
        if first as usize + 1 >= self.start.len() {
            return &[];
        }
        let bucket = self.bucket(first);
        let from = bucket.partition_point(|entry| entry.rest < rest);
        let count = bucket[from..].partition_point(|entry| entry.rest == rest);
        &bucket[from..from + count]
    }

    fn bucket(&self, node: u32) -> &[Entry<R>] {
        &self.entries[self.start[node as usize] as usize..self.start[node as usize + 1] as usize]
    }
}

/// The lowest of some nodes, and the others in rising order. There are at most R + 1 of them, and
/// `u32::MAX` stands for none.
pub fn split<const R: usize>(nodes: impl Iterator<Item = u32>) -> (u32, [u32; R]) {
    let (mut first, mut rest) = (u32::MAX, [u32::MAX; R]);
    for mut node in nodes {
        if node < first {
            std::mem::swap(&mut node, &mut first);
        }
        // What is pushed out at the end is u32::MAX.
        for place in &mut rest {
            if node < *place {
                std::mem::swap(&mut node, place);
            }
        }
    }
    (first, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_sorted_and_found_whatever_their_order() {
        assert_eq!(split::<3>([7, 3, 9].into_iter()), (3, [7, 9, u32::MAX]));
        assert_eq!(split::<3>([4, 3, 2, 1].into_iter()), (1, [2, 3, 4]));
        let sets = [[5, 1], [2, 5], [1, 5], [0, 3], [5, 2], [1, 2]];
        let things = || {
            (0..).zip(&sets).map(|(id, nodes)| {
                let (first, rest) = split::<1>(nodes.iter().copied());
                (first, Entry { rest, id })
            })
        };
        let buckets = Buckets::new(6, things);
        let ids = |first, rest| buckets.find(first, [rest]).iter().map(|e| e.id).collect();
        let found: [Vec<u32>; 4] = [ids(1, 5), ids(2, 5), ids(1, 2), ids(1, 3)];
        assert_eq!(found, [vec![0, 2], vec![1, 4], vec![5], vec![]]);
        let sizes: Vec<_> = buckets.runs().map(|(node, run)| (node, run.len())).collect();
        assert_eq!(sizes, [(0, 1), (1, 1), (1, 2), (2, 2)]);
        assert!(buckets.find(6, [7]).is_empty());
    }
}
