//! Two runs, or a run and exact values, within what the test of convergence and rounding leave
//! open.

use crate::build::Built;
use crate::change::{Change, Kind};
use crate::closed::State;
use crate::launch::{Place, Run};
use std::fs;
use std::path::Path;

/// How much larger errors of displacements and tractions may be than the forces out of balance:
/// some ten cells in a row, moduli that differ by up to 50, softening that leaves a half of the
/// stiffness.
const AMPLIFICATION: f64 = 1e3;

/// Errors that are allowed: a part of the largest value of the kind in both runs, or of what the
/// loads are measured in.
pub struct Measure<'a> {
    built: &'a Built,
    part: f64,
}

impl<'a> Measure<'a> {
    /// For runs of that `solver.tolerance`.
    pub fn of(built: &'a Built, tolerance: f64) -> Self {
        Self { built, part: AMPLIFICATION * tolerance }
    }

    fn least(&self, kind: Kind) -> f64 {
        let Built { case, stress, length, .. } = self.built;
        let area = if case.flat { case.size[0] } else { case.size[0] * case.size[1] };
        let porous = case.materials[0].porous.as_ref();
        let mass = porous.map_or(1.0, |p| p.fluid_density) * 1e-4 * case.size[2];
        let unit = match kind {
            Kind::Traction => *stress,
            Kind::Length => *length,
            Kind::Damage | Kind::Time => return 1.0,
            Kind::Force => stress * area,
            Kind::Energy => stress * length * area,
            Kind::Area => area,
            Kind::Mass => mass * area,
            Kind::Flux => mass,
        };
        0.1 * unit
    }

    /// The first and worst differences in words, none if there are none.
    pub fn differences(
        &self,
        one: &Run,
        other: &Run,
        change: &Change,
        skip: &[&str],
        common: bool,
    ) -> Option<String> {
        let flat = self.built.case.flat;
        let mut found: Vec<(f64, String)> = Vec::new();
        let columns = &one.table.columns;
        for (index, name) in columns.iter().enumerate() {
            let Some(kind) = Kind::of(name).filter(|_| !skip.contains(&name.as_str())) else {
                continue;
            };
            let (other_name, factor) = change.column(name, flat);
            let Some(other_index) = other.table.column(&other_name) else {
                if !common {
                    found.push((f64::INFINITY, format!("{other_name} is missing")));
                }
                continue;
            };
            let time =
                |run: &Run, row: &[Option<f64>]| row[run.table.column("time").expect("time")];
            let scale = self.largest(one, kind).max(self.largest(other, kind) / factor.abs());
            let scale = scale.max(self.least(kind));
            for row in &one.table.rows {
                let at = time(one, row).expect("a time");
                let theirs = other.table.rows.iter().find(|r| time(other, r) == Some(at));
                let Some(theirs) = theirs else {
                    found.push((f64::INFINITY, format!("no row at {at}")));
                    continue;
                };
                match (row[index], theirs[other_index]) {
                    (Some(a), Some(b)) => {
                        let off = (b / factor - a).abs() / scale;
                        if off.is_nan() || off > self.part {
                            let words = format!(
                                "{name} at {at}: {a:e} against {:e}, {off:.1e} of the largest",
                                b / factor
                            );
                            found.push((off, words));
                        }
                    }
                    (None, None) => {}
                    (a, b) => {
                        found.push((f64::INFINITY, format!("{name} at {at}: {a:?} and {b:?}")))
                    }
                }
            }
        }
        told(found)
    }

    fn largest(&self, run: &Run, kind: Kind) -> f64 {
        let columns = run.table.columns.iter().enumerate().filter(|c| Kind::of(c.1) == Some(kind));
        let values = columns.flat_map(|(i, _)| run.table.rows.iter().filter_map(move |r| r[i]));
        values.fold(0.0, |largest, v| largest.max(v.abs()))
    }

