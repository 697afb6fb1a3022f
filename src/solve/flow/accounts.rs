//! What the fluid does from one accepted state to the next, and the accounts of it.

use super::balance::Contents;
use super::{Flow, Source};
use crate::assembly::Discretization;
use crate::bulk::FlowStep;
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
        space.add_stored(all, (u, p), step.lumped, stored);
        space.add_flow(all, p, &step.gravity, flow);
        if space.films.are_there() {
            let mut sizes = vec![0.0; p.len()];
            self.in_films.clear(p.len());
            let Contents { stored, flow } = &mut self.in_films;
            space.films.add_stored(all, (u, p), (stored, &mut sizes));
            space.films.add_flow(all, (u, p), (&step.gravity, 1.0), (flow, &mut sizes));
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

    /// The balance of the pores in the step, with the fluxes through the surfaces, at all local
    /// nodes, not summed, and the magnitudes of its parts (m3); in `every` cell or where a pressure
    /// is to be found.
    fn of_pores(&self, all: &Discretization, u: &[f64], every: bool) -> [Vec<f64>; 2] {
        let (mut rows, mut sizes) = (vec![0.0; self.before.len()], vec![0.0; self.before.len()]);
        let state = (u, &self.pressure[..], &self.before[..]);
        self.space.add_balance(all, state, &self.step, every, (&mut rows, &mut sizes));
        self.add_start(&self.in_pores, &mut rows);
        self.add_source(&self.inflow, &mut rows, &mut sizes);
        [rows, sizes]
    }

    /// Takes what a source gives in the step off the balance.
    fn add_source(&self, source: &Source, rows: &mut [f64], sizes: &mut [f64]) {
        let ends = self.weights();
        for (i, (row, size)) in rows.iter_mut().zip(sizes).enumerate() {
            let given: f64 = ends.iter().zip(&source.at).map(|(part, at)| part * at[i]).sum();
            *row -= given;
            *size += given.abs();
        }
    }

    /// Adds what is no part of the pores: films, injection, and what the last step left.
    fn complete(&self, all: &Discretization, u: &[f64], [rows, sizes]: &mut [Vec<f64>; 2]) {
        let (films, p) = (&self.space.films, &self.pressure[..]);
        let ends = self.weights();
        films.add_stored(all, (u, p), (&mut *rows, &mut *sizes));
        films.add_flow(all, (u, p), (&self.step.gravity, ends[1]), (&mut *rows, &mut *sizes));
        self.add_start(&self.in_films, rows);
        self.add_source(&self.injection, rows, sizes);
        rows.iter_mut().zip(&self.left).for_each(|(row, left)| *row += left);
    }

    /// The balance of the step at all local nodes, not summed, and the magnitudes of its parts
    /// (m3).
    pub(super) fn rows(&self, all: &Discretization, u: &[f64]) -> [Vec<f64>; 2] {
        let mut rows = self.of_pores(all, u, false);
        self.complete(all, u, &mut rows);
        rows
    }

    /// Makes the state that was evaluated last an accepted one: `u` are its displacements at all
    /// local nodes. Collective.
    pub fn accept(&mut self, comm: &Comm, all: &Discretization, u: &[f64]) {
        self.scales[0] = self.scales[0].max(self.scales[1]);
        let mut sums = vec![0.0; 3 + 2 * self.into_sides.len()];
        let mut rows = self.of_pores(all, u, true);
        // What the pores at a lip take up comes from the interface.
        for (node, side) in &self.lips {
            sums[3 + side] += self.density * rows[0][*node as usize] / self.step.length;
        }
        self.complete(all, u, &mut rows);
        let [mut rows, _] = rows;
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
