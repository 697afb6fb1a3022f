//! Friction: when blocks start to slide, and the same answer from every form, solver and rank.

use std::f64::consts::PI;
use std::path::Path;

use column_hpc::results::Directory;

use crate::gaps::half_ellipse;
use crate::scene::{Kind, Run, Scene};

const YOUNG: f64 = 1.0e9;
const POISSON: f64 = 0.2;
/// Angle of the plane, and the pressure across over that along the weight.
const ANGLE: f64 = 30.0;
const CONFINEMENT: f64 = 0.2;

/// A block on a plane that leans by `ANGLE` against the largest pressure of an even stress, turned
/// so that the plane lies level: loads on all sides but the lowest, which moves as the stress says.
fn leaning(friction: f64) -> Scene {
    let (sin, cos) = ANGLE.to_radians().sin_cos();
    let k = CONFINEMENT;
    let [xx, zz] = [sin * sin + k * cos * cos, cos * cos + k * sin * sin].map(|s| -1.0e6 * s);
    let xz = 1.0e6 * (1.0 - k) * sin * cos;
    // Plane strain.
    let strain = (1.0 + POISSON) / YOUNG * (xx - POISSON * (xx + zz));
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0], bodies: [{{cells: [4, 2]}}, {{cells: [3, 2]}}]}}}}
materials: {{rock: {{elastic: {{young_modulus: {YOUNG}, poisson_ratio: {POISSON}}}}}}}
interfaces: [{{name: plane, z: 0.5, law: {{contact: {{friction: {friction:.12}}}}}}}]
boundary:
  - {{on: bottom, displacement: {{x: {{formula: \"{strain:e}*x\"}}, z: 0}}}}
  - {{on: top, traction: {{x: {xz:e}, z: {zz:e}}}}}
  - {{on: left, traction: {{x: {:e}, z: {:e}}}}}
  - {{on: right, traction: {{x: {xx:e}, z: {xz:e}}}}}
time: {{instants: [1]}}
",
        -xx, -xz
    );
    Scene::new("leaning", &yaml)
}

/// The coefficient from which on the block stays.
fn limit() -> f64 {
    let tan = ANGLE.to_radians().tan();
    (1.0 - CONFINEMENT) * tan / (1.0 + CONFINEMENT * tan * tan)
}

/// Ends with status 3 and names what slides.
fn slides(scene: &Scene) {
    let Err(failure) = scene.attempt(1) else { panic!("nothing slides") };
    assert_eq!(failure.status, Some(3), "{}", failure.complaint);
    for word in ["slides with friction over its whole area", "can move freely"] {
        assert!(failure.complaint.contains(word), "{}", failure.complaint);
    }
}

#[test]
fn a_confined_block_starts_to_slide_at_the_coefficient_of_equilibrium() {
    let run = leaning(limit() * (1.0 + 1e-6)).on(1);
    run.assert_column("plane.slip", &[0.0], 0.0, 1e-15);
    let ratio =
        run.column("plane.shear_traction_x.mean")[0] / run.column("plane.normal_traction.mean")[0];
    assert!((ratio + limit()).abs() < 1e-9, "{ratio} {}", limit());
    slides(&leaning(limit() * (1.0 - 1e-6)));
}

#[test]
fn a_block_on_an_inclined_plane_of_a_mesh_file_starts_to_slide_at_the_tangent_of_its_angle() {
    let plane = Scene::shipped("friction/inclined_plane.yaml").set("expect=[]");
    let limit = 35.0_f64.to_radians().tan();
    let at = |part: f64| plane.set(&format!("interfaces.0.law.contact.friction={}", part * limit));
    at(1.0 + 1e-6).on(1);
    slides(&at(1.0 - 1e-6));
}

/// Cattaneo and Mindlin: where a pushed cylinder slips its shear is that of friction, and where it
/// sticks what friction has left over is a half ellipse, as the pressure is.
#[test]
fn a_pushed_cylinder_sticks_in_the_middle_as_far_as_closed_form_says() {
    let [young, poisson, half_width, friction] = [7.0e10, 0.3, 0.004, 0.3];
    let pressure = young / (2.0 * (1.0 - poisson * poisson)) * half_width / 2.0;
    for ranks in [1, 3] {
        let run = Scene::shipped("friction/partial_slip.yaml").with_fields().on(ranks);
        let fields = Directory::open(&run.directory).expect("results");
        let fields = fields.series("contact").and_then(|series| series.at(2.0)).expect("fields");
        let points = fields.points().expect("points");
        let tractions = fields.at_points("traction").expect("tractions");
        let normals = fields.at_points("normal").expect("normals");
        let nodes = points.iter().zip(tractions.rows().zip(normals.rows()));
        // Place, pressure, and what friction has left over.
        let nodes: Vec<[f64; 3]> = nodes
            .map(|(x, (t, n))| {
                let p = -(t[0] * n[0] + t[1] * n[1]);
                [x[0], p, friction * p - (t[0] * n[1] - t[1] * n[0]).abs()]
            })
            .collect();
        for [x, p, left] in &nodes {
            assert!(*left > -1e-9 * pressure, "beyond friction at {x}: {left} of {p}");
            let slips = x.abs() > 0.6 * half_width;
            assert!(!slips || *left < 1e-9 * pressure, "sticks at {x}: {left} of {p}");
        }
        let pressures: Vec<[f64; 2]> = nodes.iter().map(|[x, p, _]| [x * x, *p]).collect();
        let pressed = pressures.iter().filter(|[_, p]| *p > 0.2 * pressure);
        let stick: Vec<[f64; 2]> = nodes.iter().map(|[x, _, left]| [x * x, *left]).collect();
        let inner = stick.iter().filter(|[r2, _]| r2.sqrt() < 0.45 * half_width);
        let found = [half_ellipse(pressed), half_ellipse(inner)].concat();
        let exact = [pressure, half_width, friction * pressure / 2.0, half_width / 2.0];
        println!("{found:?} against {exact:?}");
        for ((found, exact), tolerance) in found.iter().zip(exact).zip([1e-3, 2e-3, 1e-2, 2e-2]) {
            assert!((found / exact - 1.0).abs() < tolerance, "{found} against {exact}");
        }
    }
}

/// Pressed, then dragged about under a platen: nodes stick, slide, turn and lift. `law` is that of
/// the joint, `cells` those of both bodies.
fn dragged(law: &str, cells: &str) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 0.8, 1.6], bodies: [{{cells: {cells}}}, {{cells: {cells}}}]}}}}
materials: {{rock: {{elastic: {{young_modulus: {YOUNG}, poisson_ratio: {POISSON}}}}}}}
interfaces: [{{name: joint, z: 0.8, law: {law}}}]
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - on: top
    displacement:
      x: {{table: [[1, 0], [3, 4.0e-3], [5, -4.0e-3]]}}
      y: {{table: [[2, 0], [4, 3.0e-3]]}}
      z: {{table: [[0, 0], [1, -1.0e-3]]}}
