//! The overlaps of a secondary facet with the primary facets across from it.

use super::facet::SpaceFacet;
use super::pieces::Piece;
use super::plane::{Plane, Shadow};
use super::vector::{difference, dot, norm};
use crate::element::{QuadraturePoint, Shape, gauss, quadrature_on_triangle};
use crate::interface::mortar::polygon::{clip, signed_area};
use crate::interface::mortar::rows::Segment;
use crate::interface::mortar::segments::SegmentPoint;

/// What lies this close to a line, relative to the size of the secondary piece, lies on it. The
/// neighbours beyond the line decide alike, so nothing is lost or counted twice.
const ON_LINE: f64 = 1e-10;

/// Overlaps smaller than this part of the secondary piece are rounding.
const NO_AREA: f64 = 1e-14;

/// Facets face each other when the cosine of their normals is below this.
const FACING: f64 = -0.3;

/// A facet is hidden by another that covers half of its overlap and is nearer by this part of the
/// size of the secondary facet.
const HIDDEN: f64 = 0.05;

/// The overlap of a piece of the secondary facet with a piece of a primary one.
struct Overlap<'a> {
    primary: &'a SpaceFacet,
    piece: Piece,
    /// The common polygon in the plane of the secondary piece; of lines the ends of the common
    /// interval.
    polygon: Vec<[f64; 2]>,
    /// Distance of the two pieces in its middle, along the normal, m.
    distance: f64,
}

/// The parts of the primary facets that lie on the secondary one, as integration points on both
/// whose weights are true areas of the secondary facet. None if the secondary facet, or a primary
/// one that faces it, is turned in so that its points cannot be located.
///
/// Each piece of the secondary facet looks along its own normal. Primary facets that do not look
/// against it or lie behind others are passed over, and those that are farther away than its size
/// and their own, unless they count at `any_distance`.
pub fn overlaps<'a>(
    secondary: &SpaceFacet,
    primaries: &[&'a SpaceFacet],
    any_distance: bool,
) -> Option<Vec<Segment<'a>>> {
    let sides: Vec<(&SpaceFacet, Vec<Piece>)> =
        primaries.iter().filter_map(|p| Some((*p, Piece::of(p)?))).collect();
    let mut segments: Vec<Segment<'a>> = Vec::new();
    for piece in Piece::of(secondary)? {
        let plane = piece.plane()?;
        let shadow = plane.shadow(piece.shape(), piece.corners());
        let view = View { secondary, piece, plane, shadow, any_distance };
        let mut seen: Vec<Overlap<'a>> = Vec::new();
        for (primary, pieces) in &sides {
            seen.extend(pieces.iter().filter_map(|piece| view.overlap(primary, piece)));
        }
        for overlap in visible(seen, HIDDEN * secondary.size()) {
            let points = view.points(&overlap)?;
            match segments.last_mut().filter(|s| std::ptr::eq(s.nodes, overlap.primary.nodes())) {
                Some(segment) => segment.points.extend(points),
                None => segments.push(Segment {
                    shape: overlap.primary.shape(),
                    nodes: overlap.primary.nodes(),
                    points,
                }),
            }
        }
    }
    Some(segments)
}

/// A piece of the secondary facet and what is seen from it along its normal.
struct View<'s> {
    secondary: &'s SpaceFacet,
    piece: Piece,
    plane: Plane,
    /// The piece in its plane.
    shadow: Shadow,
    /// Whether facets count however far away they are.
    any_distance: bool,
}

