//! From one stage of a case to the next: states go on under other supports, loads and materials.

use std::rc::Rc;

use super::Model;
use super::flow::NextStep;
use super::model::{Left, cells};
use super::problem::{Prestress, Release};
use super::stepping::{Carried, FluidState, StepState, Stepper};
use crate::assembly::{CellSet, Discretization};
use crate::case::Case;
use crate::comm::Rows;
use crate::error::{Error, Result};
use crate::mesh::LocalMesh;

/// What a stage leaves to the next one, in slabs.
pub struct Handover {
    /// What is not a field.
    step: StepState,
    /// By node and along the axes: displacement (m), forces of the supports and of the loads (N);
    /// with stresses at the start the displacement from which results count (m); then the
    /// displacements at the starts of the stages but the first (m); with flow last the pressure
    /// (Pa).
    nodal: Rows,
    /// By secondary node, see `settle`.
    interface: Rows,
    /// Names of nodes are below this.
    nodes: u64,
}

/// Why a state does not fit.
fn lacking() -> Error {
    Error::Input("the mesh of this stage has nodes that the one before did not have".into())
}

impl Stepper<'_> {
    /// What the next stage needs of the last accepted state. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub fn hand_over(&self) -> Result<Handover> {
        let problem = &self.problem;
        let (comm, all) = (problem.comm, &problem.all);
        let (dim, owned) = (all.dim, all.nodes.owned);
        let displacement = along_axes(all, &self.work.displacement);
        let mut support = vec![0.0; all.nodes.len() * dim];
        for node in 0..owned {
            let of = |c: usize| match c < dim && all.prescribed[node][c] {
                true => problem.balance[node * dim + c],
                false => 0.0,
            };
            all.frames.spread(node as u32, std::array::from_fn(of), |at, force| {
                (0..dim).for_each(|c| support[at as usize * dim + c] += force[c]);
            });
        }
        all.nodes.add_to_owners(&mut support, dim);
        let mut load = vec![0.0; all.nodes.len() * dim];
        let added = problem.loads.add(self.time, |name, component, force| {
            let node = all.nodes.local(name).expect("loads act on the rank's own cells") as usize;
            load[node * dim + component] += force;
        });
        comm.agree(added)?;
        all.nodes.add_to_owners(&mut load, dim);
        let origin = problem.initial_stress.as_ref().map(|_| along_axes(all, &problem.origin));
        let mut columns: Vec<&[f64]> = vec![&displacement[..], &support, &load];
        columns.extend(origin.iter().map(|of| &of[..]));
        columns.extend(self.carried.iter().flat_map(|carried| &carried.starts).map(|s| &s[..]));
        let pressure = self.coupling.as_ref().map(|coupling| {
            let flow = &coupling.flow;
            flow.at_corners(all, flow.accepted_pressure())
        });
        let nodal = rows(all, &columns, pressure.iter().map(|of| &of[..]));
        let (step, nodes) = (self.state()?.step, all.nodes.total);
        let interface = comm.to_slabs(nodes, &self.left_at_interfaces());
        Ok(Handover { step, nodal: comm.to_slabs(nodes, &nodal), interface, nodes })
    }

    /// The fields of the state at the start of a stage, in slabs: as [`super::State::nodal`] and
    /// [`super::State::interface`]; and what the owned nodes of interfaces had. Collective.
    fn taken_over(&mut self, handed: &Handover) -> Result<([Rows; 2], Vec<Option<Left>>)> {
        let (comm, dim) = (self.problem.comm, self.problem.all.dim);
        let all = Rc::clone(&self.problem.all);
        if handed.nodes != all.nodes.total {
            return Err(lacking());
        }
        let names = &all.nodes.names[..all.nodes.owned];
        let found: Option<Vec<_>> =
            comm.from_slabs(handed.nodes, &handed.nodal, names).into_iter().collect();
        let found = comm.agree(found.ok_or_else(lacking))?;
        let column = |place: usize| -> Vec<f64> {
            found.iter().flat_map(|row| &row[place * dim..][..dim]).copied().collect()
        };
        let start = column(0);
        let displacement = unknowns(&all, &start);
        let [support, load] = [column(1), column(2)].map(|force| on_unknowns(&all, &force));
        let is_held = |unknown: usize| all.prescribed[unknown / dim][unknown % dim];
        let unheld = support.iter().enumerate();
        let released: Vec<f64> =
            unheld.map(|(unknown, force)| if is_held(unknown) { 0.0 } else { *force }).collect();
        // The stresses at the start are no load.
        let stress = self.problem.initial_stress.take();
        let of_start = usize::from(stress.is_some());
        let set = self.problem.set_load(handed.step.time);
        self.problem.initial_stress = stress;
        set?;
        let mut jump = self.problem.load.clone();
        all.nodes.add_to_owners(&mut jump, dim);
        jump.truncate(load.len());
        jump.iter_mut().zip(&load).for_each(|(jump, before)| *jump -= before);
        let force: Vec<f64> = support.iter().zip(&load).map(|(s, l)| s + l).collect();
        let origin = (of_start > 0).then(|| unknowns(&all, &column(3)));
        let places = 3 + of_start..2 + of_start + self.stage;
        let mut starts: Vec<Vec<f64>> = places.map(column).collect();
        starts.push(start);
        let pressure: Option<Vec<f64>> =
            self.coupling.as_ref().map(|_| found.iter().map(|row| row[row.len() - 1]).collect());
        let rate = pressure.as_ref().map(|of| vec![0.0; of.len()]);
        let mut values = Vec::new();
        for node in 0..all.nodes.owned {
            let of = |column: &Vec<f64>| column[node * dim..][..dim].to_vec();
            values.extend([&displacement, &force].into_iter().flat_map(of));
            values.extend(pressure.iter().chain(&rate).map(|of| of[node]));
            let of_stages = [&released, &jump].into_iter().chain(&starts);
            values.extend(origin.iter().chain(of_stages).flat_map(of));
        }
        let nodal = Rows { width: self.nodal_width(), names: names.to_vec(), values };
        let (interface, left) = self.taken_interfaces(handed.nodes, &handed.interface);
        let [nodal, interface] = [&nodal, &interface].map(|of| comm.to_slabs(handed.nodes, of));
        Ok(([nodal, interface], left))
    }

    /// Takes what a later stage has from those before it out of the rows of its state, in slabs.
    /// Collective.
    fn carry(&mut self, time: f64, until: f64, nodal: &Rows) -> Result<()> {
        let problem = &mut self.problem;
        let (comm, all) = (problem.comm, &problem.all);
        let dim = all.dim;
        let names = &all.nodes.names[..all.nodes.owned];
        let found: Option<Vec<_>> =
            comm.from_slabs(all.nodes.total, nodal, names).into_iter().collect();
        let found = comm.agree(found.ok_or_else(lacking))?;
        let first = nodal.width - (2 + self.stage) * dim;
        let column = |place: usize| -> Vec<f64> {
            found.iter().flat_map(|row| &row[first + place * dim..][..dim]).copied().collect()
        };
        let starts: Vec<Vec<f64>> = (2..2 + self.stage).map(column).collect();
        let start = starts.last().map_or_else(Vec::new, |start| unknowns(all, start));
        // Sums stand at the owners alone.
        let mut jump = column(1);
        jump.resize(all.nodes.len() * dim, 0.0);
        problem.release = Some(Release::new(column(0), time, until));
        self.carried = Some(Carried { starts, start, jump });
        Ok(())
    }
}

