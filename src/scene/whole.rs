//! All pictures of a run, none larger than a page bears.

use crate::case::Case;
use crate::error::Result;
use crate::output::history::Table;
use crate::results::Directory;

use super::instants::{Instant, chosen};
use super::lines::lines;
use super::maps::{ALONG, MAPPED, maps};
use super::model::mesh;
use super::picture::Picture;
use super::shape::shape;
use super::stage::Scene;

/// The pictures of a page.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Pictures {
    /// The mesh, and what becomes of it.
    pub body: Vec<Picture>,
    /// Of the interfaces.
    pub interfaces: Vec<Picture>,
    /// What is to be said of them, or in place of them.
    pub words: Vec<String>,
}

/// Most facets of a picture; about half of those of a body are turned away.
const OF_MESH: usize = 12_000;
const OF_SHAPES: usize = 16_000;
const OF_MAPS: usize = 12_000;
/// What shapes are coloured by.
const SHAPES: [&str; 2] = ["displacement", "von_mises"];
/// Fewest of each map.
const LEAST: usize = 300;
/// Interfaces that are drawn.
const MOST_INTERFACES: usize = 8;
/// Rows of maps.
const MOST_ROWS: usize = 3;

/// Most bytes of all pictures.
const MOST_BYTES: usize = 3_000_000;

/// All pictures of a run.
///
/// # Errors
/// `System` when the fields cannot be read.
pub(crate) fn pictures(directory: &Directory, case: &Case, history: &Table) -> Result<Pictures> {
    let Some(scene) = Scene::open(directory, case)? else {
        if history.rows.is_empty() {
            // There was no instant at which they could have been written.
            return Ok(Pictures::default());
        }
        let words = "No fields were written: with `output: {fields: all}` in the case the mesh, its \
                     deformed shape and the interfaces are drawn here.";
        return Ok(Pictures { words: vec![words.to_owned()], ..Pictures::default() });
    };
    let instants = chosen(&scene.written, history);
    let mut part = 1;
    loop {
        let found = drawn(&scene, &instants, part)?;
        if part > 64 || found.bytes()? <= MOST_BYTES {
            return Ok(found);
        }
        part *= 2;
    }
}

/// All pictures, with a part of the facets that they may have.
fn drawn(scene: &Scene<'_>, instants: &[Instant], part: usize) -> Result<Pictures> {
    let mut found = Pictures::default();
    found.body.push(mesh(scene, OF_MESH / part)?);
    let each = OF_SHAPES / (part * SHAPES.len() * instants.len().max(1));
    for quantity in SHAPES {
        found.body.push(shape(scene, instants, quantity, each)?);
    }
    let rows = &instants[instants.len().saturating_sub(MOST_ROWS)..];
    let interfaces = &scene.case.interfaces;
    let count = interfaces.len().min(MOST_INTERFACES) * MAPPED.len() * rows.len();
    let most = (OF_MAPS / (part * count.max(1))).max(LEAST / part);
    for interface in interfaces.iter().take(MOST_INTERFACES) {
        if scene.case.dim == 2 {
            found.interfaces.extend(lines(scene, &interface.name, rows, &ALONG)?);
        } else {
            found.interfaces.extend(maps(scene, &interface.name, rows, &MAPPED, most)?);
        }
    }
    if interfaces.len() > MOST_INTERFACES {
        found.words.push(format!(
            "The first {MOST_INTERFACES} of {} interfaces are drawn; `column-hpc plot` draws each.",
            interfaces.len()
        ));
    }
    Ok(found)
}

impl Pictures {
    fn bytes(&self) -> Result<usize> {
        let all = self.body.iter().chain(&self.interfaces);
        all.map(|picture| Ok(picture.svg(false)?.len())).sum()
    }
}
