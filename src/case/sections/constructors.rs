//! Short constructors of the sections: what must be there is an argument, the rest is added.

use std::collections::BTreeMap;

use super::file::{
    BodySection, BoundarySection, CaseFile, ColumnSection, Components, ControlSection,
    DissipationSection, ElasticSection, ExpectSection, FieldsSection, FieldsWord, Groups,
    InterfaceSection, MaterialSection, MeshSection, OpeningSection, OutputSection, Physics,
    ProbeSection, TimeSection,
};
use super::quantity::{
    CheckpointSection, FluidSection, ImperfectionSection, InitialSection, InterfaceInitialSection,
    LimitsSection, Quantity, SpatialQuantity,
};
use super::{
    Formulation, Gap, GradingSection, Porous, Reduce, RigidSection, Side, SolverSpec, Surface,
};
use crate::law::LawSpec;

impl CaseFile {
    /// A case without materials, interfaces and loads, solved and written as usual.
    pub fn new(mesh: MeshSection, time: TimeSection) -> Self {
        Self {
            title: None,
            mesh,
            materials: BTreeMap::new(),
            interfaces: Vec::new(),
            boundary: Vec::new(),
            gravity: None,
            body_force: Components::default(),
            initial: None,
            time,
            stages: Vec::new(),
            physics: Physics::default(),
            control: None,
            solver: SolverSpec::default(),
            reduce: Reduce::default(),
            accuracy: None,
            output: OutputSection::default(),
            limits: None,
            probes: Vec::new(),
            expect: Vec::new(),
        }
    }
}

/// Methods that set a key to what is given.
macro_rules! setters {
    ($type:ident: $($key:ident = $given:ty => $value:expr, $words:literal;)+) => {
        impl $type {
            $(
                #[doc = $words]
                #[must_use]
                pub fn $key(mut self, $key: $given) -> Self {
                    self.$key = $value;
                    self
                }
            )+
        }
    };
}

setters! { CaseFile:
    title = impl Into<String> => Some(title.into()), "With a title.";
    gravity = impl Into<Vec<f64>> => Some(gravity.into()),
        "With gravity in m/s2, by component; acts on `density` of the materials.";
    body_force = Components => body_force, "With a body force in N/m3.";
    initial = InitialSection => Some(initial), "With a state at the start.";
    physics = Physics => physics, "With what is computed.";
    control = ControlSection => Some(control), "With path following.";
    solver = SolverSpec => solver, "With how it is solved.";
    reduce = Reduce => reduce, "With whether a smaller model may serve.";
    output = OutputSection => output, "With what is written.";
    limits = LimitsSection => Some(limits), "With limits of the run.";
}

impl CaseFile {
    /// With one more material, or another one in the place of that of the same name.
    #[must_use]
    pub fn material(mut self, name: impl Into<String>, material: MaterialSection) -> Self {
        self.materials.insert(name.into(), material);
        self
    }

    /// With one more interface, above those before.
    #[must_use]
    pub fn interface(mut self, interface: InterfaceSection) -> Self {
        self.interfaces.push(interface);
        self
    }

    /// With one more entry of what is prescribed on surfaces.
    #[must_use]
    pub fn boundary(mut self, entry: BoundarySection) -> Self {
        self.boundary.push(entry);
        self
    }

    /// With one more point that is recorded.
    #[must_use]
    pub fn probe(mut self, probe: ProbeSection) -> Self {
        self.probes.push(probe);
        self
    }

    /// With one more value that the results must have.
    #[must_use]
    pub fn expect(mut self, value: ExpectSection) -> Self {
        self.expect.push(value);
        self
    }
}

impl MeshSection {
    /// A column with lengths in m and cells along x, y, z, or along x, z in 2D.
    pub fn column(size: impl Into<Vec<f64>>, cells: impl Into<Vec<u64>>) -> Self {
        let (size, cells) = (size.into(), Some(cells.into()));
        Self::of(ColumnSection { size, cells, bodies: None, grading: None })
    }

    /// The same with cells of its own for each body between interfaces, bottom to top.
    pub fn bodies(size: impl Into<Vec<f64>>, bodies: impl Into<Vec<BodySection>>) -> Self {
        let (size, bodies) = (size.into(), Some(bodies.into()));
        Self::of(ColumnSection { size, cells: None, bodies, grading: None })
    }

    /// The mesh of a file of Gmsh or SALOME, by its path.
    pub fn file(path: impl Into<String>) -> Self {
        Self { file: Some(path.into()), ..Self::nothing() }
    }

    fn of(column: ColumnSection) -> Self {
        Self { column: Some(column), ..Self::nothing() }
    }

    fn nothing() -> Self {
        Self {
            column: None,
            file: None,
            scale: None,
            raise_order: None,
            order: None,
            formulation: Formulation::default(),
            refine: 0,
        }
    }
}

