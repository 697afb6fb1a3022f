//! Prescribed displacements: which components of a node, and their values in time.

use crate::case::{BoundarySpec, Case};
use crate::error::{Error, Result};
use crate::mesh::{Column, axes};

/// The prescribed displacements of a case.
#[derive(Debug, Clone)]
pub struct Prescribed {
    column: Column,
    entries: Vec<BoundarySpec>,
}

impl Prescribed {
    /// From the boundary entries that prescribe a displacement.
    pub fn new(case: &Case, column: &Column) -> Self {
        let prescribes = |b: &&BoundarySpec| b.displacement.iter().any(Option::is_some);
        Self {
            column: column.clone(),
            entries: case.boundary.iter().filter(prescribes).cloned().collect(),
        }
    }

    /// The entry that prescribes each component of a node: the first of those that do, by its
    /// index among the entries that prescribe displacements.
    pub fn entries_of(&self, node: u64) -> [Option<usize>; 3] {
        let surfaces = self.column.surfaces(node);
        let mut of = [None; 3];
        for (component, axis) in axes(self.column.dim).iter().enumerate() {
            of[component] = self
                .entries
                .iter()
                .position(|e| e.displacement[*axis].is_some() && surfaces.contains(e.on));
        }
        of
    }

    /// Which components of a node are prescribed.
    pub fn components_of(&self, node: u64) -> [bool; 3] {
        self.entries_of(node).map(|e| e.is_some())
    }

    /// Name of the surface of an entry.
    pub fn surface(&self, entry: usize) -> &'static str {
        self.entries[entry].on.name()
    }

    /// The value of a prescribed component (m).
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number there.
    pub fn value(&self, entry: usize, component: usize, node: u64, time: f64) -> Result<f64> {
        let axis = axes(self.column.dim)[component];
        let point = self.column.point(node);
        let value =
            self.entries[entry].displacement[axis].as_ref().map_or(0.0, |v| v.at(point, time));
        if value.is_finite() {
            return Ok(value);
        }
        Err(Error::Input(format!(
            "boundary on {}: displacement.{} is {value} at {point:?} m and time {time}; \
             the formula must give finite numbers on the whole surface",
            self.surface(entry),
            ["x", "y", "z"][axis],
        )))
    }

    /// Checks that entries which prescribe the same component of a node agree at every instant.
    /// Local: `nodes` are names.
    ///
    /// # Errors
    /// `Input`, naming both surfaces, the place and the two values.
    pub fn check_agreement(&self, nodes: &[u64], instants: &[f64]) -> Result<()> {
        for node in nodes {
            let surfaces = self.column.surfaces(*node);
            for axis in axes(self.column.dim) {
                let both: Vec<&BoundarySpec> = self
                    .entries
                    .iter()
                    .filter(|e| e.displacement[*axis].is_some() && surfaces.contains(e.on))
                    .collect();
                if both.len() > 1 {
                    self.check_pairs(&both, *axis, *node, instants)?;
                }
            }
        }
        Ok(())
    }

    fn check_pairs(
        &self,
        entries: &[&BoundarySpec],
        axis: usize,
        node: u64,
        instants: &[f64],
    ) -> Result<()> {
        let point = self.column.point(node);
        let value = |e: &BoundarySpec, t: f64| {
            e.displacement[axis].as_ref().map_or(0.0, |v| v.at(point, t))
        };
        for time in instants {
            let first = value(entries[0], *time);
            for other in &entries[1..] {
                let second = value(other, *time);
                let largest = first.abs().max(second.abs());
                if (first - second).abs() > 1e-12 * largest {
                    return Err(Error::Input(format!(
                        "boundary: {} and {} prescribe different displacements {} at their common \
                         point ({}, {}, {}) m at time {time}: {first} and {second}",
                        entries[0].on.name(),
                        other.on.name(),
                        ["x", "y", "z"][axis],
                        point[0],
                        point[1],
                        point[2],
                    )));
                }
            }
        }
        Ok(())
    }
}
