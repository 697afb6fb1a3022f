//! From the cells that the ranks have read to the part of each.

use super::bodies::bodies_before;
use super::cells::{Cell, Cells};
use super::curve::Curve;
use super::doubled;
use super::homes::Homes;
use super::naming::Naming;
use super::part::Finish;
use super::pieces::Work;
use super::placed::Placed;
use super::runs::Runs;
use super::share::share;
use super::shared::Read;
use super::spread::{Held, spread};
use crate::case::Case;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::import::Pieces;
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
    file: Box<dyn Pieces>,
) -> Result<MeshFamily> {
    let Read { head, cells, homes, points, ends, orphans } = read;
    let mut said = file.remarks(orphans[0], &head.groups, &head.counts);
    said.extend(orphans_of_cells(orphans[1] as usize));
    // A file that is open takes memory.
    drop(file);
    give_back_memory();
    let skeleton = skeleton(comm, &head, request, &homes, (&cells, &points))?;
    let curve = Curve::new(comm, &homes, &cells, &points, ends);
    let asked = (request, method, &skeleton.facing(request)[..]);
    let shared = share(comm, &head, &homes, &cells, (curve, &points), asked)?;
    give_back_memory();
    let mut held = spread(comm, &homes, &head, cells, shared);
    give_back_memory();
    let all = held.nodes.iter().chain(&held.far.2).copied();
    let names = Numbers::of(0, homes.total(), all);
    let of_names = homes.fetch(comm, names.iter(), |place| points[place]);
    drop(points);
    give_back_memory();
    comm.agree(held.choose_materials(&head, request))?;
    let mut work = Work::new(names, of_names);
    let bodies = bodies_before(comm, &homes, &held, &work)?;
    let is_raised = request.raise_order == Some(2);
    let shapes = head.shapes(is_raised)?;
    let raised = raised_runs(&head, &held, &shapes);
    let runs = raised.as_ref().unwrap_or(&held.runs);
    give_back_memory();
    comm.agree(work.make(&head, &held, runs, is_raised, &skeleton.cuts()))?;
    give_back_memory();
    let mut naming = Naming::new(comm, &homes, &head, &head.centres(is_raised)?, &mut work)?;
    said.extend(remarks(&head, &shapes, is_raised));
    let placed = Placed::new((&head, &naming), held, work, raised, bodies.0);
    naming.forget_keys();
    give_back_memory();
    let asked = (case, request, ends[0], bodies.1);
    finish(comm, asked, (head, naming, shapes), (placed, skeleton), said)
}

/// Makes the part of each rank of its cells. Collective.
fn finish(
    comm: &Comm,
    (case, request, low, bodies): (&Case, &Request, [f64; 3], usize),
    (head, naming, shapes): (Head, Naming, Vec<Shape>),
    (placed, skeleton): (Placed, Skeleton),
    mut said: Vec<String>,
) -> Result<MeshFamily> {
    said.extend(skeleton.remarks.iter().cloned());
    let between = skeleton.between();
    let finish = Finish { comm, head: &head, shapes: &shapes, naming: &naming };
    let cut = finish.cut(&placed, &skeleton.names)?;
    let mut star = comm.agree(skeleton.finish(request, &cut))?;
    comm.agree(star.add_connected(case))?;
    said.append(&mut star.mesh.remarks);
    let directions = star.directions(&placed.nodes.names);
    let nodes = (&placed.nodes, &placed.shortest[..], naming.uncut());
    doubled::check(comm, nodes, low, &star.between(&cut))?;
    if bodies > 1 {
        finish.touching(&placed, &between, request.raise_order == Some(2))?;
    }
    drop(cut);
    let (part, body_count) = placed.part(comm, &naming, &shapes, bodies)?;
    give_back_memory();
    let facts = finish.facts(case, &part, &mut star, body_count)?;
    drop((head, naming));
    give_back_memory();
    let (mut mesh, marking, behind) = LocalMesh::of_part(part, facts, star, directions);
    let behind = behind.filter(|_| comm.is_root());
    give_back_memory();
    marking.mark(&mut mesh);
    Ok(MeshFamily::in_slabs(mesh, behind, said))
}

/// The cells behind surfaces and interfaces of all ranks. Collective.
fn skeleton(
    comm: &Comm,
    head: &Head,
    request: &Request,
    homes: &Homes,
    (cells, points): (&Cells, &[[f64; 3]]),
) -> Result<Skeleton> {
    let behind = Behind::new(head, request);
    let plain = head.shapes(false)?;
    let mut own = Vec::new();
    for chunk in &cells.chunks {
        let is_behind = |cell: &Cell<'_>| behind.has(plain[chunk.place], cell.nodes);
        let found = chunk.iter().filter(is_behind);
        found.for_each(|cell| {
            own.extend([cell.name, cell.set]);
            own.extend_from_slice(cell.nodes);
        });
    }
    let words = joined(comm, &own)?;
    drop(own);
    let mut all = Vec::new();
    let mut rest = &words[..];
    while let [name, set, more @ ..] = rest {
        let (nodes, more) = more.split_at(head.kind(*name).nodes());
        all.push((*name, *set, nodes));
        rest = more;
    }
    all.sort_unstable_by_key(|cell| cell.0);
    let names = all.iter().map(|cell| cell.0).collect();
    let sets = all.iter().map(|cell| cell.1).collect();
    let nodes: Vec<u32> = all.iter().flat_map(|cell| cell.2).copied().collect();
    drop(all);
    drop(words);
    let needed = nodes_of(head, request, &nodes);
    let places = homes.fetch(comm, needed.iter().copied(), |place| points[place]);
    comm.agree(Skeleton::new(head, request, [names, sets, nodes], (needed, places)))
}

/// Where the nodes of own cells stand after raising; none where no kind is raised.
fn raised_runs(head: &Head, held: &Held, shapes: &[Shape]) -> Option<Runs> {
    let mut kinds = head.kinds.iter().zip(shapes);
    let is_raised = kinds.any(|(range, shape)| range.kind.nodes() != shape.nodes());
    is_raised.then(|| held.runs.with_widths(shapes.iter().map(|shape| shape.nodes())))
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
