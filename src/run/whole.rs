//! A run of a case, once or as often as its accuracy asks for.

use std::time::Instant;

use super::accuracy;
use super::carry_out::{Output, carry_out};
use super::session::Ended;
use crate::case::Case;
use crate::error::Result;
use crate::runtime::Runtime;
use crate::timers::Timers;

/// Runs a case, the same on all ranks; without `output` nothing is written. Collective.
///
/// # Errors
/// What is wrong with the input, the numerics or the machine; the same on all ranks.
pub fn whole(
    runtime: &Runtime,
    timers: &Timers,
    case: &Case,
    started: Instant,
    output: Option<Output<'_>>,
) -> Result<Ended> {
    match &case.sections().accuracy {
        Some(wanted) => accuracy::search(runtime, case, wanted, started, output),
        None => carry_out(runtime, timers, case, started, output),
    }
}
