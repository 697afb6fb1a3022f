//! The pore pressure and its history: the balance of the fluid from one accepted state to the next.
//!
//! Masses are divided by the reference density of the fluid, as in [`crate::bulk::PorousCell`].

mod accounts;
mod balance;
mod block;
mod blocks;
pub(in crate::solve) mod coupled;
mod coupled_factors;
mod films;
mod pace;
pub(in crate::solve) mod pressures;
pub(in crate::solve) mod setup;
mod ties;

pub use coupled::Coupling;

pub use balance::FluidBalance;
pub use pace::{NextStep, Pace};

use std::rc::Rc;

use super::Problem;
use crate::assembly::{Discretization, PoreSpace};
use crate::bulk::{FlowStep, Loads};
use crate::comm::Comm;
use crate::error::Result;
use crate::solve::problem::measure::{is_rounding, rounding};
use crate::space::PrescribedPressure;
use balance::{Contents, NodalBalance};

/// Fluid that comes in from outside.
pub struct Source {
    /// Mass flux (kg/m2/s).
    rate: Loads,
    /// Through this rank's facets at the two ends of the step (m3/s), at all local nodes, not
    /// summed.
    at: [Vec<f64>; 2],
}

impl Source {
    /// Before any step.
    pub fn new(rate: Loads, nodes: usize) -> Self {
        Self { rate, at: [vec![0.0; nodes], vec![0.0; nodes]] }
    }
}

/// Pressure, time step and accounts of one rank.
pub struct Flow {
    /// Nodes and cells.
    pub space: Rc<PoreSpace>,
    prescribed: PrescribedPressure,
    /// Through the surfaces of the porous cells.
    inflow: Source,
    /// Into the films.
    injection: Source,
    /// Density of the fluid at the reference pressure (kg/m3).
    density: f64,
    /// Unknowns are pressures over this (Pa/m): their rows then have the unit and the size of those
    /// of the displacements.
    pub scale: f64,
    /// The running step.
    pub step: FlowStep,
    /// Pressure of all local nodes at the state that was evaluated last (Pa).
    pub pressure: Vec<f64>,
    /// Likewise at the last accepted state.
    before: Vec<f64>,
    /// At the last accepted state, in this rank's cells.
    in_pores: Contents,
    /// Likewise in its films; empty without any.
    in_films: Contents,
    /// What was left of the balance of owned nodes at the last accepted state (m3): the next step
    /// makes up for it, so that the accounts close however many steps there are.
    left: Vec<f64>,
    /// Largest nodal magnitude of the balance of the accepted states and of the last one (m3).
    scales: [f64; 2],
    /// The largest volume at a node for displacements of 1 m in this rank's cells (m3/m).
    coupling: f64,
    /// Fluid stored at the start (m3).
    initial: f64,
    /// The lengths of the steps, where they follow from their error.
    pub pace: Option<Pace>,
    /// Longest step (s) in which the pressure of some cell would oscillate: of cells of first
    /// order, which are held back then, and of second order.
    bounds: [f64; 2],
    /// What is to be said of steps that were too short, in words.
    pub remarks: Vec<String>,
    /// Accounts up to the last accepted state.
    pub balance: FluidBalance,
    /// Local nodes on the lips from which fluid flows into the pores, each with its side, twice the
    /// index of the interface and one more for the upper side, and the share of the side in it.
    lips: Vec<(u32, usize, f64)>,
    /// Mean rate in the last step into the lower and the upper side of each interface (kg/s).
    pub into_sides: Vec<[f64; 2]>,
}

