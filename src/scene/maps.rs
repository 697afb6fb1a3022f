//! Interfaces laid flat: what they carry and how far they are apart, facet by facet.

use crate::chart::number;
use crate::error::Result;

use super::drawing::{Align, Drawing, Paint, TEXT, TITLE};
use super::features::Features;
use super::instants::Instant;
use super::labels::{LINE, axes, legend};
use super::levels::{Levels, four};
use super::paint::{Surface, Values};
use super::picture::Picture;
use super::quantity::{Quantity, facet_normal};
use super::shape::{time_words, times};
use super::skin::Skin;
use super::stage::{Scene, grouped};
use super::thin::thinned;
use super::vector::{dot, extent, plus, unit};
use super::view::{Camera, Frame, Reach, View};

/// What is drawn of an interface.
pub(crate) const MAPPED: [&str; 4] = ["state", "damage", "normal_traction", "normal_jump"];

/// The same of a plane model, in pairs.
pub(crate) const ALONG: [&str; 5] =
    ["state", "normal_traction", "normal_jump", "damage", "shear_traction"];

/// Sizes in pixels.
const WIDE: f64 = 1200.0;
const NARROW: f64 = 640.0;
const SIDE: f64 = 16.0;
const TALLEST: f64 = 240.0;
const TALLEST_OF_ROWS: f64 = 165.0;
const GAP: f64 = 20.0;
const HEADER: f64 = 62.0;

/// An interface at one instant.
struct Moment {
    skin: Skin,
    quantities: Vec<Quantity>,
    values: Vec<Vec<f64>>,
}

/// A map of each quantity of an interface at each instant, with at most `most` facets each; none
/// where the interface has no fields.
///
/// # Errors
/// `Input` when there is no such quantity or instant, `System` when the fields cannot be read.
pub(crate) fn maps(
    scene: &Scene<'_>,
    name: &str,
    instants: &[Instant],
    quantities: &[&str],
    most: usize,
) -> Result<Option<Picture>> {
    let mut moments = Vec::new();
    let mut thin = None;
    for instant in instants {
        let Some((snapshot, whole)) = scene.interface(name, instant.time)? else { return Ok(None) };
        let read = quantities.iter().map(|q| Quantity::read(&snapshot, q, Some(&whole)));
        let quantities = read.collect::<Result<Vec<_>>>()?;
        let fewer = thinned(&whole, most);
        thin = fewer.as_ref().map(|fewer| (whole.facets.len(), fewer.edge));
        let skin = fewer.map_or(whole, |fewer| fewer.skin);
        moments.push(Moment { skin, quantities, values: Vec::new() });
    }
    for column in 0..quantities.len() {
        let same = moments.iter_mut().map(|moment| &mut moment.quantities[column]);
        Quantity::settle(&mut same.collect::<Vec<_>>());
    }
    for moment in &mut moments {
        moment.values = moment.quantities.iter().map(|q| q.on(&moment.skin)).collect();
    }
    let Some(first) = moments.first() else { return Ok(None) };
    let side = Side::of(&first.skin);
    let mut drawing = Drawing::new(if quantities.len() > 1 { WIDE } else { NARROW });
    let title = format!("Interface {name}");
    drawing.write(title.clone(), [16.0, 17.0], TITLE, Paint::Ink, Align::Left);
    let lowest = table(&mut drawing, &side, instants, &moments);
    drawing.height = lowest + 10.0;
    drawing.words = format!("{title}: {} at {}", quantities.join(", "), times(instants));
    let mut caption = side.words().to_owned();
    if let Some((facets, edge)) = thin {
        let edge = crate::chart::Unit::text("m", edge);
        caption +=
            &format!(" Of {} facets, points were merged on a grid of {edge}.", grouped(facets));
    }
    Ok(Some(Picture::drawn(&format!("map-{name}"), drawing, caption)))
}

/// From where an interface is seen.
struct Side {
    view: View,
    is_flat: bool,
    bends: bool,
}

/// Facets whose normals are off the mean by less than these lie flat, or can be laid flat (cosine).
const FLAT: f64 = 0.999;
const BENT: f64 = 0.5;

