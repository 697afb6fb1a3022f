//! Fewer facets where there are more than a drawing can hold.

use crate::element::Shape;

use super::features::{Features, Parents};
use super::skin::{Facet, Skin};
use super::vector::{Vector, extent, length, minus, plus};

/// A skin with fewer facets.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Thinned {
    pub skin: Skin,
    /// The edge of the grid on which points were merged (m).
    pub edge: f64,
    /// One of so many facets is left.
    pub every: usize,
}

/// A skin of at most `most` facets: of the points in a cell of a grid one is kept, a corner before
/// an edge and an edge before the rest. Points stay apart where surfaces do not hang together or
/// look another way, so that neither the lips of an interface nor the sides of a plate merge. None
/// where there are no more facets than that.
pub(crate) fn thinned(skin: &Skin, most: usize) -> Option<Thinned> {
    let most = most.max(1);
    if skin.facets.len() <= most {
        return None;
    }
    let points = Sorted::new(skin);
    let area: f64 = skin.facets.iter().map(|f| length(skin.area(f, &skin.points))).sum();
    // A grid cell holds about one square, which is drawn as at most two facets.
    let whole = extent(skin.points.iter().copied());
    let mut edge = (area / most as f64).sqrt().max(1e-6 * whole);
    loop {
        let mut merged = points.merged(skin, edge);
        let excess = merged.facets.len() as f64 / most as f64;
        // Parts that do not hang together never merge: of very many, some are left out.
        if excess <= 1.0 || edge >= whole {
            let every = excess.ceil().max(1.0) as usize;
            merged.facets = merged.facets.into_iter().step_by(every).collect();
            return Some(Thinned { skin: merged, edge, every });
        }
        edge *= excess.sqrt().clamp(1.05, 2.0);
    }
}

/// What tells points apart, whatever the grid.
struct Sorted {
    /// The connected part of the surface and the direction to which it looks.
    sides: Vec<(u32, u8)>,
    ranks: Vec<u8>,
    low: Vector,
}

type Key = (u32, u8, [i64; 3]);

impl Sorted {
    fn new(skin: &Skin) -> Self {
        let mut parents = Parents::new(skin.points.len());
        let mut normals = vec![[0.0; 3]; skin.points.len()];
        for facet in &skin.facets {
            let area = skin.area(facet, &skin.points);
            let nodes = skin.of_facet(facet);
            for node in nodes {
                parents.join(nodes[0], *node);
                let normal = &mut normals[*node as usize];
                *normal = plus(*normal, 1.0, area);
            }
        }
        let side = |(point, normal): (usize, &Vector)| {
            let most = (0..3).fold(0, |m, c| if normal[c].abs() > normal[m].abs() { c } else { m });
            let looks = 2 * most as u8 + u8::from(normal[most] > 0.0);
            // In a plane there is one side.
            (parents.root(point as u32), if skin.dim == 3 { looks } else { 0 })
        };
        Self {
            sides: normals.iter().enumerate().map(side).collect(),
            ranks: Features::of(skin).ranks(skin),
            low: super::vector::bounds(skin.points.iter().copied())[0],
        }
    }

    fn merged(&self, skin: &Skin, edge: f64) -> Skin {
        let key = |point: usize| -> Key {
            let (part, looks) = self.sides[point];
            let at = minus(skin.points[point], self.low);
            (part, looks, at.map(|c| (c / edge).floor() as i64))
        };
        let mut order: Vec<(Key, u32)> =
            (0..skin.points.len()).map(|point| (key(point), point as u32)).collect();
        order.sort_unstable();
        let mut kept = vec![0; skin.points.len()];
        for same in order.chunk_by(|a, b| a.0 == b.0) {
            let best = self.best(skin, same);
            same.iter().for_each(|(_, point)| kept[*point as usize] = best);
        }
        rebuilt(skin, &kept)
    }

    /// The point that stands for those of a grid cell.
    fn best(&self, skin: &Skin, same: &[(Key, u32)]) -> u32 {
        let rank = |point: u32| self.ranks[point as usize];
        let highest = same.iter().map(|(_, point)| rank(*point)).max().unwrap_or_default();
        let of_rank = || same.iter().map(|(_, point)| *point).filter(|p| rank(*p) == highest);
        let share = 1.0 / of_rank().count().max(1) as f64;
        let middle = of_rank().fold([0.0; 3], |sum, p| plus(sum, share, skin.points[p as usize]));
        let away = |point: u32| length(minus(skin.points[point as usize], middle));
        of_rank().min_by(|a, b| away(*a).total_cmp(&away(*b))).unwrap_or(same[0].1)
    }
}

