//! Interfaces of a plane model: quantities over the length along them.

use crate::chart::{Line, Look, Panel, Panels, Scale, Unit};
use crate::error::Result;

use super::drawing::{Align, Drawing, Paint, Stroke, TEXT, TITLE};
use super::features::Parents;
use super::instants::Instant;
use super::labels::legend;
use super::levels::lit;
use super::picture::Picture;
use super::quantity::Quantity;
use super::shape::time_words;
use super::skin::Skin;
use super::stage::Scene;
use super::vector::{length, minus};

/// Points that have markers of their own.
const MOST_MARKED: usize = 40;

/// Charts of quantities of an interface over the length along it, two to a picture; none where it
/// has no fields.
///
/// # Errors
/// `Input` when there is no such quantity or instant, `System` when the fields cannot be read.
pub(crate) fn lines(
    scene: &Scene<'_>,
    name: &str,
    instants: &[Instant],
    quantities: &[&str],
) -> Result<Vec<Picture>> {
    let mut panels = Vec::new();
    let mut pictures = Vec::new();
    for quantity in quantities {
        let mut curves = Vec::new();
        for instant in instants {
            let Some((snapshot, skin)) = scene.interface(name, instant.time)? else {
                return Ok(Vec::new());
            };
            let found = Quantity::read(&snapshot, quantity, Some(&skin))?;
            curves.push((found, skin));
        }
        if *quantity == STATE {
            pictures.extend(strips(name, instants, &curves));
        } else {
            panels.extend(panel(instants, curves));
        }
    }
    let title = format!("Interface {name}, along its length");
    let pairs = panels.chunks(2).enumerate().map(|(i, pair)| {
        let id = if i == 0 { format!("along-{name}") } else { format!("along-{name}-{}", i + 1) };
        let panels = Panels { title: title.clone(), panels: pair.to_vec(), below: true };
        Picture::charted(&id, panels, String::new())
    });
    pictures.extend(pairs);
    Ok(pictures)
}

/// What is one of several, for which a strip of colours stands.
const STATE: &str = "state";

/// A strip for each instant, coloured by the state along the interface.
fn strips(name: &str, instants: &[Instant], curves: &[(Quantity, Skin)]) -> Option<Picture> {
    const LEFT: f64 = 110.0;
    const ROW: f64 = 30.0;
    const BAR: f64 = 18.0;
    let (first, _) = curves.first()?;
    let levels = first.levels(
        curves
            .iter()
            .flat_map(|(quantity, skin)| quantity.on(skin))
            .collect::<Vec<_>>()
            .into_iter(),
    );
    let mut drawing = Drawing::new(640.0);
    let room = drawing.width - LEFT - 30.0;
    let title = format!("Interface {name}: state along its length");
    drawing.write(title.clone(), [16.0, 17.0], TITLE, Paint::Ink, Align::Left);
    let mut longest = 0.0;
    for (i, (instant, (quantity, skin))) in instants.iter().zip(curves).enumerate() {
        let top = 40.0 + ROW * i as f64;
        drawing.text(time_words(instant.time), [16.0, top + 0.5 * BAR], Align::Left);
        let (along, values) = (along(skin), quantity.on(skin));
        longest = along.last().map_or(longest, |(length, _)| length.max(longest));
        // Each point has the colour up to the middle of its neighbours.
        for (k, (here, point)) in along.iter().enumerate() {
            let other = |k: usize| along.get(k).map_or(*here, |(there, _)| 0.5 * (here + there));
            let [from, to] = [other(k.wrapping_sub(1)), other(k + 1)];
            let [from, to] = [from, to].map(|s| LEFT + room * s / longest.max(f64::MIN_POSITIVE));
            let fill = lit(levels.color(levels.band(values[*point as usize])), 1.0);
            let bar = vec![[from, top], [to, top], [to, top + BAR], [from, top + BAR]];
            drawing.area(bar, fill, Some(Stroke::new(fill, 0.5)));
        }
        let frame = [[0.0, 0.0], [room, 0.0], [room, BAR], [0.0, BAR], [0.0, 0.0]];
        let frame = frame.map(|[x, y]| [LEFT + x, top + y]);
        drawing.line(frame.to_vec(), Stroke::new(Paint::Ink, 1.0));
    }
    let low = 40.0 + ROW * curves.len() as f64;
    drawing.write("0", [LEFT, low], TEXT, Paint::Soft, Align::Middle);
    let end = Unit::text("m", longest);
    drawing.write(end, [LEFT + room, low], TEXT, Paint::Soft, Align::Middle);
    let bottom = legend(&mut drawing, &levels, "", [LEFT, low + 16.0], room);
    drawing.height = bottom + 10.0;
    drawing.words = title;
    Some(Picture::drawn(&format!("state-{name}"), drawing, String::new()))
}

