//! Meshes in the plane that are seen from behind.

use crate::mesh::import::order::reversal;
use crate::mesh::import::{Block, FileMesh, Kind};

/// Turns the cells of a mesh in the plane z = 0 round if all of them run clockwise. As the solids
/// of the format are mirrored, so are plane cells for some of its writers: MEDCoupling counts the
/// area of those as positive that run clockwise. Where only some do, they stay, to be refused.
pub fn face_up(mesh: &mut FileMesh) {
    let is_plane = mesh.points.iter().all(|point| point[2] == 0.0);
    if !is_plane || mesh.blocks.iter().any(|block| block.kind.dim() > 2) {
        return;
    }
    let points = &mesh.points;
    let cells = |block: &&Block| block.kind.dim() == 2 && !block.numbers.is_empty();
    let is_clockwise = |block: &Block| {
        let corners = if matches!(block.kind, Kind::Tri3 | Kind::Tri6) { 3 } else { 4 };
        let mut elements = block.nodes.chunks_exact(block.kind.nodes());
        elements.all(|nodes| area(points, &nodes[..corners]) < 0.0)
    };
    let count: usize = mesh.blocks.iter().filter(cells).map(|block| block.numbers.len()).sum();
    if count == 0 || !mesh.blocks.iter().filter(cells).all(is_clockwise) {
        return;
    }
    for block in mesh.blocks.iter_mut().filter(|block| block.kind.dim() == 2) {
        let order = reversal(block.kind);
        for nodes in block.nodes.chunks_exact_mut(order.len()) {
            let old = nodes.to_vec();
            nodes.iter_mut().zip(&order).for_each(|(node, from)| *node = old[*from]);
        }
    }
    mesh.remarks.push(format!(
        "all {count} cells run clockwise, as MEDCoupling makes them: their nodes are taken the other \
         way round"
    ));
}

/// Twice the area of a polygon in the plane, positive if it runs counter-clockwise.
fn area(points: &[[f64; 3]], nodes: &[u32]) -> f64 {
    let point = |k: usize| points[nodes[k % nodes.len()] as usize];
    (0..nodes.len())
        .map(|k| {
            let ([a, b, _], [c, d, _]) = (point(k), point(k + 1));
            a * d - b * c
        })
        .sum()
}
