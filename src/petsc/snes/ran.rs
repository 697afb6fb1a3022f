//! What PETSc solved with, asked of its objects.

#![allow(unsafe_code)]

use super::super::error::{check, text};
use super::super::ffi;
use super::Snes;
use crate::error::Result;
use std::ptr;

/// A linear solver as PETSc has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ran {
    /// Prefix of its options.
    pub prefix: String,
    /// Type of the method (`-ksp_type`).
    pub method: String,
    /// Type of the preconditioner (`-pc_type`).
    pub preconditioner: String,
    /// The package that factors (`-pc_factor_mat_solver_type`), or what of hypre is used.
    pub package: Option<String>,
}

impl Snes {
    /// The linear solver as it is after the options of the user and all that happened. Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn ran(&self) -> Result<Ran> {
        let (method, preconditioner) = (self.ksp_type()?, self.pc_type()?);
        let (pc, mut package) = (self.pc()?, ptr::null());
        match preconditioner.as_str() {
            "lu" | "cholesky" | "ilu" | "icc" => {
                // SAFETY: a valid preconditioner that factors.
                let code = unsafe { ffi::PCFactorGetMatSolverType(pc, &mut package) };
                check(code, "PCFactorGetMatSolverType")?;
            }
            // SAFETY: a valid preconditioner of hypre.
            "hypre" => check(unsafe { ffi::PCHYPREGetType(pc, &mut package) }, "PCHYPREGetType")?,
            _ => {}
        }
        // SAFETY: PETSc's own string, or null.
        let package = Some(unsafe { text(package) }).filter(|package| !package.is_empty());
        Ok(Ran { prefix: self.prefix.clone(), method, preconditioner, package })
    }
}
