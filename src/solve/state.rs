//! The state of a run between two steps: what it takes to go on as if nothing had happened.

use std::rc::Rc;

use super::flow::coupled::Coupling;
use super::flow::{NextStep, Pace};
use super::model::sliding::Sliding;
use super::problem::energy::Energy;
use super::stepping::{Accepted, FluidState, StepState, Stepper};
use crate::comm::Rows;
use crate::error::{Error, Result};

/// Numbers of a row of [`State::interface`] in the first stage.
pub(super) const HISTORY_WIDTH: usize = 6;

/// A state with its fields, this rank's own rows.
pub struct State {
    /// Displacement components per node.
    dim: usize,
    /// Whether there are columns of the pressure.
    has_pressure: bool,
    /// Whether there is a displacement from which results count.
    has_origin: bool,
    /// What is not a field.
    pub step: StepState,
    /// By node: displacement (m), then the force of supports and loads (N), by component; with flow
    /// the pore pressure (Pa) and its rate in the last step (Pa/s), 0 where there is none; with
    /// stresses at the start the displacement from which results count (m). In a later stage, by
    /// component, reactions that are released and by how much loads jump at its start (N), and the
    /// displacements at the start of each stage but the first (m).
    pub nodal: Rows,
    /// By secondary node: history (m), energy dissipated per area (J/m2), sliding by tangential
    /// component (m), its path (m), and the work of friction (J). In a later stage by component
    /// also the misfit, and the jump from which results count (m).
    pub interface: Rows,
}

impl State {
    /// The first field value of this rank that is not finite: what it is, the name of its node, and
    /// the value. Local.
    pub fn first_not_finite(&self) -> Option<(&'static str, u64, f64)> {
        // What the columns of a row hold, each as often as it has components.
        let find = |rows: &Rows, what: &[(&'static str, usize)]| {
            let at = rows.values.iter().position(|value| !value.is_finite())?;
            let columns = what.iter().flat_map(|(name, count)| std::iter::repeat_n(*name, *count));
            let name = columns.into_iter().nth(at % rows.width)?;
            Some((name, rows.names[at / rows.width], rows.values[at]))
        };
        let of_pressure = usize::from(self.has_pressure);
        let of_origin = if self.has_origin { self.dim } else { 0 };
        let nodal = [
            ("displacement", self.dim),
            ("force of supports and loads", self.dim),
            ("pressure", of_pressure),
            ("rate of the pressure", of_pressure),
            ("displacement at the start", of_origin),
            ("released reaction", self.dim),
            ("jump of the loads", self.dim),
            ("displacement at the start of a stage", self.nodal.width),
        ];
        find(&self.nodal, &nodal).or_else(|| {
            let interface = [
                ("largest jump of the history", 1),
                ("dissipated energy", 1),
                ("sliding", 3),
                ("work of friction", 1),
                ("misfit", 3),
                ("jump at the start", 3),
            ];
            find(&self.interface, &interface)
        })
    }
}

impl Stepper<'_> {
    /// The accepted states that are not stable, those of earlier runs first. Local.
    pub fn instabilities_in_words(&self) -> Vec<String> {
        let found = self.instabilities.iter().map(|found| found.words(self.case));
        self.earlier.instabilities.iter().cloned().chain(found).collect()
    }

    /// The accepted states that are not unique, those of earlier runs first. Local.
    pub fn bifurcations_in_words(&self) -> Vec<String> {
        let found = self.bifurcations.iter().map(|found| found.words(self.case));
        self.earlier.bifurcations.iter().cloned().chain(found).collect()
    }

    /// What else is to be said of accepted states, those of earlier runs first. Local.
    pub fn remarks(&self) -> Vec<String> {
        let of_flow = self.coupling.iter().flat_map(|coupling| &coupling.flow.remarks);
        let mut all: Vec<String> = Vec::new();
        for remark in self.earlier.remarks.iter().chain(of_flow).chain(&self.remarks) {
            if !all.contains(remark) {
                all.push(remark.clone());
            }
        }
        all
    }

