//! Imperfections: what strength and fracture energy of an interface are multiplied by, node by
//! node.

use crate::case::Case;
use crate::space::AtNode;

/// The factors at secondary nodes, given as interface and name; 1 where the interface is perfect.
/// Local.
///
/// # Errors
/// At the first node where the factor is not positive or not finite, naming entry and place.
pub fn strength_factors(
    case: &Case,
    nodes: impl Iterator<Item = (usize, u64, [f64; 3])>,
) -> Result<Vec<f64>, AtNode> {
    let factor = |(interface, node, point): (usize, u64, [f64; 3])| {
        let of = case.imperfections.iter().find(|one| one.interface == interface);
        let at = |one: &crate::case::Imperfection| one.at(point);
        of.map_or(Ok(1.0), at).map_err(|error| AtNode(node, error))
    };
    nodes.map(factor).collect()
}