time: {{instants: [1, 2, 2.5, 3, 4, 5]}}
solver: {{stability: \"off\"}}
"
    );
    Scene::new("dragged", &yaml)
}

const CONTACT: &str = "{contact: {friction: 0.6}}";
const COHESIVE: &str =
    "{linear_softening: {strength: 1.0e6, fracture_energy: 1000, friction: 0.6}}";

/// External work is what is stored, dissipated and taken by friction.
fn assert_balance(run: &Run, relative: f64) {
    let [elastic, dissipated, friction, external] =
        ["elastic", "dissipated", "friction", "external"]
            .map(|name| run.column(&format!("energy.{name}")));
    for row in 0..external.len() {
        let sum = elastic[row] + dissipated[row] + friction[row];
        let error = (sum - external[row]).abs();
        assert!(error <= relative * external[row].abs(), "{}: row {row}: {error:e}", run.label);
    }
    assert!(friction.is_sorted() && friction[friction.len() - 1] > 0.0, "{friction:?}");
}

/// The same history, jumps over the displacements of the platen.
fn assert_same(one: &Run, other: &Run, tolerance: f64) {
    assert_eq!(one.table.columns, other.table.columns);
    assert_eq!(one.table.rows.len(), other.table.rows.len());
    let difference = one.difference_above(other, |kind| match kind {
        Kind::Length => 4.0e-3,
        Kind::Damage => 1.0,
        _ => f64::MIN_POSITIVE,
    });
    assert!(difference <= tolerance, "{} {}: {difference:e}", one.label, other.label);
}

#[test]
fn the_condensed_form_makes_the_corrections_of_the_saddle_point_form() {
    for law in [CONTACT, COHESIVE] {
        let scene = dragged(law, "[3, 2, 2]").in_any_steps();
        let (one, other) = (scene.on(1), scene.set("solver.form=saddle_point").on(2));
        assert_same(&one, &other, 1e-8);
        assert_eq!(one.corrections(), other.corrections());
        let most = one.corrections().into_iter().fold(0.0, f64::max);
        assert!(most <= 8.0, "{:?}", one.corrections());
    }
}

#[test]
fn solvers_ranks_and_restarts_agree_and_energy_balances() {
    let scene = dragged(CONTACT, "[4, 4, 4]");
    let one = scene.on(1);
    assert_balance(&one, 1e-8);
    for (solver, ranks) in [("multigrid", 3), ("aggregation", 2)] {
        let other = scene.set(&format!("solver.linear={solver}")).on(ranks);
        assert_same(&one, &other, 1e-7);
    }
    let stopped = scene.stopped(2, "history:1:term:3", 3);
    assert_same(&one, &stopped, 1e-8);
}

