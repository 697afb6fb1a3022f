//! The saddle-point form as PETSc's SNES sees it: a cross-check of the condensed form.
//!
//! Unknowns are the displacements of all nodes and the multipliers of the secondary nodes, scaled
//! as [`SaddleTangent`] says. Newton's method is the same as that of the condensed form, since
//! equilibrium is linear: after a correction the multipliers are those that the bulk transmits.

use super::convergence::Iterate;
use super::measure::Worst;
use super::platen_columns::Linearised;
use super::{PlatenSystem, Problem};
use crate::assembly::{CellSet, LawDerivative, SaddleTangent};
use crate::error::Result;
use crate::fault;
use crate::petsc::{
    FurtherSolve, LinearTolerance, Matrix, NonlinearSystem, TangentChange, Vector, Verdict,
};
use crate::timers::Phase;

/// What the saddle-point form has beside the problem.
pub struct SaddlePoint {
    tangent: SaddleTangent,
    /// Derivatives with which the tangent was assembled, at owned secondary nodes.
    assembled: Option<Vec<LawDerivative>>,
    /// Forces on platens with the multipliers, by motion (N, N m).
    of_platens: Vec<f64>,
}

impl SaddlePoint {
    /// Nothing is assembled yet.
    pub fn new(tangent: SaddleTangent) -> Self {
        Self { tangent, assembled: None, of_platens: Vec::new() }
    }

    /// Sets the multipliers in `x` to what the bulk transmits at its displacements: the state from
    /// which the condensed form starts too. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn start(&self, problem: &mut Problem<'_>, x: &mut Vector) -> Result<()> {
        let mut x = problem.comm.agree(x.write())?;
        let dim = problem.all.dim;
        let (u, multipliers) = x.split_at_mut(problem.all.nodes.owned * dim);
        problem.evaluate_bulk(u, true);
        for (rows, own) in problem.all.secondary.iter().zip(multipliers.chunks_exact_mut(dim)) {
            for (c, row) in rows.rows[..dim].iter().enumerate() {
                let force = problem.bulk_force[rows.node as usize * dim + c];
                own[c] = row.as_ref().map_or(0.0, |row| -force / (row.own * self.tangent.scale));
            }
        }
        Ok(())
    }

    /// The change of the residual with a change of the unknowns, also of prescribed ones.
    /// Collective.
    fn forces_of(&self, problem: &Problem<'_>, change: &[f64]) -> Vec<f64> {
        let (all, scale) = (&problem.all, self.tangent.scale);
        let (dim, owned) = (all.dim, all.nodes.owned * all.dim);
        let mut u = change[..owned].to_vec();
        u.resize(all.nodes.len() * dim, 0.0);
        all.nodes.update_ghosts(&mut u, dim);
        let mut force = vec![0.0; u.len()];
        all.add_forces(CellSet::All, &u, &mut force, None);
        all.nodes.add_to_owners(&mut force, dim);
        let multipliers = &change[owned..];
        let traction = |index: usize, c: usize| {
            let row = all.secondary[index].rows[c].as_ref();
            row.map_or(0.0, |row| multipliers[index * dim + c] * scale / row.weight)
        };
        all.add_tractions(traction, &mut force);
        force.truncate(owned);
        for (index, law) in self.assembled.iter().flatten().enumerate() {
            let rows = &all.secondary[index];
            for c in 0..dim {
                if rows.rows[c].is_none() {
                    force.push(scale * multipliers[index * dim + c]);
                    continue;
                }
                let jump = |d: usize| {
                    let answer = law.augmentation * law.compliance[c][d];
                    (f64::from(u8::from(c == d)) - answer) * all.jump(index, d, &u)
                };
                let answer = |d: usize| law.compliance[c][d] * traction(index, d);
                let sum: f64 = (0..dim).map(|d| jump(d) - answer(d)).sum();
                force.push(scale * sum);
            }
        }
        force
    }
}

/// A problem in the saddle-point form.
pub(in crate::solve) struct SaddleSystem<'s, 'a> {
    pub(in crate::solve) problem: &'s mut Problem<'a>,
    pub(in crate::solve) form: &'s mut SaddlePoint,
}

impl Problem<'_> {
    /// Forces of the bulk with the tractions that the laws answer (N). Collective.
    fn balance_of_laws(&mut self) {
        let response = &self.interfaces.response;
        self.balance.copy_from_slice(&self.bulk_force);
        self.all.add_tractions(|index, c| response[index].law_traction[c], &mut self.balance);
    }

    /// The largest force that is out of balance with the answers of the laws. Local.
    fn worst_balance(&self) -> Worst {
        let (all, dim) = (&self.all, self.all.dim);
        let mut worst = Worst::default();
        for node in 0..all.nodes.owned {
            let force = self.balance[node * dim..][..dim].iter().zip(all.prescribed[node]);
            let free = force.filter(|(_, prescribed)| !prescribed);
            worst.see(free.map(|(f, _)| f * f).sum::<f64>().sqrt(), all.nodes.names[node]);
        }
        worst
    }
}

