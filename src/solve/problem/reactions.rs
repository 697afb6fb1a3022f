//! The forces of the supports, summed over surfaces.

use crate::assembly::Discretization;
use crate::case::Surface;

/// The forces of the supports on the bodies over this rank's own nodes (N; in 2D per metre): of
/// each of the `surfaces` over all its nodes, by component where one is prescribed, whoever
/// prescribes it, so that a node of two surfaces counts for both; last of all nodes, each once.
/// `force` is that at a node and component. Local.
pub fn reactions(
    all: &Discretization,
    surfaces: &[Surface],
    force: impl Fn(usize, usize) -> f64,
) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; surfaces.len() + 1];
    let (of_surfaces, total) = sums.split_at_mut(surfaces.len());
    for node in (0..all.nodes.owned).filter(|node| all.prescribed[*node] != [false; 3]) {
        for c in (0..all.dim).filter(|c| all.prescribed[node][*c]) {
            let force = force(node, c);
            total[0][c] += force;
            for (surface, sum) in surfaces.iter().zip(&mut *of_surfaces) {
                if all.nodes.marks[node].is_on(*surface) {
                    sum[c] += force;
                }
            }
        }
    }
    sums
}
