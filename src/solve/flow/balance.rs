//! What the accounts of a fluid hold.

use crate::bulk::BalanceSums;

/// Fluid that came in, went out and is stored beyond what the undeformed state held (kg; 2D: per
/// metre of thickness).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FluidBalance {
    /// Through prescribed pressures, fluxes and injection, since the start.
    pub inflow: f64,
    /// Likewise, counted positive.
    pub outflow: f64,
    /// In the pores and between the lips, since the start.
    pub stored: f64,
}

/// The balance of the fluid in a step (m3) and the magnitudes of its parts, at all local nodes, not
/// summed.
pub(super) struct NodalBalance {
    pub(super) rows: Vec<f64>,
    pub(super) sizes: Vec<f64>,
}

impl NodalBalance {
    /// Nothing at so many nodes.
    pub(super) fn zero(nodes: usize) -> Self {
        Self { rows: vec![0.0; nodes], sizes: vec![0.0; nodes] }
    }

    /// To be added to.
    pub(super) fn sums(&mut self) -> BalanceSums<'_> {
        BalanceSums { rows: &mut self.rows, sizes: &mut self.sizes }
    }
}

/// Stored fluid (m3) and flow (m3/s) at all local nodes at an accepted state, not summed.
#[derive(Debug, Clone, Default)]
pub(super) struct Contents {
    pub(super) stored: Vec<f64>,
    pub(super) flow: Vec<f64>,
}

impl Contents {
    pub(super) fn clear(&mut self, size: usize) {
        for of in [&mut self.stored, &mut self.flow] {
            of.clear();
            of.resize(size, 0.0);
        }
    }
}