impl View<'_> {
    /// The overlap with a piece of a primary facet, if it faces this one.
    fn overlap<'a>(&self, primary: &'a SpaceFacet, other: &Piece) -> Option<Overlap<'a>> {
        let cosine = dot(other.normal(), self.plane.normal());
        if cosine > FACING {
            return None;
        }
        let there = self.plane.shadow(other.shape(), other.corners());
        let polygon = common(&self.shadow, &there)?;
        let middle = middle(&polygon);
        let above = difference(other.corners()[0], self.plane.point(middle));
        let distance = dot(above, other.normal()) / cosine;
        let reach = self.secondary.size().max(primary.size());
        let overlap = Overlap { primary, piece: *other, polygon, distance: distance.abs() };
        (self.any_distance || overlap.distance <= reach).then_some(overlap)
    }

    /// The integration points of an overlap.
    fn points(&self, overlap: &Overlap) -> Option<Vec<SegmentPoint>> {
        let curved = !(self.secondary.is_straight() && overlap.primary.is_straight());
        let shapes = [self.secondary.shape(), overlap.primary.shape()];
        let far = Far {
            piece: overlap.piece,
            near: self.plane.shadow(overlap.piece.shape(), overlap.piece.corners()),
            whole: self.plane.shadow_of(overlap.primary),
        };
        let degree = match curved {
            true => ON_CURVED,
            false => degree_for(shapes) + degree_of_skew([&self.shadow, &far.near]),
        };
        let rule = rule_on(&overlap.polygon, degree, curved);
        rule.iter().map(|p| self.point(p, &far)).collect()
    }

    /// The point of the secondary facet that belongs to one of its piece, the point of the primary
    /// one across from it, and the true area that belongs to that of the plane.
    fn point(&self, PlanePoint { x, area }: &PlanePoint, far: &Far) -> Option<SegmentPoint> {
        let s = self.shadow.locate(*x, self.piece.shape().centroid())?;
        let xi = self.piece.on_facet(s);
        let stretch = self.piece.reference_measure() / self.shadow.determinant(s).abs();
        let weight = area * stretch * norm(self.secondary.normal(xi));
        let eta = far.locate(self.plane.foot(self.secondary.point(xi)))?;
        Some(SegmentPoint { xi, eta, weight })
    }
}

/// A primary facet seen in the plane of a secondary piece.
struct Far {
    piece: Piece,
    near: Shadow,
    whole: Shadow,
}

/// Points of curved facets are off their flat pieces by less than this, in reference coordinates.
const OFF_PIECE: f64 = 0.5;

impl Far {
    /// Reference coordinates of a point of the plane: those on the flat piece are near them, and
    /// stand in where the curved facet, continued beyond its edge, is not found.
    fn locate(&self, x: [f64; 2]) -> Option<[f64; 3]> {
        let start = self.near.locate(x, self.piece.shape().centroid())?;
        let start = self.piece.on_facet(start);
        let is_near = |eta: &[f64; 3]| (0..2).all(|d| (eta[d] - start[d]).abs() < OFF_PIECE);
        Some(self.whole.locate(x, start).filter(is_near).unwrap_or(start))
    }
}

/// Those that are not behind others. Without this the layers of a stack of thin bodies would see
/// through each other.
fn visible(mut seen: Vec<Overlap>, hidden: f64) -> Vec<Overlap> {
    let is_visible = |overlap: &Overlap| {
        let nearer = seen.iter().filter(|o| o.distance < overlap.distance - hidden);
        let covered: f64 = nearer.map(|o| shared(&o.polygon, &overlap.polygon)).sum();
        covered <= 0.5 * extent(&overlap.polygon)
    };
    let keep: Vec<bool> = seen.iter().map(is_visible).collect();
    let mut keep = keep.into_iter();
    seen.retain(|_| keep.next().unwrap_or_default());
    seen
}

/// The common polygon (of lines: interval) of two pieces in a plane, if it has an area.
fn common(secondary: &Shadow, primary: &Shadow) -> Option<Vec<[f64; 2]>> {
    let (here, there) = (secondary.points(), primary.points());
    let polygon = if here.len() == 2 {
        interval(here, there)
    } else {
        cut(here, there, ON_LINE * size(here))
    };
    (extent(&polygon) > NO_AREA * extent(here)).then_some(polygon)
}

/// The larger side of the bounding box.
fn size(points: &[[f64; 2]]) -> f64 {
    let side = |d: usize| {
        let low = points.iter().map(|x| x[d]).fold(f64::INFINITY, f64::min);
        points.iter().map(|x| x[d]).fold(f64::NEG_INFINITY, f64::max) - low
    };
    side(0).max(side(1))
}

/// The common interval of two lines on the first axis; the ends of `here` are kept to the bit.
fn interval(here: &[[f64; 2]], there: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let ends = |x: &[[f64; 2]]| [x[0][0].min(x[1][0]), x[0][0].max(x[1][0])];
    let ([a, b], [c, d]) = (ends(here), ends(there));
    let near = ON_LINE * (b - a);
    let low = if c <= a + near { a } else { c };
    let high = if d >= b - near { b } else { d };
    if high > low { vec![[low, 0.0], [high, 0.0]] } else { Vec::new() }
}

/// Area of a polygon, length of an interval.
fn extent(polygon: &[[f64; 2]]) -> f64 {
    match polygon {
        [a, b] => (b[0] - a[0]).abs(),
        _ => signed_area(polygon).abs(),
    }
}

/// What two convex polygons, or intervals, have in common.
fn shared(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    if a.len() == 2 {
        return extent(&interval(a, b));
    }
    extent(&cut(a, b, 0.0))
}

