//! What jumps at the start of a case.

/// What jumps at the start, and until when it grows.
pub(in crate::solve) struct Ramp {
    /// The time from which on everything acts whole (s).
    pub end: f64,
    /// Loads and forces of the pore pressure at the start, per local node, not summed (N).
    pub jump: Vec<f64>,
}
