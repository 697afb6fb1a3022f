//! Bodies that touch where their meshes do not match.

use super::bodies::bodies_of;
use super::box_tree::{BoxTree, Extent};
use super::cells::{Cells, NONE};
use super::facet::WholeFacet;
use super::facets::slot;
use super::plan::Plan;
use super::view::View;
use super::words::{count, place, wrong};
use crate::error::Result;

/// A node lies on a facet if it is closer than this part of the facet's diagonal.
const NEAR: f64 = 1e-6;
/// How far inside the sides of the facet it has to be, as a barycentric coordinate.
const INSIDE: f64 = 1e-3;
/// How far beyond the diagonal that halves a quadrilateral it may be.
const BEYOND: f64 = -1e-9;

/// Refuses nodes that lie on facets of other bodies, unless both are on interfaces `between` two
/// groups, or the facet only borders on one: bodies that are flush at the side of an interface that
/// bends come into each other there by what their facets differ. Nodes at the place of other nodes
/// are not looked for.
///
/// # Errors
/// `Input` with their number and the first place.
pub fn check(cells: &Cells, mates: &[u32], plans: &[Plan]) -> Result<()> {
    let (bodies, body_count) = bodies_of(cells.view());
    if body_count < 2 {
        return Ok(());
    }
    let between = plans.iter().filter(|plan| !plan.is_cut);
    let known = between.flat_map(|p| p.lips.iter().flatten()).copied().collect();
    check_bodies(cells, mates, known, &bodies)
}

/// As [`check`], of cells of which the bodies are known; `known` are facets of interfaces `between`
/// two groups.
///
/// # Errors
/// As [`check`].
pub fn check_bodies(
    cells: &Cells,
    mates: &[u32],
    mut known: Vec<WholeFacet>,
    bodies: &[u32],
) -> Result<()> {
    let view = cells.view();
    let all = (0..cells.shapes.len()).flat_map(|cell| view.facets(cell));
    let facets: Vec<WholeFacet> = all.filter(|facet| mates[slot(*facet)] == NONE).collect();
    let mut body_of = vec![NONE; cells.points.len()];
    for facet in &facets {
        let body = bodies[facet.cell as usize];
        view.facet_nodes(*facet).for_each(|node| body_of[node as usize] = body);
    }
    known.sort_unstable();
    let mut is_known = vec![false; cells.points.len()];
    for facet in &known {
        view.facet_nodes(*facet).for_each(|node| is_known[node as usize] = true);
    }
    let tree = BoxTree::new(facets.iter().map(|facet| extent(cells, *facet)).collect());
    let mut found = Vec::new();
    for (node, body) in (0..).zip(&body_of).filter(|(_, body)| **body != NONE) {
        let point = cells.points[node as usize];
        let met = tree.meeting(&Extent::of(std::iter::once(point)));
        let touched = met.iter().map(|number| facets[*number as usize]).find(|facet| {
            let is_told = is_known[node as usize]
                && (known.binary_search(facet).is_ok() || borders(view, *facet, &is_known));
            bodies[facet.cell as usize] != *body && !is_told && lies_on(cells, *facet, point)
        });
        found.extend(touched.map(|facet| (node, facet)));
    }
    let Some((node, facet)) = found.first() else { return Ok(()) };
    Err(wrong(format!(
        "{} on a facet of another body and belong to no interface, the first at {} on {}; name \
         both sides in an interface `between`, or mesh the bodies together, so that they share \
         their nodes (Coherence in Gmsh, Partition in SALOME)",
        count(found.len(), "node") + if found.len() == 1 { " lies" } else { " lie" },
        place(cells.points[*node as usize]),
        cells.describe_facet(*facet)
    )))
}

/// Whether an edge of a facet (in the plane an end) lies on an interface `between` two groups.
fn borders(view: View<'_>, facet: WholeFacet, is_known: &[bool]) -> bool {
    let count = view.corner_count(facet);
    let corners = view.facet_corners(facet);
    let on = corners[..count].iter().filter(|node| is_known[**node as usize]).count();
    on >= if count == 2 { 1 } else { 2 }
}

/// The box of a facet, with what is near it.
fn extent(cells: &Cells, facet: WholeFacet) -> Extent {
    let view = cells.view();
    let extent = Extent::of(view.facet_nodes(facet).map(|node| cells.points[node as usize]));
    extent.grown(NEAR * extent.diagonal())
}

/// Whether a point lies on a facet, taken as plane between its corners, and off its sides.
fn lies_on(cells: &Cells, facet: WholeFacet, point: [f64; 3]) -> bool {
    let view = cells.view();
    let corners = view.facet_corners(facet).map(|node| cells.points.get(node as usize).copied());
    let near = NEAR * extent(cells, facet).diagonal();
    match corners {
        [Some(a), Some(b), None, None] => {
            let along = minus(b, a);
            let part = dot(minus(point, a), along) / dot(along, along);
            let foot = [0, 1, 2].map(|i| a[i] + part * along[i]);
            (INSIDE..=1.0 - INSIDE).contains(&part) && distance(foot, point) <= near
        }
        [Some(a), Some(b), Some(c), None] => in_triangle([a, b, c], [INSIDE; 3], point, near),
        [Some(a), Some(b), Some(c), Some(d)] => {
            in_triangle([a, b, c], [INSIDE, BEYOND, INSIDE], point, near)
                || in_triangle([a, c, d], [INSIDE, INSIDE, BEYOND], point, near)
        }
        _ => false,
    }
}

/// Whether a point lies on a triangle, with barycentric coordinates of at least `least`.
fn in_triangle([a, b, c]: [[f64; 3]; 3], least: [f64; 3], point: [f64; 3], near: f64) -> bool {
    let (u, v, w) = (minus(b, a), minus(c, a), minus(point, a));
    // Least squares for w = s u + t v.
    let (uu, uv, vv, uw, vw) = (dot(u, u), dot(u, v), dot(v, v), dot(u, w), dot(v, w));
    let determinant = uu * vv - uv * uv;
    let (s, t) = ((vv * uw - uv * vw) / determinant, (uu * vw - uv * uw) / determinant);
    let foot = [0, 1, 2].map(|i| a[i] + s * u[i] + t * v[i]);
    let parts = [1.0 - s - t, s, t];
    parts.iter().zip(least).all(|(part, least)| *part >= least) && distance(foot, point) <= near
}

fn minus(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| p[i] - q[i])
}

fn dot(p: [f64; 3], q: [f64; 3]) -> f64 {
    p.iter().zip(q).map(|(p, q)| p * q).sum()
}

fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    dot(minus(p, q), minus(p, q)).sqrt()
}
