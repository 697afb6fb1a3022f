//! Interfaces from one stage of a case to the next.
//!
//! Where supports come or go at an interface its multipliers are shared out anew, and the rows of
//! the new stage give other jumps and other forces for what is the same state. Laws go on from the
//! jumps and tractions that they had; what is out of balance by that is released over the stage.

use super::model::Left;
use super::state::HISTORY_WIDTH;
use super::stepping::Stepper;
use crate::assembly::Discretization;
use crate::comm::Rows;
use crate::error::Result;

/// Numbers by node that a stage leaves: history, which components have a multiplier, then by
/// component the jump that the law sees (m), the traction (Pa), and the jump of the results (m).
const WIDTH: usize = HISTORY_WIDTH + 12;

impl Stepper<'_> {
    /// What this stage leaves at the interfaces. Local.
    pub(super) fn left_at_interfaces(&self) -> Rows {
        let (all, state) = (&self.problem.all, &self.problem.interfaces);
        let history = self.interface_rows();
        let indices = by_name(all);
        let rows = history.values.chunks_exact(history.width).zip(&indices);
        let values = rows.flat_map(|(row, index)| {
            let Left { has_multiplier, jump, traction, shown } = state.left_at(all, *index);
            let has = has_multiplier.map(|has| f64::from(u8::from(has)));
            [&row[..HISTORY_WIDTH], &has, &jump, &traction, &shown].concat()
        });
        Rows { width: WIDTH, values: values.collect(), names: history.names.clone() }
    }

    /// The history of the owned secondary nodes of this stage, out of what the one before has left
    /// in slabs; of those that had no multiplier it is that of the start. Then what they had, by
    /// index. Collective.
    pub(super) fn taken_interfaces(&self, nodes: u64, handed: &Rows) -> (Rows, Vec<Option<Left>>) {
        let (all, state) = (&self.problem.all, &self.problem.interfaces);
        let indices = by_name(all);
        let name = |index: &usize| all.nodes.names[all.secondary[*index].node as usize];
        let names: Vec<u64> = indices.iter().map(name).collect();
        let found = self.problem.comm.from_slabs(nodes, handed, &names);
        let (mut values, mut left) = (Vec::new(), vec![None; indices.len()]);
        for (row, index) in found.into_iter().zip(indices) {
            let at_start = [state.initial[index], state.dissipated_before(all, index)];
            let mut history =
                row.as_ref().map_or(&at_start[..], |row| &row[..HISTORY_WIDTH]).to_vec();
            history.resize(self.interface_width(), 0.0);
            values.extend(history);
            left[index] = row.map(|row| {
                let of = |k: usize| -> [f64; 3] {
                    std::array::from_fn(|c| row[HISTORY_WIDTH + 3 * k + c])
                };
                let has_multiplier = of(0).map(|has| has > 0.5);
                Left { has_multiplier, jump: of(1), traction: of(2), shown: of(3) }
            });
        }
        (Rows { width: self.interface_width(), values, names }, left)
    }

    /// Lets interfaces go on from what the stage before has `left`, and adds what is out of balance
    /// by that to what is released over the stage. Collective.
    pub(super) fn settle(&mut self, left: &[Option<Left>]) -> Result<()> {
        let problem = &mut self.problem;
        let (comm, all) = (problem.comm, std::rc::Rc::clone(&problem.all));
        let tractions = problem.interfaces.go_on_from(&all, left);
        let mut force = vec![0.0; problem.balance.len()];
        all.add_tractions(|index, c| tractions[index][c], &mut force);
        let free = all.prescribed.iter().flat_map(|of| of.iter().take(all.dim));
        let forces = force.iter().zip(&problem.bulk_force).zip(free);
        let left: Vec<f64> = forces
            .take(self.work.force.len())
            .map(|((traction, bulk), is_held)| if *is_held { 0.0 } else { traction + bulk })
            .collect();
        let mut largest = [left.iter().fold(0.0, |most: f64, force| most.max(force.abs()))];
        comm.max(&mut largest);
        // Less is what the convergence test leaves.
        if largest[0] > self.case.solver.tolerance * problem.convergence.force_scale()
            && let Some(release) = &mut problem.release
        {
            for force in [&mut release.force, &mut self.work.force] {
                force.iter_mut().zip(&left).for_each(|(force, left)| *force += left);
            }
        }
        self.resume_tractions()
    }
}

/// The indices of the owned secondary nodes, by rising name. Local.
fn by_name(all: &Discretization) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..all.owned_secondary()).collect();
    indices.sort_unstable_by_key(|index| all.name_and_interface(*index).0);
    indices
}
