//! The films of fluid between lips, and the ties that give both lips one pressure.

use super::pressures::{Displacements, Pressures};
use crate::assembly::{Discretization, FilmFacet, FilmNode, Films, Tie};
use crate::case::Case;
use crate::comm::Comm;
use crate::element::{MAX_NODES, Shape};
use crate::error::Result;
use crate::interface::{Film, Fluid, JumpRows, Multipliers, Sides, jump_rows};
use crate::mesh::{Facet, LocalMesh};
use crate::space::{Directory, Nodes};

/// Interfaces along which fluid flows.
fn flowing<'a>(case: &'a Case, sides: &'a [Sides]) -> impl Iterator<Item = (usize, &'a Sides)> {
    sides.iter().enumerate().filter(|(index, _)| case.interfaces[*index].film.is_some())
}

/// The rows that tie the pressure of secondary lips to that of primary ones. Collective.
///
/// # Errors
/// `Input` when the primary side does not cover the secondary side.
pub(in crate::solve) fn tie_rows(
    comm: &Comm,
    case: &Case,
    sides: &[Sides],
    pressures: &Pressures<'_>,
    directory: &Directory<'_>,
) -> Result<Vec<JumpRows<u64>>> {
    let sides: Vec<Sides> = flowing(case, sides).map(|(_, side)| *side).collect();
    if sides.is_empty() {
        return Ok(Vec::new());
    }
    let nodes = &pressures.corners.nodes;
    let fixed = |name: u64| {
        let node = nodes.number(name).expect("a corner of the rank's own cell");
        [pressures.prescribed.entry_of(&nodes.marks[node]).is_some(), false, false]
    };
    let multipliers = Multipliers { fixed: &fixed, is_lost: &|_| false };
    let (rows, _) = jump_rows(comm, pressures.corners, &sides, 1, &multipliers, directory)?;
    Ok(rows)
}

/// Pressure nodes that this rank needs beside those of its cells: what `rows` extend over, and the
/// corners around its secondary nodes. Local.
pub(in crate::solve) fn further_nodes(
    case: &Case,
    of: Displacements<'_>,
    rows: &[JumpRows<u64>],
) -> Vec<u64> {
    let mut nodes: Vec<u64> = rows.iter().flat_map(|rows| rows.names_of_others()).collect();
    for (_, corners) in film_nodes(case, of) {
        nodes.extend(corners.iter().map(|(corner, _)| *corner));
    }
    nodes
}

/// The ties over local nodes. Local.
pub(in crate::solve) fn ties(
    rows: &[JumpRows<u64>],
    nodes: &Nodes,
) -> (Vec<Tie>, Vec<Option<u32>>) {
    let local = |name: u64| nodes.local(name).expect("the row's nodes are held");
    let mut tie_of = vec![None; nodes.len()];
    let mut ties = Vec::new();
    for rows in rows {
        let Some(row) = &rows.rows[0] else { continue };
        let node = local(rows.node);
        let follows = row.others.iter().map(|(n, a)| (local(*n), -a / row.own)).collect();
        tie_of[node as usize] = Some(ties.len() as u32);
        ties.push(Tie { node, follows });
    }
    (ties, tie_of)
}

/// Indices into `Discretization::secondary` of the owned nodes with a film, rising, and the corners
/// around each with their parts of the pressure there, by rising name.
fn film_nodes(case: &Case, of: Displacements<'_>) -> Vec<(u32, Vec<(u64, f64)>)> {
    let Displacements { mesh, all, sides } = of;
    let mut corners_of = vec![Vec::new(); all.owned_secondary()];
    for (_, side) in flowing(case, sides) {
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let (shape, nodes) = mesh.lip_nodes(side.secondary, *facet);
            let name = |node: u32| mesh.nodes.names[node as usize];
            for (node, xi) in nodes.iter().zip(shape.node_points()) {
                let index = secondary(all, name(*node)) as usize;
                let Some(of) = corners_of.get_mut(index).filter(|of| of.is_empty()) else {
                    continue;
                };
                let mut parts = [0.0; MAX_NODES];
                shape.corners().values(*xi, &mut parts);
                let corners = nodes.iter().zip(&parts[..shape.corners().nodes()]);
                let parts = corners.filter(|(_, part)| **part != 0.0);
                of.extend(parts.map(|(node, part)| (name(*node), *part)));
                of.sort_unstable_by_key(|(name, _)| *name);
            }
        }
    }
    let numbered = corners_of.into_iter().enumerate().filter(|(_, corners)| !corners.is_empty());
    numbered.map(|(index, corners)| (index as u32, corners)).collect()
}

