//! A pore pressure that is prescribed at every node: a load on the skeleton.

use crate::assembly::{Discretization, PoreSpace};
use crate::comm::Comm;
use crate::error::Result;
use crate::space::{AtNode, PrescribedPressure};

/// The known pressure of one rank.
pub struct KnownPressure {
    /// Nodes and cells.
    pub space: PoreSpace,
    prescribed: PrescribedPressure,
    /// At all local nodes, at the time of the loads (Pa).
    pub pressure: Vec<f64>,
}

impl KnownPressure {
    /// The pressures at `times` are checked. Collective.
    ///
    /// # Errors
    /// `Input` when entries disagree or a formula gives no finite number; on all ranks.
    pub(in crate::solve) fn new(
        comm: &Comm,
        space: PoreSpace,
        prescribed: PrescribedPressure,
        times: &[f64],
    ) -> Result<Self> {
        AtNode::agree(comm, prescribed.check(space.nodes.iter_owned(), times))?;
        Ok(Self { pressure: vec![0.0; space.nodes.len()], space, prescribed })
    }

    /// Takes the pressures of `time`. Local.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub(in crate::solve) fn set(&mut self, time: f64) -> Result<()> {
        let Self { space, prescribed, pressure } = self;
        let nodes = space.nodes.marks.iter().zip(&space.nodes.points);
        for ((marks, point), pressure) in nodes.zip(pressure) {
            if let Some(entry) = prescribed.entry_of(marks) {
                *pressure = prescribed.value(entry, *point, time)?;
            }
        }
        Ok(())
    }

    /// The forces at the local displacement nodes, not summed (N). Local.
    pub(in crate::solve) fn forces(&self, all: &Discretization) -> Vec<f64> {
        let mut force = vec![0.0; all.nodes.len() * all.dim];
        self.space.add_forces(all, &self.pressure, true, &mut force);
        force
    }
}
