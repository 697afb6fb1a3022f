//! The quantities of a field file by their names.

use crate::error::{Error, Result};
use crate::input::problems::suggestion;
use crate::law::Branch;
use crate::results::{Array, Snapshot};

use super::levels::Levels;
use super::skin::Skin;
use super::vector::{Vector, dot, extent, length, plus, unit};

/// Numbers at all points or cells of a field file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Quantity {
    /// As it is asked for.
    pub name: String,
    /// In SI, without prefix.
    pub unit: &'static str,
    pub at_cells: bool,
    /// One number for each row.
    pub values: Vec<f64>,
    /// The largest number, or the length of the longest of the vectors of which these are parts.
    pub size: f64,
}

/// What numbers of an array are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    /// The number, or the length of a vector.
    Whole,
    Component(usize),
    Mises,
    /// Along the normal of an interface.
    Normal,
    /// In the plane of an interface.
    Shear,
}

const VECTOR: [&str; 3] = ["x", "y", "z"];
const TENSOR: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "xz"];

/// Less than this part of the largest number is rounding.
const ROUNDING: f64 = 1e-7;
/// The least size of jumps beside that of the interface, and of stresses (Pa), by which rounding is
/// told.
const LEAST_JUMP: f64 = 1e-6;
const LEAST_STRESS: f64 = 1e4;

/// What no drawing is of.
const NUMBERS: [&str; 2] = ["global_node_id", "global_cell_id"];

/// How the names of arrays begin that say which points are on a surface.
pub(super) const SURFACE: &str = "surface_";

/// A quantity that there is, and where it is read from.
struct Known {
    name: String,
    array: String,
    at_cells: bool,
    part: Part,
}

impl Quantity {
    /// The quantity of a field file with a name. `skin`: of an interface, whose normals are those
    /// of its facets where the file has none.
    ///
    /// # Errors
    /// [`Error::Input`] with the names that there are when this is none of them;
    /// [`Error::System`] when the file cannot be read.
    pub fn read(snapshot: &Snapshot, name: &str, skin: Option<&Skin>) -> Result<Self> {
        let known = known(snapshot, skin.is_some())?;
        let Some(found) = known.iter().find(|known| known.name == name) else {
            let names: Vec<String> = known.into_iter().map(|known| known.name).collect();
            let hint = suggestion(name, &names);
            return Err(Error::Input(format!("there is no quantity `{name}`{hint}")));
        };
        let array = if found.at_cells {
            snapshot.at_cells(&found.array)?
        } else {
            snapshot.at_points(&found.array)?
        };
        let values = match (found.part, skin) {
            (Part::Normal | Part::Shear, Some(skin)) => {
                let normals = normals(snapshot, skin)?;
                let rows = array.rows().zip(normals);
                rows.map(|(row, normal)| across(row, normal, found.part)).collect()
            }
            _ => array.rows().map(|row| number(row, found.part)).collect(),
        };
        let unit = unit_of(&found.array);
        let lengths = array.rows().map(|row| row.iter().map(|v| v * v).sum::<f64>().sqrt());
        // However small the others are, less than these are rounding.
        let least = match (found.array.as_str(), unit, skin) {
            ("jump", _, Some(skin)) => LEAST_JUMP * extent(skin.points.iter().copied()),
            (_, "Pa", _) => LEAST_STRESS,
            _ => 0.0,
        };
        let size = lengths.filter(|v| v.is_finite()).fold(least, f64::max);
        Ok(Self { name: name.to_owned(), unit, at_cells: found.at_cells, values, size })
    }

    /// The names of all quantities of a field file.
    ///
    /// # Errors
    /// [`Error::System`] when the file cannot be read.
    pub fn names(snapshot: &Snapshot, of_interface: bool) -> Result<Vec<String>> {
        Ok(known(snapshot, of_interface)?.into_iter().map(|known| known.name).collect())
    }

