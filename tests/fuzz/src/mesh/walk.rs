//! From a mesh that was read on to the parts of two ranks: as all cases together that ask for its
//! groups in one way each.

use std::collections::BTreeSet;

use column_hpc::mesh::import::FileMesh;
use column_hpc::mesh::whole::{
    InterfacePlace, InterfaceRequest, Keep, MaterialGroups, Request, WholeMesh, dual_graph, nested,
};

use super::accepted;

/// Groups of facets of which interfaces are made here.
const MOST_GROUPS: usize = 4;
/// Surfaces that are asked for here: a case has no more either.
const MOST_SURFACES: usize = 12;
/// Elements of a mesh that is refined.
pub const MOST_REFINED: usize = 40;
/// Elements of a mesh that is cut here.
const MOST_CUT: usize = 2000;

/// Makes whole meshes of what was read, refined ones too of as many elements as `refined` at most.
/// Those that can be made keep their promises.
pub fn walk(file: &FileMesh, refined: usize) {
    let elements: usize = file.blocks.iter().map(|block| block.numbers.len()).sum();
    if elements > MOST_CUT {
        return;
    }
    for request in requests(file, elements <= refined) {
        let meshes = nested(file, &request, "mesh", Keep::All);
        for mesh in accepted(meshes).iter().flatten() {
            examine(mesh, &request);
        }
    }
}

/// Everything as one material, raised, refined, with an interface on each group of facets and
/// between each two; all groups of cells as materials; all interfaces at once.
fn requests(file: &FileMesh, is_refined: bool) -> Vec<Request> {
    let dim = file.blocks.iter().map(|block| block.kind.dim()).max().unwrap_or(0);
    let names = |is_wanted: fn(usize, usize) -> bool| {
        let groups = file.groups.iter().filter(move |group| is_wanted(group.dim, dim));
        groups.map(|group| group.name.clone())
    };
    let surfaces = names(|of, dim| of < dim).collect::<BTreeSet<_>>().into_iter();
    let surfaces = surfaces.take(MOST_SURFACES).chain(["all".to_owned()]).collect();
    let facets: Vec<String> = names(|of, dim| of + 1 == dim).take(MOST_GROUPS).collect();
    let material = |name: &str, groups| MaterialGroups { name: name.into(), groups };
    let plain = Request {
        scale: 1.0,
        raise_order: None,
        refine: 0,
        materials: vec![material("rock", Vec::new())],
        surfaces,
        interfaces: Vec::new(),
        divided: Vec::new(),
    };
    let on = |(index, group): (usize, &String)| InterfaceRequest {
        name: format!("joint {index}"),
        place: InterfacePlace::On { group: group.clone(), flip: index % 2 == 1 },
    };
    let between = |lower: &String, upper: &String, has_gap| InterfaceRequest {
        name: "bed".into(),
        place: InterfacePlace::Between { lower: lower.clone(), upper: upper.clone(), has_gap },
    };
    let refine = u32::from(is_refined);
    let with = |interfaces| Request { interfaces, ..plain.clone() };
    let fine = |request: Request| Request { raise_order: Some(2), refine, ..request };
    let of_groups = names(|of, dim| of == dim).map(|name| material(&name, vec![name.clone()]));

    let mut requests = vec![
        plain.clone(),
        fine(Request { scale: 1e-3, surfaces: Vec::new(), ..plain.clone() }),
        Request { materials: of_groups.collect(), ..plain.clone() },
    ];
    let all: Vec<InterfaceRequest> = facets.iter().enumerate().map(on).collect();
    requests.extend(all.iter().map(|interface| with(vec![interface.clone()])));
    requests.extend(all.iter().map(|interface| fine(with(vec![interface.clone()]))));
    for (index, lower) in facets.iter().enumerate() {
        for upper in &facets[index + 1..] {
            requests.push(with(vec![between(lower, upper, false)]));
            requests.push(fine(with(vec![between(upper, lower, true)])));
        }
    }
    requests.push(with(all));
    requests
}

/// Indices that are there, positions that are finite, and parts that can be made.
fn examine(mesh: &WholeMesh, request: &Request) {
    let (points, cells) = (mesh.points.len() as u32, mesh.cells());
    assert!(mesh.points.iter().flatten().all(|x| x.is_finite()));
    assert!(mesh.nodes.iter().all(|node| *node < points));
    assert_eq!((mesh.start.len(), mesh.numbers.len()), (cells + 1, cells));
    assert!(mesh.materials.iter().all(|m| (*m as usize) < request.materials.len()));
    assert!(mesh.bodies.iter().all(|body| (*body as usize) < mesh.body_count));
    assert_eq!(mesh.surfaces.len(), request.surfaces.len());
    assert_eq!(mesh.interfaces.len(), request.interfaces.len());
    for surface in &mesh.surfaces {
        assert!(surface.nodes.is_sorted_by(|a, b| a < b));
        assert!(surface.nodes.iter().all(|node| *node < points));
        assert!(surface.facets.iter().all(|facet| (facet.cell as usize) < cells));
    }
    for interface in &mesh.interfaces {
        assert!(interface.lips.iter().all(|lip| !lip.is_empty()), "a lip without facets");
        for (node, normal) in &interface.normals {
            let length = normal.iter().map(|x| x * x).sum::<f64>();
            assert!(*node < points && (length - 1.0).abs() < 1e-9, "{node}: {normal:?}");
        }
    }
    let facts = mesh.facts();
    assert!(facts.size.iter().all(|size| size.is_finite()));
    dual_graph(mesh);
    let rank_of: Vec<i32> = (0..cells).map(|cell| (cell % 2) as i32).collect();
    let parts = mesh.parts(&rank_of, 2);
    assert_eq!(parts.iter().map(|part| part.cells.len()).sum::<usize>(), cells);
}
