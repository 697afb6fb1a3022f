//! The mesh with its supports and loads.

use crate::case::Case;
use crate::chart::number;
use crate::error::Result;

use super::boundary::{Mark, marks, middle, spread};
use super::cover::Cover;
use super::drawing::{Align, Drawing, Paint, Stroke, TITLE};
use super::features::Features;
use super::labels::{Label, Stack, axes, column, legend, scale_bar};
use super::levels::Levels;
use super::paint::{Surface, Values};
use super::picture::Picture;
use super::skin::Skin;
use super::stage::{Scene, Stage};
use super::symbols::signs;
use super::view::{Camera, Frame, Reach};

/// Sizes in pixels.
const WIDTH: f64 = 640.0;
const TALLEST: f64 = 470.0;
/// Room around the body for its signs.
const AROUND: f64 = 44.0;
const HEADER: f64 = 34.0;

/// Draws the mesh of a run, with at most `most` facets.
///
/// # Errors
/// `System` when the fields cannot be read.
pub(crate) fn mesh(scene: &Scene<'_>, most: usize) -> Result<Picture> {
    let stage = scene.first(most)?;
    let marks = marks(scene.case, &stage.whole, &stage.snapshot)?;
    let joints = joints(scene)?;
    let mut drawing = Drawing::new(WIDTH);
    drawing.write("Mesh, supports and loads", [16.0, 17.0], TITLE, Paint::Ink, Align::Left);

    let view = scene.view(&stage.skin);
    let reach = Reach::of(&view, stage.skin.points.iter().copied());
    let names = texts(&marks, &joints);
    let labelled = names.iter().map(Label::width).fold(0.0, f64::max);
    let beside = if names.is_empty() { 0.0 } else { labelled.min(300.0) + 40.0 };
    let room = WIDTH - beside - 2.0 * AROUND;
    let scale = reach.scale(room, TALLEST - 2.0 * AROUND);
    let height = scale * reach.size()[1];
    let width = room.min(scale * reach.size()[0]);
    let frame = Frame {
        // What is narrow stands in the middle, its names with it.
        left: AROUND + 0.5 * (room - width),
        top: HEADER + AROUND,
        width,
        height,
    };
    let camera = Camera::new(view, reach, frame);

    let (values, levels) = materials(scene.case, &stage)?;
    let features = Features::of(&stage.skin);
    let surface = Surface {
        skin: &stage.skin,
        features: &features,
        points: &stage.skin.points,
        values: Values::PerFacet(&values),
        levels: &levels,
        both_sides: stage.skin.dim < 3,
        edges: true,
    };
    surface.paint(&mut drawing, &camera);
    let cover = Cover::new(&stage.skin, &stage.skin.points, &camera);
    joints.iter().for_each(|joint| joint.trace(&mut drawing, &camera, &cover));
    marks.iter().for_each(|mark| signs(&mut drawing, &camera, &cover, mark));

    let left = frame.left + frame.width + AROUND + 18.0;
    let labels = placed(names, &marks, &joints, (&camera, &cover));
    let ended = column(&mut drawing, labels, Stack { left, top: HEADER });
    let low = (frame.top + height + AROUND).max(ended) + 12.0;
    footer(&mut drawing, &camera, &levels, low);
    drawing.words = format!("Mesh, supports and loads: {}", told(&marks));
    Ok(Picture::drawn("mesh", drawing, caption(scene, &stage)))
}

/// Axes, scale and materials below the body.
fn footer(drawing: &mut Drawing, camera: &Camera, levels: &Levels, low: f64) {
    axes(drawing, &camera.view, [34.0, low + 34.0]);
    let end = scale_bar(drawing, camera, [92.0, low + 34.0]);
    let mut bottom = low + 52.0;
    if levels.count() > 1 {
        let left = end + 34.0;
        bottom = bottom.max(legend(drawing, levels, "", [left, low + 25.0], WIDTH - left - 10.0));
    }
    drawing.height = bottom + 8.0;
}

