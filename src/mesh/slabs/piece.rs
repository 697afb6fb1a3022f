//! Some cells of a mesh with all cells that share a node with them: raised, checked and cut as the
//! whole mesh is.
//!
//! Nodes and cells rise as they do in the whole mesh, and every node of a cell that is asked for
//! has all its cells here. What is decided there comes out the same.

use super::head::Head;
use super::key::{self, Key};
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::mesh::whole::{
    Cells, Copies, FacetTable, Middles, NO_MATE, WholeFacet, are_pinched, check_copies,
    check_jacobians, cut, lay_along_axes, middles, raise, shortest_edges, slot,
};

/// A cell that is given to a piece.
#[derive(Debug, Clone, Copy)]
pub struct Given<'c> {
    /// Its name.
    pub name: u32,
    /// The names of its nodes in the file.
    pub nodes: &'c [u32],
    /// Whether it is asked for, and not only beside one that is.
    pub is_own: bool,
}

/// What has become of the cells that were asked for.
#[derive(Debug, Default)]
pub struct Made {
    /// The nodes of one cell after the other, as places in `keys`.
    pub nodes: Vec<u32>,
    /// The keys of all nodes of the piece.
    pub keys: Vec<Key>,
    /// Their positions (m).
    pub points: Vec<[f64; 3]>,
    /// The shortest edge (m) at each node that was there before cutting.
    pub shortest: Vec<f64>,
    /// The facets on the boundary of the mesh before cutting, by names of cells.
    pub boundary: Vec<(u32, u8)>,
    /// Of nodes of the file: how many new nodes in edges and in faces have it as lowest corner.
    pub counts: Vec<(u32, [u32; 2])>,
    /// Nodes that were split, and how many copies they got.
    pub splits: Vec<(Key, u32)>,
}

