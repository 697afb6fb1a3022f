//! The sections of a case: as they are written, and the types that come of them.
//!
//! What a case file says can be built in code: [`CaseFile`] and the types named `...Section` are
//! the file, with the same words and the same defaults. Fields are open, and short constructors
//! take what must be there. [`Case::build`](crate::case::Case::build) checks what was built exactly
//! as a file is checked.
//!
//! ```
//! use column_hpc::case::sections::{
//!     BoundarySection, CaseFile, Components, InterfaceSection, MaterialSection, MeshSection,
//!     Surface, TimeSection,
//! };
//! use column_hpc::case::Case;
//! use column_hpc::law::LinearSoftening;
//!
//! let pulled = [[0.0, 0.0], [1.0, 1.0e-3]];
//! let mut file = CaseFile::new(
//!     MeshSection::column([1.0, 1.0, 5.0], [1, 1, 5]),
//!     TimeSection::instants([0.5, 1.0]),
//! )
//! .material("rock", MaterialSection::elastic(5.8e9, 0.3))
//! .interface(InterfaceSection::new("joint", 2.5, LinearSoftening::new(1.1e6, 900.0)))
//! .boundary(BoundarySection::on(Surface::Bottom).displacement(Components::xyz(0.0, 0.0, 0.0)))
//! .boundary(BoundarySection::on(Surface::Top).displacement(Components::xyz(0.0, 0.0, pulled)));
//! let case = Case::build(file.clone())?;
//! assert_eq!((case.dim, case.solver.max_newton), (3, 30));
//!
//! // All mistakes are told at once.
//! file.mesh.order = Some(3);
//! file.time.instants.push(0.75);
//! assert_eq!(
//!     Case::build(file).unwrap_err().to_string(),
//!     "mesh.order must be at most 2, got 3\n\
//!      time.instants.2 must be above the instant before it at 1, got 0.75"
//! );
//! # Ok::<(), column_hpc::error::Error>(())
//! ```

mod accuracy;
mod boundary;
mod constructors;
mod instants;
pub(crate) mod file;
pub(crate) mod grading;
mod interface;
mod material;
mod mesh;
mod output;
pub(crate) mod quantity;
mod rigid;
mod solver;
mod stage;

pub use accuracy::{AccuracyBudget, AccuracyInstants, AccuracySection, AccuracyWord};
pub use boundary::{BoundarySpec, Surface, SurfaceBit};
pub use file::{
    BodySection, BoundarySection, CaseFile, ColumnSection, Components, ControlSection,
    DissipationSection, ElasticSection, ExpectSection, FieldsSection, FieldsWord, Groups,
    InterfaceSection, MaterialSection, MeshSection, OpeningSection, OutputSection, Physics,
    ProbeSection, TimeSection,
};
pub use grading::{AxisGrading, GradingSection};
pub use interface::{FilmSpec, Gap, InterfaceInitial, InterfaceSpec, Location, Side};
pub use material::{Material, Porous};
pub use mesh::{
    Cells, ColumnSpec, FileSpec, Formulation, MeshSource, MeshSpec, column_axes, file_axes,
};
pub use output::{Expectation, Fields, OutputSpec, Probe};
pub use quantity::{
    CheckpointSection, Coordinate, FluidSection, FormulaSection, ImperfectionSection,
    InitialSection, InterfaceInitialSection, LimitsSection, Quantity, SpatialQuantity,
    StressSection, TableSection,
};
pub use rigid::{
    AxesSection, Motion, MotionSection, MotionWord, RigidSection, RigidSpec, RotationSection,
    turned,
};
pub use solver::{Form, Linear, Reduce, SolverSpec, Stability};
pub use stage::{
    FreeWord, StageBoundarySection, StageComponents, StageDisplacement, StageElasticSection,
    StageFluidSection, StageMaterialSection, StagePorousSection, StageQuantity, StageRigid,
    StageSection,
};
