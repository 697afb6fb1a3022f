//! The cells of a file: those of the highest dimension, without copies, with the nodes they use.

use super::buckets::{Buckets, Entry, split};
use super::facet::WholeFacet;
use super::view::View;
use super::words::{count, place, wrong};
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::import::{FileMesh, Kind};

/// Stands for no node, cell or facet.
pub const NONE: u32 = u32::MAX;

/// How far nodes of a plane mesh may be off the plane, against its size.
const FLAT: f64 = 1e-9;

/// The cells as they are worked on.
#[derive(Debug, Clone, Default)]
pub struct Cells {
    /// Positions (m).
    pub points: Vec<[f64; 3]>,
    /// Kind of each cell in the file.
    pub kinds: Vec<Kind>,
    /// Its shape, once it is raised.
    pub shapes: Vec<Shape>,
    pub start: Vec<u32>,
    pub nodes: Vec<u32>,
    /// Number of each cell in the file.
    pub numbers: Vec<u64>,
    /// Set of groups of each cell.
    pub sets: Vec<u32>,
    /// The groups of each set.
    pub group_sets: Vec<Vec<u32>>,
    /// The node of each point of the file, or [`NONE`].
    pub names: Vec<u32>,
    /// Middle nodes by the ends of their edges, rising, where cells were raised.
    pub edges: Vec<([u32; 2], u32)>,
}

impl Cells {
    pub fn view(&self) -> View<'_> {
        View { points: &self.points, shapes: &self.shapes, start: &self.start, nodes: &self.nodes }
    }

    /// 2 or 3.
    pub fn dim(&self) -> usize {
        self.kinds.first().map_or(3, |kind| kind.dim())
    }

    /// A cell in words: kind, number in the file, place.
    pub fn describe(&self, cell: usize) -> String {
        let at = place(self.view().cell_centre(cell));
        format!("the {} number {} at {at}", self.kinds[cell].name(), self.numbers[cell])
    }

    /// A facet in words.
    pub fn describe_facet(&self, facet: WholeFacet) -> String {
        let at = place(self.view().facet_centre(facet));
        format!("the facet at {at} of element {}", self.numbers[facet.cell as usize])
    }
}

/// Takes the cells out of a file.
///
/// # Errors
/// `Input` if there are no cells, they fill neither the plane z = 0 nor space, a cell has a node
/// twice, or two cells have the same nodes and are not one cell in two groups.
pub fn collect(file: &FileMesh, scale: f64, remarks: &mut Vec<String>) -> Result<Cells> {
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(wrong(format!("`scale` is {scale}; it is a positive number of metres")));
    }
    let filled = file.blocks.iter().filter(|block| !block.numbers.is_empty());
    let dim = filled.map(|block| block.kind.dim()).max().unwrap_or(0);
    if dim < 2 {
        return Err(wrong(
            "there are no cells in it, only points and lines; mesh the surfaces (2D) or the \
             volumes, and write them too"
                .into(),
        ));
    }
    let of_cells = file.blocks.iter().filter(|block| block.kind.dim() == dim);
    check_size(of_cells.clone().map(|block| block.nodes.len()).sum())?;
    let mut cells = Cells { start: vec![0], ..Cells::default() };
    cells.group_sets.clone_from(&file.group_sets);
    for block in of_cells {
        cells.kinds.extend(block.numbers.iter().map(|_| block.kind));
        cells.numbers.extend(&block.numbers);
        cells.sets.extend(&block.groups);
        cells.nodes.extend(&block.nodes);
        for _ in &block.numbers {
            cells.start.push(cells.start.last().map_or(0, |end| end + block.kind.nodes() as u32));
        }
    }
    name_nodes(file, scale, &mut cells, remarks);
    if dim == 2 {
        flatten(&mut cells)?;
    }
    join_copies(&mut cells)?;
    Ok(cells)
}

