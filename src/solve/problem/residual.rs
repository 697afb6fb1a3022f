//! Forces of a state and the residual of the condensed form (docs/theory.md, section 4).

use super::measure::Scales;
use super::{Prestress, Problem, TangentForm, condensed};
use crate::assembly::CellSet;
use crate::interface::JumpRows;
use crate::timers::Phase;

impl Problem<'_> {
    /// Forces of the bulk at `x`, and the magnitudes of nodal forces and loads if they are wanted.
    /// Collective.
    pub(super) fn evaluate_bulk(&mut self, x: &[f64], with_scales: bool) {
        let (nodes, dim) = (&self.all.nodes, self.all.dim);
        self.displacement[..x.len()].copy_from_slice(x);
        nodes.update_ghosts(&mut self.displacement, dim);
        self.bulk_force.iter_mut().zip(&self.load).for_each(|(f, l)| *f = -l);
        self.bulk_force.iter_mut().zip(&self.pore_force).for_each(|(f, p)| *f -= p);
        if let Some(Prestress { force, .. }) = &self.prestress {
            self.bulk_force.iter_mut().zip(force).for_each(|(f, stress)| *f += stress);
        }
        let (u, force) = (&self.displacement, &mut self.bulk_force);
        if !with_scales {
            self.all.add_forces(CellSet::All, u, force, None);
            nodes.add_to_owners(force, dim);
            return;
        }
        let mut magnitude = vec![0.0; nodes.len()];
        self.all.add_forces(CellSet::All, u, force, Some(&mut magnitude));
        nodes.add_to_owners(force, dim);
        nodes.add_to_owners(&mut magnitude, 1);
        // Loads count too: they may leave the bulk without any force of its own.
        let is_loaded = self.load.iter().chain(&self.pore_force).any(|force| *force != 0.0);
        if self.comm.any(is_loaded) {
            let load = self.applied();
            for (magnitude, load) in magnitude.iter_mut().zip(load.chunks_exact(dim)) {
                let length = load.iter().map(|l| l * l).sum::<f64>().sqrt();
                *magnitude = magnitude.max(length);
            }
        }
        // Stresses at the start too, whose forces cancel at the nodes.
        if let Some(stress) = &self.initial_stress {
            let of_stress = magnitude.iter_mut().zip(&stress.magnitude);
            of_stress.for_each(|(magnitude, of_stress)| *magnitude += of_stress);
        }
        let u = self.displacement[..x.len()].chunks_exact(dim);
        let mut scales = Scales::default();
        for ((u, force), stiffness) in u.zip(&magnitude).zip(&self.stiffness) {
            scales.see(*force, u, *stiffness);
        }
        if let Some(stress) = &self.initial_stress {
            scales.displacement = scales.displacement.max(stress.displacement);
        }
        self.convergence.see_scales(self.comm, scales);
    }

    /// Loads, less the forces of the stresses at the start, and forces of the pore pressure at
    /// owned nodes (N). Collective.
    pub(super) fn applied(&self) -> Vec<f64> {
        let mut applied = self.load.clone();
        applied.iter_mut().zip(&self.pore_force).for_each(|(l, p)| *l += p);
        self.all.nodes.add_to_owners(&mut applied, self.all.dim);
        applied
    }

    /// The residual at `x`, and the scales of the state if they are wanted. Collective.
    pub(super) fn evaluate(&mut self, x: &[f64], f: &mut [f64], with_scales: bool) {
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
    pub(super) fn balance_with_laws(&mut self, f: &mut [f64]) {
        if let TangentForm::Levels(hierarchy) = &self.form {
            let state = self.interfaces.response.iter_mut().map(|r| &mut r.state);
            hierarchy.finest().choose_unknowns(state);
        }
        let dim = self.all.dim;
        let (known, known_force) = condensed::known_jumps(&self.all, &self.interfaces);
        self.known_jumps = known;
        let (all, response) = (&self.all, &self.interfaces.response);
        self.balance.fill(0.0);
        let known = |rows: &JumpRows<u32>, c: usize| match &rows.rows[c] {
            Some(row) => known_force[rows.own(c) as usize] / (row.weight * row.own),
            None => 0.0,
        };
        let traction = |index: usize, c: usize| {
            let (rows, response) = (&all.secondary[index], &response[index]);
            let friction = response.state.friction[c];
            let known = match response.state.stuck[c] {
                true => known(rows, c),
                false if friction != 0.0 => friction * known(rows, dim - 1),
                false => 0.0,
            };
            response.law_traction[c] + known
        };
        all.add_tractions(traction, &mut self.balance);
        let forces = self.balance.iter_mut().zip(&self.bulk_force).zip(&known_force);
        for (value, ((balance, bulk), known)) in f.iter_mut().zip(forces) {
            *balance += bulk;
            *value = *balance - known;
        }
        condensed::fold(self.comm, &self.all, &self.interfaces, f);
        self.see_platens(|_, i| f[i]);
        let (all, dim) = (&self.all, self.all.dim);
        // Identity rows: nothing to do where prescribed, the known jump where stuck.
        for (f, prescribed) in f.chunks_exact_mut(dim).zip(&all.prescribed) {
            if *prescribed != [false; 3] {
                let of_node = f.iter_mut().zip(prescribed).filter(|(_, prescribed)| **prescribed);
                of_node.for_each(|(f, _)| *f = 0.0);
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
