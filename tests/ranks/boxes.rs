//! Products with boxes of cells, which are gathered, against the sum over the cells.

use std::path::Path;
use std::rc::Rc;

use column_hpc::assembly::{CellSet, TangentOperator};
use column_hpc::case::Case;
use column_hpc::hash::mix;
use column_hpc::mesh::MeshFamily;
use column_hpc::partition::{self, Method};
use column_hpc::petsc::LinearOperator;
use column_hpc::runtime::Runtime;
use column_hpc::solve::BoundaryValueProblem;

/// Layers of two materials, one of which is all but incompressible, and two bodies.
fn case(cells: &str) -> Case {
    let text = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 2.0], {cells}}}}}
materials:
  soft: {{z: [0.0, 0.4], elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.499}}}}
  hard: {{z: [0.4, 2.0], elastic: {{young_modulus: 2.0e10, poisson_ratio: 0.2}}}}
interfaces: [{{name: joint, z: 1.0, law: {{tied: {{}}}}}}]
boundary: [{{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}]
time: {{instants: [1]}}
"
    );
    Case::read(&text, Path::new("boxes.yaml"), &[]).expect("the case is right")
}

/// In parts of any form, with ghosts.
pub fn give_the_sum_over_their_cells(runtime: &Runtime) {
    let comm = &runtime.comm;
    let largest = |values: &[f64]| {
        let mut largest = [values.iter().fold(0.0_f64, |m, v| m.max(v.abs()))];
        comm.max(&mut largest);
        largest[0]
    };
    let meshes = ["cells: [9, 7, 14]", "bodies: [{cells: [4, 8, 5]}, {cells: [12, 6, 3]}]"];
    for (cells, method) in meshes
        .into_iter()
        .flat_map(|mesh| [Method::Metis, Method::Scattered].map(|method| (mesh, method)))
    {
        let case = case(cells);
        let family = MeshFamily::new(&case).expect("a mesh");
        let mut parts = partition::share_out(comm, family, method).expect("a partition");
        let mesh = parts.pop().expect("a mesh");
        let problem = BoundaryValueProblem::new(comm, &case, mesh).expect("a problem");
        let all = &problem.all;
        let value = |name: u64, c: u64| mix(3 * name + c) as f64 / u64::MAX as f64 - 0.5;
        let u: Vec<f64> =
            all.nodes.names.iter().flat_map(|name| [0, 1, 2].map(|c| value(*name, c))).collect();
        let (mut gathered, mut summed) = (vec![0.0; u.len()], vec![0.0; u.len()]);
        all.add_forces(CellSet::All, &u, &mut gathered, None);
        let mut sizes = vec![0.0; all.nodes.len()];
        all.add_forces(CellSet::All, &u, &mut summed, Some(&mut sizes));
        let scale = largest(&summed);
        let difference: Vec<f64> = gathered.iter().zip(&summed).map(|(a, b)| a - b).collect();
        assert!(largest(&difference) < 1e-14 * scale, "{cells} {method:?}");

        let operator = TangentOperator::new(Rc::clone(all), scale);
        let x = &u[..3 * all.nodes.owned];
        let (mut double, mut single) = (vec![0.0; x.len()], vec![0.0_f32; x.len()]);
        operator.multiply(x, &mut double);
        let rounded: Vec<f32> = x.iter().map(|x| *x as f32).collect();
        operator.multiply_in(&rounded, &mut single);
        let difference: Vec<f64> =
            double.iter().zip(&single).map(|(a, b)| a - f64::from(*b)).collect();
        assert!(largest(&difference) < 1e-6 * largest(&double), "{cells} {method:?}");
    }
}
