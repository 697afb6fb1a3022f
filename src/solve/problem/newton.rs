//! The problem as the callbacks of Newton's method see it.

use super::path::PathControl;
use super::platen_columns::Linearised;
use super::{Problem, TangentForm, condensed};
use crate::assembly::NodeState;
use crate::error::{Error, Result};
use crate::fault;
use crate::petsc::{
    FurtherSolve, LinearTolerance, Matrix, NonlinearSystem, Petsc, TangentChange, Trial, Verdict,
};
use crate::solve::model::linear::LinearTarget;
use crate::timers::Phase;

/// Corrections that do not halve the residual, after which linear solves go on to their end.
const MOST_STALLED: usize = 3;

/// How far the residual of a linear solve has to fall where its solution decides which interface
/// gives way first.
const DIGITS_OF_ORDER: f64 = 1e-4;

impl NonlinearSystem for Problem<'_> {
    fn residual(&mut self, x: &[f64], f: &mut [f64]) -> Result<()> {
        self.evaluate(x, f, true);
        if self.answer_in_turn(self.worst_force(f)) {
            self.balance_with_laws(f);
        }
        fault::strike_values(self.comm, "residual", &mut *f)?;
        self.convergence.see_residual(&self.all, f);
        Ok(())
    }

    fn tangent(&mut self, _x: &[f64], matrix: &mut Matrix) -> Result<TangentChange> {
        fault::strike(self.comm, "tangent")?;
        let state = self.local_states();
        if !self.comm.any(self.assembled_state.as_ref() != Some(&state)) {
            return Ok(TangentChange::Unchanged);
        }
        let _phase = self.timers.enter(Phase::Assembly);
        self.forget_columns();
        if let TangentForm::Levels(hierarchy) = &mut self.form {
            hierarchy.set_state(self.comm, &state, matrix)?;
            // The levels are set up in no time.
            self.assembled_state = Some(state);
            return Ok(TangentChange::Changed);
        }
        let serves = !self.comm.any(!self.preconditioner_serves(&state));
        match &mut self.form {
            TangentForm::Assembled(tangent) => {
                tangent.assemble(self.comm, &self.all, &state, matrix)?;
            }
            TangentForm::Blocks(blocks) => {
                if !serves {
                    blocks.set_up(self.comm, &self.all, &state)?;
                }
                blocks.assemble(self.comm, &self.all, &state)?;
                matrix.assemble()?;
            }
            TangentForm::Levels(_) | TangentForm::None => {
                return Err(Error::Bug("a tangent that is held elsewhere".into()));
            }
        }
        self.assembled_state = Some(state.clone());
        if !serves {
            self.preconditioned = Some(state);
            return Ok(TangentChange::Changed);
        }
        Ok(TangentChange::ChangedKeepPreconditioner)
    }

    fn softens(&mut self) -> bool {
        let is_matrix = matches!(self.form, TangentForm::Assembled(_));
        let hard = |state: &NodeState| state.softens() || !state.is_symmetric();
        let some = self.assembled_state().iter().any(hard);
        is_matrix && self.comm.any(some)
    }

    fn stiffen(&mut self, copy: &mut Matrix) -> Result<()> {
        let state: Vec<_> = self.assembled_state().iter().map(NodeState::stiffened).collect();
        match &mut self.form {
            TangentForm::Assembled(tangent) => tangent.assemble(self.comm, &self.all, &state, copy),
            _ => Err(Error::Bug("a tangent that is no matrix".into())),
        }
    }

    fn write(&mut self, copy: &mut Matrix) -> Result<()> {
        match &self.form {
            TangentForm::Blocks(blocks) => blocks.write(self.comm, copy),
            _ => Err(Error::Bug("a tangent without blocks".into())),
        }
    }

    fn direction(
        &mut self,
        _x: &[f64],
        correction: &mut [f64],
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        fault::strike_values(self.comm, "linear", &mut *correction)?;
        self.interfaces.overstress = 1.0;
        self.correct();
        self.set_known(correction);
        self.is_skew = self.add_unsymmetric(correction, self.judged_norm, solve)?;
        let part = self.convergence.part_of_step();
        if self.path.as_ref().is_some_and(PathControl::follows) {
            self.correct_along_path(correction, part, solve)?;
            self.scale_load();
            return Ok(());
        }
        self.finish(correction, solve)?;
        correction.iter_mut().for_each(|c| *c *= part);
        Ok(())
    }

    fn trial(&mut self, correction: &[f64], norm: f64) -> Result<Trial> {
        if !self.is_tried() {
            return Ok(Trial::GoOn(None));
        }
        if self.decides_order() && norm > DIGITS_OF_ORDER * self.judged_norm {
            return Ok(Trial::GoOn(None));
        }
        let mut x = correction.to_vec();
        self.set_known(&mut x);
        condensed::follow(&self.all, &self.interfaces, &mut x);
        x.iter_mut().zip(&self.displacement).for_each(|(x, u)| *x = u - *x);
        // The linear solve goes on from the state that was linearised.
        self.exchange_with_spare();
        let response = self.interfaces.response.clone();
        let scales = self.convergence.current();
        let mut f = vec![0.0; x.len()];
        // By its own scale: with displacements prescribed anew that of the linearised state is as
        // much larger as the cells there are smaller than the body.
        self.evaluate(&x, &mut f, true);
        let mut sums = [f.iter().map(|f| f * f).sum::<f64>()];
        self.comm.sum(&mut sums);
        let worst = self.worst_force(&f);
        let traction = self.interfaces.largest_traction(self.comm);
        let scale = self.areas.scale(traction, self.convergence.force_scale());
        let (comm, all, state) = (self.comm, &self.all, &self.interfaces);
        let excess = self.convergence.excess(comm, all, state, (worst, scale));
        let rounding = self.convergence.rounding();
        self.convergence.see_again(scales);
        self.exchange_with_spare();
        self.interfaces.response = response;
        Ok(self.linear.trial([norm, rounding], sums[0].sqrt(), excess))
    }

    fn initial_guess(&mut self, rhs: &[f64], guess: &mut [f64]) -> Result<()> {
        let free = condensed::free_components(&self.all, &self.interfaces);
        let uncoupled = free.iter().zip(rhs).zip(guess.iter_mut()).filter(|((free, _), _)| !**free);
        uncoupled.for_each(|((_, rhs), guess)| *guess = rhs / self.diagonal);
        if self.is_unsymmetric() {
            // There is no energy that a guess could minimise.
            return Ok(());
        }
        let (comm, all, state) = (self.comm, &self.all, &self.interfaces);
        let rigid = self.rigid.closest(comm, all, state, self.diagonal, &free, rhs);
        if let Some(rigid) = rigid {
            self.projection.lend(comm, all, &rigid);
        }
        self.projection.guess(comm, all, state, &free, rhs, guess);
        Ok(())
    }

    fn heed(&mut self) -> Result<()> {
        self.pulse.iteration(self.comm)
    }

    fn verdict(&mut self, iteration: usize, _x: &[f64], f: &[f64], norm: f64) -> Result<Verdict> {
        self.pulse.correction(self.comm, iteration)?;
        let mut control = 0.0;
        if let Some(path) = &self.path {
            if path.failure.is_some() {
                self.convergence.failure.clone_from(&path.failure);
                return Ok(Verdict::Diverged);
            }
            control = path.error(self.comm, &self.all, &self.interfaces);
        }
        self.judge(iteration, f, norm, control)
    }

    fn linear_tolerance(&mut self, _iteration: usize, norm: f64) -> LinearTolerance {
        if self.is_tried() {
            return LinearTarget::UNTRIED;
        }
        let mut scale = self.convergence.accepted_force();
        if scale == 0.0 && self.path.as_ref().is_some_and(PathControl::follows) {
            // The path starts where the first point gives way, under forces that no step has
            // accepted yet.
            scale = self.convergence.current().force;
        }
        self.linear.tolerance(norm, self.areas.least() * scale)
    }
}

