//! What is prescribed on surfaces: where it is, and in words.

use crate::case::{BoundarySpec, Case, Value};
use crate::chart::{Unit, number};
use crate::error::Result;
use crate::results::Snapshot;

use super::levels::four;
use super::quantity::SURFACE;
use super::skin::Skin;
use super::vector::{Vector, bounds, minus, plus, unit};

/// What an entry of `boundary` prescribes on its surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mark {
    /// The name of the surface.
    pub name: String,
    /// What is said of it, line by line.
    pub words: Vec<String>,
    /// Components of the displacement that stay 0.
    pub held: [bool; 3],
    /// Whether these are all that there are.
    pub holds_all: bool,
    /// Directions of the components of the displacement that do not, at their largest.
    pub moved: Vec<Vector>,
    /// Direction of the largest traction.
    pub pushed: Option<Vector>,
    /// The points of the surface.
    pub points: Vec<Vector>,
    /// The direction outwards.
    pub outward: Vector,
}

/// Points are on a plane that are nearer than this part of the size of the mesh.
const NEAR: f64 = 1e-9;

const AXES: [&str; 3] = ["x", "y", "z"];

/// The entries of `boundary` that are of a surface. `whole` is the skin with all its points.
///
/// # Errors
/// `System` when the fields cannot be read.
pub(crate) fn marks(case: &Case, skin: &Skin, snapshot: &Snapshot) -> Result<Vec<Mark>> {
    let groups = snapshot.names_at_points()?;
    let mut found: Vec<Mark> = Vec::new();
    for entry in &case.boundary {
        let group = format!("{SURFACE}{}", entry.on.name());
        let inside: Vec<bool> = if groups.contains(&group) {
            let marked = snapshot.at_points(&group)?.values;
            skin.rows.iter().map(|row| marked[*row as usize] != 0.0).collect()
        } else {
            at_end(skin, entry.on.axis())
        };
        if !inside.contains(&true) {
            continue;
        }
        let mark = Mark::new(case, entry, &inside, skin);
        match found.iter_mut().find(|other| other.name == mark.name) {
            Some(other) => other.join(mark),
            None => found.push(mark),
        }
    }
    Ok(found)
}

/// Which points are on a side of a box: normal to an axis, at its far end or not.
fn at_end(skin: &Skin, side: Option<(usize, bool)>) -> Vec<bool> {
    let Some((axis, far)) = side else { return Vec::new() };
    let [low, high] = bounds(skin.points.iter().copied());
    let end = if far { high[axis] } else { low[axis] };
    let near = NEAR * (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
    skin.points.iter().map(|point| (point[axis] - end).abs() <= near).collect()
}

/// The direction outwards of the facets between such points; away from the middle of the mesh where
/// there are none.
fn outward(skin: &Skin, inside: &[bool], centre: Vector) -> Vector {
    let of_surface = skin
        .facets
        .iter()
        .filter(|facet| skin.dim == 3 && skin.of_facet(facet).iter().all(|i| inside[*i as usize]));
    let sum = of_surface.fold([0.0; 3], |sum, f| plus(sum, 1.0, skin.area(f, &skin.points)));
    if sum != [0.0; 3] {
        return unit(sum);
    }
    let [low, high] = bounds(skin.points.iter().copied());
    unit(minus(centre, std::array::from_fn(|c| 0.5 * (low[c] + high[c]))))
}

/// When and where values are looked at.
#[derive(Clone, Copy)]
struct Over<'a> {
    times: &'a [f64],
    places: &'a [Vector],
}

impl Over<'_> {
    /// The value of the largest size.
    fn largest(&self, value: &Value) -> f64 {
        let times = || self.times.iter().copied();
        let values = self.places.iter().flat_map(|p| times().map(|time| value.at(*p, time)));
        let values = values.filter(|v| v.is_finite());
        values.fold(0.0, |most: f64, v| if v.abs() > most.abs() { v } else { most })
    }
}

/// Places of a surface where values are looked at.
const PLACES: usize = 16;

impl Mark {
    fn new(case: &Case, entry: &BoundarySpec, inside: &[bool], skin: &Skin) -> Self {
        let points = skin.points.iter().zip(inside).filter(|(_, inside)| **inside);
        let points: Vec<Vector> = points.map(|(point, _)| *point).collect();
        let sign = |far: bool| if far { 1.0 } else { -1.0 };
        let outward = match entry.on.axis() {
            Some((axis, far)) => std::array::from_fn(|c| if c == axis { sign(far) } else { 0.0 }),
            None => outward(skin, inside, middle(&points)),
        };
        let mut mark = Self {
            name: entry.on.name().to_owned(),
            words: Vec::new(),
            held: [false; 3],
            holds_all: false,
            moved: Vec::new(),
            pushed: None,
            points,
            outward,
        };
        let (times, places) = (case.load_times(), spread(&mark.points, PLACES));
        let over = Over { times: &times, places: &places };
        mark.displacement(entry, case.dim, over);
        mark.forces(entry, over);
        mark.fluid(entry);
        mark
    }

