//! What jumps at the start of a case or of one of its stages.

/// What jumps at the start, and until when it grows.
pub(in crate::solve) struct Ramp {
    /// The time from which on everything acts whole (s).
    pub end: f64,
    /// Loads and forces of the pore pressure at the start, per local node, not summed (N).
    pub jump: Vec<f64>,
}

/// What a later stage of a case has from those before it.
pub struct Carried {
    /// The displacements at the start of each stage but the first, up to the running one: of owned
    /// nodes along the axes (m).
    pub starts: Vec<Vec<f64>>,
    /// The owned unknowns at the start of the running one (m).
    pub start: Vec<f64>,
    /// By how much the loads jump at its start, on the unknowns of local nodes, not summed (N).
    pub jump: Vec<f64>,
}
