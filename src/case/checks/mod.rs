//! From the sections of the file to the checked case: the rules that span several keys.

mod accuracy;
mod checker;
mod control;
mod flow;
mod fluid;
mod grading;
mod initial;
mod interface_initial;
mod interfaces;
mod limits;
mod loads;
mod materials;
mod mesh;
mod planes;
mod results;
mod rigid;
mod size;
mod stress;
mod supports;

pub use control::{Control, ControlKind};
pub use flow::{FlowSpec, PhysicsDecision};
pub use initial::Imperfection;
pub use interface_initial::NodeStart;
pub use limits::Every;
pub use planes::CLOSEST_PLANES;
pub use results::InterfaceQuantity;
pub use stress::{AtRest, StressSpec};

use std::path::Path;

pub(super) use checker::Checker;
use control::Instants;

use crate::case::sections::file::{CaseFile, Physics};
use crate::case::{
    BoundarySpec, Case, Form, InterfaceSpec, Linear, Material, MeshSpec, Search, SolverSpec,
    Stability,
};
use crate::error::Result;
use crate::input::problems::shortened;
use crate::petsc::refused_option;

/// Name of the field files of the bodies.
pub const BULK: &str = "bulk";

/// Longest name of an interface, a material or a probe: file systems end names at 255 bytes, of
/// which field files need some for number, kind and the mark of a temporary file.
const LONGEST_NAME: usize = 200;

/// What is said of everything that the contract plans and the program cannot do yet.
pub(super) const LATER: &str = "is not yet available";

/// Writes out the defaults that follow from the name of the file, and what was decided.
fn write_out(file: &mut CaseFile, path: &Path, physics: PhysicsDecision) {
    let stem = path.file_stem().map_or("case".into(), |stem| stem.to_string_lossy());
    file.output.directory.get_or_insert_with(|| format!("results/{stem}"));
    file.title.get_or_insert_with(|| stem.into_owned());
    file.physics = match physics {
        PhysicsDecision::Mechanics => Physics::Mechanics,
        PhysicsDecision::HydroMechanics => Physics::HydroMechanics,
    };
    if file.mesh.file.is_some() {
        file.mesh.scale.get_or_insert(1.0);
    } else {
        file.mesh.order.get_or_insert(if file.accuracy.is_some() { 2 } else { 1 });
    }
}