/// The facets between points that are kept; those that have shrunk or come twice are left out.
fn rebuilt(skin: &Skin, kept: &[u32]) -> Skin {
    let mut found: Vec<([u32; 4], u32, Vec<u32>)> = Vec::new();
    for (index, facet) in skin.facets.iter().enumerate() {
        let mut corners: Vec<u32> = skin.corners(facet).iter().map(|i| kept[*i as usize]).collect();
        corners.dedup();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        let mut key = [u32::MAX; 4];
        key.iter_mut().zip(&corners).for_each(|(k, corner)| *k = *corner);
        key.sort_unstable();
        let twice = key.windows(2).any(|pair| pair[0] == pair[1] && pair[0] != u32::MAX);
        if corners.len() >= 3 && !twice {
            found.push((key, index as u32, corners));
        }
    }
    found.sort_unstable();
    found.dedup_by_key(|(key, ..)| *key);
    found.sort_unstable_by_key(|(_, index, _)| *index);

    let mut used: Vec<u32> = found.iter().flat_map(|(_, _, corners)| corners).copied().collect();
    used.sort_unstable();
    used.dedup();
    let place = |point: &u32| used.partition_point(|other| other < point) as u32;
    let mut facets = Vec::new();
    let mut nodes = Vec::new();
    for (_, index, corners) in &found {
        let shape = if corners.len() == 3 { Shape::Tri3 } else { Shape::Quad4 };
        let cell = skin.facets[*index as usize].cell;
        facets.push(Facet { shape, start: nodes.len() as u32, cell });
        nodes.extend(corners.iter().map(place));
    }
    let points = used.iter().map(|point| skin.points[*point as usize]).collect();
    let rows = used.iter().map(|point| skin.rows[*point as usize]).collect();
    Skin { dim: skin.dim, depth: skin.depth, points, rows, facets, nodes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::skin::tests::block;
    use crate::scene::vector::bounds;

    #[test]
    fn a_block_stays_one_with_fewer_facets() {
        let skin = Skin::of(&block([30, 20, 40]));
        assert_eq!(thinned(&skin, skin.facets.len()), None);
        for most in [2000, 500, 60] {
            let Some(Thinned { skin: thin, edge, every: 1 }) = thinned(&skin, most) else {
                panic!("{most}")
            };
            assert!(thin.facets.len() <= most && edge > 1.0, "{}", thin.facets.len());
            // Every corner is still there, and all that is drawn was in the mesh.
            assert_eq!(bounds(thin.points.iter().copied()), [[0.0; 3], [30.0, 20.0, 40.0]]);
            for (point, row) in thin.points.iter().zip(&thin.rows) {
                let place = skin.rows.binary_search(row).expect("a point of the mesh");
                assert_eq!(*point, skin.points[place]);
            }
            let area: f64 = thin.facets.iter().map(|f| length(thin.area(f, &thin.points))).sum();
            assert!((area / 5200.0 - 1.0).abs() < 0.02, "{area} with {most}");
        }
        let least = thinned(&skin, 1).expect("fewer");
        assert!(least.skin.facets.len() == 1 && least.every > 1);
    }

    #[test]
    fn two_blocks_that_touch_do_not_grow_together() {
        let mut grid = block([12, 12, 6]);
        let other = block([12, 12, 6]);
        let first = grid.points.len() as u32;
        let cells = grid.nodes.len();
        grid.points.extend(other.points.iter().map(|p| [p[0], p[1], p[2] + 6.0]));
        grid.nodes.extend(other.nodes.iter().map(|node| node + first));
        grid.starts.extend(other.starts[1..].iter().map(|start| start + cells));
        grid.shapes.extend(other.shapes);
        let skin = thinned(&Skin::of(&grid), 200).expect("fewer").skin;
        let lower =
            |facet: &Facet| skin.corners(facet).iter().all(|i| skin.rows[*i as usize] < first);
        let upper =
            |facet: &Facet| skin.corners(facet).iter().all(|i| skin.rows[*i as usize] >= first);
        assert!(skin.facets.iter().all(|facet| lower(facet) || upper(facet)));
        // The lips are both there.
        let lips = skin.facets.iter().filter(|f| skin.middle(f, &skin.points)[2] == 6.0);
        assert!(lips.count() >= 4);
    }
}
