//! Bodies: cells that hang together by nodes.

use super::view::View;

/// Of a node of no cell.
const NONE: u32 = u32::MAX;

/// The body of each node, and the first cell of each body, by which bodies are numbered; a node of
/// no cell has `u32::MAX`.
///
/// # Arguments
/// * `add` puts the nodes of a cell, all of them below `nodes`, into a list
pub fn bodies(
    nodes: usize,
    cells: usize,
    add: impl Fn(usize, &mut Vec<u32>),
) -> (Vec<u32>, Vec<u32>) {
    let mut roots: Vec<u32> = (0..nodes as u32).collect();
    let mut of_cell = Vec::new();
    for cell in 0..cells {
        of_cell.clear();
        add(cell, &mut of_cell);
        let mut one = root(&mut roots, of_cell[0]);
        for node in &of_cell[1..] {
            let other = root(&mut roots, *node);
            // The lower root wins, so that paths stay short and the result is the same always.
            let (low, high) = (one.min(other), one.max(other));
            roots[high as usize] = low;
            one = low;
        }
    }
    let mut names = vec![NONE; roots.len()];
    let mut firsts = Vec::new();
    for cell in 0..cells {
        of_cell.clear();
        add(cell, &mut of_cell);
        let name = &mut names[root(&mut roots, of_cell[0]) as usize];
        if *name == NONE {
            *name = firsts.len() as u32;
            firsts.push(cell as u32);
        }
    }
    // Roots are the lowest nodes, so that what stands below a node is a body by then.
    for node in 0..nodes {
        let root = roots[node] as usize;
        roots[node] = if root == node { names[node] } else { roots[root] };
    }
    (roots, firsts)
}

/// The body of each cell of a view, and how many there are.
pub fn bodies_of(view: View<'_>) -> (Vec<u32>, usize) {
    let add = |cell: usize, nodes: &mut Vec<u32>| nodes.extend_from_slice(view.cell_nodes(cell));
    let (of_nodes, firsts) = bodies(view.points.len(), view.shapes.len(), add);
    let body = |cell: usize| of_nodes[view.cell_nodes(cell)[0] as usize];
    ((0..view.shapes.len()).map(body).collect(), firsts.len())
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
