//! What the states of a smaller model say of the interfaces: which hold, and which softens how.

use super::bound::{Joints, softening};
use super::{InterfaceSnapshot, Prolongation, Snapshot, both_could_soften};
use crate::case::Case;
use crate::law::Branch;
use crate::solve::{BoundaryValueProblem, NodeResponse};

/// Tractions of this size, over the strength, are rounding.
const ROUNDING: f64 = 1e-9;
/// Strengths that differ by less than this part are those of equals.
const CLOSE: f64 = 1e-6;

/// The interfaces in the states of a smaller model; the same on all ranks.
pub struct Lips<'p> {
    pub case: &'p Case,
    pub asked: &'p BoundaryValueProblem,
    pub prolongation: &'p Prolongation,
    pub states: &'p [Snapshot],
}

impl Lips<'_> {
    /// Branches of the nodes of an interface at all instants. Local.
    fn branches(&self, interface: usize) -> impl Iterator<Item = (Branch, f64)> {
        self.nodes_of(interface).map(|node| (node.response.branch, node.response.history))
    }

    /// The states of the nodes of an interface at all instants. Local.
    fn nodes_of(&self, interface: usize) -> impl Iterator<Item = &InterfaceSnapshot> {
        let side = self.asked.sides[interface];
        self.states.iter().flat_map(move |state| {
            let nodes = state.interface.iter().enumerate();
            let on = move |name: usize| side.is_secondary(&self.prolongation.marks_of(name));
            nodes.filter(move |(name, _)| on(*name)).filter_map(|(_, node)| node.as_ref())
        })
    }

    /// What the states say of the interfaces. Local, the same on all ranks.
    pub fn joints(&self) -> Joints {
        let column = self.prolongation.wide();
        let count = self.case.interfaces.len();
        let holds = |b: Branch| matches!(b, Branch::Stick | Branch::StickClosed | Branch::Tied);
        let is_tied = (0..count).map(|i| self.branches(i).all(|(b, _)| holds(b))).collect();
        let matches = |i: usize| {
            let [a, b] = [i, i + 1].map(|body| (column.node_extent(body), column.order(body)));
            a.0[..2] == b.0[..2] && a.1 == b.1
        };
        Joints { is_tied, is_matching: (0..count).map(matches).collect() }
    }

    /// What the softening takes of the stiffness against it. Local, the same on all ranks.
    pub fn softening(&self) -> Result<f64, String> {
        let law = |i: usize| self.case.interfaces[i].law.law();
        let softened = |i: &usize| {
            let damages = |history| law(*i).damage(history) > 0.0;
            self.branches(*i).any(|(_, history)| damages(history))
        };
        let softened: Vec<usize> = (0..self.case.interfaces.len()).filter(softened).collect();
        let name = |i: usize| self.case.interfaces[i].name.as_str();
        let Some(interface) = softened.first().copied() else { return Ok(0.0) };
        for other in (0..self.case.interfaces.len()).filter(|i| *i != interface) {
            if softened.contains(&other) || self.could_soften(other, interface) {
                let (first, second) = (interface.min(other), interface.max(other));
                return Err(both_could_soften(name(first), name(second)));
            }
        }
        let strength = law(interface).strength().unwrap_or(0.0);
        let mut held = self.nodes_of(interface).map(|node| &node.response);
        let slides = |r: &NodeResponse| {
            let normal = self.case.dim - 1;
            let sheared = r.law_traction[..normal].iter().any(|t| t.abs() > ROUNDING * strength);
            sheared && !r.branch.is_separated()
        };
        if held.any(slides) {
            return Err(format!("{} is sheared while it softens", name(interface)));
        }
        let Some(slope) = law(interface).steepest_softening() else {
            return Err(format!(
                "no bound is known of the slope of the law of {}",
                name(interface)
            ));
        };
        let column = self.prolongation.wide();
        let side = self.asked.sides[interface];
        let cells = column.extent(side.secondary_facts(&self.asked.mesh.facts).body);
        let share = softening(self.case, column, name(interface), slope, cells)?;
        if share >= 1.0 {
            return Err(format!(
                "{} may open unevenly: its softening takes {share:.2} of the stiffness of the column",
                name(interface)
            ));
        }
        Ok(share)
    }

    /// Whether an interface could have come to its strength when another one did. Local.
    fn could_soften(&self, other: usize, softened: usize) -> bool {
        let law = |i: usize| self.case.interfaces[i].law.law();
        let (Some(strength), Some(peak)) = (law(other).strength(), law(softened).strength()) else {
            return false;
        };
        // What acts between the two makes their tractions differ.
        let tractions = |interface| {
            let nodes = self.nodes_of(interface).map(|node| node.response.law_traction);
            nodes.map(|t| t[self.case.dim - 1]).collect::<Vec<f64>>()
        };
        let differences = tractions(other).into_iter().zip(tractions(softened));
        let more = differences.map(|(a, b)| a - b).fold(0.0, f64::max);
        strength <= (peak + more) * (1.0 + CLOSE)
    }
}
