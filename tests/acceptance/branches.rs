//! Branches of perfect structures: followed from an unstable state, and selected by an
//! imperfection.

use crate::scene::{Run, Scene};

const STRENGTH: f64 = 1.1e6;
const ENERGY: f64 = 900.0;
const CRITICAL: f64 = 2.0 * ENERGY / STRENGTH;
const YOUNG: f64 = 5.8e9;

/// Two interfaces in series, the upper one with a strength of its own, pulled evenly by `PULL` t.
fn two(cells: &str, upper: f64) -> Scene {
    let law = |strength: f64| {
        format!("{{linear_softening: {{strength: {strength}, fracture_energy: {ENERGY}}}}}")
    };
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 3.0], cells: {cells}}}}}
materials: {{rock: {{elastic: {{young_modulus: {YOUNG}, poisson_ratio: 0.0}}}}}}
interfaces:
  - {{name: lower, z: 1.0, law: {}}}
  - {{name: upper, z: 2.0, law: {}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {{formula: \"{PULL}*t\"}}}}}}
time: {{instants: [0.5, 1, 1.5]}}
",
        law(STRENGTH),
        law(upper),
    );
    Scene::new("two", &yaml)
}

const PULL: f64 = 1.4e-3;

/// A column on the side of which its interface gives way: taller than what an even opening is
/// stable up to, shorter than what snaps back. Pulled 1e-5 m past the peak.
fn column(layers: usize) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 8.4], cells: [4, 4, {layers}]}}}}
materials: {{rock: {{elastic: {{young_modulus: {YOUNG}, poisson_ratio: 0.0}}}}}}
interfaces:
  - {{name: joint, z: 4.2, law: {{linear_softening: {{strength: {STRENGTH}, fracture_energy: {ENERGY}}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {{formula: \"{}*t\"}}}}}}
time: {{instants: [1]}}
",
        STRENGTH * 8.4 / YOUNG + 1e-5,
    );
    Scene::new("column", &yaml)
}

const FOLLOW: &str = "solver.stability=follow";

fn imperfection(interface: &str, factor: &str) -> String {
    format!("initial={{imperfection: [{{interface: {interface}, factor: {factor}}}]}}")
}

fn assert_near(run: &Run, name: &str, exact: &[f64], scale: f64) {
    let found = run.column(name);
    assert_eq!(found.len(), exact.len(), "{}: {name}", run.label);
    for (found, exact) in found.iter().zip(exact) {
        let label = &run.label;
        assert!((found - exact).abs() <= 1e-8 * scale, "{label}: {name} {found} for {exact}");
    }
}

/// One interface alone opens, whose strength and energy have a factor; the other stays whole.
fn assert_one_opens(run: &Run, opens: &str, whole: &str, factor: f64) {
    let strength = factor * STRENGTH;
    let part = |time: f64| {
        let pulled = PULL * time;
        let bulk = strength * 3.0 / YOUNG;
        (pulled - bulk) / (CRITICAL - bulk)
    };
    let damage: Vec<f64> = [0.5, 1.0, 1.5].map(|time| part(time).min(1.0)).into();
    assert!(damage[0] > 0.0 && damage[1] < 1.0 && damage[2] == 1.0);
    let traction: Vec<f64> = damage.iter().map(|d| strength * (1.0 - d)).collect();
    let energy: Vec<f64> = damage.iter().map(|d| factor * ENERGY * d).collect();
    for statistic in ["min", "max", "mean"] {
        assert_near(run, &format!("{opens}.damage.{statistic}"), &damage, 1.0);
        assert_near(run, &format!("{opens}.normal_traction.{statistic}"), &traction, STRENGTH);
    }
    assert_near(run, "energy.dissipated", &energy, ENERGY);
    assert_eq!(run.column(&format!("{whole}.damage.max")), [0.0; 3], "{}", run.label);
    assert!(run.told("instabilities").is_empty(), "{}", run.label);
}

/// The only bifurcation that a run tells, on the screen too.
fn the_bifurcation(run: &Run) -> String {
    let mut list = run.told("bifurcations");
    assert_eq!(list.len(), 1, "{}: {list:?}", run.label);
    assert!(run.screen.contains(&format!("warning: {}", list[0])), "{}", run.label);
    assert!(list[0].contains("is not unique"), "{}: {list:?}", run.label);
    list.swap_remove(0)
}

#[test]
fn of_two_equal_interfaces_one_is_followed() {
    let mumps = two("[2, 2, 9]", STRENGTH).set(FOLLOW).set("solver.linear=mumps");
    // As fine as it takes for a coarser lattice on each number of ranks.
    let multigrid = two("[8, 8, 36]", STRENGTH).set(FOLLOW).set("solver.linear=multigrid");
    for (scene, ranks) in [(mumps, &[2, 3, 4][..]), (multigrid, &[2, 3])] {
        let first = scene.on(1);
        assert_one_opens(&first, "lower", "upper", 1.0);
        let words = the_bifurcation(&first);
        assert!(
            words.contains("at time 0.5") && words.contains("of interface lower at"),
            "{words}"
        );
        assert!(words.contains("its mirror image"), "{words}");
        for ranks in ranks {
            let run = scene.on(*ranks);
            first.assert_same(&run, 1e-8);
            assert_eq!(run.report["linear_solver"], first.report["linear_solver"]);
            assert_eq!(the_bifurcation(&run), words, "{}", run.label);
        }
    }
}

/// Two interfaces that differ are no bifurcation: smaller steps lead to the path.
#[test]
fn the_weaker_of_two_interfaces_needs_no_choice() {
    let scene = two("[2, 2, 9]", 0.9 * STRENGTH).set(FOLLOW).in_any_steps();
    let run = scene.set("time.instants=[1]").on(1);
    let path = scene.set("time.instants=[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]").on(1);
    for name in ["upper.damage.mean", "upper.normal_traction.mean", "energy.dissipated"] {
        let (one, ten) = (run.column(name)[0], path.column(name)[9]);
        assert!((one - ten).abs() <= 1e-8 * ten.abs(), "{name}: {one} {ten}");
    }
    assert!(run.column("upper.damage.min")[0] > 0.5);
    assert_eq!(run.column("lower.damage.max"), [0.0]);
    for run in [run, path] {
        assert!(run.told("bifurcations").is_empty() && run.told("instabilities").is_empty());
    }
}

#[test]
#[ignore = "two minutes: cargo test --release --test acceptance branches -- --ignored"]
fn multigrid_follows_on_more_ranks() {
    let scene = two("[8, 8, 36]", STRENGTH).set(FOLLOW).set("solver.linear=multigrid");
    let (first, run) = (scene.on(1), scene.on(4));
    first.assert_same(&run, 1e-8);
    assert_eq!(the_bifurcation(&run), the_bifurcation(&first));
    for (weak, whole) in [("lower", "upper"), ("upper", "lower")] {
        let imperfect = scene.set(&imperfection(weak, "0.999")).in_any_steps();
        for ranks in [1, 3] {
            assert_one_opens(&imperfect.on(ranks), weak, whole, 0.999);
        }
    }
}

#[test]
fn an_imperfection_selects_the_weaker_interface() {
    // On 3 ranks the coarsest lattice is a finer one, and takes ten times as long: two equal
    // interfaces have it above.
    for (weak, whole, levels) in [("lower", "upper", 1), ("upper", "lower", 2)] {
        let imperfect =
            |cells: &str| two(cells, STRENGTH).set(&imperfection(weak, "0.999")).in_any_steps();
        for (stability, others) in [("auto", &[3][..]), ("follow", &[2, 4])] {
            let scene = imperfect("[2, 2, 9]").set(&format!("solver.stability={stability}"));
            let first = scene.on(1);
            assert_one_opens(&first, weak, whole, 0.999);
            for ranks in others {
                first.assert_same(&scene.on(*ranks), 1e-8);
            }
        }
        let scene = imperfect("[8, 8, 36]").set(FOLLOW).set("solver.linear=multigrid");
        assert_one_opens(&scene.on(levels), weak, whole, 0.999);
    }
}

/// Energies in the sentence of a bifurcation: of the state that was taken, of the unstable one.
fn energies(words: &str) -> [f64; 2] {
    let after = words.split("potential energy of ").nth(1).expect("an energy");
    let numbers: Vec<f64> = after.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    [numbers[0], numbers[1]]
}

fn potential_energy(run: &Run) -> f64 {
    // No loads but prescribed displacements: nothing else has potential energy.
    run.column("energy.elastic")[0] + run.column("energy.dissipated")[0]
}

#[test]
fn a_column_that_is_too_tall_is_followed_to_one_side() {
    for (layers, solver, ranks) in [(32, "mumps", &[2, 4][..]), (64, "multigrid", &[2])] {
        let scene = column(layers).set(&format!("solver.linear={solver}"));
        let even = scene.set("solver.stability=warn").on(1);
        let tilted = scene.set(FOLLOW).on(1);
        let words = the_bifurcation(&tilted);
        assert!(words.contains("tilting of interface joint"), "{words}");
        assert!(words.contains("its mirror image"), "{words}");
        assert!(tilted.told("instabilities").is_empty());
        let [after, before] = energies(&words);
        assert!((before - potential_energy(&even)).abs() <= 1e-8 * before, "{words}");
        assert!((after - potential_energy(&tilted)).abs() <= 1e-8 * before, "{words}");
        assert!(after < before - 1.0, "{words}");
        let damage = |run: &Run, of: &str| run.column(&format!("joint.damage.{of}"))[0];
        assert!(damage(&even, "max") - damage(&even, "min") < 1e-8);
        assert!(damage(&tilted, "max") - damage(&tilted, "min") > 0.9);
        for ranks in ranks {
            let run = scene.set(FOLLOW).on(*ranks);
            tilted.assert_same(&run, 1e-8);
            assert_eq!(the_bifurcation(&run), words);
        }
        // The same branch whatever the solver.
        tilted.assert_same(&scene.set("solver.linear=hypre").set(FOLLOW).on(2), 1e-8);
    }
}

/// The branch is left where it forks, right after the peak at 0.9938, and then kept: it is the one
/// that a step far past the peak is followed to.
#[test]
fn a_branch_is_kept_from_instant_to_instant() {
    let traction = |run: &Run| run.column("joint.normal_traction.mean");
    let scene = column(32).set(FOLLOW);
    let path = scene.set("time.instants=[0.9, 0.994, 0.995, 0.997, 1]").on(2);
    assert!(the_bifurcation(&path).contains("at time 0.994"), "{}", path.label);
    assert!(path.told("instabilities").is_empty());
    let kept = traction(&path);
    assert!(kept[1] < STRENGTH && kept[1..].windows(2).all(|pair| pair[1] < pair[0]), "{kept:?}");
    let far = traction(&scene.on(1))[0];
    assert!((kept[4] - far).abs() <= 1e-8 * far, "{kept:?} {far}");
}

/// The path of the imperfect column, in small steps, ends where the perfect one is followed to.
#[test]
fn an_imperfection_selects_the_side_that_tilts() {
    let traction = |run: &Run| run.column("joint.normal_traction.mean")[0];
    let perfect = traction(&column(32).set(FOLLOW).on(1));
    for size in [1e-3, 1e-4] {
        for (side, place) in [("y", "(0, 1, 4.2)"), ("(1-y)", "(0, 0, 4.2)")] {
            let formula = format!("{{formula: \"1-{size}*{side}\"}}");
            let scene = column(32).set(&imperfection("joint", &formula));
            let followed = scene.set(FOLLOW).on(1);
            let words = the_bifurcation(&followed);
            assert!(words.contains(place) && words.contains("there is another"), "{words}");
            let error = (traction(&followed) - perfect).abs();
            assert!(error <= size * perfect, "{}: {error}", followed.label);
            // The peak is at 0.994; steps are halved ten times between instants.
            let path = scene.set("time.instants=[0.99, 1]").in_any_steps().on(1);
            assert!(path.told("instabilities").is_empty(), "{}", path.label);
            for name in ["joint.normal_traction.mean", "joint.normal_jump.max", "energy.elastic"] {
                let (one, other) = (path.column(name)[1], followed.column(name)[0]);
                assert!((one - other).abs() <= 1e-8 * one.abs(), "{name}: {one} {other}");
            }
        }
    }
}

/// A factor of 0.8 is 0.8 times the strength and the fracture energy, wherever the law counts: in
/// steps with unloading and rupture, and along a path.
#[test]
fn a_factor_is_that_of_strength_and_energy() {
    let case = Scene::shipped("mixed_mode/case.yaml").set("expect=[]");
    let path = Scene::shipped("snap_back/column_20m.yaml").set("expect=[]");
    let dissipation = path.set("control={dissipation: {of: joint, step: 0.25}}");
    for scene in [case, path, dissipation] {
        let law = &scene.on(1).report["case"]["interfaces"][0]["law"]["linear_softening"];
        let scaled = |key: &str| 0.8 * law[key].as_f64().expect("a parameter");
        let weak = |key: &str| format!("interfaces.0.law.linear_softening.{key}={:e}", scaled(key));
        let weak = scene.set(&weak("strength")).set(&weak("fracture_energy"));
        let run = scene.set(&imperfection("joint", "0.8")).on(2);
        weak.on(1).assert_same(&run, 1e-10);
    }
}

/// Along a path the dissipated part is that of the energy of rupture with its factor.
#[test]
fn a_path_dissipates_the_energy_with_its_factor() {
    let scene = Scene::shipped("snap_back/column_20m.yaml")
        .set("expect=[]")
        .set("control={dissipation: {of: joint, step: 0.25}}")
        .set(&imperfection("joint", "{formula: \"1-0.2*x\"}"))
        .in_any_steps();
    let run = scene.on(2);
    let parts = run.column("time");
    let energy: Vec<f64> = parts.iter().map(|part| 0.9 * 900.0 * part).collect();
    assert_near(&run, "energy.dissipated", &energy, 900.0);
    assert_eq!(parts.len(), 5);
}