/// What [`Flow`] is made of, every part by a stage of its own; as there.
pub struct FlowParts {
    /// Nodes and cells.
    pub space: Rc<PoreSpace>,
    /// Where pressures are prescribed.
    pub prescribed: PrescribedPressure,
    /// Through the surfaces of the porous cells.
    pub inflow: Source,
    /// Into the films.
    pub injection: Source,
    /// Density of the fluid at the reference pressure (kg/m3).
    pub density: f64,
    /// Pressure over its unknown (Pa/m).
    pub scale: f64,
    /// The first step, of no length yet.
    pub step: FlowStep,
    /// The lengths of the steps, where they follow from their error.
    pub pace: Option<Pace>,
    /// Longest step (s) in which the pressure of some cell would oscillate: of cells of first and
    /// second order.
    pub bounds: [f64; 2],
    /// Local nodes on the lips from which fluid flows into the pores, each with its side, twice the
    /// index of the interface and one more for the upper side, and the share of the side in it.
    pub lips: Vec<(u32, usize, f64)>,
    /// Interfaces of the case.
    pub interfaces: usize,
    /// Pressures of all local nodes at the start (Pa).
    pub initial: Vec<f64>,
}

impl Flow {
    /// At the start.
    pub fn new(parts: FlowParts) -> Self {
        let FlowParts {
            space,
            prescribed,
            inflow,
            injection,
            density,
            scale,
            step,
            pace,
            bounds,
            lips,
            interfaces,
            initial,
        } = parts;
        let none = || vec![0.0; space.nodes.len()];
        Self {
            before: initial.clone(),
            in_pores: Contents::default(),
            in_films: Contents::default(),
            left: none(),
            pressure: initial,
            coupling: space.largest_coupling(),
            space,
            prescribed,
            inflow,
            injection,
            density,
            scale,
            step,
            scales: [0.0; 2],
            initial: 0.0,
            pace,
            bounds,
            remarks: Vec::new(),
            balance: FluidBalance::default(),
            lips,
            into_sides: vec![[0.0; 2]; interfaces],
        }
    }