    /// The name in words.
    pub fn words(&self) -> String {
        match self.name.as_str() {
            "von_mises" => "von Mises stress".to_owned(),
            name => name.replace('_', " "),
        }
    }

    /// Takes for 0 what is nothing beside the largest of the same quantity at some instants.
    pub fn settle(together: &mut [&mut Self]) {
        let most = together.iter().map(|quantity| quantity.size).fold(0.0, f64::max);
        for value in together.iter_mut().flat_map(|quantity| &mut quantity.values) {
            if value.abs() <= ROUNDING * most {
                *value = 0.0;
            }
        }
    }

    /// The values at the points of a skin, or at its facets.
    pub fn on(&self, skin: &Skin) -> Vec<f64> {
        if self.at_cells {
            skin.facets.iter().map(|facet| self.values[facet.cell as usize]).collect()
        } else {
            skin.rows.iter().map(|row| self.values[*row as usize]).collect()
        }
    }

    /// Its colours for all of these numbers.
    pub fn levels(&self, numbers: impl Iterator<Item = f64> + Clone) -> Levels {
        let kinds = |words: &dyn Fn(i64) -> String| {
            let mut found: Vec<i64> = numbers.clone().map(|v| v.round() as i64).collect();
            found.sort_unstable();
            found.dedup();
            Levels::Kinds(found.into_iter().map(|kind| (kind, words(kind))).collect())
        };
        match self.name.as_str() {
            "state" => kinds(&state_words),
            "material" => kinds(&|kind| format!("material {}", kind + 1)),
            "rank" => kinds(&|kind| format!("rank {kind}")),
            name => Levels::over(numbers, self.unit, name == "damage"),
        }
    }
}

/// The regime of an interface by its number in the files.
fn state_words(kind: i64) -> String {
    let found = Branch::ALL.into_iter().find(|branch| *branch as i64 == kind);
    found.map_or_else(|| format!("state {kind}"), |branch| branch.words().to_owned())
}

/// All quantities of a field file; those of the bulk by its stress first.
fn known(snapshot: &Snapshot, of_interface: bool) -> Result<Vec<Known>> {
    let mut found = Vec::new();
    let places = [(false, snapshot.names_at_points()?), (true, snapshot.names_at_cells()?)];
    for (at_cells, arrays) in places {
        let drawn = |name: &String| !NUMBERS.contains(&name.as_str()) && !name.starts_with(SURFACE);
        for array in arrays.into_iter().filter(drawn) {
            let components = snapshot.components(&array, at_cells)?;
            let mut add = |name: String, part: Part| {
                found.push(Known { name, array: array.clone(), at_cells, part });
            };
            match components {
                1 => add(array.clone(), Part::Whole),
                3 => {
                    if of_interface && array != NORMAL {
                        let shear = if array == "jump" { "sliding" } else { "shear_traction" };
                        add(format!("normal_{array}"), Part::Normal);
                        add(shear.to_owned(), Part::Shear);
                    } else {
                        add(array.clone(), Part::Whole);
                    }
                    let parts = VECTOR.iter().enumerate();
                    parts.for_each(|(c, x)| add(format!("{array}_{x}"), Part::Component(c)));
                }
                6 => {
                    let prefix = array.strip_suffix("stress").unwrap_or(&array);
                    add(format!("{prefix}von_mises"), Part::Mises);
                    let parts = TENSOR.iter().enumerate();
                    parts.for_each(|(c, x)| add(format!("{array}_{x}"), Part::Component(c)));
                }
                _ => {}
            }
        }
    }
    Ok(found)
}

/// The array of the normals of an interface, where a file has them.
const NORMAL: &str = "normal";

