//! The deformed shape at some instants, coloured by a quantity.

use crate::chart::{number, width};
use crate::error::{Error, Result};

use super::drawing::{Align, Drawing, Paint, TEXT, TITLE};
use super::features::Features;
use super::instants::Instant;
use super::labels::{LINE, axes, legend, scale_bar};
use super::levels::Levels;
use super::paint::{Surface, Values, ghost};
use super::picture::Picture;
use super::quantity::Quantity;
use super::skin::Skin;
use super::stage::{Scene, Stage};
use super::vector::{Vector, extent, length, plus};
use super::view::{Camera, Frame, Reach};

/// The largest displacement is drawn as about this part of the size of the mesh.
const PART: f64 = 0.05;
/// Sizes in pixels.
const NARROW: f64 = 640.0;
const WIDE: f64 = 1200.0;
const TALLEST: f64 = 430.0;
const SIDE: f64 = 18.0;
const HEADER: f64 = 78.0;

/// The body at one instant.
struct Moment {
    stage: Stage,
    displacement: Vec<Vector>,
    quantity: Quantity,
    values: Vec<f64>,
    features: Features,
}

/// Draws the shape at instants, with at most `most` facets each.
///
/// # Errors
/// `Input` when there is no such quantity or instant, `System` when the fields cannot be read.
pub(crate) fn shape(
    scene: &Scene<'_>,
    instants: &[Instant],
    name: &str,
    most: usize,
) -> Result<Picture> {
    let moments = instants.iter().map(|instant| Moment::new(scene, instant.time, name, most));
    let mut moments = moments.collect::<Result<Vec<_>>>()?;
    Quantity::settle(&mut moments.iter_mut().map(|m| &mut m.quantity).collect::<Vec<_>>());
    moments.iter_mut().for_each(|moment| moment.values = moment.quantity.on(&moment.stage.skin));
    let Some(first) = moments.first() else {
        return Ok(Picture::drawn(name, Drawing::new(NARROW), String::new()));
    };
    let factor = factor(&moments);
    let levels = first.quantity.levels(moments.iter().flat_map(|moment| &moment.values).copied());
    let view = scene.view(&first.stage.skin);
    let moved: Vec<Vec<Vector>> = moments.iter().map(|moment| moment.moved(factor)).collect();
    let reach = Reach::of(&view, moved.iter().flatten().copied());
    let at_rest = moments.iter().flat_map(|moment| &moment.stage.skin.points).copied();
    let reach = reach.with(Reach::of(&view, at_rest));

    let count = moments.len();
    let mut drawing = Drawing::new(if count > 2 { WIDE } else { NARROW });
    let each = (drawing.width - 2.0 * SIDE) / count as f64;
    let scale = reach.scale(each - 2.0 * SIDE, TALLEST);
    let height = scale * reach.size()[1];
    let words = title(factor, &first.quantity);
    drawing.write(words.clone(), [16.0, 17.0], TITLE, Paint::Ink, Align::Left);
    let mut camera = None;
    for (i, (moment, points)) in moments.iter().zip(&moved).enumerate() {
        let left = SIDE + each * i as f64;
        heading(&mut drawing, &instants[i], left + 0.5 * each, each - 8.0);
        let frame = Frame { left: left + SIDE, top: HEADER, width: each - 2.0 * SIDE, height };
        let placed = Camera::at_scale(view, reach, frame, scale);
        ghost(&mut drawing, &placed, &moment.stage.skin, &moment.features);
        moment.surface(points, &levels).paint(&mut drawing, &placed);
        camera = Some(placed);
    }
    let low = HEADER + height + 18.0;
    axes(&mut drawing, &view, [34.0, low + 42.0]);
    let end = camera.map_or(92.0, |camera| scale_bar(&mut drawing, &camera, [92.0, low + 42.0]));
    let room = drawing.width - end - 60.0;
    let bottom =
        legend(&mut drawing, &levels, &first.quantity.words(), [end + 34.0, low + 6.0], room);
    drawing.height = bottom.max(low + 56.0) + 8.0;
    drawing.words = format!("{words}, at {}", times(instants));
    let caption = format!("{}{}", scale_words(factor), first.stage.thinned_words());
    Ok(Picture::drawn(&format!("shape-{name}"), drawing, caption))
}

