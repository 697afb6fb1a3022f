//! MED files, SALOME's format in HDF5: versions 3 and 4.
//!
//! Source: the documentation of MED 4.1, *Modèle de données* and *Représentation HDF5*. A list of
//! n nodes or elements has all first components before all second ones; indices begin at 1.

mod archive;
mod cells;
mod families;
mod groups;
mod head;
mod nodes;
mod plane;
mod slab;

use std::path::Path;

use super::FileMesh;
use crate::error::{Error, Result};
use archive::{Folder, Told};
use head::step_of;

pub use slab::Slabs;

/// Reads the mesh of a file, at its last step of geometry.
///
/// # Errors
/// `Input` with the path of the file, that of the dataset and what is wrong with it; `System` when
/// the file is locked.
///
/// # Parallel
/// Local.
pub fn read(path: &Path) -> Result<FileMesh> {
    let top = archive::open(path)?;
    let mesh = mesh_of(&top);
    mesh.map_err(|cause| {
        Error::Input(format!("cannot read the MED file {}: {cause}", path.display()))
    })
}

fn mesh_of(top: &Folder) -> Told<FileMesh> {
    let mut remarks = Vec::new();
    let (name, space, step) = step_of(top, &mut remarks)?;
    let mut nodes = nodes::read(&step, space)?;
    let mut cells = cells::read(&step, nodes.points.len())?;
    nodes::drop_orphans(&mut nodes, &mut cells, &mut remarks);
    let families = families::read(top, &name, &mut remarks)?;
    let mut mesh = groups::assemble(nodes, cells, families, remarks)?;
    plane::face_up(&mut mesh);
    Ok(mesh)
}
