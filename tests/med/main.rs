//! MED files of MEDCoupling, which `scripts/meshes_med.py` wrote, and damaged copies of them.

mod damage;
mod geometry;

use std::collections::BTreeMap;
use std::path::PathBuf;

use column_hpc::mesh::import::med;
use column_hpc::mesh::import::{FileMesh, Kind};

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(format!("med_{name}.med"))
}

fn read(name: &str) -> FileMesh {
    med::read(&path(name)).expect(name)
}

/// The kinds with their numbers of elements.
fn kinds(mesh: &FileMesh) -> Vec<(Kind, usize)> {
    mesh.blocks.iter().map(|block| (block.kind, block.groups.len())).collect()
}

/// The numbers of elements of groups by name and dimension.
fn elements(mesh: &FileMesh) -> BTreeMap<(&str, usize), usize> {
    let mut found = BTreeMap::new();
    for block in &mesh.blocks {
        for set in &block.groups {
            for group in &mesh.group_sets[*set as usize] {
                let group = &mesh.groups[*group as usize];
                assert_eq!(group.dim, block.kind.dim());
                *found.entry((group.name.as_str(), group.dim)).or_default() += 1;
            }
        }
    }
    found
}

fn node_groups(mesh: &FileMesh) -> BTreeMap<&str, Vec<u32>> {
    let groups = mesh.node_groups.iter();
    groups.map(|(group, nodes)| (&*mesh.groups[*group as usize].name, nodes.clone())).collect()
}

/// What holds for every mesh: whole lists, indices inside, no set twice, set 0 empty.
fn assert_sound(mesh: &FileMesh) {
    assert_eq!(mesh.points.len(), mesh.node_numbers.len());
    for block in &mesh.blocks {
        assert_eq!(block.nodes.len(), block.numbers.len() * block.kind.nodes());
        assert_eq!(block.groups.len(), block.numbers.len());
        assert!(block.nodes.iter().all(|node| (*node as usize) < mesh.points.len()));
        assert!(block.groups.iter().all(|set| (*set as usize) < mesh.group_sets.len()));
    }
    assert!(mesh.group_sets[0].is_empty());
    let mut sets = mesh.group_sets.clone();
    sets.sort();
    sets.dedup();
    assert_eq!(sets.len(), mesh.group_sets.len());
    for set in &mesh.group_sets {
        assert!(set.is_sorted_by(|a, b| a < b));
        assert!(set.iter().all(|group| (*group as usize) < mesh.groups.len()));
    }
    let mut groups: Vec<_> = mesh.groups.iter().map(|group| (group.dim, &group.name)).collect();
    groups.dedup();
    assert!(groups.is_sorted() && groups.len() == mesh.groups.len());
}

fn assert_close(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-12 * wanted, "{found} where {wanted} is wanted");
}

#[test]
fn counts_and_measures_are_those_of_the_writer() {
    let of = [
        // Nodes, kinds, and the measure of all elements of the highest dimension.
        ("hex8", 12, vec![(Kind::Hex8, 2), (Kind::Point1, 2), (Kind::Quad4, 4), (Kind::Line2, 3)]),
        ("hex20", 32, vec![(Kind::Hex20, 2), (Kind::Quad8, 10)]),
        ("hex27", 45, vec![(Kind::Hex27, 2), (Kind::Quad9, 10)]),
        ("tet4_version3", 8, vec![(Kind::Tet4, 6), (Kind::Tri3, 12)]),
        ("tet10", 27, vec![(Kind::Tet10, 6), (Kind::Tri6, 12)]),
        (
            "mixed",
            12,
            vec![(Kind::Hex8, 1), (Kind::Prism6, 1), (Kind::Pyramid5, 1), (Kind::Tet4, 1)],
        ),
        (
            "mixed2",
            36,
            vec![(Kind::Hex20, 1), (Kind::Pyramid13, 1), (Kind::Prism15, 1), (Kind::Tet10, 1)],
        ),
        ("prism18", 18, vec![(Kind::Prism18, 1)]),
        ("plane", 6, vec![(Kind::Quad4, 1), (Kind::Line2, 3), (Kind::Tri3, 2)]),
        ("plane2", 14, vec![(Kind::Quad8, 1), (Kind::Line3, 6), (Kind::Tri6, 2)]),
    ];
    let volumes = [6.0, 6.0, 6.0, 3.0, 3.0, 19.0 / 3.0, 19.0 / 3.0, 1.5, 4.0, 4.0];
    for ((name, nodes, wanted), volume) in of.into_iter().zip(volumes) {
        let mesh = read(name);
        assert_sound(&mesh);
        assert_eq!(mesh.points.len(), nodes, "{name}");
        assert_eq!(kinds(&mesh), wanted, "{name}");
        let dim = if name.starts_with("plane") { 2 } else { 3 };
        assert_close(geometry::total(&mesh, dim), volume);
        geometry::assert_middles(&mesh);
    }
}

