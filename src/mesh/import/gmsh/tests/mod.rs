//! Files of words, files of bytes, files of Gmsh itself, and files that are broken.

mod ascii;
mod binary;
mod errors;
mod files;
mod mutations;
mod writer;

use super::super::file_mesh::{Block, FileMesh, Kind};
use super::read;

/// The names of the groups of an element.
fn groups_of(mesh: &FileMesh, block: &Block, element: usize) -> Vec<String> {
    let set = &mesh.group_sets[block.groups[element] as usize];
    set.iter().map(|group| mesh.groups[*group as usize].name.clone()).collect()
}

fn block(mesh: &FileMesh, kind: Kind) -> &Block {
    mesh.blocks.iter().find(|block| block.kind == kind).expect("a block of the kind")
}

fn message(bytes: &[u8]) -> String {
    read(bytes).expect_err("an error").to_string()
}
