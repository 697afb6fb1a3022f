//! Normals at nodes of surfaces and lips that do not look along an axis, and middles of edges.

use serde::{Deserialize, Serialize};

use super::Lip;

/// The normal of an interface at a node of one of its lips.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LipNormal {
    /// The node, by its number.
    pub node: u32,
    /// The interface, by its index.
    pub interface: u32,
    /// Unit vector from the lower to the upper lip, by components of the displacement.
    pub normal: [f64; 3],
}

/// A normal of a surface at a node; at a kink there are several.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SurfaceNormal {
    /// The node, by its number.
    pub node: u32,
    /// The surface, by its place in the list of the case.
    pub surface: u32,
    /// Unit vector out of the mesh, by components of the displacement.
    pub normal: [f64; 3],
}

/// A node in the middle of an edge of a lip that has triangles of second order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MidNode {
    /// The node, by its number.
    pub node: u32,
    /// The interface, by its index.
    pub interface: u32,
    /// The lip.
    pub lip: Lip,
    /// The ends of the edge, by their numbers.
    pub ends: [u32; 2],
}

/// All of them, each list by rising node.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Directions {
    /// Of interfaces; none in lattices, whose interfaces look along the last axis.
    pub of_lips: Vec<LipNormal>,
    /// Of surfaces; none in lattices.
    pub of_surfaces: Vec<SurfaceNormal>,
    /// Middles of edges.
    pub middles: Vec<MidNode>,
}

impl Directions {
    /// Whether nothing is told.
    pub fn is_empty(&self) -> bool {
        self.of_lips.is_empty() && self.of_surfaces.is_empty()
    }

    /// The normal of an interface at a node, if it is told.
    pub fn of_lip(&self, node: u32, interface: usize) -> Option<[f64; 3]> {
        let all = of(&self.of_lips, node, |one| one.node);
        all.iter().find(|one| one.interface as usize == interface).map(|one| one.normal)
    }

    /// The normals of a surface at a node.
    pub fn of_surface(&self, node: u32, surface: usize) -> impl Iterator<Item = [f64; 3]> {
        let all = of(&self.of_surfaces, node, |one| one.node);
        all.iter().filter(move |one| one.surface as usize == surface).map(|one| one.normal)
    }

    /// The ends of the edge of a lip in whose middle a node lies.
    pub fn ends(&self, node: u32, interface: usize, lip: Lip) -> Option<[u32; 2]> {
        let all = of(&self.middles, node, |one| one.node);
        let here = |one: &&MidNode| one.interface as usize == interface && one.lip == lip;
        all.iter().find(here).map(|one| one.ends)
    }

    /// Sorts the lists.
    pub(super) fn sort(&mut self) {
        self.of_lips.sort_by_key(|one| (one.node, one.interface));
        self.of_surfaces.sort_by_key(|one| (one.node, one.surface));
        self.middles.sort_by_key(|one| (one.node, one.interface, one.lip.index()));
        self.middles.dedup();
    }

    /// The same with names in the place of numbers.
    pub(super) fn named(mut self, names: &[u32]) -> Self {
        let name = |node: &mut u32| *node = names[*node as usize];
        self.of_lips.iter_mut().for_each(|one| name(&mut one.node));
        self.of_surfaces.iter_mut().for_each(|one| name(&mut one.node));
        self.middles.iter_mut().for_each(|one| {
            name(&mut one.node);
            one.ends.iter_mut().for_each(name);
        });
        self
    }

    /// Those at nodes of the given rising names, by their places among them.
    pub(super) fn of_nodes(&self, names: &[u64]) -> Self {
        self.renumbered(|name| names.binary_search(&u64::from(name)).ok())
    }

    /// Those at nodes that keep a number, with their new ones.
    pub(super) fn renumbered(&self, number: impl Fn(u32) -> Option<usize>) -> Self {
        let place = |node: u32| number(node).map(|new| new as u32);
        let of_lips = self.of_lips.iter();
        let of_surfaces = self.of_surfaces.iter();
        let middles = self.middles.iter();
        Self {
            of_lips: of_lips
                .filter_map(|one| Some(LipNormal { node: place(one.node)?, ..*one }))
                .collect(),
            of_surfaces: of_surfaces
                .filter_map(|one| Some(SurfaceNormal { node: place(one.node)?, ..*one }))
                .collect(),
            middles: middles
                .filter_map(|one| {
                    let ends = [place(one.ends[0])?, place(one.ends[1])?];
                    Some(MidNode { node: place(one.node)?, ends, ..*one })
                })
                .collect(),
        }
    }
}

/// The part of a list that is of a node.
fn of<T>(list: &[T], node: u32, node_of: impl Fn(&T) -> u32) -> &[T] {
    let first = list.partition_point(|one| node_of(one) < node);
    let count = list[first..].partition_point(|one| node_of(one) == node);
    &list[first..first + count]
}
