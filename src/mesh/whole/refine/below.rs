//! Refined elements of groups that are no cells.

use crate::mesh::import::{Block, Kind};
use crate::mesh::whole::cells::corner_count;

/// Middle nodes by the ends of their edges, rising.
pub type Edges = Vec<([u32; 2], u32)>;
/// Middle nodes by the corners of their quadrilaterals, rising.
pub type Faces = Vec<([u32; 4], u32)>;

/// The nodes that the cells of a mesh have in the middle of their edges and sides.
pub struct Halves {
    pub edges: Edges,
    pub faces: Faces,
}

impl Halves {
    fn of_edge(&self, a: u32, b: u32) -> Option<u32> {
        find(&self.edges, [a.min(b), a.max(b)])
    }

    fn of_face(&self, mut corners: [u32; 4]) -> Option<u32> {
        corners.sort_unstable();
        find(&self.faces, corners)
    }
}

/// The middle node of an edge or of a side.
pub fn find<const N: usize>(table: &[([u32; N], u32)], corners: [u32; N]) -> Option<u32> {
    let place = table.binary_search_by_key(&corners, |(corners, _)| *corners);
    place.ok().map(|place| table[place].1)
}

/// Refines elements of lower dimension than the cells: lines become two, surfaces four, points stay
/// as they are. Children run the same way round as their parents, and are of first order, except
/// lines whose middle node is in `fine`. Elements that lie on no cells have no children.
pub fn refine(blocks: &[Block], halves: &Halves, fine: &Edges) -> Vec<Block> {
    let mut refined = Vec::new();
    for block in blocks {
        let count = block.kind.nodes();
        for (index, nodes) in block.nodes.chunks(count).enumerate() {
            let corners = &nodes[..corner_count(block.kind)];
            for (kind, nodes) in children(corners, halves, fine).unwrap_or_default() {
                let to = block_of(&mut refined, kind);
                to.nodes.extend(nodes);
                to.numbers.push(block.numbers[index]);
                to.groups.push(block.groups[index]);
            }
        }
    }
    refined
}

/// The children of an element by its corners; none where cells have no such edges.
fn children(corners: &[u32], halves: &Halves, fine: &Edges) -> Option<Vec<(Kind, Vec<u32>)>> {
    let half = |a, b| halves.of_edge(a, b);
    let line = |a: u32, b: u32| match find(fine, [a.min(b), a.max(b)]) {
        Some(middle) => (Kind::Line3, vec![a, b, middle]),
        None => (Kind::Line2, vec![a, b]),
    };
    Some(match *corners {
        [point] => vec![(Kind::Point1, vec![point])],
        [a, b] => {
            let middle = half(a, b)?;
            vec![line(a, middle), line(middle, b)]
        }
        [a, b, c] => {
            let [p, q, r] = [half(a, b)?, half(b, c)?, half(c, a)?];
            let rows = [[a, p, r], [p, b, q], [r, q, c], [p, q, r]];
            rows.map(|row| (Kind::Tri3, row.to_vec())).into()
        }
        [a, b, c, d] => {
            let [p, q, r, s] = [half(a, b)?, half(b, c)?, half(c, d)?, half(d, a)?];
            let m = halves.of_face([a, b, c, d])?;
            let rows = [[a, p, m, s], [p, b, q, m], [m, q, c, r], [s, m, r, d]];
            rows.map(|row| (Kind::Quad4, row.to_vec())).into()
        }
        _ => return None,
    })
}

fn block_of(blocks: &mut Vec<Block>, kind: Kind) -> &mut Block {
    let place = blocks.iter().position(|block| block.kind == kind).unwrap_or_else(|| {
        blocks.push(Block { kind, nodes: Vec::new(), numbers: Vec::new(), groups: Vec::new() });
        blocks.len() - 1
    });
    &mut blocks[place]
}
