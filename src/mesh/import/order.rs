//! Where the nodes of the kinds of elements lie, in the order of VTK, and how elements turn round.

use super::file_mesh::Kind;

/// What the kinds of one shape have in common. Their nodes are the corners, then the middles of the
/// edges, of the faces and of the whole, as many of them as the kind has.
struct Shape {
    /// The corners of the reversed element, which fixes the number of corners too.
    reversed: &'static [u8],
    edges: &'static [[u8; 2]],
    faces: &'static [[u8; 4]],
}

const POINT: Shape = Shape { reversed: &[0], edges: &[], faces: &[] };
const LINE: Shape = Shape { reversed: &[1, 0], edges: &[[0, 1]], faces: &[] };
const TRIANGLE: Shape =
    Shape { reversed: &[0, 2, 1], edges: &[[0, 1], [1, 2], [2, 0]], faces: &[] };
const QUADRILATERAL: Shape = Shape {
    reversed: &[0, 3, 2, 1],
    edges: &[[0, 1], [1, 2], [2, 3], [3, 0]],
    faces: &[[0, 1, 2, 3]],
};
const TETRAHEDRON: Shape = Shape {
    reversed: &[1, 0, 2, 3],
    edges: &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
    faces: &[],
};
const PRISM: Shape = Shape {
    reversed: &[1, 0, 2, 4, 3, 5],
    edges: &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
    faces: &[[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
};
const PYRAMID: Shape = Shape {
    reversed: &[2, 1, 0, 3, 4],
    edges: &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]],
    faces: &[[0, 1, 2, 3]],
};
/// Gmsh exchanges other corners of these than of pyramids of five nodes.
const FULL_PYRAMID: Shape = Shape { reversed: &[0, 3, 2, 1, 4], ..PYRAMID };
const HEXAHEDRON: Shape = Shape {
    reversed: &[2, 1, 0, 3, 6, 5, 4, 7],
    edges: &[
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [4, 5],
        [5, 6],
        [6, 7],
        [7, 4],
        [0, 4],
        [1, 5],
        [2, 6],
        [3, 7],
    ],
    faces: &[[0, 3, 7, 4], [1, 2, 6, 5], [0, 1, 5, 4], [3, 2, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]],
};

fn shape(kind: Kind) -> Shape {
    match kind {
        Kind::Point1 => POINT,
        Kind::Line2 | Kind::Line3 => LINE,
        Kind::Tri3 | Kind::Tri6 => TRIANGLE,
        Kind::Quad4 | Kind::Quad8 | Kind::Quad9 => QUADRILATERAL,
        Kind::Tet4 | Kind::Tet10 => TETRAHEDRON,
        Kind::Prism6 | Kind::Prism15 | Kind::Prism18 => PRISM,
        Kind::Pyramid5 => PYRAMID,
        Kind::Pyramid13 | Kind::Pyramid14 => FULL_PYRAMID,
        Kind::Hex8 | Kind::Hex20 | Kind::Hex27 => HEXAHEDRON,
    }
}

/// The corners in whose middle each node lies, one bit for each corner.
pub(super) fn supports(kind: Kind) -> Vec<u8> {
    let shape = shape(kind);
    let corners = shape.reversed.len();
    let single = (0..corners).map(|corner| 1 << corner);
    let edges = shape.edges.iter().map(|edge| bits(edge));
    let faces = shape.faces.iter().map(|face| bits(face));
    single.chain(edges).chain(faces).chain([u8::MAX]).take(kind.nodes()).collect()
}

fn bits(corners: &[u8]) -> u8 {
    corners.iter().fold(0, |set, corner| set | 1 << corner)
}

/// The permutation `p` that reverses an element: node `i` of the reversed one is node `p[i]`.
///
/// It exchanges the corners that Gmsh exchanges, so that both its formats give the same elements.
pub(super) fn reversal(kind: Kind) -> Vec<usize> {
    let reversed = shape(kind).reversed;
    let supports = supports(kind);
    let turned = |set: u8| {
        let corners = (0..reversed.len()).filter(|corner| set & (1 << corner) != 0);
        let set_of = corners.fold(0_u8, |turned, corner| turned | 1 << reversed[corner]);
        if set == u8::MAX { set } else { set_of }
    };
    let place = |set: u8| supports.iter().position(|s| *s == turned(set));
    // A reversal maps edges to edges and faces to faces, which the tests hold.
    supports.iter().enumerate().map(|(i, set)| place(*set).unwrap_or(i)).collect()
}

#[cfg(test)]
pub(super) const KINDS: [Kind; 19] = [
    Kind::Point1,
    Kind::Line2,
    Kind::Line3,
    Kind::Tri3,
    Kind::Tri6,
    Kind::Quad4,
    Kind::Quad8,
    Kind::Quad9,
    Kind::Tet4,
    Kind::Tet10,
    Kind::Prism6,
    Kind::Prism15,
    Kind::Prism18,
    Kind::Pyramid5,
    Kind::Pyramid13,
    Kind::Pyramid14,
    Kind::Hex8,
    Kind::Hex20,
    Kind::Hex27,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_of_every_kind_has_its_own_corners() {
        for kind in KINDS {
            let mut sets = supports(kind);
            assert_eq!(sets.len(), kind.nodes(), "{kind:?}");
            sets.sort_unstable();
            sets.dedup();
            assert_eq!(sets.len(), kind.nodes(), "{kind:?}");
        }
    }

    #[test]
    fn reversals_are_their_own_inverse() {
        for kind in KINDS {
            let p = reversal(kind);
            let twice: Vec<_> = p.iter().map(|i| p[*i]).collect();
            assert_eq!(twice, (0..kind.nodes()).collect::<Vec<_>>(), "{kind:?}");
            let is_same = p == twice;
            assert_eq!(is_same, kind == Kind::Point1, "{kind:?}");
        }
        assert_eq!(reversal(Kind::Line3), [1, 0, 2]);
        assert_eq!(reversal(Kind::Tri6), [0, 2, 1, 5, 4, 3]);
        assert_eq!(reversal(Kind::Quad9), [0, 3, 2, 1, 7, 6, 5, 4, 8]);
        assert_eq!(reversal(Kind::Tet10), [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]);
    }
}
