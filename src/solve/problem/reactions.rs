//! The forces of the supports, summed over surfaces.

use crate::assembly::Discretization;
use crate::case::SurfaceBit;

/// The forces of the supports on the bodies over this rank's own nodes (N; in 2D per metre): of
/// each of the `surfaces` over all its nodes, whoever prescribes something there, so that a node of
/// two surfaces counts for both; last of all nodes, each once. `force` is that on an unknown of a
/// node, where there is one. Local.
pub fn reactions(
    all: &Discretization,
    surfaces: &[SurfaceBit],
    force: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; surfaces.len() + 1];
    let (of_surfaces, total) = sums.split_at_mut(surfaces.len());
    for node in 0..all.nodes.owned {
        let of = |c: usize| if c < all.dim { force(node, c) } else { None };
        let support: [Option<f64>; 3] = std::array::from_fn(of);
        if support == [None; 3] {
            continue;
        }
        let mut support = support.map(|force| force.unwrap_or(0.0));
        if let Some(framed) = all.frames.at(node as u32) {
            support = all.frames.turned_back(&framed.rotation, support);
        }
        let here = |surface: &SurfaceBit| all.nodes.marks[node].is_on(*surface);
        let at = surfaces.iter().zip(&mut *of_surfaces).filter(|(surface, _)| here(surface));
        for sum in at.map(|(_, sum)| sum).chain(&mut *total) {
            sum.iter_mut().zip(support).for_each(|(sum, force)| *sum += force);
        }
    }
    sums
}
