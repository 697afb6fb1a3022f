//! Interfaces in meshes from files with sides, corners and facets that supports hold.

use crate::blocks::{Block, Blocks, even};
use crate::scene::Scene;

/// Displacement gradient of the patch.
const GRADIENT: [[f64; 3]; 3] =
    [[0.7e-4, 0.3e-4, 0.9e-4], [-0.2e-4, 0.4e-4, 0.6e-4], [0.5e-4, 0.1e-4, 1.1e-4]];

const TIED: &str = "{tied: {}}";
const COHESIVE: &str = "{linear_softening: {strength: 1.1e7, fracture_energy: 900}}";

/// Two blocks of 1 x 1 x 1 m, one on the other, turned about z; of prisms with triangles between
/// them, or of hexahedra. Sides: x0 to z1, `below` and `above`.
fn stacked(of_prisms: bool, across: [[usize; 2]; 2], [cos, sin]: [f64; 2]) -> String {
    let mut blocks = Blocks::of_prisms(of_prisms);
    let heights = [("lower", 0.0, "z0", "below"), ("upper", 1.0, "above", "z1")];
    for ((name, foot, low, high), [nx, ny]) in heights.into_iter().zip(across) {
        let planes = [even(nx, 1.0), even(ny, 1.0), even(1, 1.0)];
        let place = move |[x, y, z]: [f64; 3]| [cos * x - sin * y, sin * x + cos * y, foot + z];
        let around = [(0, false, "x0"), (0, true, "x1"), (1, false, "y0"), (1, true, "y1")];
        let sides = [&around[..], &[(2, false, low), (2, true, high)]].concat();
        blocks.add(&Block { name, planes: &planes, order: 1, place: &place, sides: &sides });
    }
    blocks.write()
}