impl Checker<'_> {
    /// Checks everything and builds the case.
    ///
    /// # Errors
    /// All mistakes, one line each.
    pub fn case(mut self, mut file: CaseFile, path: &Path) -> Result<Case> {
        let mesh = self.mesh(&file, path);
        let materials = self.materials(&file, &mesh);
        let interfaces = self.interfaces(&file, &mesh);
        let boundary = self.boundary(&file);
        let surfaces = self.surfaces(&boundary);
        let imperfections = self.imperfections(&file, &interfaces);
        let instants = self.time(&file);
        self.solver(&file.solver);
        let (control, Instants { times: time, start }) = self.control(&file, &interfaces, instants);
        let (physics, flow, pressure_is_load) =
            self.physics(&file, &materials, &interfaces, &boundary);
        if self.sound(&["boundary", "time"]) {
            self.agreement(&boundary, &time);
        }
        if mesh.column().is_some() {
            self.boxes(&file, &mesh, &materials, &interfaces, flow.is_some());
            self.held(&mesh, &interfaces, &boundary);
        }
        let initial_stress = self.initial_stress(&file, &materials);
        write_out(&mut file, path, physics);
        let (checkpoint, wall) = self.limits(&file);
        let output = self.output(&file, &time, checkpoint);
        let probes = self.probes(&file, &mesh, &interfaces);
        let mut case = Case {
            title: file.title.clone().unwrap_or_default(),
            dim: self.dim,
            axes: self.axes,
            knows_dimension: self.knows_dimension,
            surfaces,
            supported: [0, 1].map(|kind| self.supported_in_stages(kind)),
            stages: Vec::new(),
            mesh,
            materials,
            interfaces,
            boundary,
            body_force: self.body_force(&file),
            gravity: self.by_axis(file.gravity.as_deref().unwrap_or_default()),
            imperfections,
            initial_stress,
            physics,
            flow,
            pressure_is_load,
            time,
            start,
            control,
            solver: file.solver.clone(),
            reduce: file.reduce,
            search: Search::default(),
            output,
            wall,
            probes,
            expect: Vec::new(),
            left_out: std::mem::take(&mut self.left_out),
            file,
        };
        case.expect = self.wanted(&case);
        if self.problems.is_empty() { Ok(case) } else { Err(self.problems.into_error()) }
    }

    /// What lies beside the interfaces of a column, and how many cells it has.
    fn boxes(
        &mut self,
        file: &CaseFile,
        mesh: &MeshSpec,
        materials: &[Material],
        interfaces: &[InterfaceSpec],
        flow: bool,
    ) {
        let Some(column) = mesh.column() else { return };
        if self.sound(&["mesh", "materials", "interfaces"]) {
            self.grading(file, column, materials, interfaces);
            self.films(column, materials, interfaces);
            self.cells(column, mesh.refine, materials, interfaces, flow);
        }
    }

    /// Refuses bodies of a column that nothing holds.
    fn held(&mut self, mesh: &MeshSpec, interfaces: &[InterfaceSpec], boundary: &[BoundarySpec]) {
        let Some(column) = mesh.column() else { return };
        if self.sound(&["mesh", "interfaces", "boundary"]) && self.problems.is_empty() {
            let (holds, presses) = (supports::holds(interfaces), supports::presses(interfaces));
            for reason in supports::free_motions(column, interfaces, boundary, &holds, &presses) {
                self.add("boundary", format!("leaves a body free: {reason}"));
            }
        }
    }

    fn time(&mut self, file: &CaseFile) -> Instants {
        let time = &file.time;
        let mut before = (time.start, "start");
        for (index, instant) in time.instants.iter().enumerate() {
            if *instant <= before.0 {
                let reason =
                    format!("must be above the {} at {}, got {instant}", before.1, before.0);
                self.add(&format!("time.instants.{index}"), reason);
            }
            before = (*instant, "instant before it");
        }
        Instants { start: time.start, times: time.instants.clone() }
    }

    fn solver(&mut self, solver: &SolverSpec) {
        if solver.form == Form::SaddlePoint
            && !matches!(solver.linear, Linear::Auto | Linear::Mumps)
        {
            self.add("solver.form", "saddle_point needs linear: mumps or auto");
        }
        if solver.form == Form::SaddlePoint
            && matches!(solver.stability, Stability::Warn | Stability::Follow | Stability::Stop)
        {
            self.add("solver.stability", "needs form: condensed, whose tangent is symmetric");
        }
        let options = solver.petsc_options.trim();
        if let Some(word) = refused_option(options.split_whitespace()) {
            let reason = format!("`{word}` would run or read something other than the case");
            self.add("solver.petsc_options", reason);
        }
        if !options.is_empty() && !options.starts_with('-') {
            let reason = format!("must be written as `-name value -name value`, got `{options}`");
            self.add("solver.petsc_options", reason);
        }
    }

    /// Components along x, y, z.
    fn by_axis(&self, components: &[f64]) -> [f64; 3] {
        match *components {
            [x, y] if self.is_of_file => [x, y, 0.0],
            [x, z] => [x, 0.0, z],
            [x, y, z] => [x, y, z],
            _ => [0.0; 3],
        }
    }

    /// Names become columns and files.
    pub fn name(&mut self, path: &str, name: &str) {
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(allowed) {
            let reason =
                format!("must be made of letters, digits, _ and -, got `{}`", shortened(name));
            self.add(path, reason);
        } else if name.len() > LONGEST_NAME {
            let reason = format!(
                "has {} characters; names of files and columns may have up to {LONGEST_NAME}",
                name.len()
            );
            self.add(path, reason);
        }
    }
}
