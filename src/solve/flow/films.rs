//! The films of fluid between lips.

use super::pressures::{Displacements, flowing};
use super::ties::NamedTie;
use crate::assembly::{Discretization, FilmFacet, FilmNode, Films, Opening};
use crate::case::Case;
use crate::element::{MAX_NODES, Shape};
use crate::interface::{Film, Fluid, Sides};
use crate::mesh::{Facet, LocalMesh};
use crate::space::{AtNode, Nodes};

/// Parts of a corner below this are rounding.
const ROUNDING: f64 = 1e-12;

/// Pressure nodes that this rank needs beside those of its cells: what pressures follow, and the
/// corners around its secondary nodes. Local.
pub(in crate::solve) fn further_nodes(
    case: &Case,
    of: Displacements<'_>,
    ties: &[NamedTie],
) -> Vec<u64> {
    let follows = ties.iter().flat_map(|tie| &tie.follows);
    let mut nodes: Vec<u64> = follows.map(|(name, _)| *name).collect();
    for (_, corners) in film_nodes(case, of) {
        nodes.extend(corners.iter().map(|(corner, _)| *corner));
    }
    nodes
}

/// Indices into `Discretization::secondary` of the owned nodes with a film, rising, and the corners
/// around each with their parts of the pressure there, by rising name.
fn film_nodes(case: &Case, of: Displacements<'_>) -> Vec<(u32, Vec<(u64, f64)>)> {
    let Displacements { mesh, all, sides, .. } = of;
    let mut corners_of = vec![Vec::new(); all.owned_secondary()];
    for (_, side) in flowing(case, sides) {
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let (shape, nodes) = mesh.lip_nodes(side.secondary, *facet);
            let name = |node: u32| mesh.nodes.names[node as usize];
            for (node, xi) in nodes.iter().zip(shape.node_points()) {
                let index = secondary(all, name(*node)).map(|index| index as usize);
                let of = index.and_then(|index| corners_of.get_mut(index));
                let Some(of) = of.filter(|of| of.is_empty()) else { continue };
                *of = corners_around(mesh, shape, &nodes, *xi);
            }
        }
    }
    if mesh.is_of_file() {
        add_missing(case, of, &mut corners_of);
    }
    let numbered = corners_of.into_iter().enumerate().filter(|(_, corners)| !corners.is_empty());
    numbered.map(|(index, corners)| (index as u32, corners)).collect()
}

/// The corners around secondary nodes of which this rank has cells, but none with a facet there.
fn add_missing(case: &Case, of: Displacements<'_>, corners_of: &mut [Vec<(u64, f64)>]) {
    let Displacements { mesh, all, sides, .. } = of;
    let mut missing = vec![None; mesh.nodes.names.len()];
    for (_, side) in flowing(case, sides) {
        for (node, (name, _, marks)) in mesh.nodes.iter().enumerate() {
            let index = secondary(all, name).filter(|_| side.is_secondary(marks));
            missing[node] = index.or(missing[node]);
        }
    }
    for cell in 0..mesh.cells.len() {
        let (shape, nodes) = (mesh.shape(cell), mesh.cell_nodes(cell));
        for (node, xi) in nodes.iter().zip(shape.node_points()) {
            let index = missing[*node as usize].map(|index| index as usize);
            let of = index.and_then(|index| corners_of.get_mut(index));
            if let Some(of) = of.filter(|of| of.is_empty()) {
                *of = corners_around(mesh, shape, nodes, *xi);
            }
        }
    }
}

/// The corners around a node of a cell or a facet at its reference coordinates, with their parts of
/// a pressure there, by rising name.
fn corners_around(mesh: &LocalMesh, shape: Shape, nodes: &[u32], xi: [f64; 3]) -> Vec<(u64, f64)> {
    let mut parts = [0.0; MAX_NODES];
    shape.corners().values(xi, &mut parts);
    let corners = nodes.iter().zip(&parts[..shape.corners().nodes()]);
    let parts = corners.filter(|(_, part)| part.abs() > ROUNDING);
    let mut of: Vec<(u64, f64)> =
        parts.map(|(node, part)| (mesh.nodes.names[*node as usize], *part)).collect();
    of.sort_unstable_by_key(|(name, _)| *name);
    of
}

/// Index into `Discretization::secondary` of a node of the secondary side of this rank's cells;
/// none where interfaces meet or end.
fn secondary(all: &Discretization, name: u64) -> Option<u32> {
    let node = all.nodes.local(name).expect("a node of the rank's own cell");
    all.secondary_of[node as usize]
}

/// The openings of the nodes of a facet: each node by its place, an entry of
/// `Discretization::secondary` and its part. Where there is no row along the normal, as interfaces
/// meet or displacements are prescribed, it is the mean of those of the facet; at the edge of an
/// interface inside the mesh it is 0, and nothing stands there.
fn openings(of: Displacements<'_>, side: &Sides, facet: Facet, names: &[u64]) -> Vec<Opening> {
    let Displacements { mesh, all, .. } = of;
    let normal = all.dim - 1;
    let is_known =
        |i: &u32| !mesh.is_of_file() || all.secondary[*i as usize].rows[normal].is_some();
    let entries: Vec<Option<u32>> =
        names.iter().map(|name| secondary(all, *name).filter(is_known)).collect();
    let kept: Vec<u32> = entries.iter().copied().flatten().collect();
    if kept.len() == names.len() {
        let own = |(node, secondary)| Opening { node, secondary, part: 1.0 };
        return (0..).zip(kept).map(own).collect();
    }
    let across = mesh.across(side.interface, side.secondary, facet);
    let is_shut = |name: u64| across.iter().any(|far| far.nodes.contains(&name));
    let mut openings = Vec::new();
    for (node, (name, entry)) in (0..).zip(names.iter().zip(entries)) {
        match entry {
            Some(secondary) => openings.push(Opening { node, secondary, part: 1.0 }),
            None if is_shut(*name) => {}
            None => {
                let part = 1.0 / kept.len() as f64;
                openings.extend(kept.iter().map(|secondary| Opening {
                    node,
                    secondary: *secondary,
                    part,
                }));
            }
        }
    }
    openings
}