/// What two convex polygons have in common; nothing where they only touch, of which two points may
/// be left, which would be taken for an interval.
fn cut(here: &[[f64; 2]], there: &[[f64; 2]], near: f64) -> Vec<[f64; 2]> {
    let polygon = clip(here, there, signed_area(there).signum(), near);
    if polygon.len() < 3 { Vec::new() } else { polygon }
}

/// Mean of the corners.
fn middle(polygon: &[[f64; 2]]) -> [f64; 2] {
    let count = polygon.len() as f64;
    [0, 1].map(|d| polygon.iter().map(|x| x[d]).sum::<f64>() / count)
}

/// A point of integration in the plane.
struct PlanePoint {
    x: [f64; 2],
    /// m2; of an interval a length, m.
    area: f64,
}

/// Points of integration on a polygon, for polynomials of a degree, or on an interval.
///
/// Polygons with more than three corners are cut into triangles about their middle, so that it does
/// not matter with which corner they begin.
fn rule_on(polygon: &[[f64; 2]], degree: usize, curved: bool) -> Vec<PlanePoint> {
    if let [a, b] = polygon {
        let points = gauss(Shape::Line2, if curved { 5 } else { 3 });
        let half = 0.5 * (b[0] - a[0]);
        let at = |p: &QuadraturePoint| PlanePoint {
            x: [a[0] + (1.0 + p.xi[0]) * half, 0.0],
            area: p.weight * half,
        };
        return points.iter().map(at).collect();
    }
    let centre = middle(polygon);
    let next = |i: usize| polygon[(i + 1) % polygon.len()];
    let triangles: Vec<[[f64; 2]; 3]> = match polygon {
        [a, b, c] => vec![[*a, *b, *c]],
        _ => polygon.iter().enumerate().map(|(i, x)| [centre, *x, next(i)]).collect(),
    };
    let rule = quadrature_on_triangle(degree);
    let at = |t: &[[f64; 2]; 3], p: &QuadraturePoint| {
        let [u, v, _] = p.xi;
        let x = [0, 1].map(|d| t[0][d] + u * (t[1][d] - t[0][d]) + v * (t[2][d] - t[0][d]));
        PlanePoint { x, area: p.weight / Shape::Tri3.volume() * extent(t) }
    };
    triangles.iter().flat_map(|t| rule.iter().map(|p| at(t, p)).collect::<Vec<_>>()).collect()
}

/// The degree of the products of functions of the secondary side with those of either side, in all
/// coordinates together.
fn degree_for(shapes: [Shape; 2]) -> usize {
    let degree = |shape: Shape| match shape.corners() {
        Shape::Quad4 => 2 * shape.order(),
        _ => shape.order(),
    };
    let [here, there] = shapes.map(degree);
    here + here.max(there)
}

/// How much higher the degree has to be for quadrilaterals that are no parallelograms. Their
/// functions are series in the place, each term of one more degree and as much smaller as the skew
/// says: all those above rounding are taken, up to a limit.
fn degree_of_skew(shadows: [&Shadow; 2]) -> usize {
    let skew = shadows.map(skew).into_iter().fold(0.0, f64::max);
    if skew <= NO_SKEW {
        return 0;
    }
    let terms = (NO_SKEW.ln() / skew.min(0.5).ln()).ceil();
    (terms as usize).min(MOST_OF_SKEW)
}

/// What the two halves of a quadrilateral differ by, relative to their size; 0 of others.
fn skew(shadow: &Shadow) -> f64 {
    let [a, b, c, d] = shadow.points() else { return 0.0 };
    let part = |signs: [f64; 4]| -> [f64; 2] {
        let sum = |i: usize| signs[0] * a[i] + signs[1] * b[i] + signs[2] * c[i] + signs[3] * d[i];
        [sum(0), sum(1)]
    };
    let (u, v) = (part([-1.0, 1.0, 1.0, -1.0]), part([-1.0, -1.0, 1.0, 1.0]));
    let uneven = part([1.0, -1.0, 1.0, -1.0]);
    let across = |x: [f64; 2], y: [f64; 2]| (x[0] * y[1] - x[1] * y[0]).abs();
    (across(uneven, v) + across(u, uneven)) / across(u, v)
}

/// Quadrilaterals with less skew are parallelograms.
const NO_SKEW: f64 = 1e-13;

/// At most so much for the skew: 256 points on a triangle of second order.
const MOST_OF_SKEW: usize = 23;

/// The degree on flat pieces of curved facets, on which nothing is a polynomial: seven points.
const ON_CURVED: usize = 5;
