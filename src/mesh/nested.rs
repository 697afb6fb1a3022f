//! How the nodes of a refined mesh from a file depend on those of the mesh that it was made of.

use super::whole::{WholeMesh, reference_points};
use super::{Interpolation, LocalMesh};
use crate::element::{MAX_NODES, Shape};

/// Values of the basis below this are rounding.
const ROUNDING: f64 = 1e-14;

impl LocalMesh {
    /// Lets the nodes of this part of the mesh `fine` depend on those of the mesh `coarse`: by the
    /// basis of the parent of the first cell that has them. The copies of a node on both lips of an
    /// interface have parents on their own sides, so that they depend on nodes there.
    pub(super) fn depend_on(&mut self, fine: &WholeMesh, coarse: &WholeMesh) {
        let points: Vec<Vec<[f64; 3]>> = Shape::ALL.map(reference_points).into();
        let mut rows: Vec<Vec<(u64, f64)>> = vec![Vec::new(); self.nodes.names.len()];
        for (cell, name) in self.cells.iter().enumerate() {
            let parent = &fine.parents[*name as usize];
            let of_parent = coarse.shapes[parent.cell as usize];
            let nodes = coarse.cell_nodes(parent.cell as usize);
            let shape = self.shape(cell);
            for (local, node) in self.cell_nodes(cell).iter().enumerate() {
                let row = &mut rows[*node as usize];
                if !row.is_empty() {
                    continue;
                }
                let mut of_corners = [0.0; MAX_NODES];
                shape.corners().values(shape.node_points()[local], &mut of_corners);
                let mut xi = [0.0; 3];
                for (corner, part) in parent.corners.iter().zip(&of_corners[..8]) {
                    let point = points[of_parent as usize][*corner as usize];
                    xi.iter_mut().zip(point).for_each(|(sum, x)| *sum += part * x);
                }
                let mut values = [0.0; MAX_NODES];
                of_parent.values(xi, &mut values);
                let all = nodes.iter().map(|node| u64::from(*node)).zip(values);
                row.extend(all.filter(|(_, value)| value.abs() > ROUNDING));
            }
        }
        self.parents = Interpolation::from_rows(&rows);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::import::gmsh;
    use crate::mesh::whole::{
        InterfacePlace, InterfaceRequest, Keep, MaterialGroups, Request, nested,
    };

    /// The meshes of a file that is refined so often, coarsest first.
    fn meshes(name: &str, place: InterfacePlace, refine: u32) -> Vec<WholeMesh> {
        let path = format!("{}/tests/meshes/{name}.msh", env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(&path).expect("a file of ours");
        let file = gmsh::read(&bytes).expect("a mesh");
        let request = Request {
            scale: 1.0,
            raise_order: None,
            refine,
            materials: vec![MaterialGroups { name: "rock".into(), groups: vec![] }],
            surfaces: vec![],
            interfaces: vec![InterfaceRequest { name: "joint".into(), place }],
            divided: vec![],
        };
        nested(&file, &request, name, Keep::All).expect("a mesh")
    }

    #[test]
    fn positions_are_those_of_the_parents_and_lips_keep_apart() {
        let on = || InterfacePlace::On { group: "joint".into(), flip: false };
        let between = || InterfacePlace::Between {
            lower: "below".into(),
            upper: "above".into(),
            has_gap: false,
        };
        for (name, place, refine) in [
            ("turned/tet10", on(), 2),
            ("turned/prism18", on(), 2),
            ("turned/mixed-pair", between(), 2),
            ("turned/hex8", on(), 0),
            ("turned/hex27-apart", between(), 0),
            ("interfaces/crossing", on(), 2),
            ("interfaces/branching", on(), 2),
            ("interfaces/ending", on(), 2),
        ] {
            let meshes = meshes(name, place, refine);
            let least = if refine > 0 { 3 } else { 2 };
            assert!(meshes.len() >= least, "{name}: {}", meshes.len());
            for pair in meshes.windows(2) {
                let [coarse, fine] = [&pair[0], &pair[1]];
                let ranks = |cells: usize| (0..cells).map(|cell| (cell % 3) as i32).collect();
                let of_coarse: Vec<i32> = ranks(coarse.cells());
                let parent = |cell: usize| fine.parents[cell].cell as usize;
                let rank_of: Vec<i32> =
                    (0..fine.cells()).map(|cell| of_coarse[parent(cell)]).collect();
                let held = coarse.parts(&of_coarse, 3);
                for (mut part, held) in fine.parts(&rank_of, 3).into_iter().zip(held) {
                    part.depend_on(fine, coarse);
                    check(&part, &held, coarse);
                }
            }
        }
    }

    #[test]
    fn nodes_of_second_order_lie_between_the_corners_on_their_side() {
        let on = InterfacePlace::On { group: "joint".into(), flip: false };
        for name in ["turned/tet10", "turned/prism18"] {
            let mesh = &meshes(name, on.clone(), 2)[0];
            let rank_of: Vec<i32> = (0..mesh.cells()).map(|cell| (cell % 2) as i32).collect();
            for part in mesh.parts(&rank_of, 2) {
                let held = part.of_first_order();
                check(&part, &held, mesh);
                assert!(held.nodes.names.len() * 3 < part.nodes.names.len());
                assert!((0..held.cells.len()).all(|cell| held.shape(cell).order() == 1));
                let count = held.directions.of_lips.len();
                assert!(count > 0 && count < part.directions.of_lips.len());
                for one in &held.directions.of_lips {
                    let name = held.nodes.names[one.node as usize];
                    let node = part.nodes.number(name).expect("a node of the part") as u32;
                    let normal = part.directions.of_lip(node, one.interface as usize);
                    assert_eq!(normal, Some(one.normal), "{name}");
                }
            }
        }
    }

    fn check(part: &LocalMesh, held: &LocalMesh, coarse: &WholeMesh) {
        let all = part.interpolation(held, &part.nodes.names);
        for (node, (_, point, marks)) in part.nodes.iter().enumerate() {
            let range = all.start[node] as usize..all.start[node + 1] as usize;
            let mut sum = [0.0; 3];
            for (name, weight) in all.names[range.clone()].iter().zip(&all.weights[range]) {
                let number = held.nodes.number(*name).expect("the rank has the parent");
                assert_eq!(held.nodes.marks[number].body, marks.body);
                let parent = coarse.points[*name as usize];
                sum.iter_mut().zip(parent).for_each(|(sum, x)| *sum += weight * x);
            }
            assert!((0..3).all(|i| (sum[i] - point[i]).abs() < 1e-12), "{sum:?} {point:?}");
        }
    }
}
