//! Small signs at points of surfaces: supports, imposed displacements, forces.

use super::boundary::{Mark, spread};
use super::cover::Cover;
use super::drawing::{Drawing, Paint, Place, Stroke};
use super::vector::{Vector, dot, minus};
use super::view::Camera;

/// Sizes in pixels.
const SUPPORT: f64 = 9.0;
const ARROW: f64 = 34.0;
const HEAD: f64 = 8.0;

/// Around signs, so that they are seen on bodies too.
const AROUND: Option<Stroke> = Some(Stroke { paint: Paint::Edge, width: 0.5 });

/// Points of a surface that have signs: supports, arrows.
const MOST_SUPPORTS: usize = 9;
const MOST_ARROWS: usize = 4;
const MOST_ARROWS_IN_A_PLANE: usize = 3;
/// Signs of one kind that are nearer to each other would be a smear (pixels).
const APART: f64 = 13.0;

/// Draws the signs of a surface.
pub(crate) fn signs(drawing: &mut Drawing, camera: &Camera, cover: &Cover, mark: &Mark) {
    for axis in 0..3 {
        supports(drawing, camera, cover, (mark, axis));
    }
    let ways = mark.moved.iter().map(|way| (*way, Paint::Moved));
    let ways = ways.chain(mark.pushed.map(|way| (way, Paint::Pushed)));
    for (way, paint) in ways {
        let most = if cover.is_plane() { MOST_ARROWS_IN_A_PLANE } else { MOST_ARROWS };
        for point in apart(spread(&mark.points, most), camera) {
            let sign = Arrow { at: At { point, way }, paint, outward: mark.outward };
            arrow(drawing, camera, cover, sign);
        }
    }
}

/// The supports that hold a component. A surface that is held in its normal direction stands on
/// them; along the surface they stand at its rim, unless it is held altogether.
fn supports(drawing: &mut Drawing, camera: &Camera, cover: &Cover, (mark, axis): (&Mark, usize)) {
    if !mark.held[axis] {
        return;
    }
    let mut way = [0.0; 3];
    way[axis] = 1.0;
    let along = dot(way, mark.outward);
    let is_normal = along.abs() > 0.5;
    let stands = (0..3).any(|c| mark.held[c] && mark.outward[c].abs() > 0.5);
    if stands && !is_normal && mark.holds_all {
        return;
    }
    let centre = super::boundary::middle(&mark.points);
    let points = apart(spread(&mark.points, MOST_SUPPORTS), camera);
    let off = |point: &Vector| minus(*point, centre)[axis];
    let rim = points.iter().map(|p| off(p).abs()).fold(0.0, f64::max);
    for point in points {
        if !is_normal && off(&point).abs() < 0.6 * rim {
            continue;
        }
        let side = if is_normal { along } else { off(&point) };
        way[axis] = if side > 0.0 { 1.0 } else { -1.0 };
        support(drawing, camera, cover, At { point, way });
    }
}

/// The points that are not too near to one before them in the drawing.
fn apart(points: Vec<Vector>, camera: &Camera) -> Vec<Vector> {
    let mut kept: Vec<Vector> = Vec::new();
    for point in points {
        let [x, y] = camera.place(point);
        let near = |other: &Vector| {
            let [a, b] = camera.place(*other);
            (a - x).hypot(b - y) < APART
        };
        if !kept.iter().any(near) {
            kept.push(point);
        }
    }
    kept
}

#[derive(Clone, Copy)]
struct At {
    point: Vector,
    way: Vector,
}

/// A triangle whose tip is at the point and which stands where `way` leads.
fn support(drawing: &mut Drawing, camera: &Camera, cover: &Cover, at: At) {
    let tip = camera.place(at.point);
    let way = camera.way(at.way);
    let size = way[0].hypot(way[1]);
    // Seen from its end there is nothing to be seen.
    if size < 0.2 {
        return;
    }
    let way = way.map(|c| c / size);
    let foot = [tip[0] + SUPPORT * way[0], tip[1] + SUPPORT * way[1]];
    if cover.hides(foot, camera.view.nearness(at.point)) {
        return;
    }
    let half = 0.55 * SUPPORT;
    let sides = [1.0, -1.0].map(|s| [foot[0] - s * half * way[1], foot[1] + s * half * way[0]]);
    drawing.area(vec![tip, sides[0], sides[1]], Paint::Held, AROUND);
    let beyond = 2.5;
    let wide = 1.35;
    let base = [1.0, -1.0].map(|s| {
        [
            foot[0] + beyond * way[0] - s * wide * half * way[1],
            foot[1] + beyond * way[1] + s * wide * half * way[0],
        ]
    });
    drawing.line(base.to_vec(), Stroke::new(Paint::Held, 1.4));
}

struct Arrow {
    at: At,
    paint: Paint,
    outward: Vector,
}

/// An arrow that leads away from the surface, or onto it, and stays outside of the body.
fn arrow(drawing: &mut Drawing, camera: &Camera, cover: &Cover, arrow: Arrow) {
    let Arrow { at, paint, outward } = arrow;
    let way = camera.way(at.way);
    let size = way[0].hypot(way[1]);
    if size < 0.2 {
        return;
    }
    let way = way.map(|c| c / size);
    let here = camera.place(at.point);
    let step = |from: Place, length: f64| [from[0] + length * way[0], from[1] + length * way[1]];
    let onto = dot(at.way, outward) < -1e-3;
    let (tail, tip) = if onto { (step(here, -ARROW), here) } else { (here, step(here, ARROW)) };
    let far = if onto { tail } else { tip };
    if cover.hides(far, camera.view.nearness(at.point)) {
        return;
    }
    drawing.line(vec![tail, step(tip, -0.7 * HEAD)], Stroke::new(paint, 1.8));
    head(drawing, tip, way, paint);
}

/// The head of an arrow.
pub(super) fn head(drawing: &mut Drawing, tip: Place, way: Place, paint: Paint) {
    let back = [tip[0] - HEAD * way[0], tip[1] - HEAD * way[1]];
    let half = 0.42 * HEAD;
    let sides = [1.0, -1.0].map(|s| [back[0] - s * half * way[1], back[1] + s * half * way[0]]);
    drawing.area(vec![tip, sides[0], sides[1]], paint, AROUND);
}