/// Radius of the rounded block (m), coefficient, plane-strain modulus of both blocks together (Pa).
const ROUND: f64 = 10.0;
const RUBBING: f64 = 0.5;
const TOGETHER: f64 = YOUNG / (2.0 * (1.0 - 0.3 * 0.3));

/// A rounded block on a flat one, pressed and then pushed along, in a square of 2 m in `cells`
/// squared.
fn cattaneo_mindlin(cells: usize) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [2, 2], cells: [{cells}, {cells}]}}}}
materials: {{steel: {{elastic: {{young_modulus: {YOUNG}, poisson_ratio: 0.3}}}}}}
interfaces:
  - name: contact
    z: 1
    law: {{contact: {{friction: {RUBBING}}}}}
    initial: {{gap: {{formula: \"(x - 1)*(x - 1)/(2*{ROUND})\"}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}}}
  - on: top
    displacement:
      x: {{table: [[1, 0], [3, 1.5e-3]]}}
      z: {{table: [[0, 0], [1, -2.2e-3]]}}
time: {{instants: [1, 2, 3]}}
"
    );
    Scene::new("cattaneo_mindlin", &yaml)
}

/// Johnson, Contact Mechanics, section 7.2: under the forces P and Q the block sticks where
/// |x| < c, c = a sqrt(1 - Q/(f P)), and around that slips under f p; the shear is
/// f (p(x, a) - c/a p(x, c)). What is left is that the blocks end at eight times the half width.
#[test]
fn a_rounded_block_sticks_inside_and_slips_around() {
    let mut errors = Vec::new();
    for (cells, ranks) in [(80, 1), (160, 3)] {
        let run = cattaneo_mindlin(cells).with_fields().on(ranks);
        let fields = Directory::open(&run.directory).expect("results");
        let series = fields.series("contact").expect("fields");
        let edge = 2.0 / cells as f64;
        let mut worst: f64 = 0.0;
        for instant in [1, 2] {
            let [p, q] = ["normal_traction", "shear_traction_x"]
                .map(|name| 2.0 * run.column(&format!("contact.{name}.mean"))[instant].abs());
            let a = (4.0 * p * ROUND / (PI * TOGETHER)).sqrt();
            let c = a * (1.0 - q / (RUBBING * p)).sqrt();
            let pressure = |x: f64, a: f64, top: f64| top * (1.0 - (x / a).powi(2)).max(0.0).sqrt();
            let top = RUBBING * 2.0 * p / (PI * a);
            let fields = series.at(instant as f64 + 1.0).expect("fields");
            let points = fields.points().expect("points");
            let tractions = fields.at_points("traction").expect("tractions");
            let slips = fields.at_points("slip").expect("slips");
            let (mut off, mut sticks) = (0.0, 0.0_f64);
            for ((point, traction), slip) in points.iter().zip(tractions.rows()).zip(slips.rows()) {
                let x = point[0] - 1.0;
                let exact = pressure(x, a, top) - pressure(x, c, top * c / a);
                off += edge * (traction[0].abs() - exact).abs() / (RUBBING * p);
                if traction[2] < -1e-3 * top && slip[0] < 1e-12 {
                    sticks = sticks.max(x.abs());
                }
            }
            println!("{cells} cells: shear off by {off:.4}, sticks to {sticks:.4} of {c:.4} m");
            assert!((sticks - c).abs() < edge, "{sticks} {c}");
            worst = worst.max(off);
        }
        errors.push(worst);
    }
    assert!(errors[0] < 0.04 && errors[1] < 0.4 * errors[0], "{errors:?}");
}

/// Where points give way, slide and turn within steps their work is off; a tolerance bounds that.
#[test]
fn a_tolerance_of_steps_closes_the_balance_of_energy() {
    let yaml = "
mesh: {column: {size: [1.0, 2.0], cells: [3, 4]}}
materials: {rock: {elastic: {young_modulus: 1.0e10, poisson_ratio: 0.2}}}
interfaces:
  - {name: joint, z: 1.0, law: {linear_softening: {strength: 1.0e6, fracture_energy: 1000, friction: 0.6}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - on: top
    displacement: {x: {formula: \"3.0e-3*sin(3*t)\"}, z: {formula: \"-2.0e-4*min(1,5*t)*(1+0.3*t)\"}}
time: {instants: {from: 0, to: 1, steps: 10}}
solver: {tolerance: 1.0e-12, stability: \"off\"}
";
    let scene = Scene::new("sheared", yaml).in_any_steps();
    let off = |scene: &Scene| {
        let run = scene.on(1);
        let of = |name: &str| run.column(&format!("energy.{name}"));
        let (external, elastic) = (of("external"), of("elastic"));
        let (dissipated, friction) = (of("dissipated"), of("friction"));
        let sums = elastic.iter().zip(&dissipated).zip(&friction).map(|((e, d), f)| e + d + f);
        let off = external.iter().zip(sums).map(|(w, sum)| (w - sum).abs()).fold(0.0, f64::max);
        off / external.iter().fold(0.0, |most: f64, w| most.max(w.abs()))
    };
    assert!(off(&scene) > 1e-2, "as long as instants ask for");
    for (tolerance, most) in [("1.0e-3", 1e-3), ("1.0e-5", 1e-5)] {
        let found = off(&scene.set(&format!("time.tolerance={tolerance}")));
        assert!(found < most, "{tolerance}: {found:e}");
    }
}

/// A joint that is sheared to rupture along a path, as in steps with the same load factors, but for
/// the last one, which a path takes in parts; intact, and damaged, so that it slides before it
/// breaks further.
#[test]
fn a_path_meets_the_steps_that_have_its_loads() {
    let yaml = |damage: f64, top: &str, side: &str, time: &str| {
        format!(
            "
mesh: {{column: {{size: [1.0, 2.0], cells: [4, 4]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e10, poisson_ratio: 0.2}}}}}}
interfaces:
  - name: joint
    z: 1.0
    law: {{linear_softening: {{strength: 1.0e6, fracture_energy: 1000, friction: 0.6}}}}
    initial: {{damage: {damage}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}}}
  - {{on: top, displacement: {{{top}}}}}
  - {{on: right, traction: {{x: {side}}}}}
{time}
solver: {{stability: \"off\"}}
"
        )
    };
    let control = "control: {dissipation: {of: joint, step: 0.1}}\ntime: {instants: [1]}";
    for damage in [0.0, 0.4] {
        let path = yaml(damage, "x: 1.0e-3, z: -2.0e-4", "-2.0e5", control);
        let path = Scene::new("path", &path).in_any_steps();
        let one = path.on(1);
        let factors = one.column("load_factor");
        let grown = |by: f64| {
            let row = |(i, factor): (usize, &f64)| format!("[{}, {:e}]", i + 1, factor * by);
            let rows: Vec<String> = factors.iter().enumerate().map(row).collect();
            format!("{{table: [[0, 0], {}]}}", rows.join(", "))
        };
        let top = format!("x: {}, z: {}", grown(1.0e-3), grown(-2.0e-4));
        let time = "time: {instants: {from: 0, to: 11, steps: 11}}";
        let steps = yaml(damage, &top, &grown(-2.0e5), time);
        let steps = Scene::new("steps", &steps).in_any_steps().on(1);
        assert_eq!(one.table.rows.len(), 11);
        for name in ["shear_traction_x.max", "normal_traction.min", "sliding_x.max", "damage.min"] {
            let [one, other] = [&one, &steps].map(|run| run.column(&format!("joint.{name}")));
            let scale = one.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            for (a, b) in one.iter().zip(&other).take(10) {
                assert!((a - b).abs() < 1e-8 * scale, "{damage} {name}: {a} {b}");
            }
        }
        assert!(one.column("energy.friction").is_sorted());
        assert_same(&one, &path.set("solver.linear=aggregation").on(3), 1e-7);
        assert_same(&one, &path.stopped(2, "history:1:term:1", 1), 1e-8);
    }
}

/// A joint at 35 degrees under uniaxial compression carries strength (1 - D)/(cos (sin - D mu cos))
/// along a path, and locks at D = tan/mu, where the path ends and says why.
#[test]
fn a_leaning_joint_that_locks_ends_its_path_and_says_so() {
    let mesh =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/inclined_joint/inclined_joint.msh");
    let scene = |friction: f64, instants: usize| {
        let yaml = format!(
            "
mesh: {{file: \"{}\"}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces:
  - name: joint
    on: joint
    law: {{linear_softening: {{strength: 1.0e6, fracture_energy: 900, friction: {friction}}}}}
boundary:
  - {{on: foot, displacement: {{y: 0}}}}
  - {{on: corner, displacement: {{x: 0}}}}
  - {{on: head, traction: {{y: -1.0e6}}}}
control: {{dissipation: {{of: joint, step: {}}}}}
time: {{instants: [1]}}
",
            mesh.display(),
            1.0 / instants as f64
        );
        Scene::new("leaning", &yaml)
    };
    for (friction, instants) in [(1.0, 10), (2.0, 20)] {
        let Err(failure) = scene(friction, instants).attempt(1) else { panic!("it goes on") };
        assert_eq!(failure.status, Some(3), "{}", failure.complaint);
        let locks = 35.0_f64.to_radians().tan() / friction;
        let last = (locks * instants as f64).floor() / instants as f64;
        for word in ["interface locks before it is broken", &format!("up to time {last}")] {
            assert!(failure.complaint.contains(word), "{word}: {}", failure.complaint);
        }
    }
}
