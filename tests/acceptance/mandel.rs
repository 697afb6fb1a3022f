//! Mandel's problem: the pressure rises before it falls.

#![allow(clippy::print_stdout)] // the figures, with --nocapture

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use column_hpc::case::{Case, read_text};

use crate::scene::Scene;

/// Force on a quarter of the slab (N/m), half its width and half its height (m).
const FORCE: f64 = 1.0e4;
const WIDTH: f64 = 1.0;
const HEIGHT: f64 = 0.5;

/// The series of J. Mandel, as A. Cheng and E. Detournay write them (Int. J. Numer. Anal. Methods
/// Geomech. 12, 1988).
struct Series {
    /// Shear modulus (Pa).
    shear: f64,
    /// Drained and undrained Poisson's ratio.
    drained: f64,
    undrained: f64,
    /// Pressure at the start (Pa).
    initial: f64,
    /// Diffusivity over the square of the half width (1/s).
    rate: f64,
    roots: Vec<f64>,
}

impl Series {
    fn new(case: &Case) -> Self {
        let rock = &case.materials[0];
        let porous = rock.porous.as_ref().expect("porous data");
        let (e, nu, b, phi) =
            (rock.young_modulus, rock.poisson_ratio, porous.biot, porous.porosity);
        let (shear, bulk) = (e / (2.0 * (1.0 + nu)), e / (3.0 * (1.0 - 2.0 * nu)));
        let storage = phi * porous.fluid_compressibility + (b - phi) * (1.0 - b) / bulk;
        let skempton = b / (storage * bulk + b * b);
        let part = b * skempton * (1.0 - 2.0 * nu);
        let undrained = (3.0 * nu + part) / (3.0 - part);
        let diffusivity =
            porous.permeability / porous.viscosity / (storage + b * b / (bulk + 4.0 / 3.0 * shear));
        let slope = (1.0 - nu) / (undrained - nu);
        // tan alpha = slope alpha, slope > 1: one root in each [n pi, (n + 1/2) pi).
        let root = |n: usize| {
            let start = n as f64 * PI;
            let (mut low, mut high) = (start + if n == 0 { 0.1 } else { 0.0 }, start + FRAC_PI_2);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let (sin, cos) = (middle - start).sin_cos();
                if sin < slope * middle * cos { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        Self {
            shear,
            drained: nu,
            undrained,
            initial: FORCE * skempton * (1.0 + undrained) / (3.0 * WIDTH),
            rate: diffusivity / (WIDTH * WIDTH),
            // Times from 1e-4 of the diffusion time on need so many.
            roots: (0..100).map(root).collect(),
        }
    }

    fn sum(&self, time: f64, term: impl Fn(f64, f64, f64) -> f64) -> f64 {
        let terms = self.roots.iter().map(|alpha| {
            let (sin, cos) = alpha.sin_cos();
            term(*alpha, sin, cos) / (alpha - sin * cos) * (-alpha * alpha * self.rate * time).exp()
        });
        terms.sum()
    }

    /// Pressure at a distance from the middle.
    fn pressure(&self, x: f64, time: f64) -> f64 {
        let term = |alpha: f64, sin: f64, cos: f64| sin * ((alpha * x / WIDTH).cos() - cos);
        2.0 * self.initial * self.sum(time, term)
    }

    /// Displacement of the platen; at the start that of the undrained slab.
    fn platen(&self, time: f64) -> f64 {
        let strain = FORCE / (self.shear * WIDTH);
        if time == 0.0 {
            return -0.5 * strain * (1.0 - self.undrained) * HEIGHT;
        }
        let sum = self.sum(time, |_, sin, cos| sin * cos);
        strain * (-0.5 * (1.0 - self.drained) + (1.0 - self.undrained) * sum) * HEIGHT
    }

    /// Displacement of the drained side.
    fn side(&self, time: f64) -> f64 {
        let sum = self.sum(time, |_, sin, cos| sin * cos);
        FORCE / self.shear * (0.5 * self.drained + (1.0 - self.undrained) * sum)
    }
}

#[test]
fn the_numbers_of_the_case_are_those_of_the_series() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/mandel/case.yaml");
    let case = Case::read(&read_text(&file).expect("a case"), &file, &[]).expect("a good case");
    let series = Series::new(&case);
    let close = |value: f64, exact: f64| {
        assert!((value - exact).abs() <= 1e-8 * exact.abs(), "{value:e}, not {exact:e}");
    };
    let force = case.boundary[3].rigid.as_ref().and_then(|platen| platen.force[2].as_ref());
    assert_eq!(force.map(|force| force.at([0.0; 3], 1.0)), Some(-FORCE));
    let flow = case.flow.as_ref().expect("flow");
    close(flow.initial.at([0.0; 3], 0.0), series.initial);
    let mut above = 0;
    for expectation in &case.expect {
        let exact = match expectation.quantity.as_str() {
            "centre.pressure" => series.pressure(0.0, expectation.at),
            "half.pressure" => series.pressure(0.5, expectation.at),
            "top.reaction_z" => -FORCE,
            "top.displacement_z" => series.platen(expectation.at),
            other => panic!("{other}"),
        };
        close(expectation.equals, exact);
        above += usize::from(exact > 1.03 * series.initial);
    }
    assert!(above >= 4, "{above} pressures above the initial one");

    // Also where the platen meets the undeformed slab in the first, short step.
    for (ranks, start) in [(1, "true"), (3, "false")] {
        let scene = Scene::shipped("mandel/case.yaml").set(&format!("initial.equilibrium={start}"));
        let scene =
            if start == "true" { scene } else { scene.set("initial.pressure=0").in_any_steps() };
        let run = scene.on(ranks);
        let mut worst = [0.0_f64; 5];
        for (name, number, exact) in [
            ("centre.pressure", 0, (&|t| series.pressure(0.0, t)) as &dyn Fn(f64) -> f64),
            ("half.pressure", 1, &|t| series.pressure(0.5, t)),
            ("top.reaction_z", 2, &|_| -FORCE),
            ("corner.displacement_x", 3, &|t| series.side(t)),
            ("top.displacement_z", 4, &|t| series.platen(t)),
        ] {
            for (time, value) in case.time.iter().zip(run.column(name)) {
                worst[number] = worst[number].max((value / exact(*time) - 1.0).abs());
            }
        }
        let peak = run.column("centre.pressure").into_iter().fold(0.0, f64::max);
        println!("{}: peak {} of the initial, {worst:?}", run.label, peak / series.initial);
        assert!(peak > 1.07 * series.initial, "{}: {peak}", run.label);
        assert!(worst.iter().all(|worst| *worst <= 5e-3), "{}: {worst:?}", run.label);
        assert!(worst[2] <= 1e-9, "{}: {worst:?}", run.label);
    }
}