    /// Time of the last accepted state (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The last accepted state. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn state(&self) -> Result<State> {
        let (nodal, interface) = (self.nodal_rows(), self.interface_rows());
        let (dim, has_pressure) = (self.problem.all.dim, self.coupling.is_some());
        let (has_origin, step) = (self.problem.initial_stress.is_some(), self.step_state());
        Ok(State { dim, has_pressure, has_origin, step, nodal, interface })
    }

    /// Numbers of a row of [`State::nodal`]. Local.
    pub fn nodal_width(&self) -> usize {
        let of_start = usize::from(self.problem.initial_stress.is_some());
        let of_stages = if self.stage > 0 { 2 + self.stage } else { 0 };
        self.before_origin() + (of_start + of_stages) * self.problem.all.dim
    }

    /// Numbers of a row of [`State::interface`]. Local.
    pub fn interface_width(&self) -> usize {
        HISTORY_WIDTH + if self.stage > 0 { 6 } else { 0 }
    }

    /// Numbers of a nodal row before the displacement from which results count. Local.
    fn before_origin(&self) -> usize {
        2 * self.problem.all.dim + if self.coupling.is_some() { 2 } else { 0 }
    }

    /// [`State::nodal`] of the last accepted state. Collective.
    fn nodal_rows(&self) -> Rows {
        let all = &self.problem.all;
        let dim = all.dim;
        let names: Vec<u64> = all.nodes.names[..all.nodes.owned].to_vec();
        let pressure = self.coupling.as_ref().map(|coupling| {
            let flow = &coupling.flow;
            let none = Vec::new();
            let rate = flow.pace.as_ref().and_then(|pace| pace.rate.as_ref()).unwrap_or(&none);
            [flow.at_corners(all, flow.accepted_pressure()), flow.at_corners(all, rate)]
        });
        let width = self.nodal_width();
        let of_stages = self.of_stages();
        // Before the equilibrium at the start is found there is no origin.
        let mut origin = self.problem.origin.clone();
        origin.resize(self.problem.initial_stress.as_ref().map_or(0, |of| of.force.len()), 0.0);
        let mut values = Vec::with_capacity(names.len() * width);
        let rows = self.work.displacement.chunks_exact(dim).zip(self.work.force.chunks_exact(dim));
        for (node, (displacement, force)) in rows.enumerate() {
            values.extend(displacement.iter().chain(force));
            values.extend(pressure.iter().flatten().map(|of| of[node]));
            values.extend(origin.iter().skip(node * dim).take(dim));
            values.extend(of_stages.iter().flat_map(|of| &of[node * dim..][..dim]));
        }
        Rows { width, names, values }
    }

    /// What of [`State::nodal`] a later stage has, each by owned unknown. Local.
    fn of_stages(&self) -> Vec<&[f64]> {
        let (Some(carried), Some(release)) = (&self.carried, &self.problem.release) else {
            return Vec::new();
        };
        // What the jump is made of stands at the owners alone.
        let owned = [&release.force[..], &carried.jump[..release.force.len()]];
        owned.into_iter().chain(carried.starts.iter().map(|start| &start[..])).collect()
    }

    /// [`State::interface`] of the last accepted state. Local.
    pub(super) fn interface_rows(&self) -> Rows {
        let (all, interfaces) = (&self.problem.all, &self.problem.interfaces);
        let owned = &all.secondary[..all.owned_secondary()];
        let of_node = |index: usize| -> (u64, Vec<f64>) {
            let Sliding { at: [first, second], path, energy, .. } = interfaces.sliding[index];
            let (largest, dissipated) = (interfaces.committed[index], interfaces.dissipated[index]);
            let mut row = vec![largest, dissipated, first, second, path, energy];
            if self.stage > 0 {
                let of = |list: &[[f64; 3]]| list.get(index).copied().unwrap_or_default();
                row.extend([of(&interfaces.misfit), of(&interfaces.origin)].concat());
            }
            (all.nodes.names[owned[index].node as usize], row)
        };
        let mut rows: Vec<_> = (0..owned.len()).map(of_node).collect();
        rows.sort_unstable_by_key(|row| row.0);
        Rows {
            width: self.interface_width(),
            names: rows.iter().map(|row| row.0).collect(),
            values: rows.into_iter().flat_map(|row| row.1).collect(),
        }
    }

    /// What of the last accepted state is not a field. Local.
    fn step_state(&self) -> StepState {
        let problem = &self.problem;
        let Energy { elastic, dissipated, external, friction, .. } = self.energy;
        let Accepted { newton_iterations, linear_iterations, steps, .. } = self.since_instant;
        StepState {
            time: self.time,
            step: self.step.is_finite().then_some(self.step),
            energy: [elastic, dissipated, external, friction],
            elsewhere: self.work.elsewhere,
            fluid: self.fluid_state(),
            has_begun: self.has_begun,
            elastic_at_start: self.work.elastic_at_start,
            ramp: self.grows_until(),
            platens: problem.platens.as_ref().map_or_else(Vec::new, |of| of.platens.jump.clone()),
            remarks: self.remarks(),
            residual_norm: problem.residual_norm,
            scales: problem.convergence.accepted_scales(),
            load_factor: problem.path.as_ref().map(|path| path.accepted_factor()),
            tries_smaller_steps: self.tries_smaller_steps,
            since_instant: [newton_iterations, linear_iterations, steps],
            instabilities: self.instabilities_in_words(),
            bifurcations: self.bifurcations_in_words(),
        }
    }

    /// The fluid at the last accepted state. Local.
    fn fluid_state(&self) -> FluidState {
        let work = self.energy.fluid;
        let Some(Coupling { flow, .. }) = &self.coupling else {
            return FluidState { work, ..FluidState::default() };
        };
        let pace = flow.pace.as_ref();
        FluidState {
            work,
            balance: flow.balance,
            scale: flow.accepted_scale(),
            next_step: pace.map_or(NextStep::First, Pace::next_step),
            largest_pressure: pace.map_or(0.0, |pace| pace.largest),
        }
    }

    /// Goes on from a state: `nodal` and `interface` are its fields in slabs. Collective.
    ///
    /// # Errors
    /// `Input` when a secondary node has no row; `System` when PETSc fails.
    pub fn resume(&mut self, step: StepState, nodal: &Rows, interface: &Rows) -> Result<()> {
        self.resume_nodal(nodal, step.has_begun)?;
        let problem = &mut self.problem;
        let (comm, total) = (problem.comm, problem.all.nodes.total);
        let absent = || Error::Input("the checkpoint lacks a node of this mesh".into());
        let secondary: Vec<u64> = problem.all.secondary[..problem.all.owned_secondary()]
            .iter()
            .map(|rows| problem.all.nodes.names[rows.node as usize])
            .collect();
        let rows = comm.from_slabs(total, interface, &secondary);
        let rows: Option<Vec<Vec<f64>>> = rows.into_iter().collect();
        let rows = comm.agree(rows.ok_or_else(absent))?;
        problem.interfaces.committed = rows.iter().map(|row| row[0]).collect();
        problem.interfaces.dissipated = rows.iter().map(|row| row[1]).collect();
        let sliding = |row: &Vec<f64>| Sliding {
            at: [row[2], row[3]],
            path: row[4],
            energy: row[5],
            ..Sliding::default()
        };
        problem.interfaces.sliding = rows.iter().map(sliding).collect();
        problem.interfaces.resume_stage(&rows, HISTORY_WIDTH);
        problem.convergence.resume(step.scales);
        problem.residual_norm = step.residual_norm;
        if let (Some(path), Some(factor)) = (&mut problem.path, step.load_factor) {
            path.resume(factor);
        }
        self.has_begun |= step.has_begun;
        // Nothing acts on the undeformed state yet, whatever its pressures.
        let acts = step.time > self.case.start
            || self.stage > 0
            || step.has_begun && self.starts_in_equilibrium();
        self.resume_flow(nodal, step.fluid, acts)?;
        self.resume_load(step.time, step.fluid.work)?;
        let [elastic, dissipated, external, friction] = step.energy;
        self.energy = Energy { elastic, dissipated, external, friction, fluid: step.fluid.work };
        self.work.total = external;
        (self.work.elsewhere, self.work.elastic_at_start) = (step.elsewhere, step.elastic_at_start);
        self.time = step.time;
        self.step = step.step.unwrap_or(f64::INFINITY);
        self.tries_smaller_steps = step.tries_smaller_steps;
        let [newton_iterations, linear_iterations, steps] = step.since_instant;
        let counts =
            Accepted { newton_iterations, linear_iterations, steps, ..Accepted::default() };
        self.since_instant = counts;
        if let Some(system) = &mut self.problem.platens
            && step.platens.len() == system.platens.jump.len()
        {
            system.platens.jump.clone_from(&step.platens);
        }
        if let Some(end) = step.ramp {
            self.grow_until(end)?;
        }
        if acts {
            self.resume_tractions()?;
        }
        self.earlier = step;
        Ok(())
    }

    /// Goes on from the displacements and forces among `nodal` rows in slabs, and where the run
    /// `has_begun` from the origin of results. Collective.
    fn resume_nodal(&mut self, nodal: &Rows, has_begun: bool) -> Result<()> {
        let (place, problem) = (self.before_origin(), &mut self.problem);
        let (comm, all) = (problem.comm, Rc::clone(&problem.all));
        let dim = all.dim;
        let rows = comm.from_slabs(all.nodes.total, nodal, &all.nodes.names[..all.nodes.owned]);
        let rows: Option<Vec<Vec<f64>>> = rows.into_iter().collect();
        let absent = || Error::Input("the checkpoint lacks a node of this mesh".into());
        let rows = comm.agree(rows.ok_or_else(absent))?;
        let columns = |from: usize| {
            rows.iter().flat_map(move |row| &row[from..from + dim]).copied().collect()
        };
        self.work.displacement = columns(0);
        self.work.force = columns(dim);
        if has_begun && problem.initial_stress.is_some() {
            problem.origin = columns(place);
            problem.origin.resize(problem.displacement.len(), 0.0);
            all.nodes.update_ghosts(&mut problem.origin, all.dim);
            problem.interfaces.count_from(&all, &problem.origin);
        }
        self.x.write()?[..self.work.displacement.len()].copy_from_slice(&self.work.displacement);
        Ok(())
    }

    /// Finds the tractions of the state that `self.x` holds. Collective.
    pub(super) fn resume_tractions(&mut self) -> Result<()> {
        let norm = self.problem.residual_norm;
        self.set_accepted_load()?;
        if let Some(Coupling { flow, .. }) = &self.coupling {
            let force = &mut self.problem.pore_force;
            force.clear();
            force.resize(self.problem.displacement.len(), 0.0);
            flow.add_forces(&self.problem.all, force);
        }
        let u = self.work.displacement.clone();
        self.problem.out_of_balance(&u)?;
        self.problem.interfaces.take_tractions(&self.problem.all);
        self.problem.residual_norm = norm;
        Ok(())
    }

    /// Goes on with a pressure that is a load, from the work it has done. Collective.
    fn resume_load(&mut self, time: f64, work: f64) -> Result<()> {
        let problem = &mut self.problem;
        let Some(known) = &mut problem.known_pressure else { return Ok(()) };
        problem.comm.agree(known.set(time))?;
        let mut force = known.forces(&problem.all);
        problem.all.nodes.add_to_owners(&mut force, problem.all.dim);
        force.truncate(self.work.displacement.len());
        (self.work.pore_force, self.work.of_fluid) = (force, work);
        Ok(())
    }

    /// Goes on from the pressures among `nodal` rows in slabs; the displacements are those of
    /// `self.x`. Whether the pressures have done work already is `acts`. Collective.
    fn resume_flow(&mut self, nodal: &Rows, fluid: FluidState, acts: bool) -> Result<()> {
        let Some(coupling) = &mut self.coupling else { return Ok(()) };
        let problem = &mut self.problem;
        let (comm, all) = (problem.comm, Rc::clone(&problem.all));
        let flow = &mut coupling.flow;
        let rows = comm.from_slabs(
            all.nodes.total,
            nodal,
            &flow.space.nodes.names[..flow.space.nodes.owned],
        );
        let rows: Option<Vec<Vec<f64>>> = rows.into_iter().collect();
        let absent = || Error::Input("the checkpoint lacks a pressure of this mesh".into());
        let rows = comm.agree(rows.ok_or_else(absent))?;
        let column = |place: usize| rows.iter().map(|row| row[2 * all.dim + place]).collect();
        let (pressures, rate): (Vec<f64>, Vec<f64>) = (column(0), column(1));
        let displacements = self.work.displacement.len();
        problem.displacement[..displacements].copy_from_slice(&self.work.displacement);
        all.nodes.update_ghosts(&mut problem.displacement, all.dim);
        if let Some(pace) = &mut flow.pace {
            pace.resume(fluid.next_step, rate, fluid.largest_pressure);
        }
        flow.resume(problem, &pressures, fluid.balance, fluid.scale);
        for (x, p) in self.x.write()?[displacements..].iter_mut().zip(&pressures) {
            *x = p / flow.scale;
        }
        self.work.of_fluid = fluid.work;
        if acts {
            let mut force = vec![0.0; all.nodes.len() * all.dim];
            flow.add_forces(&all, &mut force);
            all.nodes.add_to_owners(&mut force, all.dim);
            force.truncate(displacements);
            self.work.pore_force = force;
        }
        Ok(())
    }
}
