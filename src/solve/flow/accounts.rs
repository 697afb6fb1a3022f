//! What the fluid does from one accepted state to the next, and the accounts of it.

use super::balance::{Contents, NodalBalance};
use super::{Flow, Source};
use crate::assembly::Discretization;
use crate::bulk::{BalanceSums, FlowStep, PoroState};
use crate::comm::Comm;

impl Flow {
    /// Makes displacements `u` of all local nodes and the present pressures the state from which
    /// the next step starts. Collective.
    pub fn begin(&mut self, comm: &Comm, all: &Discretization, u: &[f64]) {
        self.keep(all, u);
        let stored = self.total_stored(comm);
        self.initial = stored - self.balance.stored / self.density;
    }

    fn total_stored(&self, comm: &Comm) -> f64 {
        let mut sum = [self.own_stored()];
        comm.sum(&mut sum);
        sum[0]
    }

    fn own_stored(&self) -> f64 {
        self.in_pores.stored.iter().chain(&self.in_films.stored).sum()
    }

    fn keep(&mut self, all: &Discretization, u: &[f64]) {
        self.before.copy_from_slice(&self.pressure);
        let (p, space, step) = (&self.pressure, &self.space, &self.step);
        self.in_pores.clear(p.len());
        let Contents { stored, flow } = &mut self.in_pores;
        let state = PoroState { displacement: u, pressure: p };
        space.add_stored(all, state, step.lumped, stored);
        space.add_flow(all, p, &step.gravity, flow);
        if space.films.are_there() {
            let mut sizes = vec![0.0; p.len()];
            self.in_films.clear(p.len());
            let Contents { stored, flow } = &mut self.in_films;
            let (rows, films) = (stored, &space.films);
            films.add_stored(all, state, BalanceSums { rows, sizes: &mut sizes });
            let sums = BalanceSums { rows: flow, sizes: &mut sizes };
            films.add_flow(all, state, &step.gravity, 1.0, sums);
        }
    }

    /// The parts of the step that count for its start and for its end (s).
    fn weights(&self) -> [f64; 2] {
        let FlowStep { length, theta, .. } = self.step;
        [(1.0 - theta) * length, theta * length]
    }

    /// Adds to the balance what was stored and flowed at the start of the step.
    fn add_start(&self, contents: &Contents, rows: &mut [f64]) {
        let start = self.weights()[0];
        for (row, (stored, flow)) in rows.iter_mut().zip(contents.stored.iter().zip(&contents.flow))
        {
            *row += start * flow - stored;
        }
    }

    /// The balance of the pores in the step, with the fluxes through the surfaces, in `every` cell
    /// or where a pressure is to be found.
    fn of_pores(&self, all: &Discretization, u: &[f64], every: bool) -> NodalBalance {
        let mut balance = NodalBalance::zero(self.before.len());
        let (end, sums) = (self.state(u), balance.sums());
        self.space.add_balance(all, end, &self.before, &self.step, every, sums);
        self.add_start(&self.in_pores, &mut balance.rows);
        self.add_source(&self.inflow, balance.sums());
        balance
    }

    /// The pressures that were evaluated last with displacements.
    fn state<'s>(&'s self, u: &'s [f64]) -> PoroState<'s> {
        PoroState { displacement: u, pressure: &self.pressure }
    }

    /// Takes what a source gives in the step off the balance.
    fn add_source(&self, source: &Source, sums: BalanceSums<'_>) {
        let (ends, BalanceSums { rows, sizes }) = (self.weights(), sums);
        for (i, (row, size)) in rows.iter_mut().zip(sizes).enumerate() {
            let given: f64 = ends.iter().zip(&source.at).map(|(part, at)| part * at[i]).sum();
            *row -= given;
            *size += given.abs();
        }
    }

    /// Adds what is no part of the pores: films, injection, and what the last step left.
    fn complete(&self, all: &Discretization, u: &[f64], balance: &mut NodalBalance) {
        let (films, state) = (&self.space.films, self.state(u));
        let ends = self.weights();
        films.add_stored(all, state, balance.sums());
        films.add_flow(all, state, &self.step.gravity, ends[1], balance.sums());
        self.add_start(&self.in_films, &mut balance.rows);
        self.add_source(&self.injection, balance.sums());
        balance.rows.iter_mut().zip(&self.left).for_each(|(row, left)| *row += left);
    }

    /// The balance of the step.
    pub(super) fn nodal_balance(&self, all: &Discretization, u: &[f64]) -> NodalBalance {
        let mut balance = self.of_pores(all, u, false);
        self.complete(all, u, &mut balance);
        balance
    }

    /// Makes the state that was evaluated last an accepted one: `u` are its displacements at all
    /// local nodes. Collective.
    pub fn accept(&mut self, comm: &Comm, all: &Discretization, u: &[f64]) {
        self.scales[0] = self.scales[0].max(self.scales[1]);
        let mut sums = vec![0.0; 3 + 2 * self.into_sides.len()];
        let mut balance = self.of_pores(all, u, true);
        // What the pores at a lip take up comes from the interface.
        for (node, side, share) in &self.lips {
            sums[3 + side] +=
                share * self.density * balance.rows[*node as usize] / self.step.length;
        }
        self.complete(all, u, &mut balance);
        let mut rows = balance.rows;
        self.space.sum(&mut rows);
        for source in [&self.inflow, &self.injection] {
            for (part, at) in self.weights().iter().zip(&source.at) {
                for s in at {
                    sums[if *s > 0.0 { 0 } else { 1 }] += self.density * part * s.abs();
                }
            }
        }
        for node in (0..self.space.nodes.owned).filter(|n| self.space.prescribed[*n]) {
            let mass = self.density * rows[node];
            sums[if mass > 0.0 { 0 } else { 1 }] += mass.abs();
        }
        self.space.for_identity_rows(|node| rows[node] = 0.0);
        self.left = rows;
        let owned = self.space.nodes.owned;
        if let Some(pace) = &mut self.pace {
            pace.go_on(&self.before[..owned], &self.pressure[..owned], self.step.length);
        }
        self.keep(all, u);
        sums[2] = self.own_stored();
        comm.sum(&mut sums);
        self.balance.inflow += sums[0];
        self.balance.outflow += sums[1];
        self.balance.stored = self.density * (sums[2] - self.initial);
        for (into, sums) in self.into_sides.iter_mut().zip(sums[3..].chunks_exact(2)) {
            into.copy_from_slice(sums);
        }
    }
}
