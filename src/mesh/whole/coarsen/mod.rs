//! Coarser meshes of one from a file, before it is cut, as levels for multigrid.
//!
//! Meshes of quadrilaterals or hexahedra that were made in layers or by halving have coarser ones,
//! whatever their shape and the numbers of their nodes: eight cells (in the plane four) around a
//! node become one. Where layers are odd in number, the last one stays as it is. Walls, across
//! which no cells are joined, are elements of groups and changes of groups.

mod below;
mod bits;
mod directions;
mod families;
mod kept;

use below::Parts;
use bits::Side;
use directions::Directions;
use families::{Family, Joiner, only_shape};
use kept::{Cubes, UNKNOWN};

use super::cells::{Cells, NONE};
use super::facets::{FacetTable, of_slot, slot};
use super::named::Named;
use super::refine::{Parent, kind_of};
use crate::mesh::import::{Block, FileMesh, Kind};

/// A coarser mesh.
pub struct Coarser {
    /// What it has beside its cells; positions in metres.
    pub file: FileMesh,
    pub cells: Cells,
    /// Where each cell of the finer mesh lies in it.
    pub parents: Vec<Parent>,
}

/// A mesh is coarser if it has at most this part of the cells.
const FEWER: f64 = 0.6;

/// The mesh of the cells of first order with the same corners.
pub fn of_first_order(file: &FileMesh, cells: &Cells) -> Coarser {
    let view = cells.view();
    let mut is_kept = vec![false; cells.points.len()];
    let mut corners = Cells { start: vec![0], ..Cells::default() };
    for (cell, shape) in cells.shapes.iter().enumerate() {
        let shape = shape.corners();
        let nodes = &view.cell_nodes(cell)[..shape.nodes()];
        nodes.iter().for_each(|node| is_kept[*node as usize] = true);
        corners.nodes.extend(nodes);
        corners.start.push(corners.nodes.len() as u32);
        corners.shapes.push(shape);
        corners.kinds.push(kind_of(shape));
    }
    (corners.numbers, corners.sets) = (cells.numbers.clone(), cells.sets.clone());
    let named = Named::new(file, cells);
    let below = named.below.iter().map(|block| {
        let kind = of_corners(block.kind);
        let elements = block.nodes.chunks(block.kind.nodes());
        let nodes = elements.flat_map(|element| &element[..kind.nodes()]).copied().collect();
        Block { kind, nodes, numbers: block.numbers.clone(), groups: block.groups.clone() }
    });
    let below: Vec<Block> = below.collect();
    let places = std::array::from_fn(|corner| corner as u8);
    let parents = (0..cells.shapes.len() as u32).map(|cell| Parent { cell, corners: places });
    let parents = parents.collect();
    renumbered(cells, corners, &is_kept, &named, below, parents)
}

/// The next coarser mesh of cells all of which are quadrilaterals or all hexahedra, of first order,
/// where there is one.
///
/// # Arguments
/// * `table` and `mates` of the facets of the cells
pub fn coarser(
    file: &FileMesh,
    cells: &Cells,
    table: &FacetTable,
    mates: &[u32],
) -> Option<Coarser> {
    let shape = only_shape(&cells.shapes)?;
    let named = Named::new(file, cells);
    let is_wall = walls(cells, &named, table, mates);
    let sides = Side::of_facets(shape);
    let mut cubes = Cubes { view: cells.view(), mates, is_wall, long: Vec::new(), shape, sides };
    let bodies = bodies(&cubes);
    keep_long_layers(&mut cubes, &bodies)?;
    let families = families(&cubes, bodies)?;
    if families.len() as f64 > FEWER * cells.shapes.len() as f64 {
        return None;
    }
    let mut is_kept = vec![false; cells.points.len()];
    let mut parents = vec![Parent { cell: NONE, corners: [0; 8] }; cells.shapes.len()];
    let mut place = vec![(NONE, 0); cells.shapes.len()];
    let mut coarse = Cells { start: vec![0], ..Cells::default() };
    for (number, family) in families.iter().enumerate() {
        let first = family.children[0].cell as usize;
        let corners = &family.corners[..shape.nodes()];
        corners.iter().for_each(|node| is_kept[*node as usize] = true);
        coarse.nodes.extend(corners);
        coarse.start.push(coarse.nodes.len() as u32);
        coarse.shapes.push(shape);
        coarse.kinds.push(kind_of(shape));
        coarse.numbers.push(cells.numbers[first]);
        coarse.sets.push(cells.sets[first]);
        for (index, child) in family.children.iter().enumerate() {
            parents[child.cell as usize] = Parent { cell: number as u32, corners: child.places };
            place[child.cell as usize] = (number as u32, index as u8);
        }
    }
    let parts = Parts { cells, table, families: &families, place: &place, shape };
    let below = below::coarsen(&named.below, &parts);
    Some(renumbered(cells, coarse, &is_kept, &named, below, parents))
}

