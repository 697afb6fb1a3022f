//! Faults on demand, for tests of what a failure leaves behind: only with the feature `faults`,
//! which a program for use is built without.
//!
//! `COLUMN_HPC_FAULT=PHASE:RANK:KIND` or `PHASE:RANK:KIND:COUNT` makes one rank fail where the
//! program calls [`strike`] or [`strike_values`] with that phase for the `COUNT`-th time (1 by
//! default), or each time from the `COUNT`-th on (`COUNT+`). The kinds: `error`, `panic`, `kill`
//! (as by the system when memory runs out), `nan` (one of the values is none), `full` (files of the
//! rank can grow no further), `slow` and `late` (it takes 0.4 s or 4 s longer), `wait` (until there
//! is a file `go` in the working directory, a minute at most), and the signals `usr1`, `usr2`,
//! `term` and `int`, which the rank sends to itself.

#[cfg(feature = "faults")]
mod injector;

#[cfg(feature = "faults")]
pub use injector::{strike, strike_values};

#[cfg(not(feature = "faults"))]
use crate::{comm::Comm, error::Result};

/// Nothing: a place at which a test can make the program fail.
///
/// # Errors
/// None.
#[cfg(not(feature = "faults"))]
#[inline(always)]
pub fn strike(_: &Comm, _: &str) -> Result<()> {
    Ok(())
}

/// Nothing: as [`strike`], with numbers that a test can spoil.
///
/// # Errors
/// None.
#[cfg(not(feature = "faults"))]
#[inline(always)]
pub fn strike_values<'v>(
    _: &Comm,
    _: &str,
    _: impl IntoIterator<Item = &'v mut f64>,
) -> Result<()> {
    Ok(())
}
