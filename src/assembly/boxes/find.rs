//! Which cells make up a box.

use super::product::Runs;

/// Fewer cells along x, or in all, are no box.
const FEWEST: [usize; 2] = [3, 27];
/// Nodes that follow one another along x and in their numbers, on average at least.
const SHORTEST_RUN: usize = 3;

/// The corners at the lower and upper end along x of each line of nodes of a cell; a line's index
/// has bit 0 for the upper side along y, bit 1 along z.
const ENDS: [[usize; 2]; 4] = [[0, 1], [3, 2], [4, 5], [7, 6]];

/// A box of cells.
pub struct Found {
    /// Cells along x and y.
    pub across: [usize; 2],
    /// The prototype of each layer along z.
    pub layers: Vec<u32>,
    /// Its nodes.
    pub runs: Runs,
}

/// Like cells along x.
struct Line {
    prototype: u32,
    first_cell: usize,
    cells: usize,
    /// Nodes of the four lines along x.
    nodes: [Vec<u32>; 4],
}

/// Lines of cells, and which belongs to a box already.
struct Lines {
    list: Vec<Line>,
    /// First node of the first line of nodes and number of the line, rising.
    by_node: Vec<(u32, usize)>,
    is_taken: Vec<bool>,
}

impl Found {
    /// The boxes among cells, and of each cell whether it is in one.
    pub fn among<'c>(cells: impl Iterator<Item = (&'c [u32], u32)>) -> (Vec<Self>, Vec<bool>) {
        let mut lines = Lines::new(cells);
        let count = lines.list.last().map_or(0, |line| line.first_cell + line.cells);
        let (mut found, mut is_in_box) = (Vec::new(), vec![false; count]);
        for line in 0..lines.list.len() {
            if lines.is_taken[line] || lines.list[line].cells < FEWEST[0] {
                continue;
            }
            let layers = lines.box_from(line);
            layers.iter().flatten().for_each(|line| lines.is_taken[*line] = true);
            let Some(one) = lines.found(&layers) else { continue };
            found.push(one);
            for line in layers.iter().flatten().map(|line| &lines.list[*line]) {
                is_in_box[line.first_cell..][..line.cells].fill(true);
            }
        }
        (found, is_in_box)
    }
}

impl Lines {
    fn new<'c>(cells: impl Iterator<Item = (&'c [u32], u32)>) -> Self {
        let mut list: Vec<Line> = Vec::new();
        for (cell, (nodes, prototype)) in cells.enumerate() {
            let goes_on = |line: &Line| {
                let mut ends = line.nodes.iter().zip(ENDS);
                line.prototype == prototype
                    && ends.all(|(line, [lower, _])| line[line.len() - 1] == nodes[lower])
            };
            match list.last_mut().filter(|line| goes_on(line)) {
                Some(line) => {
                    let ends = line.nodes.iter_mut().zip(ENDS);
                    ends.for_each(|(line, [_, upper])| line.push(nodes[upper]));
                    line.cells += 1;
                }
                None => {
                    let nodes = ENDS.map(|[lower, upper]| vec![nodes[lower], nodes[upper]]);
                    list.push(Line { prototype, first_cell: cell, cells: 1, nodes });
                }
            }
        }
        let first = |(number, line): (usize, &Line)| (line.nodes[0][0], number);
        let mut by_node: Vec<(u32, usize)> = list.iter().enumerate().map(first).collect();
        by_node.sort_unstable();
        let is_taken = vec![false; list.len()];
        Self { list, by_node, is_taken }
    }

    /// The free line of as many cells whose lower lines of nodes are the upper ones of `line` along
    /// y (bit 0) or z (bit 1).
    fn next(&self, line: usize, bit: usize) -> Option<usize> {
        let own = &self.list[line];
        let other = 3 - bit;
        let start = own.nodes[bit][0];
        let first = self.by_node.partition_point(|(node, _)| *node < start);
        let starting = self.by_node[first..].iter().take_while(|(node, _)| *node == start);
        starting.map(|(_, number)| *number).find(|number| {
            let next = &self.list[*number];
            !self.is_taken[*number]
                && next.nodes[0] == own.nodes[bit]
                && next.nodes[other] == own.nodes[3]
        })
    }

    /// The line and those above it.
    fn stack(&self, line: usize) -> Vec<usize> {
        std::iter::successors(Some(line), |below| self.next(*below, 2)).collect()
    }

    /// The largest box whose first line is this one, layer by layer along z.
    fn box_from(&self, line: usize) -> Vec<Vec<usize>> {
        let prototype = |line: usize| self.list[line].prototype;
        let lowest = self.stack(line);
        let mut stacks = vec![lowest];
        let (mut height, mut best) = (stacks[0].len(), [1, stacks[0].len()]);
        while let Some(next) = self.next(stacks[stacks.len() - 1][0], 1) {
            let (stack, last) = (self.stack(next), &stacks[stacks.len() - 1]);
            let alike =
                stack.iter().zip(&stacks[0]).zip(last).take_while(|((own, first), last)| {
                    let beside = [0, 2].map(|bit| {
                        let [own, last] = [**own, **last].map(|line| &self.list[line].nodes);
                        own[bit] == last[bit + 1]
                    });
                    prototype(**own) == prototype(**first) && beside == [true; 2]
                });
            height = height.min(alike.count());
            if height == 0 {
                break;
            }
            stacks.push(stack);
            if stacks.len() * height > best[0] * best[1] {
                best = [stacks.len(), height];
            }
        }
        let [wide, high] = best;
        (0..high).map(|k| stacks[..wide].iter().map(|stack| stack[k]).collect()).collect()
    }

    /// The box of these lines, if it is one of some size.
    fn found(&self, layers: &[Vec<usize>]) -> Option<Found> {
        let cells = self.list[layers[0][0]].cells;
        let (wide, high) = (layers[0].len(), layers.len());
        if cells * wide * high < FEWEST[1] {
            return None;
        }
        let mut runs = Runs { runs: Vec::new(), start: vec![0] };
        for k in 0..=high {
            for j in 0..=wide {
                let line = &self.list[layers[k.min(high - 1)][j.min(wide - 1)]];
                let nodes = &line.nodes[usize::from(j == wide) + 2 * usize::from(k == high)];
                for run in nodes.chunk_by(|a, b| a + 1 == *b) {
                    runs.runs.push([run[0], run.len() as u32]);
                }
                runs.start.push(runs.runs.len() as u32);
            }
        }
        let nodes = (cells + 1) * (wide + 1) * (high + 1);
        let layers = layers.iter().map(|layer| self.list[layer[0]].prototype).collect();
        let across = [cells, wide];
        (runs.runs.len() * SHORTEST_RUN <= nodes).then_some(Found { across, layers, runs })
    }
}