    fn displacement(&mut self, entry: &BoundarySpec, dim: usize, over: Over<'_>) {
        let mut moved = [None; 3];
        for (c, value) in entry.displacement.iter().enumerate() {
            let Some(value) = value else { continue };
            let most = over.largest(value);
            if most == 0.0 {
                self.held[c] = true;
                continue;
            }
            let mut way = [0.0; 3];
            way[c] = if most < 0.0 { -1.0 } else { 1.0 };
            self.moved.push(way);
            moved[c] = Some(most);
        }
        let held: Vec<&str> = (0..3).filter(|c| self.held[*c]).map(|c| AXES[c]).collect();
        self.holds_all = held.len() == dim;
        if !held.is_empty() {
            self.words.push(format!("{} held", held.join(", ")));
        }
        let varies = entry.displacement.iter().flatten().any(Value::varies_in_space);
        let word = if varies { "moved at most" } else { "moved" };
        self.words.extend(by_axis(word, "m", moved));
    }

    fn forces(&mut self, entry: &BoundarySpec, over: Over<'_>) {
        let values = entry.traction.each_ref().map(|value| {
            let value = value.as_ref().filter(|value| !value.is_zero())?;
            Some(over.largest(value))
        });
        let force = values.map(|value| value.unwrap_or(0.0));
        if force != [0.0; 3] {
            self.pushed = Some(unit(force));
        }
        self.words.extend(by_axis("traction", "Pa", values));
    }

    fn fluid(&mut self, entry: &BoundarySpec) {
        for (word, base, value) in
            [("pore pressure", "Pa", &entry.pressure), ("flux", "kg/m²/s", &entry.flux)]
        {
            match value {
                Some(Value::Constant(value)) => {
                    self.words.push(format!("{word}: {}", Unit::text(base, *value)));
                }
                Some(_) => self.words.push(format!("{word}: given")),
                None => {}
            }
        }
    }

    /// Takes what another entry prescribes on the same surface.
    fn join(&mut self, other: Self) {
        self.words.extend(other.words);
        (0..3).for_each(|c| self.held[c] |= other.held[c]);
        self.holds_all |= other.holds_all;
        self.moved.extend(other.moved);
        self.pushed = self.pushed.or(other.pushed);
    }
}

/// `moved x 1, z 1.7 mm`; none where there is nothing to say.
fn by_axis(word: &str, base: &str, values: [Option<f64>; 3]) -> Option<String> {
    let unit = Unit::of(base, values.into_iter().flatten());
    let part = |(axis, value): (&str, Option<f64>)| {
        Some(format!("{axis} {}", number(four(unit.number(value?)))))
    };
    let parts: Vec<String> = AXES.into_iter().zip(values).filter_map(part).collect();
    (!parts.is_empty()).then(|| format!("{word} {} {}", parts.join(", "), unit.name))
}

/// The middle of points.
pub(super) fn middle(points: &[Vector]) -> Vector {
    let share = 1.0 / points.len().max(1) as f64;
    points.iter().fold([0.0; 3], |sum, point| plus(sum, share, *point))
}

/// Up to `most` of the points, far from each other; the first is the one with the least
/// coordinates.
pub(super) fn spread(points: &[Vector], most: usize) -> Vec<Vector> {
    let order = |a: &&Vector, b: &&Vector| {
        let pairs = a.iter().zip(b.iter()).map(|(a, b)| a.total_cmp(b));
        pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    };
    let Some(first) = points.iter().min_by(order) else { return Vec::new() };
    let mut found = vec![*first];
    let mut away: Vec<f64> = vec![f64::INFINITY; points.len()];
    while found.len() < most {
        let last = found[found.len() - 1];
        for (away, point) in away.iter_mut().zip(points) {
            *away = away.min(super::vector::length(minus(*point, last)));
        }
        let farthest =
            (0..points.len()).max_by(|a, b| away[*a].total_cmp(&away[*b]).then(b.cmp(a)));
        match farthest.filter(|i| away[*i] > 0.0) {
            Some(i) => found.push(points[i]),
            None => break,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_spread_over_a_surface() {
        let points: Vec<Vector> =
            (0..25).map(|i| [f64::from(i % 5), f64::from(i / 5), 0.0]).collect();
        let found = spread(&points, 5);
        let corners = [[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0], [2.0, 2.0]];
        assert_eq!(found.len(), 5);
        assert!(corners.iter().all(|[x, y]| found.contains(&[*x, *y, 0.0])), "{found:?}");
        assert_eq!(spread(&points[..1], 5).len(), 1);
        assert!(spread(&[], 5).is_empty());
    }
}
