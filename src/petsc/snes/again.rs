//! Another set-up of the linear solver after one that failed.

#![allow(unsafe_code)]

use super::super::error::check;
use super::super::ffi;
use super::super::linear::{Ksp, LinearFailure};
use super::definite::precondition_by;
use super::{Matrix, Snes, SolveReport};
use crate::error::Result;

/// GMRES on a tangent that is indefinite: its vectors stay orthogonal, and where a restart shows
/// that they were not, it goes on from there.
const GMRES: [(&str, &str); 3] = [
    ("ksp_gmres_restart", "200"),
    ("ksp_gmres_cgs_refinement_type", "refine_ifneeded"),
    ("ksp_gmres_breakdown_tolerance", "1e10"),
];

impl Snes {
    /// Forgets preconditioner and factors, but for what was given to the preconditioner: levels of
    /// multigrid, an operator of ours. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn forget_factors(&mut self) -> Result<()> {
        if !self.has_levels && self.pc_type()? != "shell" {
            let comm = self.petsc.comm();
            // SAFETY: the valid solver that this owns; the old linear solver is replaced here.
            self.ksp = unsafe { Ksp::renewed(self.raw, comm, &self.prefix)? };
        }
        Ok(())
    }

    /// Whether conjugate gradients, which are ours to replace, met what they cannot be used for.
    /// Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn is_suspicious(&self, report: &SolveReport) -> Result<bool> {
        let method = format!("{}ksp_type", self.prefix);
        let ours = self.defaults.contains(&method) && self.ksp_type()? == "cg";
        Ok(ours && report.failing_linear.as_ref().is_some_and(LinearFailure::is_indefinite))
    }

    /// After a linear solve in which conjugate gradients met an indefinite tangent or
    /// preconditioner, which also happens where a kept preconditioner has become a bad one: tells
    /// whether the solve is worth another try with a new one. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn try_new_preconditioner(&mut self, report: &SolveReport) -> Result<bool> {
        // The next solve makes it anew, as after any failure.
        Ok(!self.has_levels && self.pc_type()? != "shell" && self.is_suspicious(report)?)
    }

    /// After a linear solve that failed because conjugate gradients met an indefinite tangent,
    /// as softening makes it: takes GMRES from now on, unless the user has chosen the method.
    /// Tells whether it did, so that the solve is worth another try. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn try_indefinite(&mut self, report: &SolveReport) -> Result<bool> {
        if !self.is_suspicious(report)? {
            return Ok(false);
        }
        self.set_unless_fixed("ksp_type", self.ksp.indefinite_method()?)?;
        for (name, value) in GMRES {
            self.set_unless_fixed(name, value)?;
        }
        // SAFETY: a valid solver.
        check(unsafe { ffi::SNESSetFromOptions(self.raw) }, "SNESSetFromOptions")?;
        Ok(true)
    }

    /// After a linear solve that failed though its method and preconditioner are those of a preset
    /// of algebraic multigrid: takes elimination from now on, as `options` say, of `entries` where
    /// the operator has none. Tells whether it did. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn try_elimination(
        &mut self,
        options: &[(&str, &str)],
        entries: Option<Matrix>,
    ) -> Result<bool> {
        let ours = ["ksp_type", "ksp_max_it", "pc_type"];
        let ours =
            ours.iter().all(|name| self.defaults.contains(&format!("{}{name}", self.prefix)));
        let pc = self.pc_type()?;
        let serves = entries.is_some() && pc == "shell" || matches!(&*pc, "gamg" | "hypre");
        if !ours || !serves {
            return Ok(false);
        }
        for (name, value) in options {
            self.set_unless_fixed(name, value)?;
        }
        match entries {
            Some(copy) => self.definite.eliminate(copy),
            None => self.definite.forget(),
        }
        let of = self.definite.or(&self.matrix);
        // SAFETY: a valid solver, and its own matrix or the copy of it.
        unsafe { precondition_by(self.raw, of) }?;
        let comm = self.petsc.comm();
        // SAFETY: the valid solver that this owns; the old linear solver is replaced here.
        self.ksp = unsafe { Ksp::renewed(self.raw, comm, &self.prefix)? };
        Ok(true)
    }

    /// After a factorisation for which MUMPS had too little work space: gives it several times as
    /// much from now on, unless the user has said how much. Tells whether it did. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn try_more_work_space(&mut self, report: &SolveReport) -> Result<bool> {
        match &report.failing_linear {
            Some(failure) => self.give_more_work_space(failure.mumps),
            None => Ok(false),
        }
    }

    /// Gives MUMPS several times as much work space from now on where `INFOG(1)` says that it had
    /// too little, unless the user has said how much or it has it already. Tells whether it did.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn give_more_work_space(&mut self, infog: Option<i32>) -> Result<bool> {
        let name = format!("{}mat_mumps_icntl_14", self.prefix);
        let short = matches!(infog, Some(-8 | -9 | -14 | -15 | -17 | -20));
        if !short || !self.defaults.contains(&name) || self.more_work_space {
            return Ok(false);
        }
        self.more_work_space = true;
        self.petsc.set_option(&name, "500")?;
        Ok(true)
    }
}