/// One quantity at all instants.
fn panel(instants: &[Instant], mut curves: Vec<(Quantity, Skin)>) -> Option<Panel> {
    Quantity::settle(&mut curves.iter_mut().map(|(quantity, _)| quantity).collect::<Vec<_>>());
    let (first, _) = curves.first()?;
    let numbers = curves.iter().flat_map(|(quantity, _)| &quantity.values).copied();
    let unit = Unit::of(first.unit, numbers);
    let label = unit.label(&first.words());
    let mut lines = Vec::new();
    for (style, (instant, (quantity, skin))) in instants.iter().zip(&curves).enumerate() {
        let (along, values) = (along(skin), quantity.on(skin));
        let look = if along.len() <= MOST_MARKED { Look::Marked } else { Look::Joined };
        let points = along.iter().map(|(s, point)| (*s, unit.number(values[*point as usize])));
        lines.push(Line::new(&time_words(instant.time), points.collect(), Some(style), look));
    }
    let points = || lines.iter().flat_map(|line| &line.points);
    let y = Scale::over(points().map(|p| p.1), false);
    let x = Scale::over(points().map(|p| p.0), false);
    let x_label = "length along it [m]".to_owned();
    Some(Panel { x, y, x_label, y_label: label, lines, front: Vec::new() })
}

/// The points of lines in their order, with the length up to them (m). Parts that do not hang
/// together follow each other.
fn along(skin: &Skin) -> Vec<(f64, u32)> {
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); skin.points.len()];
    let mut parents = Parents::new(skin.points.len());
    for facet in &skin.facets {
        let ring: Vec<u32> = skin.ring(facet).collect();
        for pair in ring.windows(2) {
            beside[pair[0] as usize].push(pair[1]);
            beside[pair[1] as usize].push(pair[0]);
            parents.join(pair[0], pair[1]);
        }
    }
    let order = |a: &u32, b: &u32| {
        let [a, b] = [*a, *b].map(|i| skin.points[i as usize]);
        let pairs = a.iter().zip(&b).map(|(a, b)| a.total_cmp(b));
        pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    };
    let mut starts: Vec<u32> = (0..skin.points.len() as u32).collect();
    starts.sort_by(order);
    // Ends first: a ring has none, and begins anywhere.
    starts.sort_by_key(|point| beside[*point as usize].len() != 1);
    let mut seen = vec![false; skin.points.len()];
    let (mut found, mut total) = (Vec::new(), 0.0);
    for start in starts {
        let mut next = Some(start).filter(|point| !seen[*point as usize]);
        let mut last: Option<u32> = None;
        while let Some(point) = next {
            seen[point as usize] = true;
            let place = |i: u32| skin.points[i as usize];
            total += last.map_or(0.0, |last| length(minus(place(point), place(last))));
            found.push((total, point));
            last = Some(point);
            next = beside[point as usize].iter().copied().find(|other| !seen[*other as usize]);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Shape;
    use crate::results::FieldGrid;

    #[test]
    fn lines_are_walked_from_one_end_to_the_other() {
        // Three pieces of second order, in any order and any way round.
        let grid = FieldGrid {
            points: [3.0, 2.0, 0.0, 1.0, 0.5, 2.5, 1.5].map(|x| [x, 0.0, 1.0]).to_vec(),
            shapes: vec![Shape::Line3; 3],
            starts: vec![0, 3, 6, 9],
            nodes: vec![0, 1, 5, 2, 3, 4, 1, 3, 6],
        };
        let found = along(&Skin::of(&grid));
        let lengths: Vec<f64> = found.iter().map(|(s, _)| *s).collect();
        assert_eq!(lengths, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        let x: Vec<f64> = found.iter().map(|(_, i)| grid.points[*i as usize][0]).collect();
        assert_eq!(x, lengths);
    }
}