impl Side {
    fn of(skin: &Skin) -> Self {
        let normals: Vec<_> = skin.facets.iter().map(|f| facet_normal(skin, f)).collect();
        let mean = unit(normals.iter().fold([0.0; 3], |sum, n| plus(sum, 1.0, *n)));
        let least = normals.iter().map(|n| dot(unit(*n), mean)).fold(1.0, f64::min);
        let bends = least < BENT;
        let view = if bends { View::of_body() } else { View::onto(mean) };
        Self { view, is_flat: least > FLAT, bends }
    }

    fn words(&self) -> &'static str {
        match (self.is_flat, self.bends) {
            (true, _) => "Seen along its normal. Tension and opening are positive.",
            (_, false) => {
                "Seen along its mean normal: it is not flat. Tension and opening are positive."
            }
            _ => {
                "It bends too far to be laid flat: seen as the body. Tension and opening are positive."
            }
        }
    }
}

/// A column for each quantity, a row for each instant; returns where it ends.
fn table(drawing: &mut Drawing, side: &Side, instants: &[Instant], moments: &[Moment]) -> f64 {
    let columns = moments[0].quantities.len();
    let each = (drawing.width - SIDE) / columns as f64;
    let room = each - SIDE;
    let points = moments.iter().flat_map(|moment| &moment.skin.points).copied();
    let reach = Reach::of(&side.view, points);
    let tallest = if moments.len() > 1 { TALLEST_OF_ROWS } else { TALLEST };
    let scale = reach.scale(room - 8.0, tallest);
    let height = scale * reach.size()[1];
    let row = height + 2.0 * LINE + GAP;
    let ends = HEADER + row * moments.len() as f64;
    let mut lowest: f64 = 0.0;
    for column in 0..columns {
        let quantity = &moments[0].quantities[column];
        let numbers = moments.iter().flat_map(|moment| &moment.values[column]).copied();
        let levels = quantity.levels(numbers);
        let left = SIDE + each * column as f64;
        let middle = left + 0.5 * (room - 8.0);
        drawing.text(quantity.words(), [middle, 42.0], Align::Middle);
        for (i, moment) in moments.iter().enumerate() {
            let top = HEADER + row * i as f64;
            if column == 0 {
                when(drawing, &instants[i], [left, top + 0.5 * LINE]);
            }
            let frame = Frame { left, top: top + LINE + 4.0, width: room - 8.0, height };
            let camera = Camera::at_scale(side.view, reach, frame, scale);
            moment.paint(drawing, &camera, column, (&levels, side.bends));
            let range = range(quantity, &levels, &moment.values[column]);
            let at = [middle, top + 1.5 * LINE + height + 8.0];
            drawing.write(range, at, TEXT, Paint::Soft, Align::Middle);
        }
        lowest = lowest.max(legend(drawing, &levels, &quantity.words(), [left, ends], room));
    }
    axes(drawing, &side.view, [SIDE + 18.0, lowest + 58.0]);
    lowest + 72.0
}

fn when(drawing: &mut Drawing, instant: &Instant, at: [f64; 2]) {
    let mut text = time_words(instant.time);
    if !instant.why.is_empty() {
        text += &format!(": {}", instant.why.join(", "));
    }
    drawing.text(text, at, Align::Left);
}

/// Between which numbers a quantity lies, in the unit of its legend.
fn range(quantity: &Quantity, levels: &Levels, values: &[f64]) -> String {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let Levels::Bands { unit, .. } = levels else { return String::new() };
    let [a, b] = [low, high].map(|v| number(four(unit.number(v))));
    let name = if quantity.unit.is_empty() { "" } else { &unit.name };
    let text = if a == b { format!("{a} {name} everywhere") } else { format!("{a} to {b} {name}") };
    text.replace("  ", " ").trim_end().to_owned()
}

impl Moment {
    fn paint(
        &self,
        drawing: &mut Drawing,
        camera: &Camera,
        column: usize,
        (levels, bends): (&Levels, bool),
    ) {
        let features = Features::of(&self.skin);
        let values = &self.values[column][..];
        let surface = Surface {
            skin: &self.skin,
            features: &features,
            points: &self.skin.points,
            values: if self.quantities[column].at_cells {
                Values::PerFacet(values)
            } else {
                Values::PerPoint(values)
            },
            levels,
            both_sides: true,
            edges: self.skin.facets.len() < 2000 && !bends,
        };
        if extent(self.skin.points.iter().copied()) > 0.0 {
            surface.paint(drawing, camera);
        }
    }
}
