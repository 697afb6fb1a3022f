//! Bodies: cells that hang together by nodes.

use super::view::View;

/// The body of each cell, numbered by their first cells, and how many there are.
///
/// # Arguments
/// * `add` puts the nodes of a cell, all of them below `nodes`, into a list
pub fn bodies(nodes: usize, cells: usize, add: impl Fn(usize, &mut Vec<u32>)) -> (Vec<u32>, usize) {
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
    let none = u32::MAX;
    let mut names = vec![none; roots.len()];
    let mut count = 0;
    let mut bodies = Vec::with_capacity(cells);
    for cell in 0..cells {
        of_cell.clear();
        add(cell, &mut of_cell);
        let name = &mut names[root(&mut roots, of_cell[0]) as usize];
        if *name == none {
            *name = count;
            count += 1;
        }
        bodies.push(*name);
    }
    (bodies, count as usize)
}

/// Those of the cells of a view.
pub fn bodies_of(view: View<'_>) -> (Vec<u32>, usize) {
    let add = |cell: usize, nodes: &mut Vec<u32>| nodes.extend_from_slice(view.cell_nodes(cell));
    bodies(view.points.len(), view.shapes.len(), add)
}

/// The node that stands for the body of a node.
fn root(roots: &mut [u32], node: u32) -> u32 {
    let mut at = node;
    while roots[at as usize] != at {
        // Every second step is left out the next time.
        roots[at as usize] = roots[roots[at as usize] as usize];
        at = roots[at as usize];
    }
    at
}