impl NonlinearSystem for SaddleSystem<'_, '_> {
    fn residual(&mut self, x: &[f64], f: &mut [f64]) -> Result<()> {
        let problem = &mut *self.problem;
        let _phase = problem.timers.enter(Phase::Assembly);
        let (dim, scale) = (problem.all.dim, self.form.tangent.scale);
        let (u, multipliers) = x.split_at(problem.all.nodes.owned * dim);
        problem.evaluate_bulk(u, true);
        problem.interfaces.evaluate(&problem.all, &problem.displacement, |index, c, row| {
            multipliers[index * dim + c] * scale / row.weight
        });
        problem.balance_of_laws();
        problem.see_platens(|problem, i| problem.balance[i]);
        if problem.answer_in_turn(problem.worst_balance()) {
            problem.balance_of_laws();
            problem.see_platens(|problem, i| problem.balance[i]);
        }
        let (all, response) = (&problem.all, &problem.interfaces.response);
        let (f, law) = f.split_at_mut(u.len());
        let mut force = problem.bulk_force.clone();
        all.add_tractions(|index, c| response[index].bulk_traction[c], &mut force);
        f.copy_from_slice(&force[..f.len()]);
        if let Some(PlatenSystem { platens, .. }) = &problem.platens {
            self.form.of_platens = platens.times(|i| f[i]);
            problem.comm.sum(&mut self.form.of_platens);
        }
        for node in 0..all.nodes.owned {
            for c in (0..dim).filter(|c| all.prescribed[node][*c]) {
                f[node * dim + c] = 0.0;
            }
        }
        for (own, response) in law.chunks_exact_mut(dim).zip(response) {
            for (c, f) in own.iter_mut().enumerate() {
                let shifted: f64 =
                    (0..dim).map(|d| response.compliance[c][d] * response.shift[d]).sum();
                *f = scale * (response.defect[c] + shifted);
            }
        }
        fault::strike_values(problem.comm, "residual", &mut *f)?;
        problem.convergence.see_residual(&problem.all, f);
        Ok(())
    }

    fn tangent(&mut self, _x: &[f64], matrix: &mut Matrix) -> Result<TangentChange> {
        let problem = &*self.problem;
        let derivative = |(index, response): (usize, &crate::solve::NodeResponse)| {
            let law = problem.interfaces.law_at(index, &problem.all.secondary[index]);
            let augmentation = law.augmentation();
            LawDerivative { compliance: response.compliance, augmentation }
        };
        let response = problem.interfaces.response.iter().enumerate();
        let law: Vec<LawDerivative> = response.map(derivative).collect();
        if !problem.comm.any(self.form.assembled.as_ref() != Some(&law)) {
            return Ok(TangentChange::Unchanged);
        }
        let _phase = problem.timers.enter(Phase::Assembly);
        self.problem.forget_columns();
        let problem = &*self.problem;
        self.form.tangent.assemble(problem.comm, &problem.all, &law, matrix)?;
        self.form.assembled = Some(law);
        Ok(TangentChange::Changed)
    }

    fn direction(
        &mut self,
        _x: &[f64],
        correction: &mut [f64],
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        self.problem.correct();
        self.problem.interfaces.overstress = 1.0;
        self.problem.hold_prescribed(correction);
        let (all, form) = (&self.problem.all, &*self.form);
        let prescribed = &all.prescribed[..all.nodes.owned];
        let free = prescribed.iter().flat_map(|p| &p[..all.dim]).map(|p| !p);
        let mut free: Vec<bool> = free.collect();
        free.resize(correction.len(), true);
        let at = Linearised {
            free: &free,
            product: &|problem, change| form.forces_of(problem, change),
            residual: Some(&form.of_platens),
            leaves_out: false,
        };
        self.problem.move_platens(correction, &at, solve)?;
        let part = self.problem.convergence.part_of_step();
        correction.iter_mut().for_each(|c| *c *= part);
        Ok(())
    }

    fn heed(&mut self) -> Result<()> {
        self.problem.pulse.iteration(self.problem.comm)
    }

    /// Equilibrium is judged with the law's tractions, as in the condensed form: with the
    /// multipliers it holds after every correction.
    fn verdict(&mut self, iteration: usize, _x: &[f64], _f: &[f64], norm: f64) -> Result<Verdict> {
        let problem = &mut *self.problem;
        problem.pulse.correction(problem.comm, iteration)?;
        let control = match problem.beside(0.0) {
            Ok(control) => control,
            Err(words) => {
                problem.convergence.failure = Some(words);
                return Ok(Verdict::Diverged);
            }
        };
        let worst = problem.worst_balance();
        let (comm, all, state) = (problem.comm, &problem.all, &problem.interfaces);
        let iterate = Iterate { corrections: iteration, norm, worst, control };
        let verdict = problem.convergence.judge(comm, all, state, iterate)?;
        problem.corrections = iteration;
        Ok(problem.unless_waiting(verdict))
    }

    fn linear_tolerance(&mut self, _iteration: usize, norm: f64) -> LinearTolerance {
        self.problem.linear.tolerance(norm, self.problem.convergence.accepted_force())
    }
}
