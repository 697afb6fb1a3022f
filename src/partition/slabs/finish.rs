//! From the cells that the ranks have read to the part of each.

use super::File;
use super::bodies::bodies_before;
use super::curve::Curve;
use super::doubled;
use super::homes::Homes;
use super::naming::Naming;
use super::part::Finish;
use super::pieces::Work;
use super::share::share;
use super::shared::Read;
use super::spread::{Held, spread};
use crate::case::Case;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::slabs::{Behind, Head, Numbers, Skeleton, nodes_of};
use crate::mesh::whole::{Request, is_stiff, locking, orphans_of_cells, raised};
use crate::mesh::{LocalMesh, MeshFamily};
use crate::partition::journey::joined;
use crate::partition::method::Method;
use crate::runtime::give_back_memory;

/// Makes the meshes of a case of what was read. Collective.
///
/// # Errors
/// `Input` on all ranks.
pub fn family(
    comm: &Comm,
    case: &Case,
    request: &Request,
    method: Method,
    read: Read,
    file: File<'_>,
) -> Result<MeshFamily> {
    let Read { head, cells, homes, points, ends, orphans } = read;
    let mut said = file.remarks(orphans[0], &head.groups, &head.counts);
    said.extend(orphans_of_cells(orphans[1] as usize));
    give_back_memory();
    let curve = Curve::new(comm, &homes, &cells, &points, ends);
    let shared = share(comm, &head, &homes, &cells, (curve, &points), (request, method))?;
    give_back_memory();
    let mut held = spread(comm, &homes, &head, cells, shared);
    give_back_memory();
    let all = held.nodes.iter().chain(&held.far.2).copied();
    let names = Numbers::of(0, homes.total(), all);
    let of_names = homes.fetch(comm, names.iter(), |place| points[place]);
    let skeleton = skeleton(comm, &head, request, &held, &homes, &points)?;
    drop(points);
    give_back_memory();
    comm.agree(held.choose_materials(&head, request))?;
    let mut work = Work::new(names, of_names);
    let bodies = bodies_before(comm, &homes, &held, &work)?;
    let is_raised = request.raise_order == Some(2);
    let shapes = head.shapes(is_raised)?;
    let is_longer =
        head.kinds.iter().zip(&shapes).any(|(range, s)| range.kind.nodes() != s.nodes());
    let raised_start = is_longer.then(|| starts(&head, &held, &shapes));
    let start = raised_start.as_deref().unwrap_or(&held.start);
    give_back_memory();
    comm.agree(work.make(&head, &held, start, is_raised, &skeleton.cuts()))?;
    give_back_memory();
    let naming = Naming::new(comm, &homes, &head, &head.centres(is_raised)?, &mut work)?;
    said.extend(remarks(&head, &shapes, is_raised));
    said.extend(skeleton.remarks.iter().cloned());
    let names: Vec<u32> = work.fresh.iter().map(|fresh| naming.name(&head, fresh.key)).collect();
    let finish = Finish { comm, head: &head, shapes: &shapes, naming: &naming, names: &names };
    let between = skeleton.between();
    let cut = finish.cut(&held, &work, &skeleton.names, start)?;
    let mut star = comm.agree(skeleton.finish(request, &cut))?;
    comm.agree(star.add_connected(case))?;
    said.append(&mut star.mesh.remarks);
    doubled::check(comm, &work, &finish.before_cutting(&work), ends[0], &star.between(&cut))?;
    if bodies.1 > 1 {
        finish.touching(&held, &work, start, (&bodies.0, &between), is_raised)?;
    }
    drop(cut);
    let (part, body_count) = finish.part(held, work, raised_start, bodies)?;
    give_back_memory();
    let facts = finish.facts(case, &part, &mut star, body_count)?;
    let mesh = LocalMesh::of_part(part, facts, &star);
    Ok(MeshFamily::in_slabs(mesh, comm.is_root().then_some(star.mesh), said))
}

/// The cells behind surfaces and interfaces of all ranks. Collective.
fn skeleton(
    comm: &Comm,
    head: &Head,
    request: &Request,
    held: &Held,
    homes: &Homes,
    points: &[[f64; 3]],
) -> Result<Skeleton> {
    let behind = Behind::new(head, request);
    let plain = head.shapes(false)?;
    let mut own = Vec::new();
    for place in 0..held.cells.len() {
        let (name, nodes) = held.cell(place);
        if behind.has(plain[head.kind_place(name)], nodes) {
            own.push((name, held.sets[place], nodes.to_vec()));
        }
    }
    let mut all: Vec<(u32, u32, Vec<u32>)> = joined(comm, &own)?;
    drop(own);
    all.sort_unstable_by_key(|cell| cell.0);
    let names = all.iter().map(|cell| cell.0).collect();
    let sets = all.iter().map(|cell| cell.1).collect();
    let nodes: Vec<u32> = all.iter().flat_map(|cell| &cell.2).copied().collect();
    drop(all);
    let needed = nodes_of(head, request, &nodes);
    let places = homes.fetch(comm, needed.iter().copied(), |place| points[place]);
    comm.agree(Skeleton::new(head, request, [names, sets, nodes], (needed, places)))
}

/// The first node of each own cell after raising, and the end.
fn starts(head: &Head, held: &Held, shapes: &[Shape]) -> Vec<u32> {
    let mut start = Vec::with_capacity(held.cells.len() + 1);
    let mut end = 0;
    start.push(0);
    for cell in &held.cells {
        end += shapes[head.kind_place(*cell as u32)].nodes() as u32;
        start.push(end);
    }
    start
}

/// What is to be said of all cells together.
fn remarks(head: &Head, shapes: &[Shape], is_raised: bool) -> Vec<String> {
    let kinds = || head.kinds.iter().zip(shapes);
    let changed = kinds().filter(|(range, shape)| range.kind.nodes() != shape.nodes());
    let mut said: Vec<String> = changed
        .map(|(range, shape)| raised(range.kind, shape.nodes(), range.count as usize))
        .collect();
    let stiff = kinds().filter(|(_, shape)| is_stiff(**shape));
    let number = stiff.map(|(range, _)| range.count as usize).sum();
    said.extend(locking(head.dim, number).filter(|_| !is_raised));
    said
}
