//! The files of meshes, and what becomes of a mesh that can be read.

mod walk;
pub mod med;

use column_hpc::error::Error;
use column_hpc::mesh::import::{FileMesh, Pieces, gmsh as format};

use super::accepted;

/// How much memory the process has taken, where that is counted.
pub trait Meter {
    /// Forgets what was before.
    fn start(&self);
    /// Most bytes since the start above those at the start.
    fn most(&self) -> usize;
}

/// Of a process that does not count.
pub struct NoMeter;

impl Meter for NoMeter {
    fn start(&self) {}

    fn most(&self) -> usize {
        0
    }
}

/// Rows of a piece.
const ROWS: u64 = 64;

/// A reader takes no more bytes than this for each byte of the file, ...
const MOST_PER_BYTE: usize = 64;
/// ... and these.
const MOST_BEFORE: usize = 1 << 18;

/// The bytes of a mesh file of Gmsh. A refusal says where in it.
pub fn gmsh(bytes: &[u8], meter: &impl Meter) {
    let read = measured(bytes.len(), meter, || format::read(bytes));
    if let Err(Error::Input(words)) = &read {
        let has_place = words.contains("line ") || words.contains("byte ");
        // Copies of elements and of names are found when the file has been read.
        assert!(has_place || words.starts_with('$'), "no place in: {words}");
        assert!(words.len() < 1000, "{} bytes of words", words.len());
    }
    let in_pieces = measured(bytes.len(), meter, || cells_in_pieces(bytes));
    if let Some(mesh) = accepted(read) {
        // Pieces may refuse what the reader takes, but find nothing else.
        if let Some(cells) = accepted(in_pieces) {
            assert!(cells_of(&mesh) <= cells, "{} cells and {cells} in pieces", cells_of(&mesh));
        }
        sound(&mesh);
        walk::walk(&mesh, walk::MOST_REFINED);
    }
}

/// The number of cells that are found when the layout is found first, and every piece is read by
/// itself.
fn cells_in_pieces(bytes: &[u8]) -> Result<usize, Error> {
    let layout = format::Layout::of(&bytes, ROWS)?;
    let slabs = format::Slabs { layout, source: bytes };
    let (mut sets, mut counts) = (slabs.sets(), [0; 4]);
    for (piece, rows) in slabs.node_rows().into_iter().enumerate() {
        let nodes = slabs.nodes(piece)?;
        assert_eq!(nodes.points.len() as u64, rows);
        assert_eq!(nodes.numbers.len(), nodes.points.len());
        assert!(nodes.points.iter().flatten().all(|x| x.is_finite()));
    }
    for (piece, rows) in slabs.element_rows().into_iter().enumerate() {
        let elements = slabs.elements(piece, &mut sets)?;
        assert_eq!(elements.iter().map(|of| of.sets.len() as u64).sum::<u64>(), rows);
        for of in &elements {
            assert_eq!(of.nodes.len(), of.kind.nodes() * of.sets.len());
            assert!(of.sets.iter().all(|set| (*set as usize) < sets.len()));
            counts[of.kind.dim()] += of.sets.len();
        }
    }
    let (groups, of_sets) = slabs.groups(sets)?;
    assert!(of_sets.iter().flatten().all(|group| (*group as usize) < groups.len()));
    Ok(counts.into_iter().rev().find(|count| *count > 0).unwrap_or(0))
}

/// The number of cells of a mesh.
fn cells_of(mesh: &FileMesh) -> usize {
    let dim = mesh.blocks.iter().map(|block| block.kind.dim()).max().unwrap_or(0);
    let of_cells = mesh.blocks.iter().filter(|block| block.kind.dim() == dim);
    of_cells.map(|block| block.numbers.len()).sum()
}

/// Reads, and holds the memory against the size of the file.
fn measured<T>(bytes: usize, meter: &impl Meter, read: impl FnOnce() -> T) -> T {
    meter.start();
    let result = read();
    let most = meter.most();
    let limit = MOST_BEFORE + MOST_PER_BYTE * bytes;
    assert!(most <= limit, "{most} bytes of memory for a file of {bytes}");
    result
}

/// What every mesh that is read keeps to: whole lists, indices that are there, finite coordinates.
fn sound(mesh: &FileMesh) {
    let points = mesh.points.len() as u32;
    assert_eq!(mesh.points.len(), mesh.node_numbers.len());
    assert!(mesh.points.iter().flatten().all(|x| x.is_finite()));
    assert!(mesh.group_sets[0].is_empty());
    let mut kinds = Vec::new();
    for block in &mesh.blocks {
        assert!(!kinds.contains(&block.kind), "two blocks of {}", block.kind.name());
        kinds.push(block.kind);
        assert_eq!(block.nodes.len(), block.kind.nodes() * block.numbers.len());
        assert_eq!(block.groups.len(), block.numbers.len());
        assert!(block.nodes.iter().all(|node| *node < points));
        for set in &block.groups {
            let groups = &mesh.group_sets[*set as usize];
            let is_of = |group: &u32| mesh.groups[*group as usize].dim == block.kind.dim();
            assert!(groups.iter().all(is_of), "a group of another dimension");
        }
    }
    for set in &mesh.group_sets {
        assert!(set.is_sorted_by(|a, b| a < b));
        assert!(set.iter().all(|group| (*group as usize) < mesh.groups.len()));
    }
    for (group, nodes) in &mesh.node_groups {
        assert_eq!(mesh.groups[*group as usize].dim, 0);
        assert!(nodes.is_sorted_by(|a, b| a < b) && nodes.iter().all(|node| *node < points));
    }
    let mut names: Vec<_> = mesh.groups.iter().map(|group| (group.dim, &group.name)).collect();
    names.sort_unstable();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "one name twice");
}