setters! { MeshSection:
    order = u32 => Some(order), "With cells of first or second order, in a column.";
    scale = f64 => Some(scale), "With the length in m of the unit of the file's coordinates.";
    raise_order = u32 => Some(raise_order), "With cells of a file raised to second order: 2.";
    formulation = Formulation => formulation, "With how the cells are integrated.";
    refine = u32 => refine, "With so many uniform refinements.";
}

impl MeshSection {
    /// With cells of a column that grow away from named places.
    #[must_use]
    pub fn grading(mut self, grading: GradingSection) -> Self {
        if let Some(column) = &mut self.column {
            column.grading = Some(grading);
        }
        self
    }
}

impl BodySection {
    /// A body with cells along x, y, z, or along x, z in 2D.
    pub fn cells(cells: impl Into<Vec<u64>>) -> Self {
        Self { cells: cells.into(), order: None }
    }
}

setters! { BodySection:
    order = u32 => Some(order), "With cells of first or second order, whatever `mesh.order` says.";
}

impl MaterialSection {
    /// An elastic material that fills the mesh: Young's modulus in Pa, Poisson's ratio.
    pub fn elastic(young_modulus: f64, poisson_ratio: f64) -> Self {
        let elastic =
            ElasticSection { young_modulus, poisson_ratio, density: None, thermal_expansion: None };
        Self { z: None, on: None, elastic, porous: None }
    }
}

setters! { MaterialSection:
    z = [f64; 2] => Some(z), "Between two heights in m of a column only.";
    on = impl Into<Groups> => Some(on.into()), "On groups of cells of a mesh file only.";
    porous = Porous => Some(porous), "With the data of a saturated porous medium.";
}

impl InterfaceSection {
    /// An interface at a height in m of a column.
    pub fn new(name: impl Into<String>, z: f64, law: impl Into<LawSpec>) -> Self {
        Self { z: Some(z), ..Self::nowhere(name.into(), law.into()) }
    }

    /// An interface on a group of facets inside a mesh file.
    pub fn on(name: impl Into<String>, group: impl Into<String>, law: impl Into<LawSpec>) -> Self {
        Self { on: Some(group.into()), ..Self::nowhere(name.into(), law.into()) }
    }

    /// An interface between two groups of facets of a mesh file, the lower side first.
    pub fn between(
        name: impl Into<String>,
        groups: [impl Into<String>; 2],
        law: impl Into<LawSpec>,
    ) -> Self {
        Self { between: Some(groups.map(Into::into)), ..Self::nowhere(name.into(), law.into()) }
    }

    fn nowhere(name: String, law: LawSpec) -> Self {
        let (z, on, between, gap, fluid) = (None, None, None, None, None);
        let (secondary, initial) = (None, None);
        Self { name, z, on, flip: false, between, gap, law, secondary, fluid, initial }
    }
}

setters! { InterfaceSection:
    flip = bool => flip, "With the normal of its group turned, or not.";
    gap = Gap => Some(gap), "With an initial gap of a contact as drawn, or closed.";
    secondary = Side => Some(secondary), "With multipliers on this side.";
    fluid = FluidSection => Some(fluid), "With fluid between the lips.";
    initial = InterfaceInitialSection => Some(initial), "With a state at the start.";
}

impl FluidSection {
    /// Fluid of an imposed pressure in Pa.
    pub fn pressure(pressure: impl Into<Quantity>) -> Self {
        Self { pressure: Some(pressure.into()), ..Self::default() }
    }

    /// Fluid that flows along the interface, into which mass is injected, in kg/m2/s.
    pub fn injection(injection: impl Into<Quantity>) -> Self {
        Self { flow: true, injection: Some(injection.into()), ..Self::default() }
    }
}

setters! { FluidSection:
    connected = bool => connected, "Whether the pore pressure at the lips equals the imposed one.";
}

setters! { InterfaceInitialSection:
    damage = impl Into<SpatialQuantity> => Some(damage.into()), "With a damage from 0 to 1.";
    gap = impl Into<SpatialQuantity> => Some(gap.into()), "With a distance of the lips in m.";
    aperture = impl Into<SpatialQuantity> => Some(aperture.into()),
        "With a hydraulic aperture of closed lips in m.";
}

impl BoundarySection {
    /// A surface on which nothing is prescribed yet: of a column, or a group by its name.
    pub fn on(on: impl Into<Surface>) -> Self {
        let (on, nothing) = (on.into(), Components::default);
        let (displacement, traction) = (nothing(), nothing());
        Self { on, displacement, traction, pressure: None, flux: None, rigid: None }
    }
}