/// The time, and below it why it is drawn, as wide as there is room.
fn heading(drawing: &mut Drawing, instant: &Instant, middle: f64, room: f64) {
    drawing.text(time_words(instant.time), [middle, 40.0], Align::Middle);
    let mut why = instant.why.join(", ");
    if width(&why, TEXT) > room {
        why = instant.why.first().copied().unwrap_or_default().to_owned();
    }
    drawing.write(why, [middle, 40.0 + LINE], TEXT, Paint::Soft, Align::Middle);
}

/// `t = 3 s`.
pub(super) fn time_words(time: f64) -> String {
    format!("t = {} s", number(time))
}

pub(super) fn times(instants: &[Instant]) -> String {
    instants.iter().map(|i| time_words(i.time)).collect::<Vec<_>>().join(", ")
}

fn title(factor: f64, quantity: &Quantity) -> String {
    let factor = if factor == 1.0 { "1 : 1".to_owned() } else { format!("× {}", number(factor)) };
    format!("Deformed shape, displacements {factor}, coloured by {}", quantity.words())
}

fn scale_words(factor: f64) -> String {
    let grey = "The grey lines are the edges before anything has moved.";
    if factor == 1.0 {
        format!("Displacements are drawn as they are, 1 : 1. {grey}")
    } else {
        format!("Displacements are drawn {} times as large as they are. {grey}", number(factor))
    }
}

/// By how much displacements are enlarged: a round number, at least 1.
fn factor(moments: &[Moment]) -> f64 {
    let largest =
        |moment: &Moment| moment.displacement.iter().copied().map(length).fold(0.0, f64::max);
    let most = moments.iter().map(largest).fold(0.0, f64::max);
    let size = moments.iter().map(|m| extent(m.stage.skin.points.iter().copied()));
    enlarged(most, size.fold(0.0, f64::max))
}

fn enlarged(most: f64, size: f64) -> f64 {
    let wanted = PART * size / most;
    if !wanted.is_finite() || wanted < 2.0 {
        return 1.0;
    }
    let power = 10f64.powf(wanted.log10().floor());
    let factors = [5.0, 2.0, 1.0].map(|f| f * power);
    factors.into_iter().find(|f| *f <= wanted * (1.0 + 1e-9)).unwrap_or(power)
}

impl Moment {
    fn new(scene: &Scene<'_>, time: f64, name: &str, most: usize) -> Result<Self> {
        let stage = scene.at(time, most)?;
        let quantity = Quantity::read(&stage.snapshot, name, None)?;
        let array = stage.snapshot.at_points("displacement")?;
        if array.components != 3 {
            return Err(Error::Input(
                "the displacement in the field files is no vector".to_owned(),
            ));
        }
        let displacement = displacement(&stage.skin, &array.values);
        let features = Features::of(&stage.skin);
        Ok(Self { stage, displacement, quantity, values: Vec::new(), features })
    }

    fn moved(&self, factor: f64) -> Vec<Vector> {
        let points = self.stage.skin.points.iter().zip(&self.displacement);
        points.map(|(point, by)| plus(*point, factor, *by)).collect()
    }

    fn surface<'a>(&'a self, points: &'a [Vector], levels: &'a Levels) -> Surface<'a> {
        let values = &self.values[..];
        let at_cells = self.quantity.at_cells;
        Surface {
            skin: &self.stage.skin,
            features: &self.features,
            points,
            values: if at_cells { Values::PerFacet(values) } else { Values::PerPoint(values) },
            levels,
            both_sides: self.stage.skin.dim < 3,
            edges: true,
        }
    }
}

/// The displacements of the points of a skin, of three numbers for each row of the file.
fn displacement(skin: &Skin, values: &[f64]) -> Vec<Vector> {
    let of = |row: &u32| {
        let row = &values[3 * *row as usize..][..3];
        [row[0], row[1], row[2]].map(|v| if v.is_finite() { v } else { 0.0 })
    };
    skin.rows.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_are_enlarged_by_round_numbers() {
        for (most, size, factor) in [
            (1e-3, 5.0, 200.0),
            (1.1e-3, 5.0, 200.0),
            (1e-6, 1.0, 50_000.0),
            (0.0, 1.0, 1.0),
            (0.1, 1.0, 1.0),
            (0.02, 1.0, 2.0),
        ] {
            assert_eq!(enlarged(most, size), factor, "{most} of {size}");
        }
        assert!(scale_words(200.0).contains("200 times"));
        assert!(scale_words(1.0).contains("1 : 1"));
    }
}
