//! Contacts whose sides lie apart at the start: when they close, and Hertz's pressure.

use std::f64::consts::PI;

use column_hpc::results::Directory;

use crate::blocks::{Block, Blocks, even, graded};
use crate::cubes::{Blocks as Cubes, Cut, turned};
use crate::scene::{Run, Scene};

/// Two blocks of height 1 m and so many cells along each axis, `gap` m apart, in 2D or 3D.
fn apart(dim: usize, cells: [usize; 2], order: usize, gap: f64) -> String {
    let mut blocks = Blocks::default();
    let height = dim - 1;
    let names = [["low", "base", "face"], ["high", "lip", "head"]];
    for (number, [name, below, above]) in names.into_iter().enumerate() {
        let planes = vec![even(cells[number], 1.0); dim];
        let up = number as f64 * (1.0 + gap);
        let place = |mut x: [f64; 3]| {
            x[height] += up;
            x
        };
        let sides = [(height, false, below), (height, true, above)];
        blocks.add(&Block { name, planes: &planes, order, place: &place, sides: &sides });
    }
    blocks.write()
}

/// Two blocks without Poisson's ratio of which the upper one comes down by what is told for each
/// instant (m).
fn column(mesh: &str, dim: usize, down: &[f64], contact: &str) -> Scene {
    let axes = &["x", "y", "z"][..dim];
    let across: Vec<String> = axes[..dim - 1].iter().map(|axis| format!("{axis}: 0")).collect();
    let (across, up) = (across.join(", "), axes[dim - 1]);
    let times: Vec<String> = (1..=down.len()).map(|t| t.to_string()).collect();
    let rows: Vec<String> =
        down.iter().enumerate().map(|(t, u)| format!("[{}, {:e}]", t + 1, -u)).collect();
    let yaml = format!(
        "
mesh: {{file: \"{mesh}\"}}
materials: {{rock: {{on: [low, high], elastic: {{young_modulus: 1.0e10, poisson_ratio: 0}}}}}}
interfaces: [{{name: contact, between: [face, lip], {contact}}}]
boundary:
  - {{on: base, displacement: {{{across}, {up}: 0}}}}
  - {{on: head, displacement: {{{across}, {up}: {{table: [[0, 0], {}]}}}}}}
time: {{instants: [{}]}}
",
        rows.join(", "),
        times.join(", ")
    );
    Scene::new("apart", &yaml)
}

const CONTACT: &str = "law: {contact: {}}";

/// Nothing is transmitted until the gap has closed, and then as by one column.
fn closes(run: &Run, down: &[f64], gap: f64, up: &str) {
    let traction: Vec<f64> = down.iter().map(|d| -1e10 * (d - gap).max(0.0) / 2.0).collect();
    let jump: Vec<f64> = down.iter().map(|d| (gap - d).max(0.0)).collect();
    for statistic in ["min", "max", "mean"] {
        let of = |name: &str| format!("contact.{name}.{statistic}");
        run.assert_column(&of("normal_traction"), &traction, 1e-9, 1e-3);
        run.assert_column(&of("normal_jump"), &jump, 1e-9, 1e-14);
    }
    run.assert_column(&format!("contact.force_{up}"), &traction, 1e-9, 1e-3);
}

#[test]
fn a_plane_gap_closes_at_its_width() {
    let gap = 0.03;
    let down = [0.01, 0.0299, 0.031, 0.0305, 0.02, 0.04];
    for (dim, cells, order) in
        [(2, [3, 3], 1), (2, [2, 3], 1), (2, [3, 2], 2), (3, [2, 2], 1), (3, [2, 3], 1)]
    {
        let scene = column(&apart(dim, cells, order, gap), dim, &down, CONTACT);
        let up = ["x", "y", "z"][dim - 1];
        closes(&scene.on(1), &down, gap, up);
        if cells == [3, 2] || (dim, cells) == (3, [2, 3]) {
            closes(&scene.scattered().on(3), &down, gap, up);
        }
    }
}

#[test]
fn a_run_that_was_stopped_goes_on_with_its_gap() {
    let down = [0.01, 0.031, 0.02];
    let scene = column(&apart(2, [2, 3], 1, 0.03), 2, &down, CONTACT);
    closes(&scene.stopped(1, "history:0:term:1", 2), &down, 0.03, "y");
}

/// Of 0.4 m, more than the facets have.
#[test]
fn gaps_wider_than_a_facet_are_seen() {
    let down = [0.1, 0.4002];
    let scene = column(&apart(3, [4, 3], 1, 0.4), 3, &down, CONTACT);
    let run = scene.on(1);
    closes(&run, &down, 0.4, "z");
    assert_eq!(run.told("remarks"), ["interface contact: a gap of up to 4.000e-1 m at the start"]);
}

/// By less than what the facets of the round sides cut off, which is told in the report.
#[test]
fn gaps_of_curved_facets_are_taken_for_closed_and_told() {
    for ranks in [1, 2] {
        let run = Scene::shipped("circular_inclusion/contact.yaml").on(ranks);
        let told = run.told("remarks");
        let of_rim = told.iter().filter(|words| words.starts_with("interface rim: gaps of up to "));
        let of_rim: Vec<&String> = of_rim.collect();
        assert!(matches!(of_rim[..], [one] if one.ends_with("are taken for closed")), "{told:?}");
        run.assert_column("rim.normal_jump.max", &[0.0], 0.0, 1e-12);
    }
}

/// What has come into each other by 1e-4 m is pressed by that from the start.
#[test]
fn sides_in_each_other_press() {
    let down = [0.0, 1e-4, -2e-4];
    let scene = column(&apart(2, [2, 3], 2, -1e-4), 2, &down, CONTACT);
    closes(&scene.on(1), &down, -1e-4, "y");
}

#[test]
fn gaps_can_be_taken_for_closed_and_bonds_have_none() {
    let mesh = apart(2, [2, 3], 1, 1e-3);
    let down = [1e-4, -1e-4];
    let closed = column(&mesh, 2, &down, "gap: closed, law: {contact: {}}").on(1);
    let stiffness = 1e10 / 2.0;
    let traction = [-1e-4 * stiffness, 0.0];
    closed.assert_column("contact.normal_traction.mean", &traction, 1e-9, 1e-3);
    let told = closed.told("remarks");
    assert!(told.iter().any(|words| words.contains("are taken for closed there")), "{told:?}");
    let wide = apart(2, [2, 3], 1, 0.04);
    for law in ["law: {tied: {}}", "gap: closed, law: {contact: {}}"] {
        let failure = column(&wide, 2, &down, law).attempt(1).err().expect("a refusal");
        assert_eq!(failure.status, Some(2), "{}", failure.complaint);
        assert!(failure.complaint.contains("m apart"), "{}", failure.complaint);
    }
}

/// The radius of the rounded side (m), Young's modulus over twice 1 - ν², and how far the upper
/// block comes down (m).
const RADIUS: f64 = 1.0;
const MODULUS: f64 = 1e10 / (2.0 * (1.0 - 0.25 * 0.25));
const DOWN: f64 = 1.2e-3;

/// Half of a block with the rounded lower side y = x²/2 m on a flat one; so many facets of the
/// round one lie over 0.025 m, a little more than the half width of the contact.
fn hertz(facets: f64) -> Scene {
    let mut blocks = Blocks::default();
    let (fine, height) = (0.05, 1.5);
    let round = |[x, y, _]: [f64; 3]| {
        let low = 0.5 * x * x / RADIUS;
        [x, low + y * (1.0 - low / height), 0.0]
    };
    let flat = |[x, y, _]: [f64; 3]| [x, y, 0.0];
    let size = 0.025 / facets;
    let along = |size: f64| vec![graded(size, fine, 1.0), graded(size, fine, height)];
    let (upper, mut lower) = (along(size), along(size * 4.0 / 3.0));
    lower[1] = lower[1].iter().rev().map(|y| -y).collect();
    let sides = [(0, false, "axis"), (1, true, "face"), (1, false, "base")];
    blocks.add(&Block { name: "low", planes: &lower, order: 2, place: &flat, sides: &sides });
    let sides = [(0, false, "axis"), (1, false, "lip"), (1, true, "head")];
    blocks.add(&Block { name: "high", planes: &upper, order: 2, place: &round, sides: &sides });
    let yaml = format!(
        "
mesh: {{file: \"{}\"}}
materials: {{rock: {{on: [low, high], elastic: {{young_modulus: 1.0e10, poisson_ratio: 0.25}}}}}}
interfaces: [{{name: contact, between: [face, lip], {CONTACT}}}]
boundary:
  - {{on: axis, displacement: {{x: 0}}}}
  - {{on: base, displacement: {{y: 0}}}}
  - {{on: head, displacement: {{y: {:e}}}}}
time: {{instants: [1]}}
",
        blocks.write(),
        -DOWN
    );
    Scene::new("hertz", &yaml)
}

/// Johnson, Contact Mechanics, section 4.2: half width and largest pressure from the force P on
/// both halves, a² = 4 P R/(π E*), p² = P E*/(π R).
#[test]
fn a_rounded_block_on_a_flat_one_has_the_pressure_of_hertz() {
    let mut errors = Vec::new();
    for facets in [4.0, 8.0] {
        let run = hertz(facets).with_fields().on(if facets == 4.0 { 3 } else { 1 });
        let force = -2.0 * run.column("contact.force_y")[0];
        let pressure = (force * MODULUS / (PI * RADIUS)).sqrt();
        let half_width = 2.0 * (force * RADIUS / (PI * MODULUS)).sqrt();
        let found = -run.column("contact.normal_traction.min")[0];
        errors.push((found / pressure - 1.0).abs());
        let fields = Directory::open(&run.directory).expect("results");
        let fields = fields.series("contact").and_then(|series| series.at(1.0)).expect("fields");
        let points = fields.points().expect("points");
        let tractions = fields.at_points("traction").expect("tractions");
        let gaps = fields.at_points("initial_gap").expect("gaps");
        let mut closed: f64 = 0.0;
        for ((point, traction), gap) in points.iter().zip(tractions.rows()).zip(gaps.rows()) {
            closed = if traction[1] < -1e3 { closed.max(point[0]) } else { closed };
            if point[0] < 0.05 {
                // Weighted means over the facets around a node, along normals that lean.
                let exact = 0.5 * point[0] * point[0] / RADIUS;
                let allowed = 2e-3 * exact + 3e-6 * (4.0 / facets).powi(2);
                assert!((gap[0] - exact).abs() < allowed, "{gap:?} {exact}");
            }
        }
        println!("pressure {found:e} against {pressure:e}, half width {closed} of {half_width}");
        assert!((closed - half_width).abs() < 0.025 / facets, "{closed} of {half_width}");
    }
    assert!(errors[0] < 1e-2 && errors[1] < 0.3 * errors[0], "{errors:?}");
}

/// Where nothing ever touches, rounding is all that is out of balance, at zero displacement too.
#[test]
fn sides_that_never_touch_cost_nothing() {
    let gap = 1e-3;
    let is = |x: f64, at: f64| (x - at).abs() < 1e-9;
    for (cut, count) in [(Cut::Tetrahedra, [2, 2, 2]), (Cut::Hexahedra, [3, 3, 2])] {
        let blocks = Cubes::default()
            .block([0.0; 3], [1.0, 1.0, 1.0], [2, 2, 2], cut)
            .group("base", |x| is(x[2], 0.0))
            .group("face", |x| is(x[2], 1.0))
            .block([0.0, 0.0, 1.0 + gap], [1.0, 1.0, 2.0 + gap], count, cut)
            .group("lip", |x| is(x[2], 1.0 + gap))
            .group("head", |x| is(x[2], 2.0 + gap));
        let down = turned([0.0, 0.0, -1e-3]);
        let components: Vec<String> = ["x", "y", "z"]
            .iter()
            .zip(down)
            .map(|(axis, d)| format!("{axis}: {{table: [[0, 0], [1, {:e}], [2, 0]]}}", 0.5 * d))
            .collect();
        let yaml = format!(
            "
mesh: {{file: \"{}\"}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces: [{{name: contact, between: [face, lip], {CONTACT}}}]
boundary:
  - {{on: base, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: head, displacement: {{{}}}}}
time: {{instants: [0.5, 1, 1.5, 1.9, 2, 3]}}
",
            blocks.write(true),
            components.join(", ")
        );
        for ranks in [1, 3] {
            let run = Scene::new("never", &yaml).scattered().on(ranks);
            let corrections = run.corrections();
            assert!(corrections.iter().all(|n| *n <= 2.0), "{}: {corrections:?}", run.label);
            run.assert_column("contact.normal_traction.min", &[0.0; 6], 1e-9, 1e-3);
        }
    }
}

/// Height and radius of the half ellipse p² = p0² (1 - r²/a²) that is closest to pairs of r² and p.
pub fn half_ellipse<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> [f64; 2] {
    let mut sums = [0.0; 5];
    for [r2, p] in points {
        let terms = [1.0, *r2, r2 * r2, p * p, r2 * p * p];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    let [n, r, rr, p, rp] = sums;
    let slope = (n * rp - r * p) / (n * rr - r * r);
    let square = (p - slope * r) / n;
    [square.sqrt(), (-square / slope).sqrt()]
}

/// Largest pressure and radius (half width) of the shipped cases of Hertz, from a fit to the nodes
/// above a fifth of the largest pressure.
#[test]
fn shipped_contacts_have_the_pressure_and_the_radius_of_hertz() {
    for (case, up, exact, tolerances) in [
        ("hertz/cylinder.yaml", 1, [769_153_853.8, 0.02], [4e-3, 5e-3]),
        ("hertz/sphere.yaml", 2, [2_448_292_756.8, 0.05], [1e-2, 5e-3]),
    ] {
        let run = Scene::shipped(case).with_fields().on(1);
        let fields = Directory::open(&run.directory).expect("results");
        let fields = fields.series("contact").and_then(|series| series.at(1.0)).expect("fields");
        let points = fields.points().expect("points");
        let tractions = fields.at_points("traction").expect("tractions");
        let all: Vec<[f64; 2]> = points
            .iter()
            .zip(tractions.rows())
            .map(|(x, t)| [x[..up].iter().map(|x| x * x).sum(), -t[up]])
            .collect();
        let largest = all.iter().map(|[_, p]| *p).fold(0.0, f64::max);
        let found = half_ellipse(all.iter().filter(|[_, p]| *p > 0.2 * largest));
        println!("{case}: {found:?} against {exact:?}");
        for ((found, exact), tolerance) in found.iter().zip(exact).zip(tolerances) {
            assert!((found / exact - 1.0).abs() < tolerance, "{case}: {found} against {exact}");
        }
    }
}
