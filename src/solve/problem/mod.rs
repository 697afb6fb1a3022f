//! The discrete problem as PETSc's SNES sees it.
//!
//! The unknowns of SNES are the displacements of all nodes. Residual and tangent belong to the
//! linear system of the condensed form (docs/theory.md), whose solution becomes a direction in the
//! displacements by [`NonlinearSystem::direction`](crate::petsc::NonlinearSystem::direction).

mod areas;
pub mod block_tangent;
mod bordering;
mod carried;
pub(in crate::solve) mod condensed;
pub(in crate::solve) mod convergence;
mod cycles;
pub(in crate::solve) mod energy;
mod judge;
mod known_pressure;
pub(in crate::solve) mod measure;
mod newton;
pub(in crate::solve) mod path;
pub(in crate::solve) mod platen_columns;
pub(in crate::solve) mod platens;
mod predictor;
mod reactions;
mod residual;
pub(in crate::solve) mod saddle;
mod unsymmetric;

pub use carried::{Prestress, Release};
pub use energy::Energy;
pub use known_pressure::KnownPressure;
pub use platens::PlatenSystem;
pub(super) use predictor::{Onset, Prediction};
pub use reactions::reactions;

use std::borrow::Cow;
use std::rc::Rc;

use crate::assembly::{Discretization, NodeState, Tangent};
use crate::bulk::Loads;
use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::MeshFacts;
use crate::multigrid::Hierarchy;
use crate::signals::Pulse;
use crate::solve::guess::energy_projection::EnergyProjection;
use crate::solve::guess::rigid::RigidMotions;
use crate::solve::model::StressAtStart;
use crate::solve::model::interfaces::InterfaceState;
use crate::solve::model::linear::LinearTarget;
use crate::timers::Timers;
use areas::Areas;
use block_tangent::BlockTangent;
use convergence::Convergence;
use path::PathControl;

/// How the tangent of the condensed form is held.
pub enum TangentForm {
    /// As a matrix.
    Assembled(Tangent),
    /// As a matrix of blocks, with its preconditioner.
    Blocks(BlockTangent),
    /// As the operator of the finest level of a hierarchy, without a matrix.
    Levels(Hierarchy),
    /// Not at all: another form takes its place.
    None,
}

/// One rank's share of the problem.
pub struct Problem<'a> {
    /// The communicator of all collective calls.
    pub comm: &'a Comm,
    pub(super) timers: &'a Timers,
    /// Cells, nodes, rows.
    pub all: Rc<Discretization>,
    /// Loads on the bulk.
    pub loads: Loads,
    /// Laws and history.
    pub interfaces: InterfaceState,
    /// When a state is a solution.
    pub convergence: Convergence,
    /// How far linear systems are solved.
    pub linear: LinearTarget,
    form: TangentForm,
    /// Entry of identity rows (N/m).
    diagonal: f64,
    /// The largest stiffness of each owned node (N/m).
    stiffness: Vec<f64>,
    /// How forces at nodes of interfaces count.
    pub(super) areas: Areas,
    /// Displacements of all local nodes at the last evaluated state (m).
    pub displacement: Vec<f64>,
    /// Displacements of all local nodes from which those of results count (m); empty where these
    /// are the same.
    pub origin: Vec<f64>,
    /// Load of this rank's cells at the target time, less the forces of the stresses at the start,
    /// per local node, not summed (N).
    pub load: Vec<f64>,
    /// Stresses that are there at the start.
    pub initial_stress: Option<StressAtStart>,
    /// Forces of the pore pressure, likewise (N); empty without one.
    pub pore_force: Vec<f64>,
    /// The pore pressure, where it is a load.
    pub known_pressure: Option<KnownPressure>,
    /// Reactions of supports that an earlier stage had.
    pub release: Option<Release>,
    /// Stresses that stay from stages with other stiffnesses.
    pub prestress: Option<Prestress>,
    /// Out-of-balance force of the bulk alone at owned nodes: K u - load - pore force (N).
    pub bulk_force: Vec<f64>,
    /// The same with the tractions of the interfaces (N): zero where nothing is prescribed, the
    /// reaction of the support elsewhere.
    pub balance: Vec<f64>,
    /// Displacements of all local nodes that the linear solve does not find: of stuck components
    /// whose jump is not yet the one that their law asks for (m).
    pub(super) known_jumps: Vec<f64>,
    /// Path following, where the case asks for it.
    pub path: Option<PathControl>,
    /// Platens, where there are any.
    pub platens: Option<PlatenSystem>,
    /// Room for another state.
    spare: [Vec<f64>; 4],
    /// States with which the tangent was assembled, for all local secondary nodes.
    assembled_state: Option<Vec<NodeState>>,
    /// States for which the preconditioner was set up.
    preconditioned: Option<Vec<NodeState>>,
    projection: EnergyProjection,
    rigid: RigidMotions,
    prediction: Prediction,
    /// Corrections of the running step in which points have opened or closed before others give
    /// way.
    turns: usize,
    /// Whether some laws answered from the last accepted state in the last evaluation.
    waits: bool,
    /// 2-norm of the residual that was judged last.
    pub(super) judged_norm: f64,
    /// What is known of the whole mesh.
    pub mesh: MeshFacts,
    /// Corrections of the running solve up to the state that was judged last.
    pub(super) corrections: usize,
    /// Whether the last correction needed what is not symmetric in the tangent.
    pub(super) is_skew: bool,
    /// The smallest residual of the running solve, and how many corrections ago it was halved.
    stall: (f64, usize),
    /// What gives way first in the running step.
    pub(super) onset: Onset,
    /// The most potential energy (J) that a state of the running step can have: that of the answer
    /// to its loads before anything gives way; none where it is not known.
    pub(super) most_energy: Option<f64>,
    /// 2-norm of the out-of-balance forces at the state that was judged last (N).
    pub residual_norm: f64,
    /// Asks in the middle of a step whether to stop.
    pub pulse: Pulse,
}

