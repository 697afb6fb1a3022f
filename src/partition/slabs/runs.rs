//! Where the nodes of cells stand that lie by kind.

use std::ops::Range;

/// Cells one behind the other, those of one kind together: where the nodes of each stand is known
/// without a list of it.
#[derive(Debug, Clone, Default)]
pub struct Runs(Vec<Run>);

#[derive(Debug, Clone, Copy)]
struct Run {
    /// The first cell, and the first of its nodes.
    first: [usize; 2],
    /// How many cells there are, and how many nodes each has.
    count: usize,
    width: usize,
}

impl Runs {
    /// Of so many cells of so many nodes each, kind by kind.
    pub fn new(kinds: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut first = [0; 2];
        let run = |(count, width)| {
            let run = Run { first, count, width };
            first = [first[0] + count, first[1] + count * width];
            run
        };
        Self(kinds.map(run).collect())
    }

    /// The same cells with other numbers of nodes.
    pub fn with_widths(&self, widths: impl Iterator<Item = usize>) -> Self {
        Self::new(self.counts().zip(widths))
    }

    /// How many cells of each kind there are.
    pub fn counts(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().map(|run| run.count)
    }

    /// All nodes.
    pub fn nodes(&self) -> usize {
        self.0.last().map_or(0, |run| run.first[1] + run.count * run.width)
    }

    /// Where the nodes of a cell stand.
    pub fn of(&self, cell: usize) -> Range<usize> {
        // Of the runs that begin there only the last one is not empty.
        let run = self.0[self.0.partition_point(|run| run.first[0] <= cell) - 1];
        let from = run.first[1] + (cell - run.first[0]) * run.width;
        from..from + run.width
    }

    /// The first node of each cell, and the end.
    pub fn starts(&self) -> Vec<u32> {
        let mut starts = Vec::with_capacity(self.counts().sum::<usize>() + 1);
        for run in &self.0 {
            starts.extend((0..run.count).map(|cell| (run.first[1] + cell * run.width) as u32));
        }
        starts.push(self.nodes() as u32);
        starts
    }
}

#[cfg(test)]
mod tests {
    use super::Runs;

    #[test]
    fn nodes_stand_one_behind_the_other() {
        let runs = Runs::new([(0, 8), (2, 4), (0, 5), (3, 6)].into_iter());
        let starts = runs.starts();
        assert_eq!(starts, [0, 4, 8, 14, 20, 26]);
        assert_eq!(runs.nodes(), 26);
        for cell in 0..5 {
            assert_eq!(runs.of(cell), starts[cell] as usize..starts[cell + 1] as usize);
        }
        let raised = runs.with_widths([27, 10, 14, 18].into_iter());
        assert_eq!(raised.starts(), [0, 10, 20, 38, 56, 74]);
        assert_eq!(Runs::default().starts(), [0]);
    }
}
