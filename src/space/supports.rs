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

impl Supports {
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
