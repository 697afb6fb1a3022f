//! A case as the rest of the program sees it.

use super::sections::file::CaseFile;
use super::{
    BoundarySpec, Control, Expectation, FlowSpec, Formulation, Imperfection, InterfaceSpec,
    Material, MeshSpec, OutputSpec, PhysicsDecision, Probe, Reduce, SolverSpec, StressSpec,
    Surface, SurfaceBit, Value,
};

/// A checked case.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Title.
    pub title: String,
    /// The column and its cells, or the mesh file.
    pub mesh: MeshSpec,
    /// Materials, in a column bottom to top.
    pub materials: Vec<Material>,
    /// Interfaces, in a column bottom to top.
    pub interfaces: Vec<InterfaceSpec>,
    /// What is prescribed on surfaces.
    pub boundary: Vec<BoundarySpec>,
    /// Body force along x, y, z in N/m3.
    pub body_force: [Value; 3],
    /// Gravity along x, y, z in m/s2.
    pub gravity: [f64; 3],
    /// What makes the structure imperfect.
    pub imperfections: Vec<Imperfection>,
    /// Stresses that are there before.
    pub initial_stress: Option<StressSpec>,
    /// What is computed.
    pub physics: PhysicsDecision,
    /// Flow in the pores, where it is computed.
    pub flow: Option<FlowSpec>,
    /// Whether the pore pressure is prescribed at every node and acts as a load, without flow.
    pub pressure_is_load: bool,
    /// The instants in s, strictly rising, after `start`.
    pub time: Vec<f64>,
    /// The time in s of the state at the start.
    pub start: f64,
    /// Path following.
    pub control: Option<Control>,
    /// How it is solved.
    pub solver: SolverSpec,
    /// Whether a smaller model may take its place.
    pub reduce: Reduce,
    /// What a search for accuracy asks of the run.
    pub search: Search,
    /// What is written.
    pub output: OutputSpec,
    /// Wall-clock time after which the run stops (s).
    pub wall: Option<f64>,
    /// Points whose displacement is recorded.
    pub probes: Vec<Probe>,
    /// Values that the results must have.
    pub expect: Vec<Expectation>,
    /// 2 or 3; that of a mesh file counts from [`Case::for_dimension`] on.
    pub dim: usize,
    /// The coordinate axes (0, 1, 2) of the displacement components.
    pub axes: &'static [usize],
    /// Whether `dim` and `axes` are those of the mesh.
    pub(super) knows_dimension: bool,
    /// The surfaces that may be asked for, each once; see [`Case::surfaces`].
    pub(super) surfaces: Vec<Surface>,
    /// The surfaces that have a prescribed displacement in some stage; none without stages.
    /// Then those of them that are platens in some stage.
    pub(super) supported: [Vec<Surface>; 2],
    /// The stages, in their order: what else is said here of supports, loads and materials is that
    /// of the first one.
    pub stages: Vec<Stage>,
    /// One sentence for each thing that the file describes and the model leaves out.
    pub left_out: Vec<String>,
    /// The sections it was made of, with defaults written out.
    pub(super) file: CaseFile,
}

/// What a search for accuracy asks of one of its runs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Search {
    /// Times between instants at which steps end (s).
    pub stops: Vec<f64>,
    /// Whether the run fails where no smaller model serves.
    pub needs_smaller: bool,
}

/// A part of the time, in which supports, loads, fluid and materials are the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// When it ends (s).
    pub until: f64,
    /// The case as it is in this stage: it starts where the one before ended, and has the instants
    /// of this one.
    pub case: Case,
}

/// Poisson's ratio from which on full integration is not taken.
const NEARLY_INCOMPRESSIBLE: f64 = 0.45;

impl Case {
    /// Error that one step may make, as a part: of the pressure over the largest so far, of
    /// tractions over the strength, of the work over the energy (`time.tolerance`). Local.
    pub fn step_tolerance(&self) -> Option<f64> {
        self.file.time.tolerance
    }

    /// The case as it is in each of its stages; itself where it has none.
    pub fn in_stages(&self) -> Vec<&Case> {
        if self.stages.is_empty() {
            return vec![self];
        }
        self.stages.iter().map(|stage| &stage.case).collect()
    }

    /// The surfaces in the order of their bits in the marks of nodes: the sides of a column, or the
    /// groups of a mesh file on which something is prescribed.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The place of a surface among [`Case::surfaces`]; beyond them where it is none of them.
    pub fn surface_bit(&self, surface: &Surface) -> SurfaceBit {
        if *surface == Surface::All {
            return SurfaceBit::All;
        }
        let place = self.surfaces.iter().position(|other| other == surface);
        SurfaceBit::Place(place.unwrap_or(usize::MAX))
    }

    /// In the mesh of a file, the place after those of [`Case::surfaces`] of the nodes on both lips
    /// of an interface whose pressure is imposed in the pores too.
    pub fn lips_bit(&self, interface: usize) -> Option<SurfaceBit> {
        let is_one = |i: &&InterfaceSpec| i.connected;
        self.mesh.file()?;
        let before = self.interfaces[..interface].iter().filter(is_one).count();
        let is_connected = self.interfaces[interface].connected;
        is_connected.then_some(SurfaceBit::Place(self.surfaces.len() + before))
    }

    /// Whether lips may slide with friction, which makes tangents unsymmetric.
    pub fn has_friction(&self) -> bool {
        self.interfaces.iter().any(InterfaceSpec::has_friction)
    }

    /// Whether the run starts from a state of equilibrium in the place of the undeformed one.
    pub fn starts_in_equilibrium(&self) -> bool {
        self.initial_stress.is_some() || self.flow.as_ref().is_some_and(|flow| flow.equilibrium)
    }

    /// The pore pressure at the start (Pa), where one acts on the skeleton.
    pub fn pressure_at_start(&self, point: [f64; 3]) -> Option<f64> {
        let of_all = |entry: &&BoundarySpec| entry.on == Surface::All && entry.pressure.is_some();
        let prescribed = || self.boundary.iter().find(of_all)?.pressure.as_ref();
        let value = match &self.flow {
            Some(flow) => &flow.initial,
            None if self.pressure_is_load => prescribed()?,
            None => return None,
        };
        // A later stage starts later.
        let start = self.initial_stress.as_ref().map_or(self.start, |stress| stress.start);
        Some(value.at(point, start))
    }

    /// Whether a pore pressure acts on the skeleton, with flow or known beforehand.
    pub fn has_pressure(&self) -> bool {
        self.flow.is_some() || self.pressure_is_load
    }

    /// Whether the cells of a material have the mean of the volumetric strain in place of its
    /// values.
    pub fn has_mean_dilatation(&self, material: &Material) -> bool {
        match self.mesh.formulation {
            Formulation::Auto => material.poisson_ratio > NEARLY_INCOMPRESSIBLE,
            Formulation::Full => false,
            Formulation::BBar => true,
        }
    }

    /// One sentence for each material whose cells are not fully integrated.
    pub fn formulations(&self) -> Vec<String> {
        let special = self.materials.iter().filter(|m| self.has_mean_dilatation(m));
        let words = |m: &Material| match self.mesh.formulation {
            Formulation::Auto => format!(
                "{}: B-bar, since full integration locks where poisson_ratio, {}, is above \
                 {NEARLY_INCOMPRESSIBLE}",
                m.name, m.poisson_ratio
            ),
            _ => format!("{}: B-bar, asked for", m.name),
        };
        special.map(words).collect()
    }
}
