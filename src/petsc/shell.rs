//! Operators without entries, as PETSc's shell matrices.

#![allow(unsafe_code)]

use super::error::check;
use super::vector::petsc_int;
use super::{Matrix, Petsc, ReadView, Snes, WriteView, ffi};
use crate::error::{Error, Result};
use std::ffi::c_void;
use std::ptr;
use std::rc::Rc;

/// A linear map between distributed vectors. Slices hold the entries that this rank owns; all
/// methods are called collectively.
pub trait LinearOperator {
    /// y = A x.
    fn multiply(&self, x: &[f64], y: &mut [f64]);

    /// y = A^T x; that of a symmetric operator is [`LinearOperator::multiply`].
    fn multiply_transpose(&self, x: &[f64], y: &mut [f64]) {
        self.multiply(x, y);
    }

    /// The diagonal of a square operator.
    fn diagonal(&self, d: &mut [f64]) {
        d.fill(1.0);
    }
}

/// A preconditioner of ours. Slices hold the entries that this rank owns.
pub trait Preconditioner {
    /// z = M^-1 r. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails; it ends the linear solve.
    fn apply(&self, r: &[f64], z: &mut [f64]) -> Result<()>;
}

/// What a shell matrix points to.
type Shared = Rc<dyn LinearOperator>;
/// What a shell preconditioner points to.
type SharedPreconditioner = Rc<dyn Preconditioner>;

impl Matrix {
    /// A matrix that has no entries and acts as `operator`, from `columns` to `rows` owned entries
    /// in blocks of `block_size`. Collective.
    ///
    /// # Errors
    /// `Bug` when the block size does not fit; `System` when PETSc fails.
    pub fn shell(
        petsc: &Petsc,
        rows: usize,
        columns: usize,
        block_size: usize,
        operator: Rc<dyn LinearOperator>,
    ) -> Result<Self> {
        if !rows.is_multiple_of(block_size) || !columns.is_multiple_of(block_size) {
            return Err(Error::Bug(format!("{rows} x {columns} in blocks of {block_size}")));
        }
        let comm = petsc.comm();
        let total = |n: usize| petsc_int(comm.sum_u64(n as u64) as usize, "unknowns");
        let (global, global_columns) = (total(rows)?, total(columns)?);
        let (m, n) = (petsc_int(rows, "rows")?, petsc_int(columns, "columns")?);
        let context = Box::into_raw(Box::<Shared>::new(operator)).cast::<c_void>();
        let mut raw = ptr::null_mut();
        // SAFETY: PETSc is initialised, the communicator is alive; the global sizes are the sums of
        // the local ones; the context belongs to the matrix from now on.
        let code = unsafe {
            ffi::MatCreateShell(comm.raw(), m, n, global, global_columns, context, &mut raw)
        };
        check(code, "MatCreateShell")?;
        let matrix = Self::from_raw(raw, petsc, rows, global, block_size);
        type Act = unsafe extern "C" fn(ffi::Mat, ffi::Vec, ffi::Vec) -> ffi::PetscErrorCode;
        let acts: [(ffi::MatOperation, Act); 2] =
            [(ffi::MATOP_MULT, multiply), (ffi::MATOP_MULT_TRANSPOSE, multiply_transpose)];
        for (operation, act) in acts {
            // SAFETY: PETSc casts the function back to this type before it calls it.
            let act = unsafe { std::mem::transmute::<Act, unsafe extern "C" fn()>(act) };
            // SAFETY: a valid shell matrix.
            let code = unsafe { ffi::MatShellSetOperation(raw, operation, Some(act)) };
            check(code, "MatShellSetOperation")?;
        }
        type Unary = unsafe extern "C" fn(ffi::Mat, ffi::Vec) -> ffi::PetscErrorCode;
        // SAFETY: as above.
        let act = unsafe { std::mem::transmute::<Unary, unsafe extern "C" fn()>(diagonal) };
        // SAFETY: as above.
        let code = unsafe { ffi::MatShellSetOperation(raw, ffi::MATOP_GET_DIAGONAL, Some(act)) };
        check(code, "MatShellSetOperation")?;
        type End = unsafe extern "C" fn(ffi::Mat) -> ffi::PetscErrorCode;
        // SAFETY: as above.
        let act = unsafe { std::mem::transmute::<End, unsafe extern "C" fn()>(destroy) };
        // SAFETY: as above.
        let code = unsafe { ffi::MatShellSetOperation(raw, ffi::MATOP_DESTROY, Some(act)) };
        check(code, "MatShellSetOperation")?;
        if rows == columns {
            for option in [ffi::MAT_SYMMETRIC, ffi::MAT_SYMMETRY_ETERNAL] {
                // SAFETY: a valid matrix with its type set.
                check(unsafe { ffi::MatSetOption(raw, option, ffi::PETSC_TRUE) }, "MatSetOption")?;
            }
        }
        Ok(matrix)
    }
}

impl Snes {
    /// Makes `operator` the preconditioner, unless options of the user choose another. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn precondition_by(&mut self, operator: Rc<dyn Preconditioner>) -> Result<()> {
        if self.pc_type()? != "shell" {
            return Ok(());
        }
        let pc = self.pc()?;
        let context = Box::into_raw(Box::<SharedPreconditioner>::new(operator)).cast::<c_void>();
        // SAFETY: a valid preconditioner of the right type; the context belongs to it from now on.
        unsafe {
            check(ffi::PCShellSetContext(pc, context), "PCShellSetContext")?;
            check(ffi::PCShellSetDestroy(pc, Some(destroy_preconditioner)), "PCShellSetDestroy")?;
            check(ffi::PCShellSetApply(pc, Some(precondition)), "PCShellSetApply")
        }
    }
}

