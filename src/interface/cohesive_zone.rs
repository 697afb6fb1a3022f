//! Whether cells resolve the zone in which an interface softens.

use super::Sides;
use crate::case::Case;
use crate::mesh::MeshFacts;

/// The zone spans at least so many distances of nodes, or damage depends on the mesh.
const FEWEST: f64 = 2.0;

/// What is to be said of interfaces whose cohesive zone, of length E G/strength^2 (A. Hillerborg,
/// M. Modeer, P. Petersson, Cem. Concr. Res. 6, 1976), the cells beside them do not resolve. Local.
pub fn unresolved_zones(case: &Case, mesh: &MeshFacts, sides: &[Sides]) -> Vec<String> {
    let words = |(interface, sides): (&crate::case::InterfaceSpec, &Sides)| {
        let law = interface.law.law();
        let strength = law.strength()?;
        let energy = law.dissipated(law.jump_scale().unwrap_or(f64::MAX));
        let lip = sides.secondary_facts(mesh);
        let edges = lip.cell[..case.dim - 1].iter();
        let across = edges.fold(0.0_f64, |m, h| m.max(*h)) / lip.order as f64;
        let zone = case.materials[lip.material].young_modulus * energy / (strength * strength);
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