/// Supports on two sides lean against the tangents of the joint: its corner between them has no
/// neighbour on either side that carries a multiplier. However the blocks are turned, a joint that
/// is pulled evenly softens evenly.
#[test]
fn a_corner_between_two_supports_that_lean() {
    let (strength, critical, modulus) = (1.1e6, 1800.0 / 1.1e6, 5.8e9);
    let traction = [0.5, 0.75, 0.0].map(|part| part * strength);
    let jump = [0.0, 0.25, 1.2].map(|part| part * critical);
    let head = |i: usize| 2.0 * traction[i] / modulus + jump[i];
    let turns = [[1.0, 0.0], [0.8, 0.6], [0.28, -0.96]];
    let kinds = [(true, 2), (false, 2), (true, 1), (false, 1)];
    for (turn, (of_prisms, order)) in
        turns.into_iter().flat_map(|turn| kinds.into_iter().map(move |kind| (turn, kind)))
    {
        let raised = if order == 2 { ", raise_order: 2" } else { "" };
        let yaml = format!(
            "
mesh: {{file: \"{}\"{raised}}}
materials:
  rock: {{on: [lower, upper], elastic: {{young_modulus: {modulus:e}, poisson_ratio: 0.3}}}}
interfaces:
  - name: joint
    between: [below, above]
    law: {{linear_softening: {{strength: {strength:e}, fracture_energy: 900}}}}
boundary:
  - {{on: z0, displacement: {{normal: 0}}}}
  - {{on: x1, displacement: {{normal: 0}}}}
  - {{on: y0, displacement: {{normal: 0}}}}
  - {{on: z1, displacement: {{normal: {{table: [[0, 0], [1, {:e}], [2, {:e}], [3, {:e}]]}}}}}}
time: {{instants: [1, 2, 3]}}
solver: {{tolerance: 1.0e-11}}
",
            stacked(of_prisms, [[2, 3]; 2], turn),
            head(0),
            head(1),
            head(2)
        );
        let run = Scene::new("turned", &yaml).on(1);
        for statistic in ["min", "max"] {
            let name = |quantity: &str| format!("joint.{quantity}.{statistic}");
            run.assert_column(&name("normal_traction"), &traction, 1e-9, 1e-3);
            run.assert_column(&name("normal_jump"), &jump, 1e-9, 1e-12);
        }
    }
}

/// A triangle of the joint in a corner between two sides, all of whose nodes are held: across from
/// it lies a node that is not.
#[test]
fn a_facet_that_is_held_passes_its_traction_to_nodes_across() {
    let component = |i: usize| {
        let terms = GRADIENT[i].iter().zip(["x", "y", "z"]);
        terms.map(|(slope, axis)| format!("({slope:e})*{axis}")).collect::<Vec<_>>().join("+")
    };
    let components = ["x", "y", "z"].iter().enumerate();
    let components = components
        .map(|(i, axis)| format!("{axis}: {{formula: \"t*({})\"}}", component(i)))
        .collect::<Vec<_>>()
        .join(", ");
    let sides = ["x0", "x1", "y0", "y1", "z0", "z1"];
    let held = sides.map(|side| format!("{{on: {side}, displacement: {{{components}}}}}"));
    let strain = |i: usize, j: usize| 0.5 * (GRADIENT[i][j] + GRADIENT[j][i]);
    let [shear, bulk] = [5.8e9 / 1.3, 5.8e9 * 0.3 / (1.3 * 0.4)];
    let trace: f64 = (0..3).map(|i| strain(i, i)).sum();
    let stress = [0, 1, 2].map(|i| shear * strain(i, 2) + if i == 2 { bulk * trace } else { 0.0 });
    for (secondary, law, ranks) in [("lower", TIED, 1), ("upper", TIED, 3), ("upper", COHESIVE, 1)]
    {
        let yaml = format!(
            "
mesh: {{file: \"{}\"}}
materials: {{rock: {{on: [lower, upper], elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces: [{{name: joint, between: [below, above], secondary: {secondary}, law: {law}}}]
boundary: [{}]
time: {{instants: [1, 2]}}
",
            stacked(true, [[2, 2], [3, 3]], [1.0, 0.0]),
            held.join(", ")
        );
        let run = Scene::new("held", &yaml).on(ranks);
        let names = ["shear_traction_1", "shear_traction_2", "normal_traction"];
        for (name, exact) in names.iter().zip(stress) {
            for statistic in ["min", "max"] {
                let exact = [exact, 2.0 * exact];
                run.assert_column(&format!("joint.{name}.{statistic}"), &exact, 1e-9, 1e-3);
            }
        }
    }
}

/// A side of an interface whose displacement is prescribed, as that of a stamp, carries no
/// multipliers, however fine it is.
#[test]
fn a_side_that_is_held_leaves_the_multipliers_to_the_other() {
    for (law, across, ranks) in [
        ("{contact: {}}", [[3, 3], [2, 2]], 1),
        (TIED, [[2, 2], [3, 3]], 1),
        (TIED, [[3, 3], [2, 2]], 3),
    ] {
        let yaml = format!(
            "
mesh: {{file: \"{}\"}}
materials: {{rock: {{on: [lower, upper], elastic: {{young_modulus: 1e9, poisson_ratio: 0}}}}}}
interfaces: [{{name: joint, between: [below, above], law: {law}}}]
boundary:
  - {{on: below, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: z0, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: x0, displacement: {{x: 0}}}}
  - {{on: y0, displacement: {{y: 0}}}}
  - {{on: z1, displacement: {{z: -1.0e-3}}}}
time: {{instants: [1]}}
",
            stacked(false, across, [1.0, 0.0])
        );
        let run = Scene::new("stamp", &yaml).on(ranks);
        run.assert_column("joint.force_z", &[-1e6], 1e-9, 0.0);
        run.assert_column("z1.reaction_z", &[-1e6], 1e-9, 0.0);
        assert!(run.told("remarks").is_empty(), "{:?}", run.told("remarks"));
        // Whoever asks for that side is told.
        let held = Scene::new("stamp", &yaml.replace("law:", "secondary: lower, law:")).on(ranks);
        let remarks = held.told("remarks");
        assert!(remarks.iter().any(|words| words.contains("secondary: upper")), "{remarks:?}");
    }
}
