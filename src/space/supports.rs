//! The values of prescribed unknowns.

use super::node_unknowns::SpecialNode;
use super::nodes::Nodes;
use super::prescribed::Prescribed;
use crate::error::Result;

/// What is prescribed of the unknowns of a rank.
pub struct Supports {
    /// The entries of the case.
    pub prescribed: Prescribed,
    /// Nodes with unknowns of their own kind, by rising local number.
    special: Vec<SpecialNode>,
}

/// A part of the displacement of a platen in a prescribed unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlatenTerm {
    /// The entry of the case that is the platen, by its number there.
    pub entry: usize,
    /// The axis of the displacement.
    pub axis: usize,
    /// Its factor.
    pub factor: f64,
    /// Where it is taken (m).
    pub point: [f64; 3],
    /// Whether the displacement is that of the platen alone, which [`Supports::value`] does not
    /// tell.
    pub is_carried: bool,
}

impl Supports {
    /// The parts of platens in an unknown of an owned node, and whether there is nothing else in
    /// it. Local.
    pub fn of_platens(
        &self,
        nodes: &Nodes,
        node: usize,
        component: usize,
        axes: &[usize],
    ) -> (Vec<PlatenTerm>, bool) {
        let term = |entry: usize, axis: usize, factor: f64, point: [f64; 3]| {
            let number = self.prescribed.platen(entry, axis)?;
            let is_carried = self.prescribed.is_carried(entry, Some(axis));
            Some(PlatenTerm { entry: number, axis, factor, point, is_carried })
        };
        let place = self.special.binary_search_by_key(&(node as u32), |special| special.node);
        if let Ok(place) = place {
            let own = self.special[place].terms.iter().filter(|term| term.component == component);
            let found: Vec<Option<PlatenTerm>> =
                own.map(|of| term(of.given.entry, of.given.axis?, of.factor, of.point)).collect();
            let is_all = found.iter().all(Option::is_some);
            return (found.into_iter().flatten().collect(), is_all);
        }
        let entry = self.prescribed.entries_of(&nodes.marks[node])[component];
        let found = entry.and_then(|entry| term(entry, axes[component], 1.0, nodes.points[node]));
        (found.into_iter().collect(), found.is_some())
    }

    /// `special` nodes are by local number.
    pub fn new(prescribed: Prescribed, mut special: Vec<SpecialNode>) -> Self {
        special.sort_by_key(|special| special.node);
        Self { prescribed, special }
    }

    /// The value of an unknown at an owned node (m), 0 where none is prescribed.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number there.
    pub fn value(&self, nodes: &Nodes, node: usize, component: usize, time: f64) -> Result<f64> {
        let place = self.special.binary_search_by_key(&(node as u32), |special| special.node);
        if let Ok(place) = place {
            return self.special[place].value(&self.prescribed, component, time);
        }
        let entry = self.prescribed.entries_of(&nodes.marks[node])[component];
        let at = |entry| self.prescribed.value(entry, component, nodes.points[node], time);
        entry.map_or(Ok(0.0), at)
    }
}
