//! What a stage has from those before it: reactions that are released, and stresses that stay where
//! the stiffness changes.

use crate::assembly::Discretization;

/// Reactions of supports that are not there any more: forces that fall to nothing in proportion to
/// the time of the stage.
pub struct Release {
    /// Of owned unknowns, at the start of the stage (N).
    pub force: Vec<f64>,
    /// Start and end of the stage (s).
    pub from: f64,
    /// As above.
    pub until: f64,
    /// The part that acted when loads were set last.
    part: f64,
}

impl Release {
    /// Of a stage that ends at `until`.
    pub fn new(force: Vec<f64>, from: f64, until: f64) -> Self {
        Self { force, from, until, part: 1.0 }
    }

    /// Adds what acts at `time` to the loads of local nodes (N). Local.
    pub(super) fn add(&mut self, time: f64, load: &mut [f64]) {
        self.part = ((self.until - time) / (self.until - self.from)).clamp(0.0, 1.0);
        load.iter_mut().zip(&self.force).for_each(|(load, force)| *load += self.part * force);
    }

    /// What acts on an owned unknown (N). Local.
    pub fn at(&self, unknown: usize) -> f64 {
        self.part * self.force[unknown]
    }
}

/// Stresses that stay where a stage changes the stiffness: what is added to them follows from the
/// new one. With the displacements u_k at the change, from K' to K,
///
///   force  K u + (K' - K) u_k,
///   energy u K u / 2 + u (K' - K) u_k - u_k (K' - K) u_k / 2,
///
/// so that force and energy go on from what they were.
#[derive(Default)]
pub struct Prestress {
    /// (K' - K) u_k of this rank's cells, on the unknowns of local nodes, not summed (N).
    pub force: Vec<f64>,
    /// What does not depend on u in the energy of this rank's cells (J).
    pub energy: f64,
    /// What is added to the stress of each cell at its centre (Pa).
    pub stress: Vec<[f64; 6]>,
}

impl Prestress {
    /// What is added to half the work of the forces of the bulk on the unknowns `u` of local nodes,
    /// that the energy stored in this rank's cells comes of it (J). Local.
    pub(super) fn energy(&self, all: &Discretization, u: &[f64]) -> f64 {
        debug_assert_eq!(u.len(), all.nodes.len() * all.dim);
        let work: f64 = self.force.iter().zip(u).map(|(f, u)| f * u).sum();
        0.5 * work + self.energy
    }
}