    /// As [`Self::differences`], with exact values at the first instants.
    pub fn exact_differences(&self, run: &Run, states: &[State]) -> Option<String> {
        let case = &self.built.case;
        let mut found = Vec::new();
        for (row, state) in states.iter().enumerate() {
            let mut check = |name: &str, kind: Kind, exact: f64| {
                let Some(index) = run.table.column(name) else { return };
                let value = run.table.rows.get(row).and_then(|r| r[index]);
                let scale = self.largest(run, kind).max(self.least(kind));
                let off = value.map_or(f64::INFINITY, |v| (v - exact).abs() / scale);
                if off.is_nan() || off > self.part {
                    let value = value.unwrap_or(f64::NAN);
                    let at = case.instants[row];
                    let words = format!(
                        "{name} at {at}: {value:e}, exact {exact:e}, {off:.1e} of the largest"
                    );
                    found.push((off, words));
                }
            };
            for (index, joint) in case.joints.iter().enumerate() {
                for stat in ["min", "max"] {
                    let name = |quantity: &str| format!("{}.{quantity}.{stat}", joint.name);
                    check(&name("normal_traction"), Kind::Traction, state.traction[index]);
                    check(&name("normal_jump"), Kind::Length, state.jump[index]);
                    check(&name("damage"), Kind::Damage, state.damage[index]);
                }
            }
            check("bottom.reaction_z", Kind::Force, state.reaction[0]);
            check("top.reaction_z", Kind::Force, state.reaction[1]);
            if let Some(force) = state.aside {
                check("left.reaction_x", Kind::Force, force);
            }
        }
        told(found)
    }

    /// The nodes of an interface's file whose traction is no more than rounding.
    fn unloaded(&self, path: &Path, nodes: usize) -> Vec<bool> {
        let file = hdf5::File::open(path).expect("it was read before");
        let traction = file.dataset("VTKHDF/PointData/traction").and_then(|d| d.read_raw::<f64>());
        let traction = traction.expect("tractions beside states");
        let rounding = self.part * 0.1 * self.built.stress;
        let of_node = traction.chunks_exact((traction.len() / nodes.max(1)).max(1));
        of_node.map(|t| t.iter().all(|t| t.abs() <= rounding)).collect()
    }

    /// Every array of every field file.
    pub fn fields(&self, one: &Place, other: &Place) -> Option<String> {
        let mut found = Vec::new();
        let fields = |place: &Place| place.0.join("results/fields");
        let files = fs::read_dir(fields(one)).expect("fields").flatten().map(|e| e.path());
        for path in files.filter(|p| p.extension().is_some_and(|e| e == "vtkhdf")) {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            // The grids are read through the files of the instants.
            if name.contains("_mesh") {
                continue;
            }
            let theirs = fields(other).join(&name);
            let (Ok(a), Ok(b)) = (hdf5::File::open(&path), hdf5::File::open(&theirs)) else {
                found.push((f64::INFINITY, format!("{name} cannot be read in both")));
                continue;
            };
            for array in ["Points"].map(String::from).into_iter().chain(arrays(&a)) {
                let read = |file: &hdf5::File| {
                    file.dataset(&format!("VTKHDF/{array}")).and_then(|d| d.read_raw::<f64>()).ok()
                };
                let (Some(a), Some(b)) = (read(&a), read(&b)) else {
                    found.push((f64::INFINITY, format!("{array} of {name} is not in both")));
                    continue;
                };
                let Built { stress, length, case, .. } = self.built;
                // Without a traction the sign of what rounding left says whether lips are pressed.
                let unloaded = array.ends_with("/state").then(|| self.unloaded(&path, a.len()));
                let least = match array.rsplit('/').next().unwrap_or_default() {
                    "displacement" | "jump" => 0.1 * length,
                    "Points" => case.size[2],
                    "stress" | "traction" | "effective_stress" | "pressure" => 0.1 * stress,
                    "damage" => 1.0,
                    _ => f64::MIN_POSITIVE,
                };
                let scale = a.iter().chain(&b).fold(least, |m, v| m.max(v.abs()));
                let counts = |i: usize| unloaded.as_ref().is_none_or(|unloaded| !unloaded[i]);
                let pairs = a.iter().zip(&b).enumerate().filter(|(i, _)| counts(*i));
                let off = pairs.fold(0.0_f64, |m, (_, (a, b))| m.max((a - b).abs()));
                if a.len() != b.len() || off / scale > self.part {
                    let (a, b) = (a.len(), b.len());
                    let off = off / scale;
                    found.push((
                        off,
                        format!("{array} of {name}: {a} and {b} values, {off:.1e} of the largest"),
                    ));
                }
            }
        }
        told(found)
    }
}

fn arrays(file: &hdf5::File) -> Vec<String> {
    let mut names = Vec::new();
    for group in ["PointData", "CellData"] {
        let members = file.group(&format!("VTKHDF/{group}")).and_then(|g| g.member_names());
        names.extend(members.unwrap_or_default().into_iter().map(|n| format!("{group}/{n}")));
    }
    names
}

/// The first and the largest of them, and their number.
fn told(found: Vec<(f64, String)>) -> Option<String> {
    let worst = found.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let first = &found[0];
    let mut words = first.1.clone();
    if first.1 != worst.1 {
        words = format!("{words}; {}", worst.1);
    }
    Some(format!("{words} ({} differences)", found.len()))
}
