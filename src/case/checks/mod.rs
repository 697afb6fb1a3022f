//! From the sections of the file to the checked case: the rules that span several keys.

mod checker;
mod control;
mod flow;
mod fluid;
mod initial;
mod limits;
mod loads;
mod planes;
mod results;
mod size;
mod supports;

pub use control::{Control, ControlKind};
pub use flow::{FlowSpec, PhysicsDecision};
pub use initial::Imperfection;
pub use limits::Every;
pub use planes::CLOSEST_PLANES;
pub use results::InterfaceQuantity;

use std::path::Path;

pub(super) use checker::Checker;
use control::Instants;

use crate::case::sections::file::{CaseFile, MaterialSection, Physics};
use crate::case::{
    BoundarySpec, Case, Cells, Form, InterfaceSpec, LawSpec, Linear, Material, MeshSpec,
    SolverSpec, Stability,
};
use crate::error::{Result, number_text};
use crate::input::problems::shortened;
use crate::petsc::refused_option;

/// Name of the field files of the bodies.
pub const BULK: &str = "bulk";

/// Lengths (m) whose volumes and stiffnesses are numbers that a computer has.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-50..=1e50;

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
}

impl Checker<'_> {
    /// Checks everything and builds the case.
    ///
    /// # Errors
    /// All mistakes, one line each.
    pub fn case(mut self, mut file: CaseFile, path: &Path) -> Result<Case> {
        let mesh = self.mesh(&file);
        let materials = self.materials(&file, &mesh);
        let interfaces = self.interfaces(&file, &mesh);
        let boundary = self.boundary(&file);
        let body_force = self.body_force(&file);
        let imperfections = self.imperfections(&file, &interfaces);
        let instants = self.time(&file);
        self.solver(&file.solver);
        let (control, Instants { times: time, start }) = self.control(&file, &interfaces, instants);
        self.films(&mesh, &materials, &interfaces);
        let (physics, flow, pressure_is_load) =
            self.physics(&file, &materials, &interfaces, &boundary);
        if self.sound(&["mesh", "materials", "interfaces"]) {
            self.cells(&file, &mesh, &materials, &interfaces, flow.is_some());
        }
        if self.sound(&["boundary", "time"]) {
            self.agreement(&boundary, &time);
        }
        self.held(&mesh, &interfaces, &boundary);
        write_out(&mut file, path, physics);
        let gravity = self.by_axis(file.gravity.as_deref().unwrap_or_default());
        let (checkpoint, wall) = self.limits(&file);
        let output = self.output(&file, &time, checkpoint);
        let probes = self.probes(&file, &mesh, &interfaces);
        let mut case = Case {
            title: file.title.clone().unwrap_or_default(),
            dim: self.dim,
            mesh,
            materials,
            interfaces,
            boundary,
            body_force,
            gravity,
            imperfections,
            physics,
            flow,
            pressure_is_load,
            time,
            start,
            control,
            solver: file.solver.clone(),
            reduce: file.reduce,
            output,
            wall,
            probes,
            expect: Vec::new(),
            left_out: std::mem::take(&mut self.left_out),
            file,
        };
        self.history(&case);
        case.expect = self.expectations(&case);
        if self.problems.is_empty() { Ok(case) } else { Err(self.problems.into_error()) }
    }

    /// Refuses bodies that nothing holds.
    fn held(&mut self, mesh: &MeshSpec, interfaces: &[InterfaceSpec], boundary: &[BoundarySpec]) {
        if self.sound(&["mesh", "interfaces", "boundary"]) && self.problems.is_empty() {
            let holds = supports::holds(interfaces);
            for reason in supports::free_motions(mesh, interfaces, boundary, self.dim, &holds) {
                self.add("boundary", format!("leaves a body free: {reason}"));
            }
        }
    }

    fn mesh(&mut self, file: &CaseFile) -> MeshSpec {
        let section = &file.mesh;
        if section.file.is_some() {
            self.add("mesh.file", LATER);
        }
        let nothing = MeshSpec {
            size: vec![1.0; 2],
            cells: Cells::Uniform([1; 3]),
            orders: vec![1],
            formulation: section.formulation,
            refine: section.refine,
        };
        let Some(column) = &section.column else {
            if section.file.is_none() {
                self.add("mesh", "needs a column");
            }
            self.broken.insert("mesh".to_owned());
            return nothing;
        };
        self.dim = column.size.len();
        for (index, length) in column.size.iter().enumerate() {
            let path = format!("mesh.column.size.{index}");
            if *length <= 0.0 {
                self.add(&path, format!("must be positive, got {}", number_text(*length)));
                self.broken.insert("mesh".to_owned());
            } else if !LENGTHS.contains(length) {
                let (least, most) = (LENGTHS.start(), LENGTHS.end());
                let got = number_text(*length);
                self.add(&path, format!("must be between {least:e} and {most:e} m, got {got}"));
                self.broken.insert("mesh".to_owned());
            }
        }
        let cells = match (&column.cells, &column.bodies) {
            (Some(cells), None) => Cells::Uniform(self.grid("mesh.column.cells", cells)),
            (None, Some(bodies)) => {
                let grids = bodies.iter().enumerate().map(|(index, body)| {
                    self.grid(&format!("mesh.column.bodies.{index}.cells"), &body.cells)
                });
                Cells::Bodies(grids.collect())
            }
            (both, _) => {
                let what = if both.is_some() { "has both" } else { "needs" };
                let word = if both.is_some() { "and" } else { "or" };
                self.add("mesh.column", format!("{what} cells {word} bodies; give one of them"));
                self.broken.insert("mesh".to_owned());
                return nothing;
            }
        };
        let order = |given: Option<u32>| given.unwrap_or(section.order) as usize;
        let orders = match &column.bodies {
            Some(bodies) => bodies.iter().map(|body| order(body.order)).collect(),
            None => vec![order(None)],
        };
        let (formulation, refine) = (section.formulation, section.refine);
        MeshSpec { size: column.size.clone(), cells, orders, formulation, refine }
    }

    fn grid(&mut self, path: &str, cells: &[u64]) -> [usize; 3] {
        let count = |index: usize| usize::try_from(cells[index]).unwrap_or(usize::MAX);
        match (self.dim, cells.len()) {
            (2, 2) => [count(0), 1, count(1)],
            (3, 3) => [count(0), count(1), count(2)],
            (dim, length) => {
                self.add(path, format!("must have {dim} entries as size has, got {length}"));
                self.broken.insert("mesh".to_owned());
                [1; 3]
            }
        }
    }

    fn materials(&mut self, file: &CaseFile, mesh: &MeshSpec) -> Vec<Material> {
        for (name, section) in &file.materials {
            let path = format!("materials.{name}");
            self.name(&path, name);
            self.material(&path, name, section);
        }
        let mut materials: Vec<Material> = file
            .materials
            .iter()
            .map(|(name, section)| Material {
                name: name.clone(),
                z: section.z,
                young_modulus: section.elastic.young_modulus,
                poisson_ratio: section.elastic.poisson_ratio,
                porous: section.porous.clone(),
            })
            .collect();
        let bottom = |material: &Material| material.z.map_or(f64::NEG_INFINITY, |z| z[0]);
        materials.sort_by(|a, b| bottom(a).total_cmp(&bottom(b)));
        if self.sound(&["mesh", "materials"]) {
            self.layers(&materials, mesh.height());
        }
        materials
    }

    fn material(&mut self, path: &str, name: &str, section: &MaterialSection) {
        match section.elastic.thermal_expansion {
            Some(expansion) if expansion != 0.0 => self.add(
                &format!("{path}.elastic.thermal_expansion"),
                format!("must be 0 (thermal strain {LATER}), got {}", number_text(expansion)),
            ),
            Some(_) => self
                .left_out
                .push(format!("Thermal strain is left out: the thermal expansion of {name} is 0.")),
            None => {}
        }
        let Some(porous) = &section.porous else { return };
        if porous.biot < porous.porosity {
            let reason =
                format!("must be at least the porosity {}, got {}", porous.porosity, porous.biot);
            self.add(&format!("{path}.porous.biot"), reason);
        }
    }

    fn interfaces(&mut self, file: &CaseFile, mesh: &MeshSpec) -> Vec<InterfaceSpec> {
        let height = self.sound(&["mesh"]).then(|| mesh.height());
        let mut names: Vec<&str> = Vec::new();
        let mut below: Option<f64> = None;
        let mut interfaces = Vec::new();
        for (index, section) in file.interfaces.iter().enumerate() {
            let path = format!("interfaces.{index}");
            self.name(&format!("{path}.name"), &section.name);
            self.file_name(&format!("{path}.name"), &section.name, &mut names);
            let z = section.z;
            if let Some(height) = height.filter(|height| !(z > 0.0 && z < *height)) {
                let [height, z] = [height, z].map(number_text);
                let reason = format!("must lie inside the column, in (0, {height}), got {z}");
                self.add(&format!("{path}.z"), reason);
            }
            if let Some(below) = below.filter(|below| z <= *below) {
                let reason = format!("must be above the interface before it at {below}, got {z}");
                self.add(&format!("{path}.z"), reason);
            }
            if let Some(height) = height {
                self.distance(&format!("{path}.z"), z, below, height);
            }
            below = Some(z);
            self.law(&format!("{path}.law"), &section.law);
            let mut interface = InterfaceSpec {
                name: section.name.clone(),
                z,
                law: section.law.clone(),
                secondary: section.secondary,
                fluid_pressure: None,
                connected: false,
                film: None,
            };
            if let Some(fluid) = &section.fluid {
                self.fluid(&format!("{path}.fluid"), fluid, &mut interface);
            }
            interfaces.push(interface);
        }
        interfaces
    }

    fn law(&mut self, path: &str, law: &LawSpec) {
        for problem in law.law().check() {
            let (key, reason) = problem.split_once(' ').unwrap_or((problem.as_str(), ""));
            self.add(&format!("{path}.{}.{key}", law.name()), reason);
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
        match components {
            [x, z] if self.dim == 2 => [*x, 0.0, *z],
            [x, y, z] => [*x, *y, *z],
            _ => [0.0; 3],
        }
    }

    /// The name of an interface, which its field files bear beside those of the `others`.
    fn file_name<'n>(&mut self, path: &str, name: &'n str, others: &mut Vec<&'n str>) {
        let same = |other: &&&str| other.eq_ignore_ascii_case(name);
        if BULK.eq_ignore_ascii_case(name) {
            self.add(path, format!("cannot be `{name}`: {BULK} is the name of the field files"));
        } else if let Some(other) = others.iter().find(same) {
            let reason = if *other == name {
                format!("`{name}` is taken")
            } else {
                format!(
                    "`{name}` is `{other}` but for capital letters, and their field files would be one \
                     where the file system does not tell them apart"
                )
            };
            self.add(path, reason);
        }
        others.push(name);
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
