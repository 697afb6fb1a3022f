//! Normals of the facets of an interface, made one.

use super::buckets::{Buckets, Entry};
use super::cells::NONE;
use super::facet::WholeFacet;
use super::view::View;

/// Facets at one edge go straight on when they turn by less than 30 degrees: the cosine.
const STRAIGHT: f64 = 0.866_025_403_784_438_6;

/// Facets that meet in an edge (2D: in a node), as seen from one of them.
#[derive(Debug, Clone, Copy)]
struct Link {
    facet: u32,
    /// Whether the normals of both are on the same side, as their corners run now.
    is_alike: bool,
    /// Whether no other facet meets them there.
    is_alone: bool,
}

/// For each facet whether it is to be turned, so that the normals are one over each piece in which
/// not more than two facets meet in any edge, and over pieces that go straight on where more do. Of
/// those that hang together in this way the first facet stays as it is.
///
/// # Errors
/// The facet where a piece comes back to itself with its normal turned. Pieces that do so over a
/// crossing keep what they got first.
pub fn orient(view: View<'_>, facets: &[WholeFacet]) -> Result<Vec<bool>, WholeFacet> {
    let links = links(view, facets);
    let mut turned: Vec<Option<bool>> = vec![None; facets.len()];
    for first in 0..facets.len() {
        let mut waiting = vec![(first, false)];
        while let Some((facet, is_turned)) = waiting.pop() {
            if turned[facet].is_none() {
                cover(&links, facet, is_turned, &mut turned, &mut waiting)
                    .map_err(|facet| facets[facet])?;
            }
        }
    }
    Ok(turned.into_iter().map(|turned| turned == Some(true)).collect())
}

/// Goes over the piece of a facet; facets beyond crossings are to wait.
fn cover(
    links: &[[Link; 4]],
    first: usize,
    is_turned: bool,
    turned: &mut [Option<bool>],
    waiting: &mut Vec<(usize, bool)>,
) -> Result<(), usize> {
    turned[first] = Some(is_turned);
    let mut reached = vec![first];
    while let Some(facet) = reached.pop() {
        let own = turned[facet] == Some(true);
        for link in links[facet].iter().filter(|link| link.facet != NONE) {
            let other = link.facet as usize;
            let wanted = own == link.is_alike;
            match turned[other] {
                _ if !link.is_alone => waiting.push((other, wanted)),
                Some(is) if is != wanted => return Err(other),
                Some(_) => {}
                None => {
                    turned[other] = Some(wanted);
                    reached.push(other);
                }
            }
        }
    }
    Ok(())
}

/// The neighbours of each facet over its edges.
fn links(view: View<'_>, facets: &[WholeFacet]) -> Vec<[Link; 4]> {
    let rims = || {
        (0..).zip(facets).flat_map(|(id, facet)| {
            let corners = view.facet_corners(*facet);
            let count = view.corner_count(*facet);
            (0..count).map(move |i| rim(corners, count, i, id))
        })
    };
    let none = Link { facet: NONE, is_alike: true, is_alone: true };
    let mut links = vec![[none; 4]; facets.len()];
    let mut join = |one: u32, other: u32, is_alone: bool| {
        // Two facets with normals on the same side run through their edge in opposite senses,
        // which is the last bit.
        let is_alike = one & 1 != other & 1;
        for (facet, to) in [(one >> 1, other >> 1), (other >> 1, one >> 1)] {
            let row = &mut links[facet as usize];
            if let Some(place) = row.iter_mut().find(|link| link.facet == NONE) {
                *place = Link { facet: to, is_alike, is_alone };
            }
        }
    };
    for (first, run) in Buckets::new(view.points.len(), rims).runs() {
        match run {
            [_] => {}
            [one, other] => join(one.id, other.id, true),
            _ => {
                for [one, other] in straight(view, facets, [first, run[0].rest[0]], run) {
                    join(one, other, false);
                }
            }
        }
    }
    links
}

