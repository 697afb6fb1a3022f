//! The discrete problem as PETSc's SNES sees it.
//!
//! The unknowns of SNES are the displacements of all nodes. Residual and tangent belong to the
//! linear system of the condensed form (docs/theory.md), whose solution becomes a direction in the
//! displacements by [`NonlinearSystem::direction`](crate::petsc::NonlinearSystem::direction).

pub(in crate::solve) mod condensed;
pub(in crate::solve) mod convergence;
pub(in crate::solve) mod energy;
mod known_pressure;
mod newton;
pub(in crate::solve) mod path;
mod predictor;
mod reactions;
pub(in crate::solve) mod saddle;
mod unsymmetric;

pub use energy::Energy;
pub use known_pressure::KnownPressure;
pub(super) use predictor::{Onset, Prediction};
pub use reactions::reactions;

use std::rc::Rc;

use crate::assembly::{CellSet, Discretization, NodeState, Tangent};
use crate::bulk::Loads;
use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::MeshFacts;
use crate::multigrid::Hierarchy;
use crate::petsc::Verdict;
use crate::signals::Pulse;
use crate::solve::guess::energy_projection::EnergyProjection;
use crate::solve::guess::rigid::RigidMotions;
use crate::solve::model::interfaces::InterfaceState;
use crate::solve::model::linear::LinearTarget;
use crate::timers::{Phase, Timers};
use convergence::{Convergence, Scales, Worst};
use path::PathControl;

/// How the tangent of the condensed form is held.
pub enum TangentForm {
    /// As a matrix.
    Assembled(Tangent),
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
    /// Displacements of all local nodes at the last evaluated state (m).
    pub displacement: Vec<f64>,
    /// Load of this rank's cells at the target time, per local node, not summed (N).
    pub load: Vec<f64>,
    /// Forces of the pore pressure, likewise (N); empty without one.
    pub pore_force: Vec<f64>,
    /// The pore pressure, where it is a load.
    pub known_pressure: Option<KnownPressure>,
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
    /// 2-norm of the out-of-balance forces at the state that was judged last (N).
    pub residual_norm: f64,
    /// Asks in the middle of a step whether to stop.
    pub pulse: Pulse,
}

impl<'a> Problem<'a> {
    /// A problem at rest.
    #[allow(clippy::too_many_arguments)] // every part is built by a stage of its own
    pub fn new(
        comm: &'a Comm,
        timers: &'a Timers,
        all: Rc<Discretization>,
        loads: Loads,
        interfaces: InterfaceState,
        (form, diagonal): (TangentForm, f64),
        convergence: Convergence,
        linear: LinearTarget,
        mesh: MeshFacts,
    ) -> Self {
        let components = all.nodes.len() * all.dim;
        let mut of_all = vec![0.0; components];
        all.cells.add_diagonal(&mut of_all);
        all.nodes.add_to_owners(&mut of_all, all.dim);
        let of_nodes = of_all[..all.nodes.owned * all.dim].chunks_exact(all.dim);
        let stiffness = of_nodes.map(|k| k.iter().fold(0.0, |m: f64, k| m.max(*k))).collect();
        Self {
            comm,
            timers,
            loads,
            interfaces,
            convergence,
            linear,
            form,
            diagonal,
            stiffness,
            displacement: vec![0.0; components],
            load: vec![0.0; components],
            pore_force: Vec::new(),
            known_pressure: None,
            known_jumps: Vec::new(),
            bulk_force: vec![0.0; components],
            balance: vec![0.0; components],
            path: None,
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
            residual_norm: 0.0,
            pulse: Pulse::default(),
            all,
        }
    }

    /// Largest stiffness of a cell against one displacement (N/m). Local, the same on all ranks.
    pub(super) fn stiffness(&self) -> f64 {
        self.diagonal
    }

