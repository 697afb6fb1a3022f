//! What the flow in pores and along interfaces depends on, and what it adds up to.

/// State of a saturated medium, at the nodes of one cell or at all local nodes.
#[derive(Debug, Clone, Copy)]
pub struct PoroState<'a> {
    /// Displacements, by node and component (m).
    pub displacement: &'a [f64],
    /// Pressures (Pa): of a cell above the reference.
    pub pressure: &'a [f64],
}

/// Sums of the balance of the fluid, by pressure node.
pub struct BalanceSums<'a> {
    /// The balance (m3).
    pub rows: &'a mut [f64],
    /// The magnitudes of its parts (m3).
    pub sizes: &'a mut [f64],
}

impl BalanceSums<'_> {
    /// The same sums, for a while.
    pub fn reborrow(&mut self) -> BalanceSums<'_> {
        BalanceSums { rows: self.rows, sizes: self.sizes }
    }
}