/// Of more than two facets at an edge those that go straight on into each other.
fn straight(
    view: View<'_>,
    facets: &[WholeFacet],
    ends: [u32; 2],
    run: &[Entry<1>],
) -> Vec<[u32; 2]> {
    let away = |entry: &Entry<1>| away(view, facets[(entry.id >> 1) as usize], ends);
    let away: Vec<[f64; 3]> = run.iter().map(away).collect();
    let turn = |i: usize, j: usize| -> f64 { (0..3).map(|k| away[i][k] * away[j][k]).sum() };
    let best = |i: usize| {
        let others = (0..run.len()).filter(|j| *j != i);
        others.min_by(|a, b| turn(i, *a).total_cmp(&turn(i, *b)))
    };
    let mut pairs = Vec::new();
    for i in 0..run.len() {
        let Some(j) = best(i) else { continue };
        if i < j && best(j) == Some(i) && turn(i, j) < -STRAIGHT {
            pairs.push([run[i].id, run[j].id]);
        }
    }
    pairs
}

/// The unit vector from an edge into a facet, across the edge.
fn away(view: View<'_>, facet: WholeFacet, [a, b]: [u32; 2]) -> [f64; 3] {
    let from = view.points[a as usize];
    let minus = |p: [f64; 3], q: [f64; 3]| -> [f64; 3] { [0, 1, 2].map(|i| p[i] - q[i]) };
    let dot = |p: [f64; 3], q: [f64; 3]| (0..3).map(|i| p[i] * q[i]).sum::<f64>();
    let mut away = minus(view.facet_centre(facet), from);
    // Lines meet in a node, which has no direction.
    if b != NONE {
        let along = minus(view.points[b as usize], from);
        let part = dot(away, along) / dot(along, along);
        away = [0, 1, 2].map(|i| away[i] - part * along[i]);
    }
    let length = dot(away, away).sqrt();
    away.map(|x| x / length)
}

/// Edge i of a facet: its nodes, and the facet with the sense.
fn rim(corners: [u32; 4], count: usize, i: usize, facet: u32) -> (u32, Entry<1>) {
    let (a, b) = (corners[i], corners[(i + 1) % count]);
    if count == 2 {
        // A node of a line: it is the first or the second one.
        return (a, Entry { rest: [NONE], id: facet << 1 | i as u32 });
    }
    (a.min(b), Entry { rest: [a.max(b)], id: facet << 1 | u32::from(a < b) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Shape;

    /// A ring of hexahedra whose bottoms are a band of quadrilaterals; the last one is joined to
    /// the first with its sides as they are, or changed.
    fn ring(is_twisted: bool) -> (Vec<[f64; 3]>, Vec<u32>, Vec<WholeFacet>) {
        let count = 5_u32;
        let mut nodes = Vec::new();
        for cell in 0..count {
            let [a, b] = [2 * cell, 2 * cell + 1];
            let [c, d] = match cell + 1 {
                next if next < count => [2 * next + 1, 2 * next],
                _ if is_twisted => [0, 1],
                _ => [1, 0],
            };
            let top = 2 * count + 4 * cell;
            nodes.extend([a, b, c, d, top, top + 1, top + 2, top + 3]);
        }
        let facets = (0..count).map(|cell| WholeFacet { cell, facet: 0 }).collect();
        (vec![[0.0; 3]; 6 * count as usize], nodes, facets)
    }

    #[test]
    fn a_band_has_two_sides_unless_it_is_twisted() {
        for is_twisted in [false, true] {
            let (points, nodes, facets) = ring(is_twisted);
            let (shapes, start) = ([Shape::Hex8; 5], [0, 8, 16, 24, 32, 40]);
            let view = View { points: &points, shapes: &shapes, start: &start, nodes: &nodes };
            let result = orient(view, &facets);
            assert_eq!(result.is_err(), is_twisted, "{result:?}");
            // Cut open, both have two sides.
            assert_eq!(orient(view, &facets[1..]), Ok(vec![false; 4]));
        }
    }
}