/// What a [`Problem`] is made of, every part by a stage of its own; as there.
pub struct ProblemParts<'a> {
    /// The communicator of all collective calls.
    pub comm: &'a Comm,
    /// Of the phases of a run.
    pub timers: &'a Timers,
    /// Cells, nodes, rows.
    pub all: Rc<Discretization>,
    /// Loads on the bulk.
    pub loads: Loads,
    /// Laws and history.
    pub interfaces: InterfaceState,
    /// How the tangent is formed.
    pub form: TangentForm,
    /// Entry of identity rows (N/m).
    pub diagonal: f64,
    /// When a state is a solution.
    pub convergence: Convergence,
    /// How far linear systems are solved.
    pub linear: LinearTarget,
    /// What is known of the whole mesh.
    pub mesh: MeshFacts,
}

impl<'a> Problem<'a> {
    /// A problem at rest.
    pub fn new(parts: ProblemParts<'a>) -> Self {
        let ProblemParts {
            comm,
            timers,
            all,
            loads,
            interfaces,
            form,
            diagonal,
            convergence,
            linear,
            mesh,
        } = parts;
        let components = all.nodes.len() * all.dim;
        Self {
            comm,
            timers,
            loads,
            interfaces,
            convergence,
            linear,
            form,
            diagonal,
            stiffness: stiffness_of_nodes(&all),
            areas: Areas::new(comm, &all, mesh.order),
            displacement: vec![0.0; components],
            origin: Vec::new(),
            load: vec![0.0; components],
            initial_stress: None,
            pore_force: Vec::new(),
            known_pressure: None,
            release: None,
            prestress: None,
            known_jumps: Vec::new(),
            bulk_force: vec![0.0; components],
            balance: vec![0.0; components],
            path: None,
            platens: None,
            spare: Default::default(),
            assembled_state: None,
            preconditioned: None,
            projection: EnergyProjection::default(),
            rigid: RigidMotions::new(&mesh),
            mesh,
            prediction: Prediction::default(),
            turns: 0,
            waits: false,
            judged_norm: 0.0,
            corrections: 0,
            is_skew: false,
            stall: (0.0, 0),
            onset: Onset::default(),
            most_energy: None,
            residual_norm: 0.0,
            pulse: Pulse::default(),
            all,
        }
    }

    /// The force of a support on an unknown of an owned node (N), also of one that an earlier stage
    /// had; none where there is no support. Local.
    pub fn support_force(&self, node: usize, component: usize) -> Option<f64> {
        let unknown = node * self.all.dim + component;
        let released = || self.release.as_ref().map(|release| release.at(unknown));
        let is_prescribed = self.all.prescribed[node][component];
        if is_prescribed { Some(self.balance[unknown]) } else { released() }
    }

    /// Largest stiffness of a cell against one displacement (N/m). Local, the same on all ranks.
    pub(super) fn stiffness(&self) -> f64 {
        self.diagonal
    }

    /// The levels of multigrid, where it is the solver.
    pub fn hierarchy(&self) -> Option<&Hierarchy> {
        if let TangentForm::Levels(hierarchy) = &self.form { Some(hierarchy) } else { None }
    }

