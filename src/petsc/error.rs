//! Error codes of PETSc as errors of ours, with PETSc's message and call path.

#![allow(unsafe_code)]

use super::ffi;
use crate::comm::doubt;
use crate::error::{Error, Result};
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt::Write;
use std::ptr;

/// What the handler recorded since the last error was taken.
#[derive(Default)]
struct Record {
    message: String,
    path: Vec<String>,
}

thread_local! {
    static RECORD: RefCell<Record> = RefCell::default();
}

/// A C string of PETSC as text; empty for a null pointer.
///
/// # Safety
/// `text` is null or a string that ends with a zero byte and stays valid during the call.
pub(super) unsafe fn text(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: not null, so by the contract a valid string.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

/// A string for PETSc.
///
/// # Errors
/// `Input` when it contains a zero byte.
pub(super) fn c_string(text: &str) -> Result<CString> {
    CString::new(text)
        .map_err(|_| Error::Input(format!("a PETSc option contains a zero byte: {text:?}")))
}

/// Keeps the message and the call path; prints nothing, stops nothing.
///
/// PETSc calls it once where the error arises and once for each function it passes through. A
/// panic cannot leave it: `extern "C"` aborts.
pub(super) unsafe extern "C" fn record(
    _comm: mpi::ffi::MPI_Comm,
    line: c_int,
    function: *const c_char,
    file: *const c_char,
    code: ffi::PetscErrorCode,
    kind: ffi::PetscErrorType,
    message: *const c_char,
    _context: *mut c_void,
) -> ffi::PetscErrorCode {
    // SAFETY: PETSc passes a string or null for each of the three.
    let message = unsafe { text(message) };
    // SAFETY: as above.
    let function = unsafe { text(function) };
    // SAFETY: as above.
    let file = unsafe { text(file) };
    RECORD.with_borrow_mut(|record| {
        if kind == ffi::PETSC_ERROR_INITIAL {
            *record = Record { message: message.trim_end().to_string(), path: Vec::new() };
        }
        record.path.push(format!("{function} ({file}:{line})"));
    });
    code
}

/// Forgets what was recorded of an error that was foreseen.
pub(super) fn forget() {
    RECORD.take();
}

/// The error behind a code that is not 0. Other ranks may not see it, and wait in the same call for
/// this one: it is put down as a doubt.
///
/// # Errors
/// `System` with the call, PETSc's message and its call path.
pub(super) fn check(code: ffi::PetscErrorCode, call: &str) -> Result<()> {
    if code == 0 {
        return Ok(());
    }
    let mut record = RECORD.take();
    if record.message.is_empty() {
        let mut generic = ptr::null();
        // SAFETY: `generic` outlives the call; the second result is not asked for.
        unsafe { ffi::PetscErrorMessage(code, &mut generic, ptr::null_mut()) };
        // SAFETY: PETSc set a static string or left the null.
        record.message = unsafe { text(generic) };
    }
    let mut words = format!("{call} failed: PETSc error {code}: {}", record.message);
    for place in record.path {
        let _ = write!(words, "\n    at {place}");
    }
    doubt(&words);
    Err(Error::System(words))
}
