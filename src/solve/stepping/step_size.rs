//! How long steps are.

/// The size of the step that is tried next: a time (s), or a part of what acts at the start.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepSize {
    /// Of the step.
    pub step: f64,
    /// The smallest that is tried.
    pub smallest: f64,
}

impl StepSize {
    /// Whether none smaller is tried.
    pub fn is_smallest(self) -> bool {
        self.step <= self.smallest
    }
}
