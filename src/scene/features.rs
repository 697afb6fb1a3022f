//! Edges at which a surface ends or bends sharply, and the smooth patches between them.

use super::skin::Skin;
use super::vector::{dot, unit};

/// Two facets whose normals differ by less are one smooth surface (cosine of 35 degrees).
const SMOOTH: f64 = 0.82;

/// The sharp edges of a surface, and its patches.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Features {
    /// Ends of the sharp edges, the smaller first, sorted.
    sharp: Vec<[u32; 2]>,
    /// The patch of each facet.
    pub patches: Vec<u32>,
}

impl Features {
    /// Those of a skin.
    pub fn of(skin: &Skin) -> Self {
        let normals: Vec<_> =
            skin.facets.iter().map(|f| unit(skin.area(f, &skin.points))).collect();
        let mut edges: Vec<([u32; 2], u32)> = Vec::new();
        for (index, facet) in skin.facets.iter().enumerate() {
            let ends = skin.edges(facet).map(|[a, b]| [a.min(b), a.max(b)]);
            edges.extend(ends.map(|ends| (ends, index as u32)));
        }
        edges.sort_unstable();
        let mut sharp = Vec::new();
        let mut parents = Parents::new(skin.facets.len());
        for same in edges.chunk_by(|a, b| a.0 == b.0) {
            let smooth = match same {
                [(_, a), (_, b)] => {
                    // Cells of a plane mesh may run around either way.
                    let bend = dot(normals[*a as usize], normals[*b as usize]);
                    if skin.dim == 3 { bend > SMOOTH } else { bend.abs() > SMOOTH }
                }
                _ => false,
            };
            if smooth {
                parents.join(same[0].1, same[1].1);
            } else {
                sharp.push(same[0].0);
            }
        }
        let patches = (0..skin.facets.len() as u32).map(|facet| parents.root(facet)).collect();
        Self { sharp, patches }
    }

    /// Whether the edge between two points is sharp.
    pub fn is_sharp(&self, [a, b]: [u32; 2]) -> bool {
        self.sharp.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// The ends of all sharp edges.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.sharp
    }

    /// How much of a feature each of so many points is: 0 on a smooth surface, 1 on an edge, 2
    /// where edges meet, end or turn a corner.
    pub fn ranks(&self, skin: &Skin) -> Vec<u8> {
        let mut along = vec![Vec::new(); skin.points.len()];
        for [a, b] in &self.sharp {
            let way = |from: u32, to: u32| {
                let [from, to] = [from, to].map(|i| skin.points[i as usize]);
                unit(super::vector::minus(to, from))
            };
            along[*a as usize].push(way(*a, *b));
            along[*b as usize].push(way(*b, *a));
        }
        let rank = |ways: &Vec<_>| match ways[..] {
            [] => 0,
            [a, b] if dot(a, b) < -SMOOTH => 1,
            _ => 2,
        };
        along.iter().map(rank).collect()
    }
}

/// Sets that are joined; the root of a set is its least member.
#[derive(Debug, Clone)]
pub(super) struct Parents(Vec<u32>);

impl Parents {
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub fn root(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            let above = self.0[self.0[member as usize] as usize];
            self.0[member as usize] = above;
            member = above;
        }
        member
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [self.root(a), self.root(b)];
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::skin::tests::block;

    #[test]
    fn a_block_has_twelve_edges_and_six_patches() {
        let skin = Skin::of(&block([2, 3, 4]));
        let features = Features::of(&skin);
        assert_eq!(features.edges().len(), 4 * (2 + 3 + 4));
        assert!(features.edges().iter().all(|[a, b]| features.is_sharp([*b, *a])));
        let mut patches = features.patches.clone();
        patches.sort_unstable();
        patches.dedup();
        assert_eq!(patches.len(), 6);
        let ranks = features.ranks(&skin);
        let count = |rank| ranks.iter().filter(|r| **r == rank).count();
        assert_eq!((count(2), count(1)), (8, 4 * (1 + 2 + 3)));
    }
}
