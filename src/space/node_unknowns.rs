//! The unknowns of nodes whose directions are not the axes: on interfaces and supports that lean.

use super::SHARE_OF_END;
use super::node_frame::{NodeFrame, Rotation};
use super::prescribed::{AtNode, Given, Prescribed};
use crate::error::{Error, Result};
use crate::mesh::{Lip, LocalMesh};

/// What is prescribed twice at a node differs by no more than this part of the largest value.
const AGREE: f64 = 1e-12;

/// The unknowns of a node that are not its displacements, or not all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct SpecialNode {
    /// The node, by its number in the mesh of the rank.
    pub node: u32,
    /// The directions of its unknowns; none where they are the axes.
    pub rotation: Option<Rotation>,
    /// The ends of the edge in whose middle it lies, where they have a share in its displacement,
    /// by their numbers in the mesh.
    pub ends: Option<[u32; 2]>,
    /// Which of its unknowns are prescribed.
    pub fixed: [bool; 3],
    /// Whether supports and interface do not fit each other, so that it carries no multiplier.
    pub is_at_odds: bool,
    /// What is prescribed, by unknown: its value is the sum.
    pub terms: Vec<SupportTerm>,
}

/// A part of the value of a prescribed unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportTerm {
    /// The unknown, by its place at the node.
    pub component: usize,
    /// What the case prescribes.
    pub given: Given,
    /// Its factor.
    pub factor: f64,
    /// Where it is taken (m).
    pub point: [f64; 3],
}

impl SpecialNode {
    /// The value of a prescribed unknown (m).
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub fn value(&self, prescribed: &Prescribed, component: usize, time: f64) -> Result<f64> {
        let mut sum = 0.0;
        for term in self.terms.iter().filter(|term| term.component == component) {
            sum += term.factor * prescribed.value_of(&term.given, term.point, time)?;
        }
        Ok(sum)
    }
}

/// The special nodes of a rank's mesh, by rising number; `secondary` is the lip of each interface
/// that carries the multipliers. Local.
pub fn special_nodes(
    mesh: &LocalMesh,
    secondary: &[Lip],
    prescribed: &Prescribed,
) -> Vec<SpecialNode> {
    if mesh.directions.is_empty() {
        return Vec::new();
    }
    let nodes = 0..mesh.nodes.names.len() as u32;
    nodes.filter_map(|node| special_node(mesh, secondary, prescribed, node)).collect()
}

fn special_node(
    mesh: &LocalMesh,
    secondary: &[Lip],
    prescribed: &Prescribed,
    node: u32,
) -> Option<SpecialNode> {
    let marks = &mesh.nodes.marks[node as usize];
    let lip = marks
        .lip()
        .filter(|(interface, lip)| !marks.is_junction && secondary.get(*interface) == Some(lip));
    let normal = lip.and_then(|(interface, _)| mesh.directions.of_lip(node, interface));
    let given = given_at(mesh, prescribed, node);
    let directions: Vec<[f64; 3]> = given.iter().map(|given| given.direction).collect();
    let frame = NodeFrame::new(mesh.dim(), normal, &directions);
    let of_edges = |(interface, lip): (usize, &Lip)| mesh.directions.ends(node, interface, *lip);
    let ends = secondary.iter().enumerate().find_map(of_edges);
    // Only where the ends are held alike the middle's own part is known.
    let holds = |end: u32| {
        let marks = &mesh.nodes.marks[end as usize];
        given.iter().all(|given| prescribed.is_on(given.entry, marks))
    };
    let is_held_alike = ends.is_none_or(|ends| ends.into_iter().all(holds));
    let is_at_odds = frame.is_at_odds || !is_held_alike;
    // Without a multiplier there is no need of shares.
    let ends = ends.filter(|_| !is_at_odds && !marks.is_junction);
    let is_along_axes = given.iter().all(|given| given.axis.is_some());
    if frame.rotation.is_none() && ends.is_none() && is_along_axes && !is_at_odds {
        return None;
    }
    let terms = terms(mesh, node, &frame, &given, ends);
    Some(SpecialNode {
        node,
        rotation: frame.rotation,
        ends,
        fixed: frame.fixed,
        is_at_odds,
        terms,
    })
}

/// Checks that what is prescribed along directions of which one follows from the others agrees at
/// every one of the `times`, to 1e-12 of the `largest` value of the case. Local.
///
/// # Errors
/// At the first node where it does not, naming the entries, the place and the values.
pub fn check_directions(
    mesh: &LocalMesh,
    prescribed: &Prescribed,
    times: &[f64],
    largest: f64,
) -> std::result::Result<(), AtNode> {
    for node in mesh.directions.of_surfaces.iter().map(|one| one.node) {
        let (name, point) = (mesh.nodes.names[node as usize], mesh.nodes.points[node as usize]);
        let given = given_at(mesh, prescribed, node);
        let directions: Vec<[f64; 3]> = given.iter().map(|given| given.direction).collect();
        for (index, factors) in NodeFrame::new(mesh.dim(), None, &directions).dependent {
            let is_carried = |i: &usize| prescribed.is_carried(given[*i].entry, given[*i].axis);
            let others: Vec<usize> = factors.iter().map(|(other, _)| *other).collect();
            if let Some(other) = others.first()
                && (is_carried(&index) || others.iter().any(is_carried))
            {
                let entries = [*other, index].map(|i| given[i].entry);
                let words = "the displacement along one direction";
                return Err(AtNode(name, prescribed.held_twice(entries, words, point)));
            }
            for time in times {
                let value = |index: usize| {
                    let value = prescribed.value_of(&given[index], point, *time);
                    value.map_err(|error| AtNode(name, error))
                };
                let (own, mut others) = (value(index)?, 0.0);
                for (other, factor) in &factors {
                    others += factor * value(*other)?;
                }
                if (own - others).abs() > AGREE * largest {
                    let names: Vec<String> =
                        factors.iter().map(|(i, _)| prescribed.name(given[*i].entry)).collect();
                    let ([x, y, z], of) = (point, prescribed.name(given[index].entry));
                    return Err(AtNode(
                        name,
                        Error::Input(format!(
                            "{} and {of} prescribe displacements that contradict each other along \
                             one direction at ({x}, {y}, {z}) m at time {time}: {others:e} and \
                             {own:e} m; make them agree there",
                            names.join(", ")
                        )),
                    ));
                }
            }
        }
    }
    Ok(())
}

fn given_at(mesh: &LocalMesh, prescribed: &Prescribed, node: u32) -> Vec<Given> {
    let normals = |surface| mesh.directions.of_surface(node, surface).collect();
    prescribed.given_at(&mesh.nodes.marks[node as usize], normals)
}

/// The parts of the values of the prescribed unknowns of a node.
fn terms(
    mesh: &LocalMesh,
    node: u32,
    frame: &NodeFrame,
    given: &[Given],
    ends: Option<[u32; 2]>,
) -> Vec<SupportTerm> {
    let mut terms = Vec::new();
    for (component, values) in frame.values.iter().enumerate() {
        for (index, factor) in values {
            let mut add = |factor: f64, at: u32| {
                let point = mesh.nodes.points[at as usize];
                terms.push(SupportTerm { component, given: given[*index], factor, point });
            };
            let Some(ends) = ends else {
                add(*factor, node);
                continue;
            };
            // What the middle has beyond the share of the ends.
            let own = factor / (1.0 - 2.0 * SHARE_OF_END);
            add(own, node);
            ends.into_iter().for_each(|end| add(-SHARE_OF_END * own, end));
        }
    }
    terms
}
