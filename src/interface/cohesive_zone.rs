//! Whether cells resolve the zone in which an interface softens.

use super::Sides;
use crate::case::Case;
use crate::mesh::Column;

/// The zone spans at least so many distances of nodes, or damage depends on the mesh.
const FEWEST: f64 = 2.0;

/// What is to be said of interfaces whose cohesive zone, of length E G/strength^2 (A. Hillerborg,
/// M. Modeer, P. Petersson, Cem. Concr. Res. 6, 1976), the cells beside them do not resolve. Local.
pub fn unresolved_zones(case: &Case, column: &Column, sides: &[Sides]) -> Vec<String> {
    let words = |(interface, sides): (&crate::case::InterfaceSpec, &Sides)| {
        let law = interface.law.law();
        let strength = law.strength()?;
        let energy = law.dissipated(law.jump_scale().unwrap_or(f64::MAX));
        let place = column.facet_cell(sides.secondary, [0, 0]);
        let (size, material) = column.cell_size(place);
        let order = column.order(place.body) as f64;
        let across = size[..case.dim - 1].iter().fold(0.0_f64, |m, h| m.max(*h)) / order;
        let zone = case.materials[material].young_modulus * energy / (strength * strength);
        (zone < FEWEST * across).then(|| {
            format!(
                "the cohesive zone of interface {}, E G/strength^2 = {zone:.3e} m, is not resolved \
                 by nodes {across:.3e} m apart: unless the interface opens evenly, its damage depends \
                 on the mesh; have nodes at most {:.3e} m apart across the column",
                interface.name,
                zone / FEWEST
            )
        })
    };
    case.interfaces.iter().zip(sides).filter_map(words).collect()
}