impl Model<'_> {
    /// Goes on from a state of the stage of this model: `nodal` and `interface` are its fields in
    /// slabs. `case` is the one with all stages. Collective.
    ///
    /// # Errors
    /// As [`Stepper::resume`].
    pub fn resume(
        &mut self,
        case: &Case,
        step: StepState,
        nodal: &Rows,
        interface: &Rows,
    ) -> Result<()> {
        let stage = self.stepper.stage;
        if stage > 0 {
            let own = self.stepper.case;
            let until = own.time.last().copied().unwrap_or(own.start);
            self.stepper.carry(own.start, until, nodal)?;
            let cases = case.in_stages();
            let starts = self.stepper.carried.iter().flat_map(|carried| &carried.starts);
            let all = &self.stepper.problem.all;
            let prestress = prestress(&cases[..=stage], &self.mesh, all, starts);
            self.stepper.problem.prestress = prestress;
        }
        self.stepper.resume(step, nodal, interface)
    }

    /// Starts the stage of this model from the state that the one before has left. `case` is the
    /// one with all stages. Collective.
    ///
    /// # Errors
    /// `Input` when the mesh is another one, or a formula gives no finite number; `System` when
    /// PETSc fails.
    pub fn take_over(&mut self, case: &Case, handed: Handover) -> Result<()> {
        let ([nodal, interface], left) = self.stepper.taken_over(&handed)?;
        // What follows is not smooth with what was before.
        let fluid = FluidState { next_step: NextStep::First, ..handed.step.fluid };
        let [elastic, dissipated, _, friction] = handed.step.energy;
        let elsewhere = [0.0; 3];
        let step = StepState { step: None, ramp: None, fluid, elsewhere, ..handed.step };
        self.resume(case, step, &nodal, &interface)?;
        let stepper = &mut self.stepper;
        stepper.settle(&left)?;
        stepper.platens_jump_from_here()?;
        let here = stepper.work.energies(&stepper.problem);
        let before = [elastic, dissipated, friction];
        // What new supports hold at interfaces has no multiplier any more, but an energy.
        stepper.work.elsewhere = std::array::from_fn(|i| before[i] - here[i]);
        Ok(())
    }
}

