//! Prescribed displacements: which components of a node, and their values in time.

use crate::case::{BoundarySpec, Case};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::{Marks, Places, axes};

/// The prescribed displacements of a case.
#[derive(Debug, Clone)]
pub struct Prescribed {
    dim: usize,
    /// With their numbers in the case.
    entries: Vec<(usize, BoundarySpec)>,
}

impl Prescribed {
    /// From the boundary entries that prescribe a displacement.
    pub fn new(case: &Case) -> Self {
        let prescribes = |b: &BoundarySpec| b.displacement.iter().any(Option::is_some);
        let entries = case.boundary.iter().cloned().enumerate();
        Self { dim: case.dim, entries: entries.filter(|(_, b)| prescribes(b)).collect() }
    }

    /// The entry that prescribes each component of a node: the first of those that do, by its
    /// index among the entries that prescribe displacements.
    pub fn entries_of(&self, node: &Marks) -> [Option<usize>; 3] {
        let mut of = [None; 3];
        for (component, axis) in axes(self.dim).iter().enumerate() {
            of[component] = self
                .entries
                .iter()
                .position(|(_, e)| e.displacement[*axis].is_some() && node.is_on(e.on));
        }
        of
    }

    /// Which components of a node are prescribed.
    pub fn components_of(&self, node: &Marks) -> [bool; 3] {
        self.entries_of(node).map(|e| e.is_some())
    }

    /// Name of the surface of an entry.
    pub fn surface(&self, entry: usize) -> &'static str {
        self.entries[entry].1.on.name()
    }

    /// The value of a prescribed component at a point (m).
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number there.
    pub fn value(&self, entry: usize, component: usize, point: [f64; 3], time: f64) -> Result<f64> {
        self.value_along(entry, axes(self.dim)[component], point, time)
    }

    fn value_along(&self, entry: usize, axis: usize, point: [f64; 3], time: f64) -> Result<f64> {
        let displacement = &self.entries[entry].1.displacement[axis];
        let value = displacement.as_ref().map_or(0.0, |v| v.at(point, time));
        if value.is_finite() {
            return Ok(value);
        }
        let [x, y, z] = point;
        Err(Error::Input(format!(
            "{}: displacement.{} is {value} at ({x}, {y}, {z}) m at time {time}; the formula must \
             give finite numbers on the whole surface at every instant",
            self.name(entry),
            ["x", "y", "z"][axis],
        )))
    }

    /// The largest magnitude that is prescribed at the nodes at any instant (m). Local.
    ///
    /// # Errors
    /// At the first node where a formula gives no finite number, naming entry, place and time.
    pub fn largest_value(
        &self,
        nodes: &Places,
        instants: &[f64],
    ) -> std::result::Result<f64, AtNode> {
        let mut largest = 0.0_f64;
        for (node, marks) in nodes.marks.iter().enumerate() {
            for (entry, axis) in self.all_of(marks) {
                for time in instants {
                    let value = self.value_along(entry, axis, nodes.points[node], *time);
                    let value = value.map_err(|error| AtNode(nodes.names[node], error))?;
                    largest = largest.max(value.abs());
                }
            }
        }
        Ok(largest)
    }

    /// Checks that entries which prescribe the same component of a node agree at every instant, to
    /// 1e-12 of the `largest` value of the case. Local.
    ///
    /// # Errors
    /// At the first node where they do not, naming both entries, the place and the two values.
    pub fn check_agreement(
        &self,
        nodes: &Places,
        instants: &[f64],
        largest: f64,
    ) -> std::result::Result<(), AtNode> {
        for (node, marks) in nodes.marks.iter().enumerate() {
            let (name, point) = (nodes.names[node], nodes.points[node]);
            let all = self.all_of(marks);
            for (position, (other, axis)) in all.iter().enumerate() {
                let Some((first, _)) = all[..position].iter().find(|(_, a)| a == axis) else {
                    continue;
                };
                for time in instants {
                    let value = |entry| {
                        let value = self.value_along(entry, *axis, point, *time);
                        value.map_err(|error| AtNode(name, error))
                    };
                    let (one, two) = (value(*first)?, value(*other)?);
                    if (one - two).abs() > 1e-12 * largest {
                        let error = self.disagreement([*first, *other], *axis, point, *time);
                        return Err(AtNode(name, error([one, two])));
                    }
                }
            }
        }
        Ok(())
    }

    /// Every entry and axis that prescribe something at a node.
    fn all_of(&self, node: &Marks) -> Vec<(usize, usize)> {
        let on = |e: &BoundarySpec| node.is_on(e.on);
        let entries = self.entries.iter().enumerate().filter(|(_, (_, e))| on(e));
        entries
            .flat_map(|(index, (_, e))| {
                let given = axes(self.dim).iter().filter(|a| e.displacement[**a].is_some());
                given.map(move |axis| (index, *axis))
            })
            .collect()
    }

    fn disagreement(
        &self,
        entries: [usize; 2],
        axis: usize,
        [x, y, z]: [f64; 3],
        time: f64,
    ) -> impl Fn([f64; 2]) -> Error {
        let [first, second] = entries.map(|e| self.name(e));
        let axis = ["x", "y", "z"][axis];
        move |[one, two]| {
            Error::Input(format!(
                "{first} and {second} prescribe different values of displacement.{axis} at their \
                 common point ({x}, {y}, {z}) m at time {time}: {one:e} and {two:e} m; make them \
                 agree there, or leave the component out of one of them"
            ))
        }
    }

    /// An entry as the case file and the user call it.
    fn name(&self, entry: usize) -> String {
        let (number, spec) = &self.entries[entry];
        format!("boundary.{number} ({})", spec.on.name())
    }
}

/// A mistake at a node, by its name: of several ranks' the one at the lowest node is told, which is
/// the same on any number of ranks.
#[derive(Debug, Clone, PartialEq)]
pub struct AtNode(pub u64, pub Error);

impl AtNode {
    /// Makes a mistake on some ranks one on all. Collective.
    ///
    /// # Errors
    /// The mistake at the lowest node.
    pub fn agree<T>(comm: &Comm, local: std::result::Result<T, AtNode>) -> Result<T> {
        let mine = local.as_ref().err().map_or(u64::MAX, |AtNode(node, _)| *node);
        let lowest = u64::MAX - comm.max_u64(u64::MAX - mine);
        let told = match local {
            Ok(value) => Ok(Some(value)),
            Err(AtNode(node, error)) if node == lowest => Err(error),
            Err(_) => Ok(None),
        };
        let value = comm.agree(told)?;
        value.ok_or_else(|| Error::Bug("a mistake at a node that no rank holds".into()))
    }
}
