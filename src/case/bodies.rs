//! Bodies and the interfaces that join them.

use super::{ColumnSpec, InterfaceSpec};
use crate::graph::groups;

/// The bodies of a column: boxes on top of each other, of which each interface joins two.
pub(super) struct Bodies<'c> {
    interfaces: &'c [InterfaceSpec],
    height: f64,
}

impl<'c> Bodies<'c> {
    /// Of a column.
    pub fn new(column: &ColumnSpec, interfaces: &'c [InterfaceSpec]) -> Self {
        Self { interfaces, height: column.height() }
    }

    /// Number of bodies.
    pub fn count(&self) -> usize {
        self.interfaces.len() + 1
    }

    /// Lower and upper end of a body (m).
    pub fn z(&self, body: usize) -> [f64; 2] {
        let [below, above] = self.interfaces_of(body);
        let z = |interface: Option<&InterfaceSpec>| interface.and_then(InterfaceSpec::height);
        [z(below).unwrap_or(0.0), z(above).unwrap_or(self.height)]
    }

    /// The interfaces below and above a body.
    pub fn interfaces_of(&self, body: usize) -> [Option<&'c InterfaceSpec>; 2] {
        [
            body.checked_sub(1).and_then(|below| self.interfaces.get(below)),
            self.interfaces.get(body),
        ]
    }

    /// The bodies that move together where the interfaces marked in `holds` join theirs, group by
    /// group.
    pub fn together(&self, holds: &[bool]) -> Vec<Vec<usize>> {
        let joints = (0..self.interfaces.len()).filter(|i| holds.get(*i).is_some_and(|h| *h));
        let group = groups(self.count(), joints.map(|interface| [interface, interface + 1]));
        let count = group.iter().max().map_or(0, |last| last + 1);
        let mut members = vec![Vec::new(); count];
        group.iter().enumerate().for_each(|(body, group)| members[*group].push(body));
        members
    }

    /// Where some bodies lie, in words: between which interfaces or ends.
    pub fn place(&self, members: &[usize]) -> String {
        let [first, last] = [members.first(), members.last()].map(|b| b.copied().unwrap_or(0));
        match [self.interfaces_of(first)[0], self.interfaces_of(last)[1]] {
            [None, None] => "the whole column".to_owned(),
            [below, above] => format!(
                "between {} and {}",
                below.map_or("the bottom", |interface| &interface.name),
                above.map_or("the top", |interface| &interface.name)
            ),
        }
    }
}
