//! Reading results: the history, the report and the fields of an output directory.
//!
//! Opens the directory that it is given, or that of a run which it makes first: a block that is
//! lifted more at its right side than at its left. Prints where each interface is open widest.
//!
//! `cargo run --release --example results -- [DIRECTORY]`, or under `mpirun -n 2`.

#![allow(clippy::print_stdout)] // what the example shows

use std::path::Path;

use column_hpc::case::Case;
use column_hpc::case::sections::{
    BoundarySection, CaseFile, Components, InterfaceSection, MaterialSection, MeshSection, Surface,
    TimeSection,
};
use column_hpc::error::Result;
use column_hpc::law::LinearSoftening;
use column_hpc::results::Directory;
use column_hpc::run::{self, Run};
use column_hpc::runtime::Runtime;

/// The run whose results are read where none are given.
fn make(runtime: &Runtime, directory: &Path) -> Result<()> {
    let law = LinearSoftening::new(1.0e6, 900.0);
    let case = Case::build(
        CaseFile::new(
            MeshSection::column([1.0, 2.0], [4, 8]),
            TimeSection::instants([0.1, 0.3, 0.5]),
        )
        .title("A block")
        .material("rock", MaterialSection::elastic(5.0e9, 0.2))
        .interface(InterfaceSection::new("joint", 1.0, law))
        .boundary(BoundarySection::on(Surface::Bottom).displacement(Components::xz(0.0, 0.0)))
        .boundary(
            BoundarySection::on(Surface::Top).displacement(Components::xz(0.0, "5e-3*t*(1 + x)")),
        ),
    )?;
    Run::of(&case).output(directory).start(runtime)?;
    Ok(())
}

/// What one rank alone can read, or a program without MPI.
fn read(path: &Path) -> Result<()> {
    let directory = Directory::open(path)?;
    let (case, report, history) = (directory.case()?, directory.report()?, directory.history()?);
    let (unknowns, instants) = (&report["unknowns"], history.times().len());
    println!("{}: {unknowns} unknowns, {instants} instants", case.title);
    for interface in &case.interfaces {
        let series = directory.series(&interface.name)?;
        for time in series.times() {
            let fields = series.at(time)?;
            let (points, jump) = (fields.points()?, fields.at_points("jump")?);
            let openings = points.iter().zip(jump.rows()).map(|(point, jump)| (jump[2], point));
            let widest = openings.max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((opening, [x, y, z])) = widest else { continue };
            let told = history.at(time, &format!("{}.normal_jump.max", interface.name))?;
            println!(
                "{} at {time} s: widest {opening:.6e} m at ({x}, {y}, {z}) m; history {told:.6e} m",
                interface.name
            );
        }
    }
    Ok(())
}

fn results(runtime: &Runtime) -> Result<()> {
    let root = runtime.comm.is_root();
    if let Some(given) = std::env::args_os().nth(1) {
        return if root { read(Path::new(&given)) } else { Ok(()) };
    }
    let name = format!("column-hpc-example-{}", std::process::id());
    let directory = std::env::temp_dir().join(name); // that of rank 0 counts
    make(runtime, &directory)?;
    let told = if root { read(&directory) } else { Ok(()) };
    if root {
        let _ = std::fs::remove_dir_all(&directory);
    }
    told
}

/// Ends with status 2 where the directory holds no results.
pub fn main() -> std::process::ExitCode {
    run::program(results)
}
