//! A pressure that is switched on in an interface and spreads into rock that does not move.

#![allow(clippy::print_stdout)] // the figures, with --nocapture

use std::f64::consts::PI;
use std::path::Path;

use column_hpc::case::{Case, read_text};

use crate::scene::Scene;

/// Half the height of the column (m).
const LENGTH: f64 = 2.5;

/// The linear theory of a layer whose sides are at two pressures from the start (H. Carslaw, J.
/// Jaeger, Conduction of Heat in Solids, 1959, section 3.3).
struct Layer {
    /// Pressure in the interface (Pa).
    pressure: f64,
    /// What a volume stores per pressure (kg/m3/Pa).
    storage: f64,
    /// pi^2 c/L^2 (1/s).
    rate: f64,
}

impl Layer {
    fn new(case: &Case) -> Self {
        let porous = case.materials[0].porous.as_ref().expect("porous data");
        let storage = porous.porosity * porous.fluid_compressibility;
        let diffusivity = porous.permeability / porous.viscosity / storage;
        let pressure = case.interfaces[0].fluid_pressure.as_ref().expect("a fluid");
        Self {
            pressure: pressure.at([0.0; 3], 0.0),
            storage: storage * porous.fluid_density,
            rate: PI * PI * diffusivity / (LENGTH * LENGTH),
        }
    }

    fn sum(&self, time: f64, term: impl Fn(f64) -> f64) -> f64 {
        (1..100).map(f64::from).map(|n| term(n) * (-n * n * self.rate * time).exp()).sum()
    }

    fn at(&self, distance: f64, time: f64) -> f64 {
        let part = distance / LENGTH;
        let sum = self.sum(time, |n| 2.0 / (n * PI) * (n * PI * part).sin());
        self.pressure * (1.0 - part - sum)
    }

    /// What both halves have taken up (kg/m).
    fn stored(&self, time: f64) -> f64 {
        let odd = |n: f64| if n % 2.0 == 1.0 { 4.0 / (n * PI).powi(2) } else { 0.0 };
        2.0 * self.storage * self.pressure * LENGTH * (0.5 - self.sum(time, odd))
    }
}

/// The shipped case.
fn shipped() -> Case {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/wtnv147/transient.yaml");
    Case::read(&read_text(&file).expect("a case"), &file, &[]).expect("a good case")
}

#[test]
fn an_interface_under_pressure_feeds_both_sides() {
    let case = shipped();
    let layer = Layer::new(&case);
    let exact = |quantity: &str, time: f64| match quantity.strip_suffix(".pressure") {
        Some(name) => {
            let probe = case.probes.iter().find(|probe| probe.name == name).expect("a probe");
            layer.at((probe.at[2] - LENGTH).abs(), time)
        }
        None => layer.stored(time),
    };
    assert_eq!(case.expect.len(), 25);
    for expectation in &case.expect {
        let exact = exact(&expectation.quantity, expectation.at);
        assert!((expectation.equals - exact).abs() <= 1e-8 * exact, "{expectation:?}: {exact}");
    }
    for ranks in [2] {
        let run = Scene::shipped("wtnv147/transient.yaml").in_any_steps().on(ranks);
        for (number, time) in case.time.iter().enumerate() {
            let quantities =
                ["below.pressure", "above.pressure", "far_below.pressure", "far_above.pressure"];
            let error = |quantity| {
                let exact = exact(quantity, *time);
                (run.column(quantity)[number] / exact - 1.0).abs()
            };
            let errors = quantities.map(error);
            let list = errors.map(|error| format!("{error:.1e}")).join(" ");
            println!("{ranks} ranks, {time} s: {list}, stored {:.1e}", error("mass.stored"));
            assert!(errors.iter().chain([&error("mass.stored")]).all(|error| *error <= 1e-2));
        }
        let balance = ["mass.in", "mass.out", "mass.stored"].map(|name| run.column(name)[4]);
        let missing = balance[0] - balance[1] - balance[2];
        assert!(missing.abs() <= 1e-10 * balance[0], "{}: {missing}", run.label);
    }
}

/// Steps are as short as their error asks for along the shortest edge of cells of 1 m x 6 cm:
/// early, when steps as the longest edge would have them leave an error of 5e-3.
#[test]
fn the_tolerance_of_the_time_holds_in_slender_cells() {
    let run = Scene::shipped("wtnv147/transient.yaml")
        .set("mesh.column.cells=[1, 80]")
        .set("time={instants: [0.02], tolerance: 1.0e-4}")
        .set("expect=")
        .in_any_steps()
        .on(1);
    run.assert_column("below.pressure", &[Layer::new(&shipped()).at(0.5, 0.02)], 1e-3, 0.0);
}