/// How wide the films are before anything moves.
struct Widths<'a> {
    case: &'a Case,
    all: &'a Discretization,
    /// Gaps at all local nodes (m), 0 at those that are not secondary.
    gaps: Vec<f64>,
}

impl<'a> Widths<'a> {
    /// Collective.
    fn new(case: &'a Case, of: Displacements<'a>) -> Self {
        let Displacements { all, gaps: owned, .. } = of;
        let mut gaps = vec![0.0; all.nodes.len()];
        for (rows, gap) in all.secondary.iter().zip(owned) {
            gaps[rows.node as usize] = *gap;
        }
        all.nodes.update_ghosts(&mut gaps, 1);
        Self { case, all, gaps }
    }

    /// What closed lips conduct at a node of an interface (m). Local.
    fn aperture(&self, interface: usize, name: u64, point: [f64; 3]) -> Result<f64, AtNode> {
        let start = self.case.interfaces[interface].start_at(interface, point);
        start.map(|start| start.aperture).map_err(|error| AtNode(name, error))
    }

    /// The gap at an entry of `Discretization::secondary` (m). Local.
    fn gap(&self, secondary: u32) -> f64 {
        self.gaps[self.all.secondary[secondary as usize].node as usize]
    }

    /// The width at an entry of `Discretization::secondary` (m). Local.
    fn at(&self, secondary: u32) -> Result<f64, AtNode> {
        let (rows, nodes) = (&self.all.secondary[secondary as usize], &self.all.nodes);
        let node = rows.node as usize;
        let aperture = self.aperture(rows.interface, nodes.names[node], nodes.points[node])?;
        Ok(aperture + self.gap(secondary))
    }

    /// The widths at the nodes of a facet, whose names and places are given (m). Local.
    fn of_facet(
        &self,
        interface: usize,
        nodes: impl Iterator<Item = (u64, [f64; 3])>,
        openings: &[Opening],
    ) -> Result<Vec<f64>, AtNode> {
        let apertures = nodes.map(|(name, point)| self.aperture(interface, name, point));
        let mut widths = apertures.collect::<Result<Vec<f64>, AtNode>>()?;
        for Opening { node, secondary, part } in openings {
            widths[*node as usize] += part * self.gap(*secondary);
        }
        Ok(widths)
    }
}

/// The films of this rank's secondary nodes and facets. Collective.
///
/// # Errors
/// At the first node where a formula gives no aperture.
pub(in crate::solve) fn films(
    case: &Case,
    of: Displacements<'_>,
    nodes: &Nodes,
) -> Result<Films, AtNode> {
    let Displacements { mesh, sides, .. } = of;
    let before = Widths::new(case, of);
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
            let openings = openings(of, side, *facet, &names);
            let places = nodes.iter().map(|node| mesh.nodes.points[*node as usize]);
            let places = names.iter().copied().zip(places);
            let widths = before.of_facet(side.interface, places, &openings)?;
            films.facets.push(FilmFacet {
                prototype: prototype as u32,
                openings,
                widths,
                corners: corners.iter().map(|name| local(*name)).collect(),
            });
        }
    }
    for (secondary, corners) in film_nodes(case, of) {
        let corners = corners.into_iter().map(|(name, part)| (local(name), part)).collect();
        films.nodes.push(FilmNode { secondary, width: before.at(secondary)?, corners });
    }
    Ok(films)
}

/// The edges of a facet with these nodes (m) whose first edges run along the first axes and whose
/// normal lies along the last one, if it belongs to a box.
fn edges(mesh: &LocalMesh, facet: Facet, nodes: &[u32]) -> Option<[f64; 2]> {
    let size = mesh.prototype(facet.cell as usize).geometry.size()?;
    let (axes, points) = (mesh.facts.axes, by_component(mesh, nodes));
    let normal = axes.len() - 1;
    let is_flat = points.iter().all(|x| x[normal] == points[0][normal]);
    let runs_along = (1..axes.len()).all(|c| points[0][c] == points[1][c])
        && (normal < 2 || points[1][1] < points[2][1]);
    (is_flat && runs_along && points[0][0] < points[1][0]).then(|| [size[axes[0]], size[axes[1]]])
}

/// Positions of nodes by displacement component (m).
fn by_component(mesh: &LocalMesh, nodes: &[u32]) -> Vec<[f64; 3]> {
    let axes = mesh.facts.axes;
    let along = |x: [f64; 3]| std::array::from_fn(|c| axes.get(c).map_or(0.0, |axis| x[*axis]));
    nodes.iter().map(|node| along(mesh.nodes.points[*node as usize])).collect()
}