/// Makes a piece of cells that rise.
///
/// # Arguments
/// * `point` (m) of a node of the file
/// * `cuts`: the facets along which the mesh is cut, of any cells, rising
///
/// # Errors
/// `Input` for what is wrong with the cells, in the words of the whole mesh, with counts of the
/// piece; and for cells that share a node, but no facets there.
pub fn piece(
    head: &Head,
    given: &[Given<'_>],
    point: &dyn Fn(u32) -> [f64; 3],
    is_raised: bool,
    cuts: &[(u32, u8)],
) -> Result<Made> {
    let mut names: Vec<u32> = given.iter().flat_map(|cell| cell.nodes).copied().collect();
    names.sort_unstable();
    names.dedup();
    let mut cells = cells_of(head, given, &names, point);
    check_copies(&mut cells)?;
    raise(&mut cells, is_raised.then_some(2), &mut Vec::new())?;
    lay_along_axes(&mut cells);
    let own = || (0..given.len()).filter(|cell| given[*cell].is_own);
    check_jacobians(&cells, own())?;
    let table = FacetTable::new(cells.view());
    let mut mates = table.mates(&cells)?;
    drop(table);
    let mut made = Made { shortest: shortest_edges(&cells), ..Made::default() };
    let outer = own().flat_map(|cell| cells.view().facets(cell));
    let outer = outer.filter(|facet| mates[slot(*facet)] == NO_MATE);
    made.boundary = outer.map(|facet| (given[facet.cell as usize].name, facet.facet)).collect();
    let fresh = fresh_nodes(&cells, names.len(), given);
    let cuts = cuts_of(given, cuts);
    let copies =
        if cuts.is_empty() { Copies::none(&cells) } else { cut(&mut cells, &mut mates, &cuts) };
    let mut is_own = vec![false; cells.points.len()];
    for cell in own() {
        cells.view().cell_nodes(cell).iter().for_each(|node| is_own[*node as usize] = true);
        made.nodes.extend_from_slice(cells.view().cell_nodes(cell));
    }
    if are_pinched(&cells, &mates, &|node| is_own[node as usize]) {
        return Err(Error::Input(
            "some of its cells hang on others by nodes or edges alone".into(),
        ));
    }
    // A node whose first sector lies beside the cells that are asked for is theirs all the same.
    for copy in copies.base()..cells.points.len() as u32 {
        is_own[copies.origin(copy) as usize] |= is_own[copy as usize];
    }
    made.keys = keys(&names, &fresh, &copies, cells.points.len());
    made.counts = counts(&names, &fresh, &is_own);
    made.splits = splits(&made.keys, &copies, &is_own);
    made.points = cells.points;
    Ok(made)
}

/// The cells with their nodes by place.
fn cells_of(
    head: &Head,
    given: &[Given<'_>],
    names: &[u32],
    point: &dyn Fn(u32) -> [f64; 3],
) -> Cells {
    let mut cells = Cells { start: vec![0], ..Cells::default() };
    let place = |name: &u32| names.binary_search(name).unwrap_or_default() as u32;
    for cell in given {
        cells.kinds.push(head.kind(cell.name));
        cells.numbers.push(u64::from(cell.name));
        cells.nodes.extend(cell.nodes.iter().map(place));
        cells.start.push(cells.nodes.len() as u32);
    }
    cells.sets = vec![0; given.len()];
    cells.group_sets = vec![Vec::new()];
    cells.points = names.iter().map(|name| point(*name)).collect();
    cells
}

/// The facets to cut that have both sides here.
fn cuts_of(given: &[Given<'_>], cuts: &[(u32, u8)]) -> Vec<WholeFacet> {
    let mut found = Vec::new();
    if cuts.is_empty() {
        return found;
    }
    for (cell, given) in (0..).zip(given) {
        let from = cuts.partition_point(|(name, _)| *name < given.name);
        let of_cell = cuts[from..].iter().take_while(|(name, _)| *name == given.name);
        found.extend(of_cell.map(|(_, facet)| WholeFacet { cell, facet: *facet }));
    }
    found
}

/// The lowest corner of each new node (of one in a cell the cell's name), and what it is in.
fn fresh_nodes(cells: &Cells, plain: usize, given: &[Given<'_>]) -> Vec<(u64, u32)> {
    let mut found = vec![(0, 0); cells.points.len() - plain];
    if found.is_empty() {
        return found;
    }
    let of_shapes: Vec<Middles> = Shape::ALL.iter().map(|shape| middles(*shape)).collect();
    let view = cells.view();
    for (cell, shape) in cells.shapes.iter().enumerate() {
        let (nodes, of_shape) = (view.cell_nodes(cell), &of_shapes[*shape as usize]);
        let lowest = |corners: &[usize]| corners.iter().map(|c| nodes[*c]).min().unwrap_or(0);
        let mut tell = |local: usize, kind: u64, base: u32| {
            if let Some(place) = (nodes[local] as usize).checked_sub(plain) {
                found[place] = (kind, base);
            }
        };
        of_shape.edges.iter().for_each(|(node, ends)| tell(*node, key::EDGE, lowest(ends)));
        of_shape.faces.iter().for_each(|(node, four)| tell(*node, key::FACE, lowest(four)));
        of_shape.centre.iter().for_each(|node| tell(*node, key::CENTRE, given[cell].name));
    }
    found
}

/// The keys of all nodes.
fn keys(names: &[u32], fresh: &[(u64, u32)], copies: &Copies, count: usize) -> Vec<Key> {
    let mut keys: Vec<Key> = names.iter().map(|name| Key::plain(*name)).collect();
    let mut place = 0;
    for (index, (kind, base)) in fresh.iter().enumerate() {
        place = if index > 0 && fresh[index - 1] == (*kind, *base) { place + 1 } else { 0 };
        let base = if *kind == key::CENTRE { *base } else { names[*base as usize] };
        keys.push(Key::fresh(*kind, base, place));
    }
    let mut sector = 0;
    for copy in copies.base()..count as u32 {
        let origin = copies.origin(copy);
        let is_next = copy > copies.base() && copies.origin(copy - 1) == origin;
        sector = if is_next { sector + 1 } else { 1 };
        keys.push(keys[origin as usize].copy(sector));
    }
    keys
}

/// How many new nodes have each node of the cells asked for as lowest corner.
fn counts(names: &[u32], fresh: &[(u64, u32)], is_own: &[bool]) -> Vec<(u32, [u32; 2])> {
    if fresh.is_empty() {
        return Vec::new();
    }
    let mut counts = vec![[0, 0]; names.len()];
    for (kind, base) in fresh.iter().filter(|(kind, _)| *kind != key::CENTRE) {
        counts[*base as usize][usize::from(*kind == key::FACE)] += 1;
    }
    let of_node = names.iter().copied().zip(counts).zip(is_own);
    of_node
        .filter(|((_, counts), is_own)| **is_own && *counts != [0, 0])
        .map(|(of, _)| of)
        .collect()
}

fn splits(keys: &[Key], copies: &Copies, is_own: &[bool]) -> Vec<(Key, u32)> {
    let all: Vec<u32> =
        (copies.base()..keys.len() as u32).map(|copy| copies.origin(copy)).collect();
    let runs = all.chunk_by(|a, b| a == b).filter(|run| is_own[run[0] as usize]);
    runs.map(|run| (keys[run[0] as usize], run.len() as u32)).collect()
}