/// The stresses that stay from earlier stages: `starts` are the displacements at the start of each
/// of the `cases` but the first, of owned nodes along the axes. None where no stiffness changes.
/// Collective.
fn prestress<'s>(
    cases: &[&Case],
    mesh: &LocalMesh,
    all: &Discretization,
    starts: impl Iterator<Item = &'s Vec<f64>>,
) -> Option<Prestress> {
    let elastic = |case: &Case| -> Vec<[f64; 2]> {
        case.materials.iter().map(|m| [m.young_modulus, m.poisson_ratio]).collect()
    };
    let dim = all.dim;
    let mut total: Option<Prestress> = None;
    for (pair, start) in cases.windows(2).zip(starts) {
        if elastic(pair[0]) == elastic(pair[1]) {
            continue;
        }
        let mut u = start.clone();
        u.resize(all.nodes.len() * dim, 0.0);
        all.nodes.update_ghosts(&mut u, dim);
        let [before, after] = [pair[0], pair[1]].map(|case| cells(case, mesh, &all.nodes));
        let [mut force, mut now] = [vec![0.0; u.len()], vec![0.0; u.len()]];
        before.add_forces(CellSet::All, &u, &mut force, None);
        after.add_forces(CellSet::All, &u, &mut now, None);
        force.iter_mut().zip(&now).for_each(|(force, now)| *force -= now);
        let none = || Prestress {
            force: vec![0.0; u.len()],
            energy: 0.0,
            stress: vec![[0.0; 6]; before.len()],
        };
        let sum = total.get_or_insert_with(none);
        let work: f64 = force.iter().zip(&u).map(|(f, u)| f * u).sum();
        sum.energy -= 0.5 * work;
        sum.force.iter_mut().zip(&force).for_each(|(sum, force)| *sum += force);
        let mut nodal = Vec::new();
        for (cell, sum) in sum.stress.iter_mut().enumerate() {
            nodal.clear();
            let nodes = before.nodes(cell).iter();
            nodes.for_each(|node| nodal.extend_from_slice(&u[*node as usize * dim..][..dim]));
            let [old, new] = [&before, &after].map(|cells| cells.stress(cell, &nodal));
            (0..6).for_each(|i| sum[i] += old[i] - new[i]);
        }
    }
    if let Some(total) = &mut total {
        all.frames.fold(&mut total.force);
    }
    total
}

/// Displacements along the axes of owned nodes for their unknowns, or those of all local nodes (m).
/// Collective.
fn along_axes(all: &Discretization, unknowns: &[f64]) -> Vec<f64> {
    let mut local = unknowns.to_vec();
    local.resize(all.nodes.len() * all.dim, 0.0);
    all.nodes.update_ghosts(&mut local, all.dim);
    all.frames.displacements(&local)[..all.nodes.owned * all.dim].to_vec()
}

/// The unknowns of owned nodes for their displacements along the axes (m). Collective.
fn unknowns(all: &Discretization, displacement: &[f64]) -> Vec<f64> {
    let dim = all.dim;
    let mut local = displacement.to_vec();
    local.resize(all.nodes.len() * dim, 0.0);
    all.nodes.update_ghosts(&mut local, dim);
    let field = |node: u32| {
        std::array::from_fn(|c| if c < dim { local[node as usize * dim + c] } else { 0.0 })
    };
    let nodes = 0..all.nodes.owned as u32;
    nodes.flat_map(|node| all.frames.unknowns(node, field).into_iter().take(dim)).collect()
}

/// Forces on the unknowns of owned nodes for those along the axes (N). Collective.
fn on_unknowns(all: &Discretization, force: &[f64]) -> Vec<f64> {
    let mut local = force.to_vec();
    local.resize(all.nodes.len() * all.dim, 0.0);
    all.frames.fold(&mut local);
    all.nodes.add_to_owners(&mut local, all.dim);
    local.truncate(force.len());
    local
}

/// Rows of the owned nodes, of vectors and then of numbers by node.
fn rows<'c>(
    all: &Discretization,
    vectors: &[&[f64]],
    numbers: impl Iterator<Item = &'c [f64]> + Clone,
) -> Rows {
    let (dim, count) = (all.dim, numbers.clone().count());
    let mut values = Vec::new();
    for node in 0..all.nodes.owned {
        values.extend(vectors.iter().flat_map(|of| &of[node * dim..][..dim]));
        values.extend(numbers.clone().map(|of| of[node]));
    }
    let names = all.nodes.names[..all.nodes.owned].to_vec();
    Rows { width: vectors.len() * dim + count, names, values }
}