/// The unit normal at each point of an interface: as the file has it, or else the mean over the
/// facets, turned so that its largest component is positive.
fn normals(snapshot: &Snapshot, skin: &Skin) -> Result<Vec<Vector>> {
    if snapshot.names_at_points()?.iter().any(|name| name == NORMAL) {
        let array: Array = snapshot.at_points(NORMAL)?;
        return Ok(array.rows().map(|row| [row[0], row[1], row[2]]).collect());
    }
    let rows = skin.rows.last().map_or(0, |row| *row as usize + 1);
    let mut sums = vec![[0.0; 3]; rows];
    for facet in &skin.facets {
        let normal = facet_normal(skin, facet);
        for node in skin.of_facet(facet) {
            let sum = &mut sums[skin.rows[*node as usize] as usize];
            *sum = plus(*sum, 1.0, normal);
        }
    }
    Ok(sums.into_iter().map(unit).collect())
}

/// Of a facet of an interface, times its area (m2; of a line, its length).
pub(super) fn facet_normal(skin: &Skin, facet: &super::skin::Facet) -> Vector {
    let area = if skin.dim == 1 {
        let [from, to] = [0, 1].map(|i| skin.points[skin.of_facet(facet)[i] as usize]);
        let along = super::vector::minus(to, from);
        match skin.depth {
            0 => [0.0, -along[2], along[1]],
            1 => [-along[2], 0.0, along[0]],
            _ => [-along[1], along[0], 0.0],
        }
    } else {
        skin.area(facet, &skin.points)
    };
    let most = (0..3).fold(2, |m, c| if area[c].abs() > area[m].abs() * 1.000001 { c } else { m });
    if area[most] < 0.0 { area.map(|c| -c) } else { area }
}

/// A part of a vector at a point with a normal.
fn across(row: &[f64], normal: Vector, part: Part) -> f64 {
    let vector = [row[0], row[1], row[2]];
    let along = dot(vector, normal);
    match part {
        Part::Normal => along,
        _ => length(plus(vector, -along, normal)),
    }
}

fn number(row: &[f64], part: Part) -> f64 {
    match part {
        Part::Component(c) => row[c],
        Part::Mises => mises(row),
        _ if row.len() == 1 => row[0],
        _ => row.iter().map(|v| v * v).sum::<f64>().sqrt(),
    }
}

/// Of xx, yy, zz, xy, yz, xz.
fn mises(s: &[f64]) -> f64 {
    let normal = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    (0.5 * normal + 3.0 * shear).sqrt()
}

fn unit_of(array: &str) -> &'static str {
    match array {
        "displacement" | "jump" => "m",
        "stress" | "effective_stress" | "traction" | "pressure" => "Pa",
        "fluid_flux" => "kg/m²/s",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stress_of_von_mises_is_that_of_a_bar_in_tension() {
        assert_eq!(mises(&[3.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 3.0);
        assert!((mises(&[0.0, 0.0, 0.0, 0.0, 2.0, 0.0]) - 12f64.sqrt()).abs() < 1e-14);
        assert_eq!(mises(&[5.0, 5.0, 5.0, 0.0, 0.0, 0.0]), 0.0);
    }

    #[test]
    fn a_straight_interface_has_the_normal_of_its_plane() {
        use crate::element::Shape;
        for (depth, normal) in [(1, [0.0, 0.0, 2.0]), (2, [0.0, 2.0, 0.0])] {
            let grid = crate::results::FieldGrid {
                points: vec![[3.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
                shapes: vec![Shape::Line2],
                starts: vec![0, 2],
                nodes: vec![0, 1],
            };
            let skin = Skin { depth, ..Skin::of(&grid) };
            let found = facet_normal(&skin, &skin.facets[0]).map(|c| c + 0.0);
            assert_eq!(found, normal);
        }
    }

    #[test]
    fn vectors_of_an_interface_have_parts_along_and_across_its_normal() {
        let normal = unit([1.0, 0.0, 1.0]);
        let row = [3.0, 2.0, 1.0];
        let along = across(&row, normal, Part::Normal);
        assert!((along - 4.0 / 2f64.sqrt()).abs() < 1e-14);
        let shear = across(&row, normal, Part::Shear);
        assert!((shear.powi(2) + along.powi(2) - 14.0).abs() < 1e-12);
    }
}
