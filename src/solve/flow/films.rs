//! The films of fluid between lips, and the ties that give both lips one pressure.

use super::pressures::Pressures;
use crate::assembly::{Discretization, FilmFacet, FilmNode, Films, Tie};
use crate::case::Case;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::interface::{Film, Fluid, JumpRows, Sides, jump_rows};
use crate::mesh::{LocalMesh, NodePlace};
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
    let fixed = |node: u64| [pressures.prescribed.entry_of(node).is_some(), false, false];
    jump_rows(comm, pressures.corners, &sides, 1, &fixed, directory)
}

/// Pressure nodes that this rank needs beside those of its cells: what `rows` extend over, and the
/// corners around its secondary nodes. Local.
pub(in crate::solve) fn further_nodes(
    case: &Case,
    (mesh, all): (&LocalMesh, &Discretization),
    pressures: &Pressures<'_>,
    rows: &[JumpRows<u64>],
) -> Vec<u64> {
    let others = rows.iter().filter_map(|row| row.rows[0].as_ref()).flat_map(|row| &row.others);
    let mut nodes: Vec<u64> = others.map(|(node, _)| *node).collect();
    for (_, corners) in film_nodes(case, (mesh, all), pressures) {
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

/// Indices into `Discretization::secondary` of the owned nodes with a film, and the corners around
/// each with their parts of the pressure there, by name.
fn film_nodes(
    case: &Case,
    (mesh, all): (&LocalMesh, &Discretization),
    pressures: &Pressures<'_>,
) -> Vec<(u32, Vec<(u64, f64)>)> {
    let owned = all.secondary[..all.owned_secondary()].iter().enumerate();
    let with_film = owned.filter(|(_, rows)| case.interfaces[rows.interface].film.is_some());
    let corners = |(index, rows): (usize, &JumpRows<u32>)| {
        let NodePlace { body, at } = mesh.column.node_place(all.nodes.names[rows.node as usize]);
        let order = mesh.column.order(body);
        let mut corners = vec![(at.map(|at| at / order), 1.0)];
        for axis in 0..2 {
            let part = (at[axis] % order) as f64 / order as f64;
            if part == 0.0 {
                continue;
            }
            let next = |(mut at, of): ([usize; 3], f64)| {
                at[axis] += 1;
                (at, part * of)
            };
            let further: Vec<_> = corners.iter().copied().map(next).collect();
            corners.iter_mut().for_each(|(_, of)| *of *= 1.0 - part);
            corners.extend(further);
        }
        let name = |at| pressures.corners.column.node(NodePlace { body, at });
        (index as u32, corners.into_iter().map(|(at, part)| (name(at), part)).collect())
    };
    with_film.map(corners).collect()
}

/// The films of this rank's secondary nodes and facets. Local.
pub(in crate::solve) fn films(
    case: &Case,
    sides: &[Sides],
    (mesh, all): (&LocalMesh, &Discretization),
    pressures: &Pressures<'_>,
    nodes: &Nodes,
) -> Films {
    let column = &mesh.column;
    let local = |name: u64| nodes.local(name).expect("the corners of a film are held");
    let mut films = Films::default();
    let mut sizes: Vec<([f64; 2], usize)> = Vec::new();
    for (_, side) in flowing(case, sides) {
        let place = column.facet_cell(side.secondary, [0, 0]);
        let porous = case.materials[column.cell_size(place).1].porous.as_ref();
        films.fluid = films.fluid.or(porous.map(|porous| Fluid {
            viscosity: porous.viscosity,
            density: porous.fluid_density,
            compressibility: porous.fluid_compressibility,
            reference: porous.reference_pressure,
        }));
        let order = column.order(side.secondary.body);
        let places = mesh.cells.iter().map(|cell| column.cell_place(*cell));
        for place in places.filter(|place| side.cell_is_secondary(column, *place)) {
            let ([x, y, _], _) = column.cell_size(place);
            let like = ([x, y], order);
            let prototype = sizes.iter().position(|size| *size == like).unwrap_or_else(|| {
                films.prototypes.push(Film::new(Shape::of(case.dim - 1, order), [x, y]));
                sizes.push(like);
                sizes.len() - 1
            });
            let at = [place.at[0], place.at[1]];
            let secondary = |name: &u64| {
                let node = all.nodes.local(*name).expect("a node of the rank's own cell");
                all.secondary_of[node as usize].expect("a node of the secondary side")
            };
            let corners = pressures.corners.column.facet_nodes(side.secondary, at);
            films.facets.push(FilmFacet {
                prototype: prototype as u16,
                nodes: column.facet_nodes(side.secondary, at).iter().map(secondary).collect(),
                corners: corners.into_iter().map(local).collect(),
            });
        }
    }
    for (secondary, corners) in film_nodes(case, (mesh, all), pressures) {
        let corners = corners.into_iter().map(|(name, part)| (local(name), part)).collect();
        films.nodes.push(FilmNode { secondary, corners });
    }
    films
}
