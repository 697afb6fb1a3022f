//! From the cells that the ranks have read to the part of each.

use super::File;
use super::bodies::{count, even_homes, merge};
use super::curve;
use super::digest::digest;
use super::doubled;
use super::labels::AtNodes;
use super::naming::Naming;
use super::pieces::{Work, fresh_place};
use super::shared::Read;
use super::spread::{Held, PieceList, spread};
use crate::case::Case;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::hash::mix;
use crate::mesh::slabs::{Behind, Cut, Head, Numbers, Part, Skeleton, Skin, Star, nodes_of};
use crate::mesh::whole::{Request, bodies, is_stiff, locking, orphans_of_cells, raised};
use crate::mesh::{LocalMesh, MeshFacts, MeshFamily, Places};
use crate::partition::journey::joined;
use crate::partition::method::Method;

/// Cells of the coarse graph for each rank, and at most.
const CLUSTERS: u64 = 1024;
const MOST_CLUSTERS: u64 = 1 << 17;
/// Cells of a piece.
const PIECE: f64 = 32_768.0;

/// Debug.
pub fn hwm(what: &str) {
    if std::env::var("HWM").is_err() {
        return;
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let get = |k: &str| status.lines().find(|l| l.starts_with(k)).unwrap().split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1000.0;
    eprintln!("HWM {what}: now {:.0} most {:.0}", get("VmRSS"), get("VmHWM"));
}

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
    let is_raised = request.raise_order == Some(2);
    let shapes = head.shapes(is_raised)?;
    let mut said = file.remarks(orphans[0], &head.groups, &head.counts);
    said.extend(orphans_of_cells(orphans[1] as usize));
    hwm("start");
    let held = {
        let keys = curve::keys(comm, &homes, &cells, &points, ends);
        hwm("keys");
        let (labels, list, at_nodes) = share(comm, &head, &homes, &cells, keys, method)?;
        hwm("share");
        spread(comm, &homes, &head, cells, &labels, (&list, &at_nodes))
    };
    hwm("spread");
    let all = held.nodes.iter().chain(&held.far.2).copied();
    let names = Numbers::of(0, homes.total(), all);
    let of_names = homes.fetch(comm, names.iter(), |place| points[place]);
    hwm("fetched");
    let skeleton = skeleton(comm, &head, request, &held, &homes, &points)?;
    drop(points);
    hwm("skeleton");
    let mut work = Work::new(names, of_names);
    let (of_cells, bodies_before) = bodies_before(comm, &held, &work)?;
    hwm("bodies");
    let start = starts(&head, &held, &shapes);
    let cuts = skeleton.cuts();
    comm.agree(work.make(&head, &held, &start, is_raised, &cuts))?;
    hwm("pieces");
    let centres = head.centres(is_raised)?;
    let naming = Naming::new(comm, &homes, &head, &centres, &mut work)?;
    said.extend(remarks(&head, &shapes, is_raised));
    said.extend(skeleton.remarks.iter().cloned());
    hwm("naming");
    let materials = comm.agree(materials(&head, request, &held))?;
    let names: Vec<u32> = work.fresh.iter().map(|fresh| naming.name(&head, fresh.key)).collect();
    let finish = Finish { comm, head: &head, shapes: &shapes, naming: &naming, names: &names };
    let between = skeleton.between();
    let cut = finish.cut(&held, &work, &skeleton.names, &start, &materials)?;
    let mut star = comm.agree(skeleton.finish(request, &cut))?;
    comm.agree(star.add_connected(case))?;
    said.append(&mut star.mesh.remarks);
    let uncut: Vec<Option<u32>> = work
        .fresh
        .iter()
        .zip(&names)
        .map(|(fresh, name)| (fresh.key.sector() == 0).then_some(*name))
        .collect();
    hwm("star");
    doubled::check(comm, &work, &uncut, ends[0], &star.between(&cut))?;
    if bodies_before > 1 {
        finish.touching(&held, &work, &start, (&of_cells, &between), is_raised)?;
    }
    hwm("doubled");
    let is_cut = !naming.origins.is_empty();
    let known = (!is_cut).then_some((of_cells, bodies_before));
    let (part, body_count) = finish.part(held, work, start, materials, known)?;
    hwm("part");
    let facts = finish.facts(case, &part, &mut star, body_count)?;
    hwm("facts");
    let mesh = LocalMesh::of_part(part, facts, &star);
    hwm("local");
    Ok(MeshFamily::in_slabs(mesh, comm.is_root().then_some(star.mesh), said))
}

