//! Files that Gmsh 4.15 wrote, see `scripts/meshes.py`.

use std::collections::BTreeMap;

use super::super::super::file_mesh::{FileMesh, Kind};
use super::super::super::order::{KINDS, supports};
use super::{block, groups_of, read};

pub(super) const NAMES: [&str; 12] = [
    "arc-2.2",
    "arc-4.1",
    "every-type-4.1",
    "hex20-4.1",
    "hex27-2.2",
    "prism15-4.1-binary",
    "square-2.2",
    "square-2.2-binary",
    "square-4.1",
    "square-4.1-binary",
    "tet10-4.1-binary",
    "tet4-2.2-binary",
];

pub(super) fn bytes(name: &str) -> Vec<u8> {
    let path = format!("{}/tests/meshes/{name}.msh", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn mesh(name: &str) -> FileMesh {
    read(&bytes(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The measures of the simplices of which an element with plane sides consists. Volumes have a
/// sign; those of surfaces are their normals' z where the surface is level.
fn measures(p: &[Point], kind: Kind) -> Vec<f64> {
    const HEX: [[usize; 4]; 6] =
        [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    const PRISM: [[usize; 4]; 3] = [[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]];
    const PYRAMID: [[usize; 4]; 2] = [[0, 1, 2, 4], [0, 2, 3, 4]];
    let tetrahedron = |t: &[usize; 4]| {
        let [a, b, c] = [1, 2, 3].map(|i| minus(p[t[i]], p[t[0]]));
        dot(cross(a, b), c) / 6.0
    };
    let triangle = |a: usize, b: usize, c: usize| {
        let normal = cross(minus(p[b], p[a]), minus(p[c], p[a]));
        let area = dot(normal, normal).sqrt() / 2.0;
        if normal[2].abs() > area { normal[2] / 2.0 } else { area }
    };
    match kind {
        Kind::Point1 => vec![0.0],
        Kind::Line2 | Kind::Line3 => {
            let line = minus(p[1], p[0]);
            vec![dot(line, line).sqrt()]
        }
        Kind::Tri3 | Kind::Tri6 => vec![triangle(0, 1, 2)],
        Kind::Quad4 | Kind::Quad8 | Kind::Quad9 => vec![triangle(0, 1, 2), triangle(0, 2, 3)],
        Kind::Tet4 | Kind::Tet10 => vec![tetrahedron(&[0, 1, 2, 3])],
        Kind::Prism6 | Kind::Prism15 | Kind::Prism18 => PRISM.iter().map(tetrahedron).collect(),
        Kind::Pyramid5 | Kind::Pyramid13 | Kind::Pyramid14 => {
            PYRAMID.iter().map(tetrahedron).collect()
        }
        Kind::Hex8 | Kind::Hex20 | Kind::Hex27 => HEX.iter().map(tetrahedron).collect(),
    }
}

/// The points of each element with its kind and its groups.
fn elements(mesh: &FileMesh) -> Vec<(Kind, Vec<Point>, Vec<String>)> {
    let mut found = Vec::new();
    for block in &mesh.blocks {
        for (e, nodes) in block.nodes.chunks(block.kind.nodes()).enumerate() {
            let points = nodes.iter().map(|node| mesh.points[*node as usize]).collect();
            found.push((block.kind, points, groups_of(mesh, block, e)));
        }
    }
    found
}

/// Of each dimension and group the number of elements and their measure; all are positive, and all
/// middle nodes lie between their corners.
fn totals(mesh: &FileMesh) -> BTreeMap<(usize, String), (usize, f64)> {
    let mut totals = BTreeMap::new();
    for (kind, points, groups) in elements(mesh) {
        let parts = measures(&points, kind);
        assert!(
            kind.dim() == 0 || parts.iter().all(|m| *m > 1e-3),
            "{kind:?} {points:?} {parts:?}"
        );
        check_middles(&points, kind);
        for group in groups {
            let total = totals.entry((kind.dim(), group)).or_insert((0, 0.0));
            total.0 += 1;
            total.1 += parts.iter().sum::<f64>();
        }
    }
    totals
}

/// Each node is the mean of the corners that its place in the order of VTK says.
fn check_middles(points: &[Point], kind: Kind) {
    let supports = supports(kind);
    let corners = supports.iter().filter(|set| set.count_ones() == 1).count();
    for (node, set) in supports.into_iter().enumerate() {
        let of = (0..corners).filter(|corner| set & (1 << corner) != 0).collect::<Vec<_>>();
        for axis in 0..3 {
            let sum: f64 = of.iter().map(|corner| points[*corner][axis]).sum();
            let gap = points[node][axis] - sum / of.len() as f64;
            assert!(gap.abs() < 1e-9, "{kind:?}: node {node} of {points:?}");
        }
    }
}

fn assert_totals(name: &str, expected: &[(usize, &str, usize, f64)]) {
    let found = totals(&mesh(name));
    assert_eq!(found.len(), expected.len(), "{name}: {found:?}");
    for (dim, group, count, measure) in expected {
        let total = found.get(&(*dim, (*group).to_owned()));
        let (n, m) = total.unwrap_or_else(|| panic!("{name}: no {group} in {found:?}"));
        assert_eq!(n, count, "{name}: {group}");
        assert!((m - measure).abs() < 1e-9, "{name}: {group} is {m}, not {measure}");
    }
}

#[test]
fn a_square_has_its_groups_in_both_versions_and_encodings() {
    let expected = [
        (0, "pin", 1, 0.0),
        (1, "left", 2, 1.0),
        (1, "right", 2, 1.0),
        (1, "sides", 4, 2.0),
        (1, "bottom", 4, 2.0),
        (1, "joint", 2, 1.0),
        (2, "left", 14, 1.0),
        (2, "21", 14, 1.0),
        (2, "all of it", 28, 2.0),
    ];
    let mut first: Option<Vec<_>> = None;
    for name in ["square-2.2", "square-2.2-binary", "square-4.1", "square-4.1-binary"] {
        assert_totals(name, &expected);
        let mesh = mesh(name);
        assert!(mesh.remarks.is_empty(), "{:?}", mesh.remarks);
        // Elements, senses and groups are the same; numbers and the order are not.
        let rounded = |p: &Point| p.map(|x| (x * 1e9).round() as i64);
        let mut all: Vec<_> = elements(&mesh)
            .into_iter()
            .map(|(kind, points, groups)| {
                (kind, points.iter().map(rounded).collect::<Vec<_>>(), groups)
            })
            .collect();
        all.sort();
        assert_eq!(&all, first.get_or_insert_with(|| all.clone()), "{name}");
        for (_, points, groups) in elements(&mesh) {
            let is_bottom = groups == ["bottom"];
            assert!(!is_bottom || points[0][0] > points[1][0], "{name}: against x");
        }
    }
}

#[test]
fn boxes_of_tetrahedra_have_their_volume() {
    for (name, kind, count) in
        [("tet4-2.2-binary", Kind::Tet4, 68), ("tet10-4.1-binary", Kind::Tet10, 68)]
    {
        assert_totals(
            name,
            &[(3, "body", count, 6.0), (2, "left", 14, 6.0), (2, "right", 14, 6.0)],
        );
        let mesh = mesh(name);
        assert_eq!(block(&mesh, kind).numbers.len(), count);
        // Gmsh's own surface x = 0 looks to -x; the negative tag turns it.
        for (kind, p, groups) in elements(&mesh) {
            if kind.dim() == 2 {
                let normal = cross(minus(p[1], p[0]), minus(p[2], p[0]));
                assert!(normal[0] > 0.0, "{groups:?}");
            }
        }
    }
}

#[test]
fn extruded_hexahedra_and_prisms_have_their_volume() {
    let area = 1.75;
    let with = |count: usize, cells: usize| {
        [(3, "body", cells, 2.0 * area), (2, "bottom", count, area), (2, "top", count, area)]
    };
    assert_totals("hex20-4.1", &with(1, 2));
    assert_totals("hex27-2.2", &with(1, 2));
    assert_totals("prism15-4.1-binary", &with(2, 4));
    assert_eq!(mesh("hex20-4.1").blocks[1].kind, Kind::Hex20);
    assert_eq!(mesh("hex27-2.2").blocks[1].kind, Kind::Hex27);
    assert_eq!(mesh("prism15-4.1-binary").blocks[1].kind, Kind::Prism15);
}

#[test]
fn every_type_has_its_nodes_where_vtk_has_them() {
    let mesh = mesh("every-type-4.1");
    totals(&mesh);
    let kinds: Vec<_> = mesh.blocks.iter().map(|block| block.kind).collect();
    // The point has no group, so that it is left out.
    assert_eq!(kinds, KINDS[1..]);
    for (kind, points, _) in elements(&mesh) {
        let expected = match kind {
            Kind::Point1 => 0.0,
            Kind::Line2 | Kind::Line3 => 2.0,
            Kind::Tri3 | Kind::Tri6 => 0.5,
            Kind::Quad4 | Kind::Quad8 | Kind::Quad9 => 4.0,
            Kind::Tet4 | Kind::Tet10 => 1.0 / 6.0,
            Kind::Prism6 | Kind::Prism15 | Kind::Prism18 => 1.0,
            Kind::Pyramid5 | Kind::Pyramid13 | Kind::Pyramid14 => 4.0 / 3.0,
            Kind::Hex8 | Kind::Hex20 | Kind::Hex27 => 8.0,
        };
        let volume: f64 = measures(&points, kind).iter().sum();
        assert!((volume - expected).abs() < 1e-9, "{kind:?}: {volume}");
    }
}

#[test]
fn what_is_lost_in_a_file_of_all_entities_is_said() {
    let [old, new] = ["arc-2.2", "arc-4.1"].map(mesh);
    assert_eq!(old.groups, new.groups);
    assert_eq!(old.remarks.len(), 2, "{:?}", old.remarks);
    assert!(old.remarks[0].starts_with("the file names groups, but no element belongs to one"));
    assert_eq!(new.remarks, ["nodes of no element, left out: 1"]);
    assert_eq!(old.remarks[1..], new.remarks[..]);
    assert!(totals(&old).is_empty());
    let area = |mesh: &FileMesh| -> f64 {
        let found = elements(mesh).into_iter().filter(|(kind, ..)| kind.dim() == 2);
        found.flat_map(|(kind, points, _)| measures(&points, kind)).sum()
    };
    // The shoelace formula of the polygon that the lines make.
    let lines = elements(&new).into_iter().filter(|(kind, ..)| kind.dim() == 1);
    let polygon: f64 = lines.map(|(_, p, _)| cross(p[0], p[1])[2] / 2.0).sum();
    assert!((area(&old) - polygon.abs()).abs() < 1e-9, "{} {polygon}", area(&old));
    assert!((totals(&new)[&(2, "ring".to_owned())].1 - area(&old)).abs() < 1e-9);
}