/// A mesh of cells that are given by nodes of the finer one, of which it keeps some. So are its
/// other elements, `below`: those without one of their nodes go.
fn renumbered(
    fine: &Cells,
    mut cells: Cells,
    is_kept: &[bool],
    named: &Named,
    below: Vec<Block>,
    parents: Vec<Parent>,
) -> Coarser {
    let mut number = vec![NONE; is_kept.len()];
    for (node, _) in is_kept.iter().enumerate().filter(|(_, is_kept)| **is_kept) {
        number[node] = cells.points.len() as u32;
        cells.points.push(fine.points[node]);
    }
    cells.nodes.iter_mut().for_each(|node| *node = number[*node as usize]);
    cells.names = (0..cells.points.len() as u32).collect();
    cells.group_sets.clone_from(&fine.group_sets);
    let below = below.iter().map(|block| kept(block, &number)).collect();
    let file = named.renumbered(below, &number).file(&cells);
    Coarser { file, cells, parents }
}

/// The elements all of whose nodes `number` gives a new number. Of cells of second order those that
/// were in the middle of an edge have none, and points may lie there.
fn kept(block: &Block, number: &[u32]) -> Block {
    let mut kept =
        Block { kind: block.kind, nodes: Vec::new(), numbers: Vec::new(), groups: Vec::new() };
    for (index, element) in block.nodes.chunks(block.kind.nodes()).enumerate() {
        let nodes = element.iter().map(|node| number[*node as usize]);
        if nodes.clone().all(|node| node != NONE) {
            kept.nodes.extend(nodes);
            kept.numbers.push(block.numbers[index]);
            kept.groups.push(block.groups[index]);
        }
    }
    kept
}

/// For each place of a facet whether cells on both its sides are never joined.
fn walls(cells: &Cells, named: &Named, table: &FacetTable, mates: &[u32]) -> Vec<bool> {
    let groups_of = |set: u32| &cells.group_sets[set as usize];
    let mut is_wall = vec![false; mates.len()];
    for (place, mate) in mates.iter().enumerate().filter(|(_, mate)| **mate != NONE) {
        let [one, other] = [place as u32, *mate].map(|s| cells.sets[of_slot(s).cell as usize]);
        is_wall[place] = one != other && groups_of(one) != groups_of(other);
    }
    for block in named.below.iter().filter(|block| block.kind.dim() + 1 == cells.dim()) {
        let corners = of_corners(block.kind).nodes();
        for (element, set) in block.nodes.chunks(block.kind.nodes()).zip(&block.groups) {
            if !groups_of(*set).is_empty() {
                let found = table.find(element[..corners].iter().copied());
                found.for_each(|facet| is_wall[slot(facet)] = true);
            }
        }
    }
    is_wall
}

/// The cells that hang together by facets.
fn bodies(cubes: &Cubes) -> Vec<Vec<u32>> {
    let mut seen = vec![false; cubes.view.shapes.len()];
    let mut bodies = Vec::new();
    for first in 0..seen.len() {
        if !seen[first] {
            bodies.push(cubes.connected(first as u32, &mut seen));
        }
    }
    bodies
}

/// The axes along which cells are not joined, which get walls; none where too many cells would
/// become long.
fn keep_long_layers(cubes: &mut Cubes, bodies: &[Vec<u32>]) -> Option<()> {
    let mut directions = Directions::new(cubes);
    let mut long = vec![0; cubes.view.shapes.len()];
    if !bodies.iter().all(|body| directions.find_long(cubes, body, &mut long)) {
        return None;
    }
    for (cell, axes) in long.iter().enumerate() {
        for facet in cubes.view.facets(cell) {
            let axis = cubes.sides[facet.facet as usize].axis;
            cubes.is_wall[slot(facet)] |= axes >> axis & 1 == 1;
        }
    }
    cubes.long = long;
    Some(())
}

/// The coarser cells, with as few of them as can be.
fn families(cubes: &Cubes, bodies: Vec<Vec<u32>>) -> Option<Vec<Family>> {
    let count = cubes.view.shapes.len();
    let mut uses = vec![0_u8; cubes.view.points.len()];
    for node in cubes.view.nodes {
        uses[*node as usize] = uses[*node as usize].saturating_add(1);
    }
    let mut is_joined = vec![false; count];
    let mut kept = vec![UNKNOWN; count];
    let mut joiner = Joiner::new(cubes);
    let mut all = Vec::new();
    for mut cells in bodies {
        // A corner of the body, most often.
        let lone =
            |cell: u32| (0..=cubes.full()).find(|c| uses[cubes.node(cell, *c) as usize] == 1);
        let corner = cells.iter().enumerate().find_map(|(i, cell)| Some((i, lone(*cell)?)));
        let (start, of_first) = corner.unwrap_or((0, 0));
        cells.swap(0, start);
        let mut best: Option<Vec<Family>> = None;
        for turn in 0..=cubes.full() {
            if !cubes.spread(&cells, of_first ^ turn, &mut kept) {
                continue;
            }
            let Some(found) = joiner.join(&cells, &kept, &mut is_joined) else { continue };
            let is_full = found.len() * (cubes.full() + 1) == cells.len();
            if best.as_ref().is_none_or(|best| found.len() < best.len()) {
                best = Some(found);
            }
            if is_full {
                break;
            }
        }
        all.append(&mut best?);
    }
    Some(all)
}

/// The kind of elements, no cells in space, with the same corners and no other nodes.
fn of_corners(kind: Kind) -> Kind {
    match kind {
        Kind::Line3 => Kind::Line2,
        Kind::Tri6 => Kind::Tri3,
        Kind::Quad8 | Kind::Quad9 => Kind::Quad4,
        other => other,
    }
}