/// Labels of the cells, the pieces of these, and the pieces at nodes. Collective.
fn share(
    comm: &Comm,
    head: &Head,
    homes: &super::homes::Homes,
    cells: &super::cells::Cells,
    keys: Vec<u64>,
    method: Method,
) -> Result<(Vec<u32>, PieceList, AtNodes)> {
    let ranks = comm.size() as u32;
    if method == Method::Scattered && ranks > 1 {
        let rank =
            |cell: super::cells::Cell<'_>| (mix(u64::from(cell.name)) % u64::from(ranks)) as u32;
        let labels: Vec<u32> = cells.iter().map(rank).collect();
        let at_nodes = AtNodes::new(comm, homes, cells, &labels);
        let list = PieceList { firsts: (0..=ranks).collect(), of_label: (0..ranks).collect() };
        return Ok((labels, list, at_nodes));
    }
    let wanted = (CLUSTERS * u64::from(ranks)).min(MOST_CLUSTERS).min(head.cells());
    let cuts = curve::cuts(comm, &keys, wanted);
    let label = |key: u64| cuts.partition_point(|cut| *cut <= key) as u32;
    let labels: Vec<u32> = keys.into_iter().map(label).collect();
    let at_nodes = AtNodes::new(comm, homes, cells, &labels);
    let mut sums = vec![0.0; 2 * (cuts.len() + 1)];
    for (cell, label) in cells.iter().zip(&labels) {
        sums[2 * *label as usize] += 1.0;
        sums[2 * *label as usize + 1] += cell.nodes.len() as f64;
    }
    comm.sum(&mut sums);
    let work: Vec<f64> = sums.iter().skip(1).step_by(2).copied().collect();
    let rank_of = at_nodes.ranks(comm, &work)?;
    let mut list = PieceList { firsts: vec![0], of_label: vec![0; work.len()] };
    for rank in 0..ranks {
        let (mut piece, mut size) = (list.firsts[rank as usize], 0.0);
        for label in (0..work.len()).filter(|label| rank_of[*label] == rank) {
            if size >= PIECE {
                (piece, size) = (piece + 1, 0.0);
            }
            list.of_label[label] = piece;
            size += sums[2 * label];
        }
        list.firsts.push(piece + 1);
    }
    let at_nodes = at_nodes.renamed(&list.of_label);
    Ok((labels, list, at_nodes))
}

