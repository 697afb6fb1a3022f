//! Places at which a test can make the program fail, to see what a failure leaves behind.
//!
//! The library holds no faults: the program `column-hpc-faults`, which only the tests run, brings
//! them (`tests/faults`).

use std::sync::OnceLock;

use crate::comm::Comm;
use crate::error::Result;

/// What may fail at a place: it is told the name of the phase, and numbers that it can spoil.
/// Collective where it fails.
pub type Injector = fn(&Comm, &str, &mut dyn Iterator<Item = &mut f64>) -> Result<()>;

static INJECTOR: OnceLock<Injector> = OnceLock::new();

/// From here on `injector` is asked at every place; the first one stays.
pub fn inject(injector: Injector) {
    INJECTOR.get_or_init(|| injector);
}

/// A place in a phase. Collective where it fails.
///
/// # Errors
/// Those of the injector, on every rank; none without one.
#[inline]
pub fn strike(comm: &Comm, phase: &str) -> Result<()> {
    strike_values(comm, phase, [])
}

/// As [`strike`], with numbers that a test can spoil.
///
/// # Errors
/// As [`strike`].
#[inline]
pub fn strike_values<'v>(
    comm: &Comm,
    phase: &str,
    values: impl IntoIterator<Item = &'v mut f64>,
) -> Result<()> {
    match INJECTOR.get() {
        Some(injector) => injector(comm, phase, &mut values.into_iter()),
        None => Ok(()),
    }
}
