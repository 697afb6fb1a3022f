//! `column-hpc plot`: one picture of a finished run.

use std::path::PathBuf;

use crate::case::Case;
use crate::error::{Error, Result};
use crate::output::atomic;
use crate::output::history::Table;
use crate::results::Directory;

use super::instants::{Instant, chosen};
use super::lines::lines;
use super::maps::{MAPPED, maps};
use super::model::mesh;
use super::picture::Picture;
use super::quantity::Quantity;
use super::shape::shape;
use super::stage::Scene;

/// What is to be drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Request {
    /// The output directory of a run.
    pub directory: PathBuf,
    /// The quantity, or `mesh`.
    pub of: String,
    /// The instant (s); the last one where none is named.
    pub at: Option<f64>,
    /// The file to write; `plot.svg` in the directory where none is named.
    pub output: Option<PathBuf>,
}

/// Most facets of the picture.
const MOST_FACETS: usize = 20_000;
/// Most bytes of a picture.
const MOST_BYTES: usize = 3_000_000;

/// The mesh in place of a quantity.
const MESH: &str = "mesh";

/// Draws it, writes it as SVG and, beside it, as PNG, and returns both paths. Local.
///
/// # Errors
/// [`Error::Input`] when there are no results, no fields, no such quantity or instant, with those
/// that there are, or when the file to write is no SVG; [`Error::System`] when a file cannot be
/// read or written.
pub fn plot(request: &Request) -> Result<[PathBuf; 2]> {
    let directory = Directory::open(&request.directory)?;
    let path = request.output.clone().unwrap_or_else(|| directory.path().join("plot.svg"));
    if path.extension().is_none_or(|end| end != "svg") {
        return Err(Error::Input(format!(
            "--output {}: the picture is an SVG, with a PNG beside it; name a file that ends in .svg",
            path.display()
        )));
    }
    let case = directory.case()?;
    let history = Table::read(&directory.path().join(crate::output::directory::HISTORY))?;
    let mut most = MOST_FACETS;
    let (picture, text) = loop {
        let picture = picture(&directory, &case, request, (&history, most))?.captioned();
        let text = picture.svg(true)?;
        if text.len() <= MOST_BYTES || most < 100 {
            break (picture, text);
        }
        most /= 2;
    };
    let image = path.with_extension("png");
    atomic::write_text(&path, &text)?;
    atomic::write_bytes(&image, &picture.png()?)?;
    Ok([path, image])
}

fn picture(
    directory: &Directory,
    case: &Case,
    request: &Request,
    (history, most): (&Table, usize),
) -> Result<Picture> {
    let place = directory.path().display();
    let Some(scene) = Scene::open(directory, case)? else {
        return Err(Error::Input(format!(
            "{place} has no field files, from which pictures are drawn: run the case with `output: {{fields: all}}`"
        )));
    };
    let instant = instant(&scene, request.at, history)?;
    let instants = std::slice::from_ref(&instant);
    let name = request.of.as_str();
    if name == MESH {
        return mesh(&scene, most);
    }
    let parts = case.interfaces.iter().find_map(|interface| {
        let rest = name.strip_prefix(interface.name.as_str())?;
        (rest.is_empty() || rest.starts_with('.'))
            .then(|| (&interface.name, rest.trim_start_matches('.')))
    });
    let Some((interface, quantity)) = parts else {
        let known = || names(&scene, instant.time);
        let found = Quantity::names(&scene.at(instant.time, most)?.snapshot, false)?;
        if !found.iter().any(|other| other == name) {
            let hint = crate::input::problems::suggestion(name, &known()?);
            return Err(Error::Input(format!("{place} has no quantity `{name}`{hint}")));
        }
        return shape(&scene, instants, name, most);
    };
    let one = [quantity];
    let found = if case.dim == 2 {
        let two: &[&str] =
            if quantity.is_empty() { &["normal_traction", "normal_jump"] } else { &one };
        lines(&scene, interface, instants, two)?.into_iter().next()
    } else {
        let all: &[&str] = if quantity.is_empty() { &MAPPED } else { &one };
        maps(&scene, interface, instants, all, most / all.len())?
    };
    found.ok_or_else(|| Error::Input(format!("{place} has no fields of `{interface}`")))
}

/// The instant asked for, or the last one.
fn instant(scene: &Scene<'_>, at: Option<f64>, history: &Table) -> Result<Instant> {
    let last = scene.written[scene.written.len() - 1];
    let time = at.unwrap_or(last);
    if !scene.written.contains(&time) {
        let mut near = scene.written.clone();
        near.sort_by(|a, b| (a - time).abs().total_cmp(&(b - time).abs()));
        near.truncate(5);
        near.sort_by(f64::total_cmp);
        let near: Vec<String> = near.iter().map(f64::to_string).collect();
        let count = scene.written.len();
        return Err(Error::Input(format!(
            "no fields were written at {time} s; the nearest of {count} instants: {}",
            near.join(", ")
        )));
    }
    let known = chosen(&scene.written, history).into_iter().find(|found| found.time == time);
    Ok(known.unwrap_or(Instant { time, why: Vec::new() }))
}

/// All that can be drawn.
fn names(scene: &Scene<'_>, time: f64) -> Result<Vec<String>> {
    let mut found = vec![MESH.to_owned()];
    found.extend(Quantity::names(&scene.at(time, usize::MAX)?.snapshot, false)?);
    for interface in &scene.case.interfaces {
        let Some((snapshot, _)) = scene.interface(&interface.name, time)? else { continue };
        found.push(interface.name.clone());
        let names = Quantity::names(&snapshot, true)?.into_iter();
        found.extend(names.map(|name| format!("{}.{name}", interface.name)));
    }
    Ok(found)
}