/// Index into `Discretization::secondary` of a node of the secondary side of this rank's cells.
fn secondary(all: &Discretization, name: u64) -> u32 {
    let node = all.nodes.local(name).expect("a node of the rank's own cell");
    all.secondary_of[node as usize].expect("a node of the secondary side")
}

/// The films of this rank's secondary nodes and facets. Local.
pub(in crate::solve) fn films(case: &Case, of: Displacements<'_>, nodes: &Nodes) -> Films {
    let Displacements { mesh, all, sides } = of;
    let local = |name: u64| nodes.local(name).expect("the corners of a film are held");
    let mut films = Films::default();
    // The edges of facets of boxes, and the shapes.
    let mut known: Vec<(Option<[f64; 2]>, Shape)> = Vec::new();
    for (_, side) in flowing(case, sides) {
        let lip = side.secondary_facts(&mesh.facts);
        let porous = case.materials[lip.material].porous.as_ref();
        films.fluid = films.fluid.or(porous.map(|porous| Fluid {
            viscosity: porous.viscosity,
            density: porous.fluid_density,
            compressibility: porous.fluid_compressibility,
            reference: porous.reference_pressure,
        }));
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let (shape, nodes) = mesh.lip_nodes(side.secondary, *facet);
            let edges = edges(mesh, *facet, &nodes);
            let alike = |of: &(Option<[f64; 2]>, Shape)| of.0.is_some() && *of == (edges, shape);
            let prototype = known.iter().position(alike).unwrap_or_else(|| {
                films.prototypes.push(match edges {
                    Some(size) => Film::new(shape, size),
                    None => Film::of_points(shape, &by_component(mesh, &nodes)),
                });
                known.push((edges, shape));
                known.len() - 1
            });
            let names: Vec<u64> =
                nodes.iter().map(|node| mesh.nodes.names[*node as usize]).collect();
            let corners = &names[..shape.corners().nodes()];
            films.facets.push(FilmFacet {
                prototype: prototype as u32,
                nodes: names.iter().map(|name| secondary(all, *name)).collect(),
                corners: corners.iter().map(|name| local(*name)).collect(),
            });
        }
    }
    for (secondary, corners) in film_nodes(case, of) {
        let corners = corners.into_iter().map(|(name, part)| (local(name), part)).collect();
        films.nodes.push(FilmNode { secondary, corners });
    }
    films
}

/// The edges of a facet with these nodes (m) whose first edge lies along the first axis and whose
/// normal along the last one, if it belongs to a box.
fn edges(mesh: &LocalMesh, facet: Facet, nodes: &[u32]) -> Option<[f64; 2]> {
    let size = mesh.prototype(facet.cell as usize).geometry.size()?;
    let (axes, points) = (mesh.facts.axes, by_component(mesh, nodes));
    let normal = axes.len() - 1;
    let is_flat = points.iter().all(|x| x[normal] == points[0][normal]);
    let runs_along = (1..axes.len()).all(|c| points[0][c] == points[1][c]);
    (is_flat && runs_along && points[0][0] < points[1][0]).then(|| [size[axes[0]], size[axes[1]]])
}

/// Positions of nodes by displacement component (m).
fn by_component(mesh: &LocalMesh, nodes: &[u32]) -> Vec<[f64; 3]> {
    let axes = mesh.facts.axes;
    let along = |x: [f64; 3]| std::array::from_fn(|c| axes.get(c).map_or(0.0, |axis| x[*axis]));
    nodes.iter().map(|node| along(mesh.nodes.points[*node as usize])).collect()
}
