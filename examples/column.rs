//! A column from Rust: built in code, run in memory, compared with the closed form.
//!
//! A column of 5 m is pulled at its top until the joint at half its height is broken. In series
//! with the column, of stiffness K = E/height, a joint that softens on a line carries
//! (g - g_c)/(1/K - g_c/strength) at a displacement g, with g_c = 2 fracture_energy/strength.
//!
//! `cargo run --release --example column`, or under `mpirun -n 2`.

#![allow(clippy::print_stdout)] // what the example shows

use column_hpc::case::Case;
use column_hpc::case::sections::{
    BoundarySection, CaseFile, Components, InterfaceSection, MaterialSection, MeshSection, Surface,
    TimeSection,
};
use column_hpc::error::{Error, Result};
use column_hpc::law::LinearSoftening;
use column_hpc::run::{self, Run};
use column_hpc::runtime::Runtime;

const HEIGHT: f64 = 5.0; // m
const YOUNG_MODULUS: f64 = 5.8e9; // Pa
const STRENGTH: f64 = 1.1e6; // Pa
const FRACTURE_ENERGY: f64 = 900.0; // J/m2
const PULLED: f64 = 2.0e-3; // m, at time 1

/// The case, in the words of a case file.
fn case() -> Result<Case> {
    let pulled = Components::xyz(0.0, 0.0, [[0.0, 0.0], [1.0, PULLED]]);
    let instants: Vec<f64> = (1..=10).map(|i| f64::from(i) / 10.0).collect();
    let law = LinearSoftening::new(STRENGTH, FRACTURE_ENERGY);
    Case::build(
        CaseFile::new(
            MeshSection::column([1.0, 1.0, HEIGHT], [2, 2, 10]),
            TimeSection::instants(instants),
        )
        .title("A column from Rust")
        .material("rock", MaterialSection::elastic(YOUNG_MODULUS, 0.0))
        .interface(InterfaceSection::new("joint", HEIGHT / 2.0, law))
        .boundary(BoundarySection::on(Surface::Bottom).displacement(Components::xyz(0.0, 0.0, 0.0)))
        .boundary(BoundarySection::on(Surface::Top).displacement(pulled)),
    )
}

/// The traction (Pa) that grows from nothing to a displacement of the top (m).
fn closed_form(displacement: f64) -> f64 {
    let (stiffness, critical) = (YOUNG_MODULUS / HEIGHT, 2.0 * FRACTURE_ENERGY / STRENGTH);
    let elastic = stiffness * displacement;
    let softening = (displacement - critical) / (1.0 / stiffness - critical / STRENGTH);
    if elastic <= STRENGTH { elastic } else { softening.max(0.0) }
}

fn column(runtime: &Runtime) -> Result<()> {
    let results = Run::of(&case()?).start(runtime)?;
    let history = &results.history;
    let tractions = history.column("joint.normal_traction")?;
    let mut worst: f64 = 0.0;
    if runtime.comm.is_root() {
        println!("{:>6} {:>14} {:>14}", "time", "traction (Pa)", "exact (Pa)");
    }
    for (time, traction) in history.times().into_iter().zip(tractions) {
        let exact = closed_form(PULLED * time);
        worst = worst.max((traction - exact).abs() / STRENGTH);
        if runtime.comm.is_root() {
            println!("{time:>6.2} {traction:>14.3} {exact:>14.3}");
        }
    }
    if worst > 1.0e-9 {
        return Err(Error::Numerics(format!("off by {worst:.1e} of the strength")));
    }
    Ok(())
}

/// Ends with status 3 where the tractions are not those of the closed form.
pub fn main() -> std::process::ExitCode {
    run::program(column)
}
