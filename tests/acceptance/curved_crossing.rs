//! Two curved interfaces that cross: rigid motions are exact, uniform stresses converge.
//!
//! Beside the crossing a multiplier acts beyond its own facets, where the normal is another: of the
//! uniform patch only as much is exact as on facets in one plane.

use crate::cubes::{Blocks, Cut};
use crate::scene::{Run, Scene};

/// Where displacements are compared (m).
const PROBES: [[f64; 2]; 2] = [[0.11, 0.13], [-0.3, -0.25]];
const ROTATION: [[f64; 2]; 2] = [[0.0, 3e-4], [-3e-4, 0.0]];
const STRAIN: [[f64; 2]; 2] = [[0.7e-4, 0.3e-4], [-0.2e-4, 0.4e-4]];

/// A square of 2 m whose axes are bent, both cut; of prisms 0.5 m thick.
fn scene(cut: Cut, cells: usize, gradient: [[f64; 2]; 2]) -> Scene {
    let (dim, n) = if cut == Cut::Squares { (2, 0) } else { (3, 1) };
    let high = [1.0, 1.0, if dim == 3 { 0.5 } else { 0.0 }];
    let is = |x: f64, place: f64| (x - place).abs() < 1e-9;
    let mut blocks = Blocks::default().block([-1.0, -1.0, 0.0], high, [cells, cells, n], cut);
    for axis in [0, 1] {
        blocks = blocks.group("joint", |x| is(x[axis], 0.0));
        blocks = blocks.group("outer", |x| is(x[axis].abs(), 1.0));
    }
    if dim == 3 {
        blocks = blocks.group("faces", |x| is(x[2], 0.0)).group("faces", |x| is(x[2], 0.5));
    }
    let mesh = blocks.mapped(|[u, v, z]| {
        let bent = |along: f64, from: f64, phase: f64| {
            from + 0.25 * (1.0 - from * from) * (1.2 * along + phase).sin()
        };
        [bent(v, u, 0.3), bent(u, v, -0.4), z]
    });
    let given =
        |i: usize| format!("{{formula: \"t*({:e}*x+{:e}*y)\"}}", gradient[i][0], gradient[i][1]);
    let [out, faces] =
        if dim == 3 { [", z: 0", "\n  - {on: faces, displacement: {z: 0}}"] } else { ["", ""] };
    let probes = [0, 1].map(|i| {
        format!("{{name: p{i}, at: {:?}}}", [PROBES[i][0], PROBES[i][1], 0.2].split_at(dim).0)
    });
    let yaml = format!(
        "
mesh: {{file: \"{}\"}}
materials: {{rock: {{elastic: {{young_modulus: 5.0e9, poisson_ratio: 0.3}}}}}}
interfaces: [{{name: joint, on: joint, law: {{tied: {{}}}}}}]
boundary:
  - {{on: outer, displacement: {{x: {}, y: {}{out}}}}}{faces}
probes: [{}]
time: {{instants: [1]}}
",
        mesh.write(false),
        given(0),
        given(1),
        probes.join(", ")
    );
    Scene::new("curved_crossing", &yaml)
}

/// The largest error of the displacements (m).
fn error(run: &Run, gradient: [[f64; 2]; 2]) -> f64 {
    let mut largest = 0.0_f64;
    for (probe, at) in PROBES.iter().enumerate() {
        for (axis, row) in ["x", "y"].iter().zip(gradient) {
            let found = run.column(&format!("p{probe}.displacement_{axis}"))[0];
            largest = largest.max((found - row[0] * at[0] - row[1] * at[1]).abs());
        }
    }
    largest
}

#[test]
fn curved_interfaces_that_cross_pass_rigid_motions() {
    for (cut, ranks) in [(Cut::Squares, 1), (Cut::Prisms, 3)] {
        let run = scene(cut, 6, ROTATION).scattered().on(ranks);
        let off = error(&run, ROTATION);
        assert!(off < 1e-16, "{}: {off:e}", run.label);
        let largest = |name: &str| run.column(&format!("joint.normal_traction.{name}"))[0].abs();
        assert!(largest("min").max(largest("max")) < 1.0, "{}", run.label);
    }
}

/// The observed orders of the displacement at points are 5.2, 3.5, 3.3 from these cells on.
#[test]
fn uniform_stresses_across_curved_crossings_converge() {
    let off = |cells: usize| error(&scene(Cut::Squares, cells, STRAIN).on(1), STRAIN);
    let errors = [8, 16].map(off);
    assert!(errors[1] < errors[0] / 8.0 && errors[1] < 1e-8, "{errors:?}");
}