    /// Starts a step from `start` to `target`. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub fn start_step(&mut self, comm: &Comm, start: f64, target: f64) -> Result<()> {
        self.step.length = target - start;
        self.remark();
        let (nodes, density) = (&self.space.nodes, self.density);
        for Source { rate, at } in [&mut self.inflow, &mut self.injection] {
            for (time, at) in [start, target].into_iter().zip(at) {
                at.fill(0.0);
                let added = rate.add(time, |name, _, mass| {
                    let node = nodes.local(name).expect("sources act on the rank's porous cells");
                    at[node as usize] += mass / density;
                });
                comm.agree(added)?;
            }
        }
        Ok(())
    }

    /// Tells once of each kind of cells whose pressure would oscillate in the running step. Local:
    /// the same on all ranks.
    fn remark(&mut self) {
        let length = self.step.length;
        for (order, bound) in self.bounds.iter_mut().enumerate().filter(|(_, b)| length < **b) {
            let what = format!(
                "a step of {length:.3e} s is shorter than {bound:.3e} s (h^2/(6 theta c_v)), below \
                 which the pressure beside drained surfaces oscillates"
            );
            let remark = if order == 0 {
                format!("{what}: cells of first order are held back as far as they need it")
            } else {
                format!(
                    "{what} with cells of second order: take mesh.order: 1, longer steps or \
                     smaller cells there"
                )
            };
            if order == 0 {
                tracing::info!("  {remark}");
            } else {
                tracing::warn!("warning: {remark}");
            }
            self.remarks.push(remark);
            *bound = 0.0;
        }
    }

    /// Whether the step to the last state is accurate enough. Collective.
    pub fn is_accurate(&mut self, comm: &Comm) -> bool {
        let (owned, length) = (self.space.nodes.owned, self.step.length);
        let (before, after) = (&self.before[..owned], &self.pressure[..owned]);
        self.pace.as_mut().is_none_or(|pace| pace.accepts(comm, before, after, length))
    }

    /// Writes the prescribed pressures at `time` into `x`, the scaled pressures of owned nodes.
    /// Local.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub fn write_prescribed(&self, time: f64, x: &mut [f64]) -> Result<()> {
        for (node, x) in x.iter_mut().enumerate() {
            let nodes = &self.space.nodes;
            if let Some(entry) = self.prescribed.entry_of(&nodes.marks[node]) {
                *x = self.prescribed.value(entry, nodes.points[node], time)? / self.scale;
            }
        }
        Ok(())
    }

    /// Takes the scaled pressures `x` of owned nodes for the state that is evaluated. Collective.
    pub fn take(&mut self, x: &[f64]) {
        let pairs = self.pressure.iter_mut().zip(x);
        pairs.for_each(|(p, x)| *p = self.scale * x);
        self.space.nodes.update_ghosts(&mut self.pressure, 1);
        self.space.follow(&mut self.pressure);
    }

    /// Forces of the pressure on the local displacement nodes, not summed (N). Local.
    pub fn add_forces(&self, all: &Discretization, force: &mut [f64]) {
        self.space.add_forces(all, &self.pressure, true, force);
    }

    /// The residual of the last state, with displacements `u`: of what is missing at each owned
    /// node, in the unit of a force (N). `known` are displacements that the linear solve does not
    /// find. Returns how much
    /// is missing at most over the largest magnitude, and how much of that rounding may be.
    /// Collective.
    pub fn residual(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        u: &[f64],
        known: &[f64],
        f: &mut [f64],
    ) -> [f64; 2] {
        let NodalBalance { mut rows, mut sizes } = self.nodal_balance(all, u);
        self.space.fold(&mut rows);
        self.space.sum(&mut sizes);
        let largest = |of: &[f64]| {
            of.iter().fold(0.0_f64, |m, v| if v.is_nan() { f64::INFINITY } else { m.max(v.abs()) })
        };
        let owned = f.len();
        let mut free = sizes;
        self.space.for_identity_rows(|node| free[node] = 0.0);
        // Bodies that move as wholes make no volume but for rounding.
        let cancelling = largest(u) * self.coupling;
        let mut worst = [largest(&rows[..owned]), largest(&free[..owned]), cancelling];
        comm.max(&mut worst);
        self.scales[1] = worst[1];
        let scale = worst[1].max(self.scales[0]);
        let mut followed = vec![0.0; rows.len()];
        self.space.add_volumes(all, known, &mut followed);
        self.space.fold(&mut followed);
        for ((f, row), followed) in f.iter_mut().zip(&rows).zip(&followed) {
            *f = self.scale * (followed - row);
        }
        let is_nothing = worst[0] == 0.0 || is_rounding(worst[0], scale, worst[2]);
        if is_nothing { [0.0; 2] } else { [worst[0] / scale, rounding(worst[2]) / scale] }
    }

    /// The largest magnitude of the balance in the unit of a force (N). Local: the same on all
    /// ranks.
    pub fn force_scale(&self) -> f64 {
        self.scale * self.scales[0].max(self.scales[1])
    }

    /// Largest magnitude of the balance at the accepted states (m3), for a run that goes on.
    pub fn accepted_scale(&self) -> f64 {
        self.scales[0]
    }

    /// Pressure of all local nodes at the last accepted state (Pa). Local.
    pub fn accepted_pressure(&self) -> &[f64] {
        &self.before
    }

    /// Values of pressure nodes, the owned ones or none, at every owned displacement node that is a
    /// corner of a porous cell; 0 at others. Collective.
    pub fn at_corners(&self, all: &Discretization, values: &[f64]) -> Vec<f64> {
        let mut at = vec![0.0; all.nodes.len()];
        for cell in &self.space.cells {
            let nodes = all.cells.nodes(cell.cell as usize);
            for (node, own) in nodes.iter().zip(cell.corners()) {
                if (*own as usize) < self.space.nodes.owned
                    && let Some(value) = values.get(*own as usize)
                {
                    at[*node as usize] = *value;
                }
            }
        }
        // The owner of the displacement need not be that of the pressure: only this one sends.
        all.nodes.add_to_owners(&mut at, 1);
        at.truncate(all.nodes.owned);
        at
    }

    /// Goes on from an accepted state of an earlier run: the pressures of owned nodes, the accounts
    /// and the largest magnitude of the balance (m3). Collective.
    pub fn resume(
        &mut self,
        problem: &Problem<'_>,
        owned: &[f64],
        balance: FluidBalance,
        scale: f64,
    ) {
        self.pressure[..owned.len()].copy_from_slice(owned);
        self.space.nodes.update_ghosts(&mut self.pressure, 1);
        self.balance = balance;
        self.scales[0] = scale;
        self.begin(problem.comm, &problem.all, &problem.displacement);
    }
}