    /// The levels of multigrid, where it is the solver.
    pub fn hierarchy(&self) -> Option<&Hierarchy> {
        if let TangentForm::Levels(hierarchy) = &self.form { Some(hierarchy) } else { None }
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
        if let Some(known) = &mut self.known_pressure {
            self.comm.agree(known.set(time))?;
            self.pore_force = known.forces(&self.all);
        }
        if let Some(path) = &mut self.path {
            path.unit_load.clone_from(&self.load);
            self.scale_load();
        }
        Ok(())
    }

    /// Makes the load that of the present load factor. Local.
    pub(super) fn scale_load(&mut self) {
        if let Some(path) = &self.path {
            self.load.iter_mut().zip(&path.unit_load).for_each(|(l, unit)| *l = path.factor * unit);
        }
    }

    /// Forces of the bulk at `x`, and the magnitudes of nodal forces and loads if they are wanted.
    /// Collective.
    pub(super) fn evaluate_bulk(&mut self, x: &[f64], with_scales: bool) {
        let (nodes, dim) = (&self.all.nodes, self.all.dim);
        self.displacement[..x.len()].copy_from_slice(x);
        nodes.update_ghosts(&mut self.displacement, dim);
        self.bulk_force.iter_mut().zip(&self.load).for_each(|(f, l)| *f = -l);
        self.bulk_force.iter_mut().zip(&self.pore_force).for_each(|(f, p)| *f -= p);
        let (u, force) = (&self.displacement, &mut self.bulk_force);
        if !with_scales {
            self.all.cells.add_forces(CellSet::All, u, force, None);
            nodes.add_to_owners(force, dim);
            return;
        }
        let mut magnitude = vec![0.0; nodes.len()];
        self.all.cells.add_forces(CellSet::All, u, force, Some(&mut magnitude));
        nodes.add_to_owners(force, dim);
        nodes.add_to_owners(&mut magnitude, 1);
        // Loads count too: they may leave the bulk without any force of its own.
        let load = self.applied();
        for (magnitude, load) in magnitude.iter_mut().zip(load.chunks_exact(dim)) {
            let length = load.iter().map(|l| l * l).sum::<f64>().sqrt();
            *magnitude = magnitude.max(length);
        }
        let u = self.displacement[..x.len()].chunks_exact(dim);
        let mut scales = Scales::default();
        for ((u, force), stiffness) in u.zip(&magnitude).zip(&self.stiffness) {
            scales.see(*force, u, *stiffness);
        }
        self.convergence.see_scales(self.comm, scales);
    }

    /// Loads and forces of the pore pressure at owned nodes (N). Collective.
    pub(super) fn applied(&self) -> Vec<f64> {
        let mut applied = self.load.clone();
        applied.iter_mut().zip(&self.pore_force).for_each(|(l, p)| *l += p);
        self.all.nodes.add_to_owners(&mut applied, self.all.dim);
        applied
    }

    /// States with which the tangent was assembled, for all local secondary nodes. Local.
    pub(super) fn assembled_state(&self) -> &[NodeState] {
        self.assembled_state.as_deref().unwrap_or_default()
    }

    /// Keeps a correction of the displacements for the guesses of later ones. Collective.
    pub(super) fn keep(&mut self, correction: &[f64]) {
        self.projection.keep(self.comm, &self.all, correction);
    }

    /// The verdict on the state that was evaluated last, with the residual `f` of the
    /// displacements; `other` is the error of what else has to hold, over its scale. Collective.
    pub(super) fn judge(
        &mut self,
        iteration: usize,
        f: &[f64],
        norm: f64,
        other: f64,
    ) -> Result<Verdict> {
        let worst = self.worst_force(f);
        let free = condensed::free_components(&self.all, &self.interfaces);
        let forces = f.iter().zip(free).filter(|(_, free)| *free);
        let mut square = [forces.map(|(f, _)| f * f).sum::<f64>()];
        self.comm.sum(&mut square);
        self.residual_norm = square[0].sqrt();
        let (comm, all) = (self.comm, &self.all);
        let verdict =
            self.convergence.judge(comm, all, &self.interfaces, iteration, norm, worst, other)?;
        (self.judged_norm, self.corrections) = (norm, iteration);
        self.is_skew &= iteration > 0;
        let (smallest, since) = self.stall;
        self.stall = match iteration {
            0 => (norm, 0),
            _ if norm < 0.5 * smallest => (norm, 0),
            _ => (smallest, since + 1),
        };
        Ok(self.unless_waiting(verdict))
    }

