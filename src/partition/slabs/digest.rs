//! The digest of a mesh that no rank holds: parts of it go through the root, in their order.

use crate::comm::Comm;
use crate::element::Shape;
use crate::mesh::slabs::{Part, Star};
use crate::mesh::whole::{Digest, facet_number, shape_number};

/// Nodes or cells that go through the root at once.
const STEP: u64 = 1 << 13;

/// The digest that the whole mesh would have. Collective.
///
/// # Arguments
/// * `nodes` and the shapes of all cells with their numbers
pub fn digest(comm: &Comm, part: &Part, star: &Star, nodes: u64, shapes: &[(Shape, u64)]) -> u64 {
    let mut digest = Digest::default();
    add_points(comm, part, nodes, &mut digest);
    let all = shapes
        .iter()
        .flat_map(|(shape, count)| std::iter::repeat_n(shape_number(*shape), *count as usize));
    digest.list(all);
    add_cells(comm, part, shapes, &mut digest);
    for (surface, is_all) in star.mesh.surfaces.iter().zip(&star.is_all) {
        let facets = surface.facets.iter();
        digest.list(facets.map(|f| facet_number(star.cells[f.cell as usize], f.facet)));
        if *is_all {
            digest.list(0..nodes);
        } else {
            digest.list(surface.nodes.iter().map(|n| u64::from(star.nodes[*n as usize])));
        }
    }
    for lip in star.mesh.interfaces.iter().flat_map(|interface| &interface.lips) {
        digest.list(lip.iter().map(|f| facet_number(star.cells[f.cell as usize], f.facet)));
    }
    comm.max_u64(if comm.is_root() { digest.number() } else { 0 })
}

/// Collective.
fn add_points(comm: &Comm, part: &Part, nodes: u64, digest: &mut Digest) {
    let mut from = 0;
    while from < nodes {
        let to = (from + STEP).min(nodes);
        let range = range(&part.nodes.names, from, to);
        let names: Vec<u32> =
            part.nodes.names[range.clone()].iter().map(|name| (name - from) as u32).collect();
        let points = comm.gather(part.nodes.points[range].as_flattened());
        if let (Some(names), Some(points)) = (comm.gather(&names), points) {
            let mut all = vec![[0.0; 3]; (to - from) as usize];
            let points = points.iter().flat_map(|points| points.as_chunks::<3>().0);
            for (name, point) in names.iter().flatten().zip(points) {
                all[*name as usize] = *point;
            }
            all.iter().flatten().for_each(|x: &f64| digest.add(x.to_bits()));
        }
        from = to;
    }
    digest.add(3 * nodes);
}

/// Nodes and materials of the cells. Collective.
fn add_cells(comm: &Comm, part: &Part, shapes: &[(Shape, u64)], digest: &mut Digest) {
    let (mut before, mut entries) = (0, 0);
    let mut materials = Vec::new();
    for (shape, count) in shapes {
        let mut from = before;
        while from < before + count {
            let to = (from + STEP).min(before + count);
            let range = range(&part.cells, from, to);
            let names: Vec<u32> =
                part.cells[range.clone()].iter().map(|name| (name - from) as u32).collect();
            let own = part.start[range.start] as usize..part.start[range.end] as usize;
            let name = |node: &u32| part.nodes.names[*node as usize] as u32;
            let nodes: Vec<u32> = part.connectivity[own].iter().map(name).collect();
            if let (Some(names), Some(nodes)) = (comm.gather(&names), comm.gather(&nodes)) {
                let width = shape.nodes();
                let mut all = vec![0; width * (to - from) as usize];
                for (names, nodes) in names.iter().zip(&nodes) {
                    for (name, nodes) in names.iter().zip(nodes.chunks(width)) {
                        all[*name as usize * width..][..width].copy_from_slice(nodes);
                    }
                }
                all.iter().for_each(|node| digest.add(u64::from(*node)));
            }
            from = to;
        }
        before += count;
        entries += count * shape.nodes() as u64;
    }
    digest.add(entries);
    let mut from = 0;
    while from < before {
        let to = (from + STEP).min(before);
        let range = range(&part.cells, from, to);
        let cells = part.cells[range.clone()].iter().zip(&part.materials[range]);
        let rows: Vec<u32> =
            cells.flat_map(|(name, material)| [(name - from) as u32, *material]).collect();
        if let Some(rows) = comm.gather(&rows) {
            materials.clear();
            materials.resize((to - from) as usize, 0);
            for row in rows.iter().flat_map(|rows| rows.chunks(2)) {
                materials[row[0] as usize] = row[1];
            }
            materials.iter().for_each(|material| digest.add(u64::from(*material)));
        }
        from = to;
    }
    digest.add(before);
}

/// The part of rising names from one on and before another.
fn range(names: &[u64], from: u64, to: u64) -> std::ops::Range<usize> {
    names.partition_point(|name| *name < from)..names.partition_point(|name| *name < to)
}