    /// Displacements of all local nodes since the start, whose stresses may have had to be brought
    /// into equilibrium (m). Local.
    pub fn displacement_since_start(&self) -> Cow<'_, [f64]> {
        if self.origin.is_empty() {
            return Cow::Borrowed(&self.displacement);
        }
        let pairs = self.displacement.iter().zip(&self.origin);
        Cow::Owned(pairs.map(|(u, origin)| u - origin).collect())
    }

    /// Sets the load to that at `time`, of which path following takes its part. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub fn set_load(&mut self, time: f64) -> Result<()> {
        self.load.fill(0.0);
        let (dim, nodes, load) = (self.all.dim, &self.all.nodes, &mut self.load);
        let added = self.loads.add(time, |name, component, force| {
            let node = nodes.local(name).expect("loads act on the rank's own cells") as usize;
            load[node * dim + component] += force;
        });
        self.comm.agree(added)?;
        self.all.frames.fold(&mut self.load);
        if let Some(release) = &mut self.release {
            release.add(time, &mut self.load);
        }
        if let Some(stress) = &self.initial_stress {
            self.load.iter_mut().zip(&stress.force).for_each(|(load, force)| *load -= force);
        }
        if let Some(known) = &mut self.known_pressure {
            self.comm.agree(known.set(time))?;
            self.pore_force = known.forces(&self.all);
        }
        let platens = self.platens.as_mut().map_or(Ok(()), |of| of.platens.set_load(time));
        self.comm.agree(platens)?;
        if let Some(path) = &mut self.path {
            path.unit_load.clone_from(&self.load);
            path.unit_of_platens = match &self.platens {
                Some(of) => of.platens.load.clone(),
                None => Vec::new(),
            };
            self.scale_load();
        }
        Ok(())
    }

    /// Makes the load that of the present load factor. Local.
    pub(super) fn scale_load(&mut self) {
        if let Some(path) = &self.path {
            let of_platens = self.platens.iter_mut().flat_map(|of| &mut of.platens.load);
            let of_platens = of_platens.zip(&path.unit_of_platens);
            let loads = self.load.iter_mut().zip(&path.unit_load);
            loads.chain(of_platens).for_each(|(load, unit)| *load = path.factor * unit);
        }
    }

    /// States with which the tangent was assembled, for all local secondary nodes. Local.
    pub(super) fn assembled_state(&self) -> &[NodeState] {
        self.assembled_state.as_deref().unwrap_or_default()
    }

    /// Keeps a correction of the displacements for the guesses of later ones. Collective.
    pub(super) fn keep(&mut self, correction: &[f64]) {
        self.projection.keep(self.comm, &self.all, correction);
    }

    /// States of all local secondary nodes, the ghosts' from their owners. Collective.
    fn local_states(&self) -> Vec<NodeState> {
        const WIDTH: usize = NodeState::WIDTH;
        let mut packed = vec![0.0; self.all.nodes.len() * WIDTH];
        for (rows, response) in self.all.secondary.iter().zip(&self.interfaces.response) {
            packed[rows.node as usize * WIDTH..][..WIDTH].copy_from_slice(&response.state.pack());
        }
        self.all.nodes.update_ghosts(&mut packed, WIDTH);
        let unpack = |r: &crate::interface::JumpRows<u32>| {
            NodeState::unpack(&packed[r.node as usize * WIDTH..][..WIDTH])
        };
        self.all.secondary.iter().map(unpack).collect()
    }

    /// Puts the state aside, or gets it back. Local.
    fn exchange_with_spare(&mut self) {
        let [u, jumps] = [&mut self.displacement, &mut self.known_jumps];
        let state = [u, jumps, &mut self.bulk_force, &mut self.balance];
        for (state, spare) in state.into_iter().zip(&mut self.spare) {
            spare.resize(state.len(), 0.0);
            std::mem::swap(state, spare);
        }
    }
}

/// The largest stiffness of each owned node (N/m). Collective.
fn stiffness_of_nodes(all: &Discretization) -> Vec<f64> {
    let mut of_all = vec![0.0; all.nodes.len() * all.dim];
    all.add_diagonal(&mut of_all);
    all.nodes.add_to_owners(&mut of_all, all.dim);
    let of_nodes = of_all[..all.nodes.owned * all.dim].chunks_exact(all.dim);
    of_nodes.map(|k| k.iter().fold(0.0, |most: f64, k| most.max(*k))).collect()
}