    /// Evaluates a state with its scales; the 2-norm of its out-of-balance forces (N). Collective.
    pub(super) fn out_of_balance(&mut self, x: &[f64]) -> Result<f64> {
        let mut f = vec![0.0; x.len()];
        self.evaluate(x, &mut f, true);
        self.judge(0, &f, 0.0, 0.0)?;
        Ok(self.residual_norm)
    }

    /// The largest out-of-balance nodal force in a residual. Local.
    fn worst_force(&self, f: &[f64]) -> Worst {
        let (all, dim) = (&self.all, self.all.dim);
        let mut worst = Worst::default();
        for node in 0..all.nodes.owned {
            let index = all.secondary_of[node].map(|i| i as usize);
            let stuck = index.map_or([false; 3], |i| self.interfaces.response[i].state.stuck);
            // The rows of stuck components hold a displacement, which the jumps judge.
            let force = f[node * dim..][..dim].iter().zip(stuck).filter(|(_, stuck)| !stuck);
            let length = force.map(|(f, _)| f * f).sum::<f64>().sqrt();
            worst.see(length, all.nodes.names[node]);
        }
        worst
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

    /// The residual at `x`, and the scales of the state if they are wanted. Collective.
    fn evaluate(&mut self, x: &[f64], f: &mut [f64], with_scales: bool) {
        let _phase = self.timers.enter(Phase::Assembly);
        self.evaluate_bulk(x, with_scales);
        let (all, dim) = (&self.all, self.all.dim);
        // In equilibrium with the bulk at every iterate.
        self.interfaces.evaluate(all, &self.displacement, |index, c, row| {
            let own = all.secondary[index].node as usize * dim + c;
            -self.bulk_force[own] / (row.weight * row.own)
        });
        self.balance_with_laws(f);
    }

    /// The residual of the condensed form, from the forces of the bulk and the answers of the laws.
    /// Collective.
    fn balance_with_laws(&mut self, f: &mut [f64]) {
        if let TangentForm::Levels(hierarchy) = &self.form {
            let state = self.interfaces.response.iter_mut().map(|r| &mut r.state);
            hierarchy.finest().choose_unknowns(state);
        }
        let dim = self.all.dim;
        let (known, known_force) = condensed::known_jumps(&self.all, &self.interfaces);
        self.known_jumps = known;
        let (all, response) = (&self.all, &self.interfaces.response);
        self.balance.fill(0.0);
        let traction = |index: usize, c: usize| {
            let (rows, response) = (&all.secondary[index], &response[index]);
            match &rows.rows[c] {
                Some(row) if response.state.stuck[c] => {
                    let own = rows.node as usize * dim + c;
                    response.law_traction[c] + known_force[own] / (row.weight * row.own)
                }
                _ => response.law_traction[c],
            }
        };
        all.add_tractions(traction, &mut self.balance);
        for (i, value) in f.iter_mut().enumerate() {
            self.balance[i] += self.bulk_force[i];
            *value = self.balance[i] - known_force[i];
        }
        condensed::fold(self.comm, &self.all, &self.interfaces, f);
        let (all, dim) = (&self.all, self.all.dim);
        // Identity rows: nothing to do where prescribed, the known jump where stuck.
        for node in 0..all.nodes.owned {
            for c in (0..dim).filter(|c| all.prescribed[node][*c]) {
                f[node * dim + c] = 0.0;
            }
        }
        for (rows, response) in all.secondary.iter().zip(&self.interfaces.response) {
            for c in (0..dim).filter(|c| rows.rows[*c].is_some() && response.state.stuck[*c]) {
                let own = rows.node as usize * dim + c;
                f[own] = self.diagonal * self.known_jumps[own];
            }
        }
    }
}