/// What a shell preconditioner points to.
///
/// # Safety
/// `pc` is one that [`Snes::precondition_by`] has set up; PETSc keeps it until it destroys it.
unsafe fn context_of(pc: ffi::PC) -> Result<*mut SharedPreconditioner> {
    let mut context: *mut c_void = ptr::null_mut();
    let address = (&raw mut context).cast::<c_void>();
    // SAFETY: valid by the contract; PETSc writes the pointer that it was given.
    check(unsafe { ffi::PCShellGetContext(pc, address) }, "PCShellGetContext")?;
    Ok(context.cast::<SharedPreconditioner>())
}

/// # Safety
/// To be called by PETSc only, with a preconditioner of [`Snes::precondition_by`] and two vectors
/// that fit it.
unsafe extern "C" fn precondition(pc: ffi::PC, x: ffi::Vec, y: ffi::Vec) -> ffi::PetscErrorCode {
    let work = || {
        // SAFETY: PETSc lends a valid preconditioner and two different valid vectors during the
        // call; the context is a boxed `SharedPreconditioner`, which lives as long as the
        // preconditioner.
        let (operator, x, mut y) =
            unsafe { (Rc::clone(&*context_of(pc)?), ReadView::new(x)?, WriteView::new(y)?) };
        operator.apply(&x, &mut y)
    };
    answer(work())
}

/// # Safety
/// To be called by PETSc once, when nothing refers to the preconditioner any more.
unsafe extern "C" fn destroy_preconditioner(pc: ffi::PC) -> ffi::PetscErrorCode {
    let work = || {
        // SAFETY: as in `precondition`.
        let context = unsafe { context_of(pc)? };
        if !context.is_null() {
            // SAFETY: boxed by `Snes::precondition_by`, given back once.
            drop(unsafe { Box::from_raw(context) });
        }
        Ok(())
    };
    answer(work())
}

/// The operator of a shell matrix.
///
/// # Safety
/// `matrix` is a valid matrix made by [`Matrix::shell`].
unsafe fn operator(matrix: ffi::Mat) -> Result<Shared> {
    let mut context: *mut c_void = ptr::null_mut();
    let address = (&raw mut context).cast::<c_void>();
    // SAFETY: valid by the contract; PETSc writes the pointer that it was given.
    check(unsafe { ffi::MatShellGetContext(matrix, address) }, "MatShellGetContext")?;
    // SAFETY: the context is a boxed `Shared`, which lives as long as the matrix.
    Ok(Rc::clone(unsafe { &*context.cast::<Shared>() }))
}

/// A callback's result as a code of PETSc.
fn answer(result: Result<()>) -> ffi::PetscErrorCode {
    if result.is_ok() { 0 } else { ffi::PETSC_ERR_USER as ffi::PetscErrorCode }
}

/// # Safety
/// To be called by PETSc only, with a matrix of [`Matrix::shell`] and two vectors that fit it.
unsafe extern "C" fn multiply(a: ffi::Mat, x: ffi::Vec, y: ffi::Vec) -> ffi::PetscErrorCode {
    let work = || {
        // SAFETY: PETSc lends a valid matrix and two different valid vectors during the call.
        let (operator, x, mut y) = unsafe { (operator(a)?, ReadView::new(x)?, WriteView::new(y)?) };
        operator.multiply(&x, &mut y);
        Ok(())
    };
    answer(work())
}

/// # Safety
/// As [`multiply`].
unsafe extern "C" fn multiply_transpose(
    a: ffi::Mat,
    x: ffi::Vec,
    y: ffi::Vec,
) -> ffi::PetscErrorCode {
    let work = || {
        // SAFETY: PETSc lends a valid matrix and two different valid vectors during the call.
        let (operator, x, mut y) = unsafe { (operator(a)?, ReadView::new(x)?, WriteView::new(y)?) };
        operator.multiply_transpose(&x, &mut y);
        Ok(())
    };
    answer(work())
}

/// # Safety
/// As [`multiply`], with one vector.
unsafe extern "C" fn diagonal(a: ffi::Mat, d: ffi::Vec) -> ffi::PetscErrorCode {
    let work = || {
        // SAFETY: PETSc lends a valid matrix and a valid vector during the call.
        let (operator, mut d) = unsafe { (operator(a)?, WriteView::new(d)?) };
        operator.diagonal(&mut d);
        Ok(())
    };
    answer(work())
}

/// # Safety
/// To be called by PETSc once, when nothing refers to the matrix any more.
unsafe extern "C" fn destroy(a: ffi::Mat) -> ffi::PetscErrorCode {
    let mut context: *mut c_void = ptr::null_mut();
    let address = (&raw mut context).cast::<c_void>();
    // SAFETY: a matrix of `Matrix::shell`; PETSc writes the pointer that it was given.
    let code = unsafe { ffi::MatShellGetContext(a, address) };
    if code == 0 && !context.is_null() {
        // SAFETY: boxed by `Matrix::shell`, given back once.
        drop(unsafe { Box::from_raw(context.cast::<Shared>()) });
    }
    code
}