impl Problem<'_> {
    /// Whether the states that the running linear solve leads to are of use to it. Local: the same
    /// on all ranks.
    fn is_tried(&self) -> bool {
        // On a path, or with platens, the correction is not yet the whole one. The symmetric part
        // alone leads elsewhere; and corrections that are broken off early can lead round in
        // circles.
        let is_whole = self.path.is_none() && !self.has_free_platens();
        is_whole && self.stall.1 < MOST_STALLED && !self.is_skew
    }

    /// Makes the answer of the tangent a correction of the displacements, platens included.
    /// Collective.
    fn finish(&mut self, correction: &mut [f64], solve: &mut FurtherSolve<'_>) -> Result<()> {
        if !self.has_free_platens() {
            condensed::follow(&self.all, &self.interfaces, correction);
            self.keep(correction);
            return Ok(());
        }
        let mut own = correction.to_vec();
        condensed::follow(&self.all, &self.interfaces, &mut own);
        self.keep(&own);
        let free = condensed::free_components(&self.all, &self.interfaces);
        let at = Linearised::new(&free, &|problem, u| problem.forces_of(u));
        self.move_platens(correction, &at, solve)?;
        condensed::follow(&self.all, &self.interfaces, correction);
        Ok(())
    }

    /// The tangent in blocks as a matrix of PETSc; none of another form. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails or memory is short.
    pub fn matrix_of_blocks(&self, petsc: &Petsc) -> Result<Option<Matrix>> {
        match &self.form {
            TangentForm::Blocks(blocks) => blocks.copy(self.comm, petsc).map(Some),
            _ => Ok(None),
        }
    }

    /// Whether the laws at the state that was evaluated last make the tangent unsymmetric: where
    /// lips slide with friction. Collective.
    pub fn is_unsymmetric(&self) -> bool {
        let mut state = self.interfaces.response.iter().map(|r| &r.state);
        self.comm.any(state.any(|state| !state.is_symmetric()))
    }

    /// Elimination has taken over from the preconditioner of the tangent in blocks. Local.
    pub fn leave_to_elimination(&mut self) {
        if let TangentForm::Blocks(blocks) = &mut self.form {
            blocks.leave_to_elimination();
        }
    }

    /// Forgets a preconditioner of ours that was set up for another state than the tangent; tells
    /// whether there was one. Collective.
    pub fn forget_kept_preconditioner(&mut self) -> bool {
        let kept = self.preconditioned != self.assembled_state;
        if !matches!(self.form, TangentForm::Blocks(_)) || !self.comm.any(kept) {
            return false;
        }
        (self.preconditioned, self.assembled_state) = (None, None);
        true
    }

    /// Whether the preconditioner was set up for a state that is close to this one at this rank's
    /// nodes. Local.
    fn preconditioner_serves(&self, state: &[NodeState]) -> bool {
        let Some(old) = &self.preconditioned else { return false };
        let mut nodes = old.iter().zip(state).zip(&self.all.secondary);
        nodes.all(|((old, new), rows)| {
            // The owner of a node judges it.
            let cells = self.stiffness.get(rows.node as usize);
            cells.is_none_or(|k| old.is_close_to(new, k / rows.law_weight(self.all.dim)))
        })
    }
}
