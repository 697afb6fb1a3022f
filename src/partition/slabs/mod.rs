//! Large meshes of files, read in slabs on all ranks: no rank ever holds the whole of one.
//!
//! Every rank reads its part of the file and names the nodes ([`names`]). Cells are joined to
//! pieces of a curve that fills space ([`curve`]), METIS cuts the graph of these, and every rank
//! gets its cells and those around them ([`spread`]). There they are checked, raised and cut, a few
//! at a time, by the code for whole meshes ([`crate::mesh::slabs`]); the names that new nodes have
//! in the whole mesh are counted from their lowest corners ([`naming`]). What is wrong anywhere is
//! an error everywhere, and told by the one who reads the file whole.

mod bodies;
mod cells;
mod curve;
mod digest;
mod doubled;
mod exact;
mod finish;
mod homes;
mod labels;
mod names;
mod naming;
mod pieces;
mod placed;
mod part;
mod read;
mod runs;
mod share;
mod shared;
mod spread;

use crate::case::{Case, FileSpec, Linear};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::import::Pieces;
use crate::mesh::import::gmsh::{Layout, OpenFile, Slabs};
use crate::mesh::import::med;
use crate::mesh::{MeshFamily, is_med, request};
use crate::partition::journey::{pack, unpack};
use crate::partition::method::{Import, Method};
use crate::runtime::OwnPages;

/// Files with more cells are read in slabs.
const MANY: u64 = 2_000_000;
/// No cell takes fewer bytes in a file.
const LEAST_BYTES: u64 = 10;
/// Rows that are read at once.
const ROWS: u64 = 1 << 15;
/// The same in tests, whose meshes are small.
const FEW_ROWS: u64 = 64;

/// The mesh of a case from a file, read in slabs: none where it is small. Collective.
///
/// # Errors
/// `Input` for what is wrong with the file, and for what is not done in slabs.
pub fn family(
    comm: &Comm,
    case: &Case,
    import: Import,
    method: Method,
) -> Result<Option<MeshFamily>> {
    let Some(file) = case.mesh.file() else { return Ok(None) };
    let Some(pieces) = open(comm, file, import)? else { return Ok(None) };
    if case.mesh.refine > 0 {
        return Err(Error::Input("it is refined".into()));
    }
    if case.solver.linear == Linear::Multigrid {
        return Err(Error::Input("multigrid is asked for".into()));
    }
    let request = comm.agree(request(case, file))?;
    let _pages = OwnPages::start();
    let read = shared::read(comm, &*pieces, &request)?;
    finish::family(comm, case, &request, method, read, pieces).map(Some)
}

/// Opens a file that is to be read in slabs. Collective.
fn open(comm: &Comm, file: &FileSpec, import: Import) -> Result<Option<Box<dyn Pieces>>> {
    let is_forced = import == Import::Slabs;
    let length = || std::fs::metadata(&file.path).map_or(0, |about| about.len());
    let is_wanted = |rows: u64| is_forced || rows > MANY;
    let is_long = is_forced || import == Import::Auto && length() >= MANY * LEAST_BYTES;
    if !comm.any(comm.is_root() && is_long) {
        return Ok(None);
    }
    let rows = if is_forced { FEW_ROWS } else { ROWS };
    if is_med(&file.path) {
        let slabs = comm.agree(med::Slabs::open(&file.path, rows as usize))?;
        return Ok(is_wanted(slabs.rows()).then(|| Box::new(slabs) as Box<dyn Pieces>));
    }
    let source = comm.agree(OpenFile::new(&file.path))?;
    let layout = if comm.is_root() { Layout::of(&source, rows).map(Some) } else { Ok(None) };
    let layout = comm.agree(layout)?.filter(|layout| is_wanted(layout.rows()));
    let bytes = comm.broadcast_bytes(comm.agree(pack(&layout))?);
    let layout: Option<Layout> = comm.agree(unpack(&bytes))?;
    Ok(layout.map(|layout| Box::new(Slabs { layout, source }) as Box<dyn Pieces>))
}

/// The pieces of a file.
type File<'f> = &'f dyn Pieces;
