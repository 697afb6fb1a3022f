//! A number that tells two meshes apart.

use super::facet::WholeFacet;
use super::types::WholeMesh;
use crate::element::Shape;

/// The digest of a mesh: of the points, the cells with their materials, and the facets and nodes of
/// surfaces and interfaces, in their order. Two meshes that differ in any of that have the same one
/// by chance only. It is the same on every machine and has to stay so: checkpoints hold it.
pub fn digest(mesh: &WholeMesh) -> u64 {
    let mut digest = Digest(0);
    digest.list(mesh.points.iter().flatten().map(|x| x.to_bits()));
    digest.list(mesh.shapes.iter().map(|shape| shape_number(*shape)));
    for list in [&mesh.nodes, &mesh.materials] {
        digest.list(list.iter().map(|number| u64::from(*number)));
    }
    for surface in &mesh.surfaces {
        digest.facets(&surface.facets);
        digest.list(surface.nodes.iter().map(|node| u64::from(*node)));
    }
    for interface in &mesh.interfaces {
        interface.lips.iter().for_each(|lip| digest.facets(lip));
    }
    digest.0
}

/// A digest of numbers as they come.
#[derive(Debug, Clone, Copy, Default)]
pub struct Digest(u64);

impl Digest {
    /// So far.
    pub fn number(self) -> u64 {
        self.0
    }

    /// Adds a number: the finaliser of splitmix64.
    pub fn add(&mut self, number: u64) {
        let x = (self.0 ^ number).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = x ^ (x >> 31);
    }

    /// Adds numbers, and how many they are.
    pub fn list(&mut self, numbers: impl Iterator<Item = u64>) {
        let mut count = 0;
        for number in numbers {
            self.add(number);
            count += 1;
        }
        self.add(count);
    }

    fn facets(&mut self, facets: &[WholeFacet]) {
        self.list(facets.iter().map(|f| facet(f.cell, f.facet)));
    }
}

/// A shape as a number.
pub fn shape_number(shape: Shape) -> u64 {
    (shape.nodes() << 2 | shape.dim()) as u64
}

/// A facet as a number.
pub fn facet(cell: u32, facet: u8) -> u64 {
    u64::from(cell) << 8 | u64::from(facet)
}
