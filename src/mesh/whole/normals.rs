//! Normals of facets, and of nodes from those of their facets.

use super::facet::WholeFacet;
use super::types::WholeMesh;
use super::view::View;
use crate::element::{MAX_NODES, QuadraturePoint, Shape, stiffness_rule};

/// Normals closer than this are one: the cosine of 30 degrees.
const ONE: f64 = 0.866_025_403_784_438_6;

/// What a sum of normals may lose by cancelling before it says nothing.
const CANCELLED: f64 = 1e-6;

/// A node with a normal of one of its facets, of the length of the facet's area.
type Part = (u32, [f64; 3]);

/// Rules by which facets are measured.
pub struct Measure {
    rules: Vec<(Shape, Vec<QuadraturePoint>)>,
}

impl Measure {
    pub fn new() -> Self {
        let facets = Shape::ALL.iter().filter(|shape| shape.dim() < 3);
        Self { rules: facets.map(|shape| (*shape, stiffness_rule(*shape))).collect() }
    }

    /// The area of a facet (m2; in 2D its length).
    pub fn area(&self, view: View<'_>, facet: WholeFacet) -> f64 {
        let (points, shape) = view.facet_points(facet);
        let rule = self.rules.iter().find(|(of, _)| *of == shape);
        let points = |p: &QuadraturePoint| p.weight * length(normal(&points, shape, p.xi));
        rule.map_or(0.0, |(_, rule)| rule.iter().map(points).sum())
    }

    /// Adds, for each node of a facet, the outward normal there times the area and `sign`.
    pub fn add(&self, view: View<'_>, facet: WholeFacet, sign: f64, parts: &mut Vec<Part>) {
        let area = self.area(view, facet);
        let (points, shape) = view.facet_points(facet);
        for (node, xi) in view.facet_nodes(facet).zip(shape.node_points()) {
            let unit = unit(normal(&points, shape, *xi)).unwrap_or_default();
            parts.push((node, unit.map(|x| x * area * sign)));
        }
    }
}

/// The outward normal of a facet at a point of its reference cell, of the length of the area that a
/// unit of the reference cell has.
fn normal(points: &[[f64; 3]; MAX_NODES], shape: Shape, xi: [f64; 3]) -> [f64; 3] {
    let mut gradients = [[0.0; 3]; MAX_NODES];
    shape.gradients(xi, &mut gradients);
    let along = |d: usize| -> [f64; 3] {
        let of = |i: usize| (0..shape.nodes()).map(|a| points[a][i] * gradients[a][d]).sum();
        [0, 1, 2].map(of)
    };
    let a = along(0);
    if shape.dim() == 1 {
        return [a[1], -a[0], 0.0];
    }
    let b = along(1);
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The unit normal of each node, by rising node, weighted by the areas of the facets.
pub fn averaged(mut parts: Vec<Part>) -> Vec<Part> {
    // Stable, so that sums keep the order of the facets.
    parts.sort_by_key(|(node, _)| *node);
    let mean = |parts: &[Part]| {
        let sum = sum(parts.iter().map(|(_, normal)| *normal));
        let areas: f64 = parts.iter().map(|(_, normal)| length(*normal)).sum();
        let is_lost = length(sum) <= CANCELLED * areas;
        let mean = if is_lost { parts[0].1 } else { sum };
        (parts[0].0, unit(mean).unwrap_or([0.0, 0.0, 1.0]))
    };
    parts.chunk_by(|a, b| a.0 == b.0).map(mean).collect()
}

/// For each node of the facets of a surface, by rising node, the distinct unit normals of its
/// facets, out of the mesh. Facets whose normals at the node differ by less than 30 degrees, also
/// over others between them, count as one, with the average weighted by area; a node at a kink has
/// one normal for each side, in the order of the facets.
pub fn surface_normals(mesh: &WholeMesh, surface: usize) -> Vec<(u32, Vec<[f64; 3]>)> {
    let measure = Measure::new();
    let mut parts = Vec::new();
    for facet in &mesh.surfaces[surface].facets {
        measure.add(mesh.view(), *facet, 1.0, &mut parts);
    }
    parts.sort_by_key(|(node, _)| *node);
    let of_node = |parts: &[Part]| (parts[0].0, directions(parts));
    parts.chunk_by(|a, b| a.0 == b.0).map(of_node).collect()
}

/// The distinct directions of some normals.
fn directions(parts: &[Part]) -> Vec<[f64; 3]> {
    let units: Vec<Option<[f64; 3]>> = parts.iter().map(|(_, normal)| unit(*normal)).collect();
    let mut class = vec![usize::MAX; parts.len()];
    let mut found = Vec::new();
    for first in (0..parts.len()).filter(|i| units[*i].is_some()) {
        if class[first] != usize::MAX {
            continue;
        }
        class[first] = found.len();
        let mut reached = vec![first];
        while let Some(one) = reached.pop() {
            for other in 0..parts.len() {
                let (Some(a), Some(b)) = (units[one], units[other]) else { continue };
                if class[other] == usize::MAX && dot(a, b) > ONE {
                    class[other] = found.len();
                    reached.push(other);
                }
            }
        }
        let members = (0..parts.len()).filter(|i| class[*i] == found.len());
        let mean = sum(members.map(|i| parts[i].1));
        found.push(unit(mean).or(units[first]).unwrap_or_default());
    }
    found
}

fn sum(vectors: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    vectors.fold([0.0; 3], |sum, vector| std::array::from_fn(|i| sum[i] + vector[i]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(vector: [f64; 3]) -> f64 {
    unit(vector).map_or(0.0, |unit| dot(unit, vector))
}

/// Squares of the components alone would be lost for facets far smaller than any mesh has.
fn unit(vector: [f64; 3]) -> Option<[f64; 3]> {
    let most = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let scaled = vector.map(|x| x / most);
    let length = dot(scaled, scaled).sqrt();
    // Zero stays zero, so that a plane's normal has none of the wrong sign.
    (most > 0.0 && length.is_finite()).then(|| scaled.map(|x| x / length + 0.0))
}

/// The area of some facets together (m2; in 2D their length).
pub fn area(mesh: &WholeMesh, facets: &[WholeFacet]) -> f64 {
    let measure = Measure::new();
    facets.iter().map(|facet| measure.area(mesh.view(), *facet)).sum()
}
