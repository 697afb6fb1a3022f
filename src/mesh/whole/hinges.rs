//! Parts of bodies that hang on others by nodes or edges alone: they may turn about them.

use super::across::facing;
use super::bodies::root;
use super::cells::{Cells, NONE};
use super::facets::{of_slot, slot};
use super::types::WholeMesh;
use crate::element::Shape;
use crate::mesh::facts::{HingeNode, Hinges, Part};

/// More parts than this are not looked at.
const MOST_PARTS: usize = 10_000;

/// Those of a mesh after cutting; `mates`: the facets on the other sides of all facets.
pub fn hinges(mesh: &WholeMesh, mates: &[u32]) -> Hinges {
    let (of_cell, count) = by_facets(mesh, mates);
    if count == mesh.body_count || count > MOST_PARTS {
        return Hinges::default();
    }
    let (of_cell, count) = joined(mesh, &of_cell, count);
    let mut found = Hinges { parts: vec![Part::default(); count], nodes: Vec::new() };
    let mut of_node = vec![NONE; mesh.points.len()];
    let mut shared = Vec::new();
    for (cell, part) in of_cell.iter().enumerate() {
        let of_part = &mut found.parts[*part as usize];
        let nodes = mesh.cell_nodes(cell);
        for node in nodes {
            let seen = &mut of_node[*node as usize];
            if *seen == NONE {
                *seen = *part;
            } else if *seen != *part {
                shared.push((*node, [*seen as usize, *part as usize]));
            }
            let point = mesh.points[*node as usize];
            (0..3).for_each(|i| of_part.middle[i] += point[i] / nodes.len() as f64);
        }
        of_part.cells += 1;
    }
    if shared.is_empty() {
        return Hinges::default();
    }
    for part in &mut found.parts {
        part.middle = part.middle.map(|sum| sum / part.cells as f64);
    }
    shared.sort_unstable();
    shared.dedup();
    shared.iter().for_each(|(node, _)| of_node[*node as usize] = NONE);
    for (index, surface) in mesh.surfaces.iter().enumerate() {
        let parts = surface.nodes.iter().map(|node| of_node[*node as usize]);
        for part in parts.filter(|part| *part != NONE) {
            let surfaces = &mut found.parts[part as usize].surfaces;
            if surfaces.last() != Some(&index) {
                surfaces.push(index);
            }
        }
    }
    let on = |node: &u32| {
        let surfaces = mesh.surfaces.iter().enumerate();
        surfaces.filter(|(_, s)| s.nodes.binary_search(node).is_ok()).map(|(i, _)| i).collect()
    };
    let hinge = |(node, parts): &(u32, [usize; 2])| HingeNode {
        point: mesh.points[*node as usize],
        parts: *parts,
        surfaces: on(node),
    };
    found.nodes = shared.iter().map(hinge).collect();
    found
}

/// Whether around some wanted corner, all of whose cells are here, these do not hang together by
/// facets at it, or whether it lies in the middle of another cell's edge or facet. Where that is
/// nowhere, no part hangs on another by nodes alone.
pub fn are_pinched(cells: &Cells, mates: &[u32], is_wanted: &dyn Fn(u32) -> bool) -> bool {
    let view = cells.view();
    // Of the places of nodes in cells, which facets join.
    let mut roots: Vec<u32> = (0..cells.nodes.len() as u32).collect();
    let place = |cell: usize, node: u32| {
        let local = view.cell_nodes(cell).iter().position(|other| *other == node);
        cells.start[cell] + local.unwrap_or_default() as u32
    };
    for facet in (0..cells.shapes.len()).flat_map(|cell| view.facets(cell)) {
        let (cell, mate) = (facet.cell as usize, mates[slot(facet)]);
        if mate == NONE || of_slot(mate).cell < facet.cell {
            continue;
        }
        let other = of_slot(mate).cell as usize;
        let corners = view.facet_nodes(facet).take(view.corner_count(facet));
        for node in corners.filter(|node| is_wanted(*node)) {
            let [one, other] = [cell, other].map(|cell| root(&mut roots, place(cell, node)));
            roots[one.max(other) as usize] = one.min(other);
        }
    }
    let mut of_node = vec![NONE; cells.points.len()];
    for (cell, shape) in cells.shapes.iter().enumerate() {
        let places = cells.start[cell]..;
        for (place, node) in places.zip(&view.cell_nodes(cell)[..shape.corners().nodes()]) {
            let (root, seen) = (root(&mut roots, place), &mut of_node[*node as usize]);
            if *seen != NONE && *seen != root && is_wanted(*node) {
                return true;
            }
            *seen = root;
        }
    }
    let middles =
        |(cell, shape): (usize, &Shape)| &view.cell_nodes(cell)[shape.corners().nodes()..];
    let mut middles = cells.shapes.iter().enumerate().flat_map(middles);
    middles.any(|node| of_node[*node as usize] != NONE)
}

/// The part of each cell, where cells hang together by facets, and the number of parts.
fn by_facets(mesh: &WholeMesh, mates: &[u32]) -> (Vec<u32>, usize) {
    let mut of_cell = vec![NONE; mesh.cells()];
    let (mut count, mut waiting) = (0, Vec::new());
    for first in 0..mesh.cells() {
        if of_cell[first] != NONE {
            continue;
        }
        of_cell[first] = count;
        waiting.push(first);
        while let Some(cell) = waiting.pop() {
            for facet in mesh.view().facets(cell) {
                let mate = mates[slot(facet)];
                if mate == NONE {
                    continue;
                }
                let other = of_slot(mate).cell as usize;
                if of_cell[other] == NONE {
                    of_cell[other] = count;
                    waiting.push(other);
                }
            }
        }
        count += 1;
    }
    (of_cell, count as usize)
}

/// The parts after interfaces have joined some.
fn joined(mesh: &WholeMesh, of_cell: &[u32], count: usize) -> (Vec<u32>, usize) {
    let mut pairs = Vec::new();
    for interface in &mesh.interfaces {
        if interface.faces.is_empty() {
            pairs.extend(facing(mesh, interface));
        } else {
            let [lower, upper] = &interface.lips;
            pairs.extend(lower.iter().zip(upper).map(|(one, other)| [*one, *other]));
        }
    }
    let mut roots: Vec<u32> = (0..count as u32).collect();
    for pair in pairs {
        let [a, b] = pair.map(|facet| root(&mut roots, of_cell[facet.cell as usize]));
        roots[a.max(b) as usize] = a.min(b);
    }
    // A root is the lowest of its parts: it has its number before the others ask for it.
    let mut numbers = vec![0; count];
    let mut next = 0;
    for part in 0..count as u32 {
        let first = root(&mut roots, part);
        numbers[part as usize] = if first == part { next } else { numbers[first as usize] };
        next += u32::from(first == part);
    }
    (of_cell.iter().map(|part| numbers[*part as usize]).collect(), next as usize)
}