setters! { BoundarySection:
    displacement = Components => displacement, "With displacements in m.";
    traction = Components => traction, "With a surface force in Pa.";
    pressure = impl Into<Quantity> => Some(pressure.into()), "With a pore pressure in Pa.";
    flux = impl Into<Quantity> => Some(flux.into()),
        "With a mass flux of the fluid in kg/m2/s, positive inwards.";
    rigid = RigidSection => Some(rigid), "As a platen, with one motion for all of it.";
}

impl Components {
    /// All three components.
    pub fn xyz(x: impl Into<Quantity>, y: impl Into<Quantity>, z: impl Into<Quantity>) -> Self {
        Self { x: Some(x.into()), y: Some(y.into()), z: Some(z.into()), normal: None }
    }

    /// Both components of a column in 2D.
    pub fn xz(x: impl Into<Quantity>, z: impl Into<Quantity>) -> Self {
        Self { x: Some(x.into()), z: Some(z.into()), ..Self::default() }
    }

    /// Both components of a mesh file in the plane z = 0.
    pub fn xy(x: impl Into<Quantity>, y: impl Into<Quantity>) -> Self {
        Self { x: Some(x.into()), y: Some(y.into()), ..Self::default() }
    }
}

setters! { Components:
    x = impl Into<Quantity> => Some(x.into()), "With a component along x.";
    y = impl Into<Quantity> => Some(y.into()), "With a component along y.";
    z = impl Into<Quantity> => Some(z.into()), "With a component along z.";
    normal = impl Into<Quantity> => Some(normal.into()),
        "With a component along the outward normal of the surface.";
}

impl From<&str> for Groups {
    fn from(name: &str) -> Self {
        Groups::One(name.to_owned())
    }
}

impl<const N: usize> From<[&str; N]> for Groups {
    fn from(names: [&str; N]) -> Self {
        Groups::Many(names.map(str::to_owned).to_vec())
    }
}

/// A surface of a column is `Surface::Bottom` and so on; this is a group of a mesh file.
impl From<&str> for Surface {
    fn from(name: &str) -> Self {
        Surface::Group(name.to_owned())
    }
}

impl ImperfectionSection {
    /// An imperfection of an interface: a factor, or a formula of one in x, y, z.
    pub fn new(interface: impl Into<String>, factor: impl Into<SpatialQuantity>) -> Self {
        Self { interface: interface.into(), factor: factor.into() }
    }
}

impl TimeSection {
    /// From 0 to these times in s, rising.
    pub fn instants(instants: impl Into<Vec<f64>>) -> Self {
        Self { instants: instants.into(), start: 0.0, theta: None, tolerance: None }
    }
}

setters! { TimeSection:
    start = f64 => start, "From this time in s.";
    theta = f64 => Some(theta), "With a weight of the end of each step of the flow.";
    tolerance = f64 => Some(tolerance),
        "With an error of the pore pressure that one step may make, over the largest so far.";
}

impl ControlSection {
    /// The mean normal jump of an interface is given, in m.
    pub fn opening(of: impl Into<String>, equals: impl Into<Quantity>) -> Self {
        ControlSection::Opening(OpeningSection { of: of.into(), equals: equals.into() })
    }

    /// Each step dissipates so much of the energy of an interface.
    pub fn dissipation(of: impl Into<String>, step: f64) -> Self {
        ControlSection::Dissipation(DissipationSection { of: of.into(), step })
    }
}

setters! { OutputSection:
    directory = impl Into<String> => Some(directory.into()), "Into this directory.";
    fields = impl Into<FieldsSection> => fields.into(), "With fields of these instants.";
    checkpoint = impl Into<String> => Some(CheckpointSection { every: checkpoint.into() }),
        "With a checkpoint every so often, as `10 min` or `5 instants`.";
}

impl From<FieldsWord> for FieldsSection {
    fn from(word: FieldsWord) -> Self {
        FieldsSection::Word(word)
    }
}

impl From<Vec<f64>> for FieldsSection {
    fn from(times: Vec<f64>) -> Self {
        FieldsSection::Times(times)
    }
}

impl LimitsSection {
    /// Ends before a wall-clock time is over, as `23:30:00` or `2 h`.
    pub fn wall(wall: impl Into<String>) -> Self {
        Self { wall: wall.into() }
    }
}

impl ProbeSection {
    /// A point in m: x, y, z, or in 2D x, z in a column and x, y on a mesh file.
    pub fn new(name: impl Into<String>, at: impl Into<Vec<f64>>) -> Self {
        Self { name: name.into(), at: at.into() }
    }
}

impl ExpectSection {
    /// A value at an instant, still without its tolerance.
    pub fn new(quantity: impl Into<String>, at: f64, equals: f64) -> Self {
        Self { quantity: quantity.into(), at, equals, relative: None, absolute: None }
    }
}

setters! { ExpectSection:
    relative = f64 => Some(relative), "With an allowed error over |equals|.";
    absolute = f64 => Some(absolute), "With an allowed error.";
}
