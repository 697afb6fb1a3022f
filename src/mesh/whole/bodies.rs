//! Bodies: cells that hang together by nodes.

use super::view::View;

/// The body of each cell, numbered by their first cells, and how many there are.
pub fn bodies(view: View<'_>) -> (Vec<u32>, usize) {
    let mut roots: Vec<u32> = (0..view.points.len() as u32).collect();
    for cell in 0..view.shapes.len() {
        let nodes = view.cell_nodes(cell);
        let mut one = root(&mut roots, nodes[0]);
        for node in &nodes[1..] {
            let other = root(&mut roots, *node);
            // The lower root wins, so that paths stay short and the result is the same always.
            let (low, high) = (one.min(other), one.max(other));
            roots[high as usize] = low;
            one = low;
        }
    }
    let none = u32::MAX;
    let mut names = vec![none; roots.len()];
    let mut count = 0;
    let mut bodies = Vec::with_capacity(view.shapes.len());
    for cell in 0..view.shapes.len() {
        let name = &mut names[root(&mut roots, view.cell_nodes(cell)[0]) as usize];
        if *name == none {
            *name = count;
            count += 1;
        }
        bodies.push(*name);
    }
    (bodies, count as usize)
}

/// The node that stands for the body of a node.
pub(super) fn root(roots: &mut [u32], node: u32) -> u32 {
    let mut at = node;
    while roots[at as usize] != at {
        // Every second step is left out the next time.
        roots[at as usize] = roots[roots[at as usize] as usize];
        at = roots[at as usize];
    }
    at
}