/// The cells behind surfaces and interfaces of all ranks. Collective.
fn skeleton(
    comm: &Comm,
    head: &Head,
    request: &Request,
    held: &Held,
    homes: &super::homes::Homes,
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

/// The bodies of own cells before cutting, and how many there are. Collective.
fn bodies_before(comm: &Comm, held: &Held, work: &Work) -> Result<(Vec<u32>, usize)> {
    let place = |name: &u32| work.names.place(*name).unwrap_or_default() as u32;
    let add = |cell: usize, nodes: &mut Vec<u32>| nodes.extend(held.cell(cell).1.iter().map(place));
    let (of_cells, count) = bodies(work.names.len(), held.cells.len(), add);
    let homes = even_homes(comm, comm.max_u64(1 + work.names.iter().max().map_or(0, u64::from)));
    let mut of_nodes = vec![u32::MAX; work.names.len()];
    for (cell, body) in of_cells.iter().enumerate() {
        held.cell(cell).1.iter().for_each(|name| of_nodes[place(name) as usize] = *body);
    }
    let nodes = work.names.iter().zip(of_nodes).filter(|(_, body)| *body != u32::MAX);
    all_bodies(comm, &homes, nodes, of_cells, count, &held.cells)
}

/// Bodies of all ranks in the place of those of this one. Collective.
fn all_bodies(
    comm: &Comm,
    homes: &super::homes::Homes,
    nodes: impl Iterator<Item = (u32, u32)>,
    mut of_cells: Vec<u32>,
    count: usize,
    cells: &[u64],
) -> Result<(Vec<u32>, usize)> {
    let mut first_cells = vec![u32::MAX; count];
    for (body, cell) in of_cells.iter().zip(cells) {
        let first = &mut first_cells[*body as usize];
        *first = (*first).min(*cell as u32);
    }
    let (names, count) = merge(comm, homes, nodes, &first_cells)?;
    of_cells.iter_mut().for_each(|body| *body = names[*body as usize]);
    Ok((of_cells, count))
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

/// The materials of own cells.
fn materials(head: &Head, request: &Request, held: &Held) -> Result<Vec<u32>> {
    let of_sets = head.materials(request)?;
    let wrong = || Error::Input("cells are in no material, or in several".into());
    held.sets.iter().map(|set| of_sets[*set as usize].ok_or_else(wrong)).collect()
}

/// What is needed to finish.
struct Finish<'f> {
    comm: &'f Comm,
    head: &'f Head,
    shapes: &'f [Shape],
    naming: &'f Naming,
    /// Names of the new nodes.
    names: &'f [u32],
}

impl Finish<'_> {
    /// The name and the position (m) of a node of an own cell by what stands for it.
    fn node(&self, work: &Work, word: u32) -> (u32, [f64; 3]) {
        match fresh_place(word) {
            Some(place) => (self.names[place], work.fresh[place].point),
            None => (word, work.points[work.names.place(word).unwrap_or_default()]),
        }
    }

    /// What stands for the nodes of an own cell.
    fn words<'w>(&self, held: &'w Held, work: &'w Work, start: &[u32], cell: usize) -> &'w [u32] {
        let range = start[cell] as usize..start[cell + 1] as usize;
        &work.nodes.as_ref().unwrap_or(&held.nodes)[range]
    }

    /// The cells of a skeleton after cutting. Collective.
    fn cut(
        &self,
        held: &Held,
        work: &Work,
        names: &[u32],
        start: &[u32],
        materials: &[u32],
    ) -> Result<Cut> {
        let mut own = Vec::new();
        for name in names {
            let Ok(cell) = held.cells.binary_search(&u64::from(*name)) else { continue };
            let nodes = self.words(held, work, start, cell).iter();
            let nodes: Vec<(u32, [f64; 3])> = nodes.map(|word| self.node(work, *word)).collect();
            own.push((*name, materials[cell], nodes));
        }
        let mut all: Vec<(u32, u32, Vec<(u32, [f64; 3])>)> = joined(self.comm, &own)?;
        all.sort_unstable_by_key(|cell| cell.0);
        Ok(Cut {
            dim: self.head.dim,
            nodes: all.iter().flat_map(|cell| &cell.2).map(|node| node.0).collect(),
            points: all.iter().flat_map(|cell| &cell.2).map(|node| node.1).collect(),
            first: self.naming.uncut() as u32,
            origins: self.naming.origins.clone(),
            materials: all.iter().map(|cell| cell.1).collect(),
        })
    }

    /// Refuses bodies that touch where their meshes do not match. Collective.
    fn touching(
        &self,
        held: &Held,
        work: &Work,
        start: &[u32],
        (bodies, between): (&[u32], &[(u32, u8)]),
        is_raised: bool,
    ) -> Result<()> {
        let mut cells: Vec<u32> = work.boundary.iter().map(|facet| facet.0).collect();
        cells.sort_unstable();
        cells.dedup();
        let mut own = Vec::new();
        for name in cells {
            let Ok(cell) = held.cells.binary_search(&u64::from(name)) else { continue };
            let nodes = self.words(held, work, start, cell).iter();
            let nodes = nodes.map(|word| {
                let (name, point) = self.node(work, *word);
                (self.naming.before(name), point)
            });
            own.push((name, bodies[cell], nodes.collect::<Vec<(u32, [f64; 3])>>()));
        }
        let mut all = joined(self.comm, &own)?;
        let facets = joined(self.comm, &work.boundary)?;
        all.sort_unstable_by_key(|cell: &(u32, u32, Vec<(u32, [f64; 3])>)| cell.0);
        let local = if self.comm.is_root() {
            let skin = Skin {
                cells: all.iter().map(|cell| (cell.0, cell.1)).collect(),
                nodes: all.iter().flat_map(|cell| &cell.2).map(|node| node.0).collect(),
                points: all.iter().flat_map(|cell| &cell.2).map(|node| node.1).collect(),
                facets,
            };
            skin.check(self.head, is_raised, between)
        } else {
            Ok(())
        };
        self.comm.agree(local)
    }

    /// The cells of this rank with their nodes by place, and how many bodies there are. Collective.
    fn part(
        &self,
        held: Held,
        work: Work,
        start: Vec<u32>,
        materials: Vec<u32>,
        known: Option<(Vec<u32>, usize)>,
    ) -> Result<(Part, usize)> {
        let Work { names, points, nodes, fresh, .. } = work;
        let Held { cells, nodes: of_file, .. } = held;
        let mut connectivity = nodes.unwrap_or(of_file);
        let total = self.naming.total();
        let name = |word: u32| fresh_place(word).map_or(word, |place| self.names[place]);
        let used = Numbers::of(0, total, connectivity.iter().map(|word| name(*word)));
        let mut places = Places {
            names: used.iter().map(u64::from).collect(),
            points: vec![[0.0; 3]; used.len()],
            marks: Vec::new(),
        };
        for (name, point) in names.iter().zip(points) {
            if let Some(place) = used.place(name) {
                places.points[place] = point;
            }
        }
        for (name, fresh) in self.names.iter().zip(fresh) {
            if let Some(place) = used.place(*name) {
                places.points[place] = fresh.point;
            }
        }
        let place = |word: u32| used.place(name(word)).unwrap_or_default() as u32;
        connectivity.iter_mut().for_each(|word| *word = place(*word));
        drop(used);
        let add = |cell: usize, nodes: &mut Vec<u32>| {
            nodes.extend_from_slice(&connectivity[start[cell] as usize..start[cell + 1] as usize]);
        };
        let tell = |of_cells: &[u32]| {
            let mut of_nodes = vec![0; places.names.len()];
            for (cell, body) in of_cells.iter().enumerate() {
                let range = start[cell] as usize..start[cell + 1] as usize;
                connectivity[range].iter().for_each(|node| of_nodes[*node as usize] = *body);
            }
            of_nodes
        };
        let (of_cells, count) = match known {
            Some(known) => known,
            None => {
                let (of_cells, count) = bodies(places.names.len(), cells.len(), add);
                let nodes = places.names.iter().map(|name| *name as u32).zip(tell(&of_cells));
                let homes = even_homes(self.comm, total);
                all_bodies(self.comm, &homes, nodes, of_cells, count, &cells)?
            }
        };
        let of_nodes = tell(&of_cells);
        let shape = |cell: &u64| self.shapes[self.head.kind_place(*cell as u32)];
        let shapes = cells.iter().map(shape).collect();
        let part =
            Part { cells, shapes, materials, nodes: places, start, connectivity, bodies: of_nodes };
        Ok((part, count))
    }

    /// What is known of the mesh; tells the bodies of the cells behind surfaces. Collective.
    fn facts(
        &self,
        case: &Case,
        part: &Part,
        star: &mut Star,
        body_count: usize,
    ) -> Result<MeshFacts> {
        let mut own = Vec::new();
        for name in &star.cells {
            if let Ok(cell) = part.cells.binary_search(&u64::from(*name)) {
                let node = part.connectivity[part.start[cell] as usize];
                own.push((*name, part.bodies[node as usize]));
            }
        }
        let mut all: Vec<(u32, u32)> = joined(self.comm, &own)?;
        all.sort_unstable();
        star.mesh.bodies = all.into_iter().map(|(_, body)| body).collect();
        star.mesh.body_count = body_count;
        let total = self.naming.total();
        let mut is_corner = vec![false; part.nodes.names.len()];
        for (cell, shape) in part.shapes.iter().enumerate() {
            let corners =
                &part.connectivity[part.start[cell] as usize..][..shape.corners().nodes()];
            corners.iter().for_each(|node| is_corner[*node as usize] = true);
        }
        let corners = part.nodes.names.iter().zip(is_corner).filter(|(_, is)| *is);
        let corners = corners.map(|(name, _)| *name as u32);
        let corners = count(self.comm, &even_homes(self.comm, total), corners);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in &part.nodes.points {
            for i in 0..3 {
                (low[i], high[i]) = (low[i].min(point[i]), high[i].max(point[i]));
            }
        }
        self.comm.min(&mut low);
        self.comm.max(&mut high);
        let counts = self.head.kinds.iter().map(|range| u64::from(range.count));
        let shapes: Vec<(Shape, u64)> = self.shapes.iter().copied().zip(counts).collect();
        let digest = digest(self.comm, part, star, total, &shapes);
        let dim = self.head.dim;
        let of_lips = star.mesh.facts();
        Ok(MeshFacts {
            origin: low,
            size: std::array::from_fn(|i| high[i] - low[i]),
            bodies: body_count,
            cells: self.head.cells(),
            coarser: Vec::new(),
            nodes: total,
            corners,
            order: self.shapes.iter().map(|shape| shape.order()).max().unwrap_or(1),
            nodes_per_cell: self.shapes.iter().map(|shape| shape.nodes()).max().unwrap_or(8),
            section: (total as f64).powf((dim as f64 - 1.0) / dim as f64),
            digest,
            names: case.interfaces.iter().map(|interface| interface.name.clone()).collect(),
            ..of_lips
        })
    }
}
