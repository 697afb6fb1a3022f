//! Which facets of two lips may face each other.

use super::box_tree::{BoxTree, Extent};
use super::facet::WholeFacet;
use super::types::{WholeInterface, WholeMesh};
use super::view::View;

/// How far apart facets of sides that lie on each other may be, against the diagonal of the lower
/// one.
const REACH: f64 = 0.1;
/// How far facets of sides with a gap may have come into each other, against the diagonal of one.
const OVERLAP: f64 = 0.5;
/// The widest gap against the diagonal of the smaller side: small displacements close none that is
/// as wide as the sides are large.
const WIDEST: f64 = 0.5;
/// Steps along a normal until nothing is found there.
const MOST_STEPS: usize = 10_000;
/// Facets face each other when the cosine of their normals is below this.
const FACING: f64 = -0.3;

/// Facets of the lower and of the upper lip of an interface that may face each other.
pub fn facing(mesh: &WholeMesh, interface: &WholeInterface) -> Vec<[WholeFacet; 2]> {
    facing_of_lips(mesh.view(), &interface.lips, interface.has_gap)
}

/// Facets of two lips that may face each other: where the sides have to lie on each other those
/// whose boxes meet; with a gap those that meet the way from one of them along its normal.
pub fn facing_of_lips(
    view: View<'_>,
    lips: &[Vec<WholeFacet>; 2],
    has_gap: bool,
) -> Vec<[WholeFacet; 2]> {
    let [lower, upper] = lips.each_ref().map(|lip| Side::new(view, lip));
    if !has_gap {
        let mut pairs = Vec::new();
        for (facet, seen) in lower.facets.iter().zip(&lower.seen) {
            let met = upper.tree.meeting(&seen.extent.grown(REACH * seen.extent.diagonal()));
            pairs.extend(met.into_iter().map(|other| [*facet, upper.facets[other as usize]]));
        }
        return pairs;
    }
    let widest = WIDEST * lower.diagonal().min(upper.diagonal());
    let mut pairs = Vec::new();
    for (facet, seen) in lower.facets.iter().zip(&lower.seen) {
        pairs.extend(upper.across_from(seen, widest).into_iter().map(|other| [*facet, other]));
    }
    // A facet is looked at along the normal of either side, and may be hidden from the other.
    for (facet, seen) in upper.facets.iter().zip(&upper.seen) {
        pairs.extend(lower.across_from(seen, widest).into_iter().map(|other| [other, *facet]));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// A facet as the other side sees it.
struct Seen {
    extent: Extent,
    centre: [f64; 3],
    /// Unit normal out of its cell.
    normal: [f64; 3],
}

/// The facets of a lip.
struct Side<'a> {
    facets: &'a [WholeFacet],
    seen: Vec<Seen>,
    tree: BoxTree,
}

impl<'a> Side<'a> {
    fn new(view: View<'_>, facets: &'a [WholeFacet]) -> Self {
        let seen: Vec<Seen> = facets.iter().map(|facet| Seen::of(view, *facet)).collect();
        let tree = BoxTree::new(seen.iter().map(|seen| seen.extent).collect());
        Self { facets, seen, tree }
    }

    /// The diagonal of its box (m).
    fn diagonal(&self) -> f64 {
        let extents: Vec<Extent> = self.seen.iter().map(|seen| seen.extent).collect();
        Extent::around(&extents).diagonal()
    }

    /// The facets that a facet of the other lip may face: found step by step along its normal, one
    /// step beyond the first that lies over it.
    fn across_from(&self, from: &Seen, widest: f64) -> Vec<WholeFacet> {
        let step = from.extent.diagonal();
        let steps = ((widest / step).ceil() as usize).min(MOST_STEPS);
        let mut found = self.facing(from, &from.extent.grown(OVERLAP * step));
        let mut last = if found.iter().any(|i| self.is_over(*i, from)) { 1 } else { steps };
        let mut done = 0;
        while done < last {
            let ends = [done, done + 1].map(|n| from.extent.moved(n as f64 * step, from.normal));
            let met = self.facing(from, &Extent::around(&ends).grown(REACH * step));
            done += 1;
            if last == steps && met.iter().any(|i| self.is_over(*i, from)) {
                last = steps.min(done + 1);
            }
            found.extend(met);
        }
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(|i| self.facets[i as usize]).collect()
    }

    /// The facets whose boxes meet a box and that look against a facet.
    fn facing(&self, from: &Seen, extent: &Extent) -> Vec<u32> {
        let mut met = self.tree.meeting(extent);
        met.retain(|i| dot(self.seen[*i as usize].normal, from.normal) < FACING);
        met
    }

    /// Whether the normal in the middle of a facet passes near the middle of another.
    fn is_over(&self, other: u32, from: &Seen) -> bool {
        let other = &self.seen[other as usize];
        let way: [f64; 3] = std::array::from_fn(|i| other.centre[i] - from.centre[i]);
        let along = dot(way, from.normal);
        let beside = (dot(way, way) - along * along).max(0.0).sqrt();
        beside <= 0.5 * other.extent.diagonal()
    }
}

impl Seen {
    fn of(view: View<'_>, facet: WholeFacet) -> Self {
        let corners = view.facet_corners(facet);
        let at = |i: usize| view.points[corners[i] as usize];
        let minus = |p: [f64; 3], q: [f64; 3]| -> [f64; 3] { [0, 1, 2].map(|i| p[i] - q[i]) };
        let normal = match view.corner_count(facet) {
            2 => {
                let [x, y, _] = minus(at(1), at(0));
                [y, -x, 0.0]
            }
            3 => cross(minus(at(1), at(0)), minus(at(2), at(0))),
            _ => cross(minus(at(2), at(0)), minus(at(3), at(1))),
        };
        let length = dot(normal, normal).sqrt();
        Self {
            extent: Extent::of(view.facet_nodes(facet).map(|node| view.points[node as usize])),
            centre: view.facet_centre(facet),
            normal: normal.map(|x| x / length),
        }
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
