//! The types of elements of Gmsh: their numbers, and where their nodes stand in the order of VTK.

use super::super::file_mesh::Kind;

/// The kind of a type number of Gmsh; none for those that are not read.
pub(super) fn kind(number: i64) -> Option<Kind> {
    Some(match number {
        1 => Kind::Line2,
        2 => Kind::Tri3,
        3 => Kind::Quad4,
        4 => Kind::Tet4,
        5 => Kind::Hex8,
        6 => Kind::Prism6,
        7 => Kind::Pyramid5,
        8 => Kind::Line3,
        9 => Kind::Tri6,
        10 => Kind::Quad9,
        11 => Kind::Tet10,
        12 => Kind::Hex27,
        13 => Kind::Prism18,
        14 => Kind::Pyramid14,
        15 => Kind::Point1,
        16 => Kind::Quad8,
        17 => Kind::Hex20,
        18 => Kind::Prism15,
        19 => Kind::Pyramid13,
        _ => return None,
    })
}

/// What a type that is not read is called.
pub(super) fn foreign_name(number: i64) -> &'static str {
    match number {
        20..=25 | 42..=46 | 52..=56 => "triangle of third or higher order",
        26..=28 | 62..=66 => "line of third or higher order",
        29..=33 | 71..=75 | 79..=83 => "tetrahedron of third or higher order",
        34 => "polygon",
        35 => "polyhedron",
        36..=41 | 47..=51 | 57..=61 => "quadrilateral of third or higher order",
        84..=89 | 132 => "element of order zero",
        90 | 91 | 106..=117 => "prism of third or higher order",
        92..=105 => "hexahedron of third or higher order",
        118..=131 => "pyramid of third or higher order",
        67..=70 | 76..=78 | 133..=140 => "border, cut or enriched element",
        _ => "type that is not known",
    }
}

/// The permutation `p` from the order of Gmsh to that of VTK: `vtk[i] = gmsh[p[i]]`; none where the
/// orders are the same.
pub(super) fn order(kind: Kind) -> Option<&'static [usize]> {
    const HEX: [usize; 27] = [
        0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20,
        25, 26,
    ];
    const PRISM: [usize; 18] = [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16];
    const PYRAMID: [usize; 14] = [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13];
    const TET: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
    match kind {
        Kind::Tet10 => Some(&TET),
        Kind::Hex20 | Kind::Hex27 => Some(&HEX[..kind.nodes()]),
        Kind::Prism15 | Kind::Prism18 => Some(&PRISM[..kind.nodes()]),
        Kind::Pyramid13 | Kind::Pyramid14 => Some(&PYRAMID[..kind.nodes()]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::order::reversal;
    use super::*;

    /// Of each type, the nodes of an element of a group with a negative tag as Gmsh 4.15.2 writes
    /// them in MSH 2.2, where they are reversed; in MSH 4.1 they are 0, 1, 2 and so on.
    const REVERSED: [(i64, &[usize]); 18] = [
        (1, &[1, 0]),
        (2, &[0, 2, 1]),
        (3, &[0, 3, 2, 1]),
        (4, &[1, 0, 2, 3]),
        (5, &[2, 1, 0, 3, 6, 5, 4, 7]),
        (6, &[1, 0, 2, 4, 3, 5]),
        (7, &[2, 1, 0, 3, 4]),
        (8, &[1, 0, 2]),
        (9, &[0, 2, 1, 5, 4, 3]),
        (10, &[0, 3, 2, 1, 7, 6, 5, 4, 8]),
        (11, &[1, 0, 2, 3, 4, 6, 5, 9, 8, 7]),
        (
            12,
            &[
                2, 1, 0, 3, 6, 5, 4, 7, 11, 13, 14, 8, 12, 9, 10, 15, 18, 19, 16, 17, 20, 23, 24,
                21, 22, 25, 26,
            ],
        ),
        (13, &[1, 0, 2, 4, 3, 5, 6, 9, 10, 7, 8, 11, 12, 14, 13, 15, 17, 16]),
        (14, &[0, 3, 2, 1, 4, 6, 5, 7, 10, 12, 8, 11, 9, 13]),
        (16, &[0, 3, 2, 1, 7, 6, 5, 4]),
        (17, &[2, 1, 0, 3, 6, 5, 4, 7, 11, 13, 14, 8, 12, 9, 10, 15, 18, 19, 16, 17]),
        (18, &[1, 0, 2, 4, 3, 5, 6, 9, 10, 7, 8, 11, 12, 14, 13]),
        (19, &[0, 3, 2, 1, 4, 6, 5, 7, 10, 12, 8, 11, 9]),
    ];

    #[test]
    fn elements_are_reversed_as_gmsh_reverses_them() {
        for (number, nodes) in REVERSED {
            let kind = kind(number).expect("a kind");
            let same: Vec<usize> = (0..kind.nodes()).collect();
            let order = order(kind).unwrap_or(&same);
            let old: Vec<_> = order.iter().map(|place| nodes[*place]).collect();
            let new: Vec<_> = reversal(kind).iter().map(|place| order[*place]).collect();
            assert_eq!(old, new, "{kind:?}");
        }
    }

    #[test]
    fn every_type_is_read_or_has_a_name() {
        let unnamed = |number: &i64| foreign_name(*number) == foreign_name(0);
        let found: Vec<_> = (1..=140).filter(|n| kind(*n).is_none() && unnamed(n)).collect();
        assert!(found.is_empty(), "{found:?}");
    }
}
