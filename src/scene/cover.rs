//! What of a scene is hidden behind something else.

use super::drawing::Place;
use super::skin::Skin;
use super::vector::{Vector, extent, unit};
use super::view::Camera;

/// The edge of a square of the drawing for which it is known what lies there (pixels).
const SQUARE: f64 = 12.0;

/// The length of the pieces of a line that are seen or not (pixels).
const PIECE: f64 = 4.0;

/// What hides points behind it.
pub(crate) struct Cover {
    facets: Vec<Plate>,
    /// The first square and how many there are to the right and down.
    first: [i64; 2],
    counts: [i64; 2],
    /// The facets in each square, row by row.
    squares: Vec<Vec<u32>>,
    /// What is nearer by less than this hides nothing (m).
    slack: f64,
}

/// A facet that is turned to the eye.
struct Plate {
    ring: Vec<Place>,
    /// How near it is to the eye at its first place (m), and how that grows to the right and down
    /// (m per pixel).
    near: f64,
    slope: Place,
}

impl Plate {
    /// How near it is to the eye at a place (m).
    fn nearness(&self, [x, y]: Place) -> f64 {
        let [x0, y0] = self.ring[0];
        self.near + self.slope[0] * (x - x0) + self.slope[1] * (y - y0)
    }

    /// The squares that it touches, from and to.
    fn squares(&self) -> [[i64; 2]; 2] {
        let of = |pick: fn(f64, f64) -> f64, start: f64| {
            [0, 1].map(|c| square(self.ring.iter().map(|place| place[c]).fold(start, pick)))
        };
        [of(f64::min, f64::INFINITY), of(f64::max, f64::NEG_INFINITY)]
    }
}

fn square(pixels: f64) -> i64 {
    (pixels / SQUARE).floor() as i64
}

impl Cover {
    /// The body itself, its points where they are given; nothing where it is plane.
    pub fn new(skin: &Skin, points: &[Vector], camera: &Camera) -> Self {
        let mut facets = Vec::new();
        for facet in skin.facets.iter().filter(|_| skin.dim == 3) {
            let normal = unit(skin.area(facet, points));
            let turned = camera.view.turned(normal);
            if turned > 1e-3 {
                let first = points[skin.of_facet(facet)[0] as usize];
                let ring = skin.ring(facet).map(|i| camera.place(points[i as usize]));
                let [right, down] = camera.way(normal);
                let slope = [right, down].map(|part| -part / (turned * camera.scale));
                let near = camera.view.nearness(first);
                facets.push(Plate { ring: ring.collect(), near, slope });
            }
        }
        let slack = 2e-3 * extent(points.iter().copied());
        Self::sorted(facets, slack)
    }

    fn sorted(facets: Vec<Plate>, slack: f64) -> Self {
        let (mut low, mut high) = ([i64::MAX; 2], [i64::MIN; 2]);
        for [from, to] in facets.iter().map(Plate::squares) {
            for c in 0..2 {
                (low[c], high[c]) = (low[c].min(from[c]), high[c].max(to[c]));
            }
        }
        let counts = if facets.is_empty() { [0; 2] } else { [0, 1].map(|c| high[c] - low[c] + 1) };
        let mut squares = vec![Vec::new(); (counts[0] * counts[1]) as usize];
        for (index, plate) in facets.iter().enumerate() {
            let [from, to] = plate.squares();
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let place = (y - low[1]) * counts[0] + x - low[0];
                    squares[place as usize].push(index as u32);
                }
            }
        }
        Self { facets, first: low, counts, squares, slack }
    }

    /// Whether nothing can be hidden.
    pub fn is_plane(&self) -> bool {
        self.facets.is_empty()
    }

    /// Whether something of the body is before a place that is so near.
    pub fn hides(&self, place: Place, nearness: f64) -> bool {
        let [x, y] = [0, 1].map(|c| square(place[c]));
        let at = [0, 1].map(|c| [x, y][c].saturating_sub(self.first[c]));
        if (0..2).any(|c| at[c] < 0 || at[c] >= self.counts[c]) {
            return false;
        }
        let here = &self.squares[(at[1] * self.counts[0] + at[0]) as usize];
        here.iter().map(|index| &self.facets[*index as usize]).any(|plate| {
            is_inside(&plate.ring, place) && plate.nearness(place) > nearness + self.slack
        })
    }

    /// The parts of a line between two points that are seen.
    pub fn seen(&self, ends: [Vector; 2], camera: &Camera) -> Vec<[Place; 2]> {
        let [from, to] = ends.map(|end| camera.place(end));
        if self.facets.is_empty() {
            return vec![[from, to]];
        }
        let near = ends.map(|end| camera.view.nearness(end));
        let long = (to[0] - from[0]).hypot(to[1] - from[1]);
        let count = (long / PIECE).ceil().clamp(1.0, 200.0);
        let at = |share: f64| [0, 1].map(|c| from[c] + share * (to[c] - from[c]));
        let mut parts: Vec<[Place; 2]> = Vec::new();
        let mut last_hidden = true;
        for piece in 0..count as usize {
            let [start, end] = [piece as f64 / count, (piece + 1) as f64 / count];
            let half = 0.5 * (start + end);
            let hidden = self.hides(at(half), near[0] + half * (near[1] - near[0]));
            if !hidden {
                match parts.last_mut().filter(|_| !last_hidden) {
                    Some(part) => part[1] = at(end),
                    None => parts.push([at(start), at(end)]),
                }
            }
            last_hidden = hidden;
        }
        parts
    }
}

/// Whether a place is inside a convex ring.
fn is_inside(ring: &[Place], [x, y]: Place) -> bool {
    let next = ring.iter().cycle().skip(1);
    let turns =
        ring.iter().zip(next).map(|(a, b)| (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]));
    let (mut left, mut right) = (false, false);
    for turn in turns {
        left |= turn > 0.0;
        right |= turn < 0.0;
    }
    !(left && right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::skin::tests::block;
    use crate::scene::view::{Frame, Reach, View};

    #[test]
    fn the_body_hides_what_is_behind_it() {
        let skin = Skin::of(&block([2, 2, 2]));
        let view = View::of_body();
        let frame = Frame { left: 0.0, top: 0.0, width: 200.0, height: 200.0 };
        let camera = Camera::new(view, Reach::of(&view, skin.points.iter().copied()), frame);
        let cover = Cover::new(&skin, &skin.points, &camera);
        let hidden = |p: Vector| cover.hides(camera.place(p), view.nearness(p));
        assert!(hidden([1.0, 1.0, 0.0]) && hidden([0.2, 1.9, 0.1]));
        assert!(!hidden([1.0, 0.0, 1.0]) && !hidden([1.0, 1.0, 2.0]));
        let length = |ends| -> f64 {
            let parts = cover.seen(ends, &camera).into_iter();
            parts.map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
        };
        // An edge in front is seen, one at the back is not; a line through the body comes out.
        assert!(length([[2.0, 0.0, 0.0], [2.0, 0.0, 2.0]]) > 50.0);
        assert_eq!(length([[0.0, 2.0, 0.0], [0.0, 2.0, 1.9]]), 0.0);
        let through = [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];
        let whole = through.map(|p| camera.place(p));
        let whole = (whole[0][0] - whole[1][0]).hypot(whole[0][1] - whole[1][1]);
        assert!((0.3..0.7).contains(&(length(through) / whole)));
    }
}
