//! A parameter sweep: many runs within one process, in memory.
//!
//! A block of 1 m x 2 m is pulled and bent until its joint is broken, for three strengths of the
//! joint on two meshes. Rupture takes the energy of the law, whatever the strength and the mesh.
//!
//! `cargo run --release --example sweep`, or under `mpirun -n 2`.

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

const FRACTURE_ENERGY: f64 = 900.0; // J/m2

/// A block whose top is lifted, at its right side twice as far as at its left.
fn block() -> CaseFile {
    let instants: Vec<f64> = (1..=20).map(|i| f64::from(i) / 20.0).collect();
    let law = LinearSoftening::new(1.0e6, FRACTURE_ENERGY);
    CaseFile::new(MeshSection::column([1.0, 2.0], [4, 8]), TimeSection::instants(instants))
        .material("rock", MaterialSection::elastic(5.0e9, 0.2))
        .interface(InterfaceSection::new("joint", 1.0, law))
        .boundary(BoundarySection::on(Surface::Bottom).displacement(Components::xz(0.0, 0.0)))
        .boundary(
            BoundarySection::on(Surface::Top).displacement(Components::xz(0.0, "5e-3*t*(1 + x)")),
        )
}

fn sweep(runtime: &Runtime) -> Result<()> {
    let (root, base) = (runtime.comm.is_root(), block());
    if root {
        println!("strength (Pa)  cells  unknowns  peak load (N/m)  dissipated (J/m)  corrections");
    }
    for strength in [0.5e6, 1.0e6, 1.5e6] {
        for refine in [0, 1] {
            let mut sections = base.clone();
            sections.interfaces[0].law = LinearSoftening::new(strength, FRACTURE_ENERGY).into();
            sections.mesh.refine = refine;
            let results = Run::of(&Case::build(sections)?).start(runtime)?;
            let (history, report) = (&results.history, &results.report);
            let peak = history.column("top.reaction_z")?.into_iter().fold(0.0, f64::max);
            let dissipated = history.at(1.0, "energy.dissipated")?;
            if root {
                let [cells, unknowns, corrections] =
                    ["cells", "unknowns", "newton_iterations"].map(|key| report[key].to_string());
                println!(
                    "{strength:>13.1e} {cells:>6} {unknowns:>9} {peak:>16.4e} \
                     {dissipated:>17.4} {corrections:>12}"
                );
            }
            if (dissipated - FRACTURE_ENERGY).abs() > 1.0e-6 * FRACTURE_ENERGY {
                return Err(Error::Numerics(format!("{dissipated} J/m are dissipated")));
            }
        }
    }
    Ok(())
}

/// Ends with status 3 where a rupture takes another energy than that of the law.
pub fn main() -> std::process::ExitCode {
    run::program(sweep)
}
