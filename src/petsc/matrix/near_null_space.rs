//! The motions that algebraic multigrid has to reproduce.

use std::ptr;

use super::Matrix;
use crate::error::{Error, Result};
use crate::petsc::error::check;
use crate::petsc::{Vector, ffi};

impl Matrix {
    /// Tells algebraic multigrid the rigid-body motions of the nodes at `coordinates`, a vector of
    /// as many entries and the same blocks as the rows. Collective.
    ///
    /// # Errors
    /// `Bug` when a length does not fit; `System` when PETSc fails.
    pub fn set_rigid_body_near_null_space(&mut self, coordinates: &Vector) -> Result<()> {
        if coordinates.owned() != self.owned {
            return Err(Error::Bug(format!(
                "{} coordinates for {} rows",
                coordinates.owned(),
                self.owned
            )));
        }
        let mut motions = ptr::null_mut();
        // SAFETY: a valid vector with its block size set.
        let code = unsafe { ffi::MatNullSpaceCreateRigidBody(coordinates.raw(), &mut motions) };
        check(code, "MatNullSpaceCreateRigidBody")?;
        // SAFETY: two valid objects; the matrix takes a reference of its own.
        let code = unsafe { ffi::MatSetNearNullSpace(self.raw, motions) };
        // SAFETY: our reference, given up once.
        unsafe { ffi::MatNullSpaceDestroy(&mut motions) };
        check(code, "MatSetNearNullSpace")
    }

    /// Tells algebraic multigrid the motions of the bodies in the unknowns, at right angles to each
    /// other and of 2-norm 1. Collective.
    ///
    /// # Errors
    /// `Bug` when a length does not fit; `System` when PETSc fails.
    pub fn set_near_null_space(&mut self, motions: &[Vector]) -> Result<()> {
        if let Some(other) = motions.iter().find(|motion| motion.owned() != self.owned) {
            return Err(Error::Bug(format!(
                "a motion of {} entries for {} rows",
                other.owned(),
                self.owned
            )));
        }
        let raw: Vec<_> = motions.iter().map(|motion| motion.raw()).collect();
        let mut space = ptr::null_mut();
        // SAFETY: `raw` holds as many valid vectors as is said; the space takes references.
        let code = unsafe {
            ffi::MatNullSpaceCreate(
                self.petsc.comm().raw(),
                ffi::PETSC_FALSE,
                raw.len() as i32,
                raw.as_ptr(),
                &mut space,
            )
        };
        check(code, "MatNullSpaceCreate")?;
        // SAFETY: two valid objects; the matrix takes a reference of its own.
        let code = unsafe { ffi::MatSetNearNullSpace(self.raw, space) };
        // SAFETY: our reference, given up once.
        unsafe { ffi::MatNullSpaceDestroy(&mut space) };
        check(code, "MatSetNearNullSpace")
    }
}
