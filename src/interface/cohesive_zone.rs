//! Whether cells resolve the zone in which an interface softens.

use crate::case::Case;
use crate::mesh::{Lip, MeshFacts};

/// The zone spans at least so many distances of nodes, or damage depends on the mesh: between two
/// (Y. Mi, M. Crisfield, G. Davies, H. Hellweg, J. Compos. Mater. 32, 1998; M. Falk, A. Needleman,
/// J. Rice, J. Phys. IV 11, 2001: two to five) and more than ten (N. Moes, T. Belytschko, Eng.
/// Fract. Mech. 69, 2002) are asked for; A. Turon, C. Davila, P. Camanho, J. Costa (Eng. Fract.
/// Mech. 74, 2007) find that three suffice.
pub const FEWEST: f64 = 3.0;

/// Length of the cohesive zone of an interface, E' G/strength^2 (A. Hillerborg, M. Modeer, P.
/// Petersson, Cem. Concr. Res. 6, 1976), with the modulus in plane strain of the softer side (m);
/// none where its law has no strength or no end. Local.
pub fn zone_length(case: &Case, mesh: &MeshFacts, interface: usize) -> Option<f64> {
    let law = case.interfaces[interface].law.law();
    let strength = law.strength()?;
    let energy = law.dissipated(law.jump_scale().unwrap_or(f64::MAX));
    let modulus = |lip: Lip| {
        let material = &case.materials[mesh.interfaces[interface][lip.index()].material];
        material.young_modulus / (1.0 - material.poisson_ratio.powi(2))
    };
    let softer = Lip::BOTH.map(modulus).into_iter().fold(f64::INFINITY, f64::min);
    let zone = softer * energy / (strength * strength);
    (zone.is_finite() && zone > 0.0).then_some(zone)
}

/// What is to be said, before a run, of interfaces whose cohesive zone the cells beside them would
/// not resolve. Local.
pub fn unresolved_zones(case: &Case, mesh: &MeshFacts) -> Vec<String> {
    let words = |(number, interface): (usize, &crate::case::InterfaceSpec)| {
        let zone = zone_length(case, mesh, number)?;
        let spacing = |lip: Lip| {
            let facts = &mesh.interfaces[number][lip.index()];
            let longest = facts.cell[..case.dim - 1].iter().fold(0.0_f64, |m, h| m.max(*h));
            longest / facts.order as f64
        };
        let across = Lip::BOTH.map(spacing).into_iter().fold(0.0, f64::max);
        (zone < FEWEST * across).then(|| {
            format!(
                "the cohesive zone of interface {}, E' G/strength^2 = {zone:.3e} m, is not resolved \
                 by nodes {across:.3e} m apart: unless the interface opens evenly, its damage \
                 depends on the mesh; have nodes at most {:.3e} m apart along the interface",
                interface.name,
                zone / FEWEST
            )
        })
    };
    case.interfaces.iter().enumerate().filter_map(words).collect()
}