/// The material of each facet, and their colours.
fn materials(case: &Case, stage: &Stage) -> Result<(Vec<f64>, Levels)> {
    let names = stage.snapshot.names_at_cells()?;
    let values: Vec<f64> = if names.iter().any(|name| name == "material") {
        let materials = stage.snapshot.at_cells("material")?.values;
        stage.skin.facets.iter().map(|facet| materials[facet.cell as usize]).collect()
    } else {
        vec![0.0; stage.skin.facets.len()]
    };
    let mut kinds: Vec<i64> = values.iter().map(|v| *v as i64).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let name = |kind: i64| {
        let found = usize::try_from(kind).ok().and_then(|kind| case.materials.get(kind));
        found.map_or_else(|| format!("material {}", kind + 1), |material| material.name.clone())
    };
    let kinds = kinds.into_iter().map(|kind| (kind, name(kind))).collect();
    Ok((values, Levels::Kinds(kinds)))
}

/// The trace of an interface on the surface of the body.
struct Joint {
    name: String,
    skin: Skin,
    features: Features,
    law: String,
}

fn joints(scene: &Scene<'_>) -> Result<Vec<Joint>> {
    let mut found = Vec::new();
    for interface in &scene.case.interfaces {
        let Some(skin) = scene.interface_skin(&interface.name)? else { continue };
        let features = Features::of(&skin);
        let law = interface.law.name().replace('_', " ");
        found.push(Joint { name: interface.name.clone(), skin, features, law });
    }
    Ok(found)
}

impl Joint {
    fn trace(&self, drawing: &mut Drawing, camera: &Camera, cover: &Cover) {
        let stroke = Stroke::new(Paint::Joint, 2.2);
        let point = |i: u32| self.skin.points[i as usize];
        if self.skin.dim == 1 {
            for facet in &self.skin.facets {
                let along = self.skin.ring(facet).map(|i| camera.place(point(i)));
                drawing.line(along.collect(), stroke);
            }
            return;
        }
        for ends in self.features.edges() {
            for part in cover.seen(ends.map(point), camera) {
                drawing.line(part.to_vec(), stroke);
            }
        }
    }
}

/// What is said of surfaces and interfaces; their places come later.
fn texts(marks: &[Mark], joints: &[Joint]) -> Vec<Label> {
    let paint = |text: &str| match text {
        text if text.ends_with(" held") => Paint::Held,
        text if text.starts_with("moved") => Paint::Moved,
        text if text.starts_with("traction") => Paint::Pushed,
        _ => Paint::Soft,
    };
    let of_marks = marks.iter().map(|mark| Label {
        at: [0.0; 2],
        name: mark.name.clone(),
        lines: mark.words.iter().map(|text| (text.clone(), paint(text))).collect(),
    });
    let of_joints = joints.iter().map(|joint| Label {
        at: [0.0; 2],
        name: joint.name.clone(),
        lines: vec![(format!("interface, {}", joint.law), Paint::Joint)],
    });
    of_marks.chain(of_joints).collect()
}

/// Labels at what they name: at a place that is seen, if there is one.
fn placed(
    mut labels: Vec<Label>,
    marks: &[Mark],
    joints: &[Joint],
    (camera, cover): (&Camera, &Cover),
) -> Vec<Label> {
    let of_marks = marks.iter().map(|mark| (&mark.points, true));
    let of_joints = joints.iter().map(|joint| (&joint.skin.points, false));
    for (label, (points, in_the_middle)) in labels.iter_mut().zip(of_marks.chain(of_joints)) {
        let centre = middle(points);
        let seen = |p: &[f64; 3]| !cover.hides(camera.place(*p), camera.view.nearness(*p));
        let mut best = centre;
        if !(in_the_middle && seen(&centre)) {
            let right = |p: &[f64; 3]| camera.place(*p)[0];
            let found = spread(points, 24).into_iter().filter(|p| seen(p));
            best = found.max_by(|a, b| right(a).total_cmp(&right(b))).unwrap_or(centre);
        }
        label.at = camera.place(best);
    }
    labels
}

fn told(marks: &[Mark]) -> String {
    let told = marks.iter().map(|mark| format!("{} {}", mark.name, mark.words.join(", ")));
    told.collect::<Vec<_>>().join("; ")
}

/// Cells by their kinds, the body force, and what was left out.
fn caption(scene: &Scene<'_>, stage: &Stage) -> String {
    let mut caption = format!("{}.", stage.cells);
    let gravity = &scene.case.gravity;
    let size = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    if size > 0.0 {
        let parts: Vec<String> = gravity.iter().map(|g| number(*g)).collect();
        caption += &format!(" Gravity: ({}) m/s².", parts.join(", "));
    }
    caption += &stage.thinned_words();
    caption
}