/// Refuses connectivity that the 32-bit numbers of a graph of cells cannot count.
pub fn check_size(connectivity: usize) -> Result<()> {
    if i32::try_from(connectivity).is_ok() {
        return Ok(());
    }
    Err(wrong(format!(
        "its cells have {connectivity} nodes together; more than {} cannot be read: give a coarser \
         mesh",
        i32::MAX
    )))
}

/// Numbers the points that cells use.
fn name_nodes(file: &FileMesh, scale: f64, cells: &mut Cells, remarks: &mut Vec<String>) {
    let mut names = vec![NONE; file.points.len()];
    cells.nodes.iter().for_each(|node| names[*node as usize] = 0);
    for (name, point) in names.iter_mut().zip(&file.points) {
        if *name != NONE {
            *name = cells.points.len() as u32;
            cells.points.push(point.map(|x| x * scale));
        }
    }
    cells.nodes.iter_mut().for_each(|node| *node = names[*node as usize]);
    remarks.extend(orphans_of_cells(names.len() - cells.points.len()));
    cells.names = names;
}

/// What is to be said of so many nodes of no cell.
pub fn orphans_of_cells(orphans: usize) -> Option<String> {
    (orphans > 0).then(|| format!("nodes of no cell, left out: {orphans}"))
}

/// Checks that a mesh of surfaces lies in the plane z = 0.
fn flatten(cells: &mut Cells) -> Result<()> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in &cells.points {
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(point[i]), high[i].max(point[i]));
        }
    }
    check_plane(low, high)?;
    cells.points.iter_mut().for_each(|point| point[2] = 0.0);
    Ok(())
}

/// Checks that points with these least and largest coordinates (m) lie in the plane z = 0.
///
/// # Errors
/// `Input` if they do not.
pub fn check_plane(low: [f64; 3], high: [f64; 3]) -> Result<()> {
    let size = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
    if low[2].abs().max(high[2].abs()) <= FLAT * size {
        return Ok(());
    }
    Err(wrong(if high[2] - low[2] <= FLAT * size {
        format!("its cells lie in the plane z = {} m; move them to z = 0", low[2])
    } else {
        format!(
            "its cells are surfaces, and z runs from {} to {} m; a mesh of surfaces lies in the \
             plane z = 0 (turn it), and a body in space has to be meshed with volumes",
            low[2], high[2]
        )
    }))
}

/// Joins cells that are one in several groups, and refuses other copies.
fn join_copies(cells: &mut Cells) -> Result<()> {
    // No kind has more than 8 corners.
    let things = || {
        (0..cells.kinds.len()).map(|cell| {
            let (first, rest) = split::<7>(corners(cells, cell).iter().copied());
            (first, Entry { rest, id: cell as u32 })
        })
    };
    let buckets = Buckets::new(cells.points.len(), things);
    let mut copies = Vec::new();
    let mut joined = Vec::new();
    for (first, run) in buckets.runs() {
        let mut nodes = [first; 8];
        nodes[1..].copy_from_slice(&run[0].rest);
        if nodes.windows(2).any(|pair| pair[0] == pair[1] && pair[0] != NONE) {
            return Err(wrong(format!(
                "{} has a node twice; mesh it with cells of another kind",
                describe(cells, run[0].id as usize)
            )));
        }
        if run.len() > 1 {
            let ids: Vec<usize> = run.iter().map(|entry| entry.id as usize).collect();
            joined.push((ids[0], joint_set(cells, &ids)?));
            copies.extend_from_slice(&ids[1..]);
        }
    }
    for (cell, set) in joined {
        cells.sets[cell] = cells.group_sets.len() as u32;
        cells.group_sets.push(set);
    }
    drop_cells(cells, copies);
    Ok(())
}

/// Refuses cells with a node twice, and cells that are there twice.
///
/// # Errors
/// `Input` with the first of them.
pub fn check_copies(cells: &mut Cells) -> Result<()> {
    let before = cells.kinds.len();
    let twice = || wrong("cells stand in it once for each of their groups".into());
    join_copies(cells).map_err(|_| twice())?;
    if cells.kinds.len() == before { Ok(()) } else { Err(twice()) }
}