#[test]
fn faces_and_edges_are_those_of_the_writer() {
    // As MEDCoupling measures them.
    assert!((geometry::total(&read("hex8"), 2) - 7.132092).abs() < 1e-6);
    assert!((geometry::total(&read("hex8"), 1) - 4.719640).abs() < 1e-6);
    for name in ["hex20", "hex27"] {
        assert!((geometry::total(&read(name), 2) - 22.511241).abs() < 1e-6, "{name}");
    }
    for name in ["tet4_version3", "tet10"] {
        assert!((geometry::total(&read(name), 2) - 13.255620).abs() < 1e-6, "{name}");
    }
    assert!((geometry::total(&read("plane"), 1) - 4.039608).abs() < 1e-6);
    assert!((geometry::total(&read("plane2"), 1) - 8.079216).abs() < 1e-6);
}

#[test]
fn groups_are_those_of_the_writer() {
    let mesh = read("hex8");
    let wanted = [
        (("bottom", 2), 1),
        (("corner", 0), 2),
        (("edge", 1), 2),
        (("ends", 2), 2),
        (("front", 2), 2),
        (("lower", 3), 1),
        (("rock", 1), 1),
        (("rock", 3), 2),
        (("top", 2), 1),
    ];
    assert_eq!(elements(&mesh), BTreeMap::from(wanted), "one name on two dimensions is two groups");
    let wanted = [("corner", vec![0, 5]), ("fixed", vec![0, 1, 2, 3])];
    assert_eq!(node_groups(&mesh), BTreeMap::from(wanted));
    assert_eq!(mesh.blocks[0].numbers, [41, 17]);
    assert_eq!(mesh.node_numbers, (0..12).map(|node| 100 + 7 * node).collect::<Vec<u64>>());
    assert!(mesh.remarks.is_empty(), "{:?}", mesh.remarks);

    for name in ["tet4_version3", "tet10"] {
        let wanted = [(("half", 3), 3), (("most", 3), 5), (("skin", 2), 12)];
        assert_eq!(elements(&read(name)), BTreeMap::from(wanted), "{name}");
    }
    for name in ["mixed", "mixed2"] {
        let wanted = [(("box", 3), 1), (("others", 3), 3), (("wedge", 3), 1)];
        assert_eq!(elements(&read(name)), BTreeMap::from(wanted), "{name}");
    }
}

#[test]
fn a_plane_mesh_lies_at_z_0_and_loses_the_node_that_nothing_uses() {
    let mesh = read("plane");
    assert!(mesh.points.iter().all(|point| point[2] == 0.0));
    assert_eq!(mesh.node_numbers, [1, 2, 3, 4, 5, 6]);
    assert_eq!(node_groups(&mesh), BTreeMap::from([("fixed", vec![0, 2])]));
    let wanted = [(("bottom", 1), 2), (("left", 2), 2), (("right", 1), 1), (("right", 2), 1)];
    assert_eq!(elements(&mesh), BTreeMap::from(wanted));
    let says = "nodes that no element uses are left out: 1 of 7, of which 1 in families";
    assert_eq!(mesh.remarks, [says]);
}

/// Quadrilaterals of MEDCoupling, which runs them clockwise, stand the right way round when read.
#[test]
fn cells_that_all_run_clockwise_are_turned_round() {
    let mesh = read("clockwise");
    assert_sound(&mesh);
    assert_eq!(geometry::total(&mesh, 2), 3.0);
    geometry::assert_middles(&mesh);
    let words = mesh.remarks.iter().filter(|words| words.contains("all 4 cells run clockwise"));
    assert_eq!(words.count(), 1, "{:?}", mesh.remarks);
    let counts = elements(&mesh);
    assert_eq!([counts[&("rock", 2)], counts[&("joint", 1)], counts[&("left", 1)]], [4, 2, 2]);
}