/// The groups of all copies of a cell.
fn joint_set(cells: &Cells, copies: &[usize]) -> Result<Vec<u32>> {
    let nodes =
        |cell: usize| &cells.nodes[cells.start[cell] as usize..][..cells.kinds[cell].nodes()];
    let sets = copies.iter().map(|cell| &cells.group_sets[cells.sets[*cell] as usize]);
    let are_grouped = sets.clone().all(|set| !set.is_empty());
    let mut set: Vec<u32> = sets.flatten().copied().collect();
    set.sort_unstable();
    let are_distinct = set.windows(2).all(|pair| pair[0] != pair[1]);
    let are_alike = copies.iter().all(|copy| nodes(*copy) == nodes(copies[0]));
    if are_grouped && are_distinct && are_alike {
        return Ok(set);
    }
    let why = if are_alike { "are the same cell" } else { "have the same corners" };
    Err(wrong(format!(
        "elements {} and {} {why}: {}; leave one out",
        cells.numbers[copies[0]],
        cells.numbers[copies[1]],
        describe(cells, copies[0])
    )))
}

/// Takes out some cells.
fn drop_cells(cells: &mut Cells, mut dropped: Vec<usize>) {
    if dropped.is_empty() {
        return;
    }
    dropped.sort_unstable();
    let mut kept = Cells { start: vec![0], ..Cells::default() };
    for cell in (0..cells.kinds.len()).filter(|cell| dropped.binary_search(cell).is_err()) {
        kept.kinds.push(cells.kinds[cell]);
        kept.numbers.push(cells.numbers[cell]);
        kept.sets.push(cells.sets[cell]);
        let range = cells.start[cell] as usize..cells.start[cell + 1] as usize;
        kept.nodes.extend_from_slice(&cells.nodes[range]);
        kept.start.push(kept.nodes.len() as u32);
    }
    (cells.kinds, cells.numbers, cells.sets) = (kept.kinds, kept.numbers, kept.sets);
    (cells.start, cells.nodes) = (kept.start, kept.nodes);
}

/// The corners of a cell of a file, which are its first nodes.
fn corners(cells: &Cells, cell: usize) -> &[u32] {
    &cells.nodes[cells.start[cell] as usize..][..corner_count(cells.kinds[cell])]
}

/// The number of corners of a kind.
pub fn corner_count(kind: Kind) -> usize {
    match kind {
        Kind::Point1 => 1,
        Kind::Line2 | Kind::Line3 => 2,
        Kind::Tri3 | Kind::Tri6 => 3,
        Kind::Quad4 | Kind::Quad8 | Kind::Quad9 | Kind::Tet4 | Kind::Tet10 => 4,
        Kind::Pyramid5 | Kind::Pyramid13 | Kind::Pyramid14 => 5,
        Kind::Prism6 | Kind::Prism15 | Kind::Prism18 => 6,
        Kind::Hex8 | Kind::Hex20 | Kind::Hex27 => 8,
    }
}

/// As [`Cells::describe`], before cells are raised.
fn describe(cells: &Cells, cell: usize) -> String {
    let nodes = corners(cells, cell);
    let sum = |i: usize| nodes.iter().map(|node| cells.points[*node as usize][i]).sum::<f64>();
    let at = [0, 1, 2].map(|i| sum(i) / nodes.len() as f64);
    format!("the {} number {} at {}", cells.kinds[cell].name(), cells.numbers[cell], place(at))
}

/// Cells in words: how many, and the first.
pub fn first_of(cells: &Cells, list: &[usize]) -> String {
    match list {
        [] => "no cell".into(),
        [one] => cells.describe(*one),
        [first, ..] => {
            format!("{}, the first of them {}", count(list.len(), "cell"), cells.describe(*first))
        }
    }
}
