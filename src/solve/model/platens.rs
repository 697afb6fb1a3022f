//! Platens: surfaces of which some components move as those of a rigid body.
//!
//! Their unknowns are prescribed ones for everything else. What is prescribed is R q, with the few
//! freedoms q of all platens; those that are free follow from the balance of each platen, R^T f = F
//! with the forces f of the supports.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::BoundaryValueProblem;
use crate::bulk::Loads;
use crate::case::{Case, Motion, RigidSpec, Surface, Value, turned};
use crate::comm::Comm;
use crate::error::{Error, Result};

/// A freedom whose displacements are below this part of the size of the mesh turns nothing.
const NOTHING: f64 = 1e-12;
/// Motions that nodes tell apart by less than this part of others are not told apart.
const LEAST: f64 = 1e-12;

/// A motion of a platen: a translation along an axis, or a rotation about one through its centroid.
#[derive(Debug, Clone)]
pub struct Freedom {
    /// The entry of the case, by its number.
    entry: usize,
    /// Its surface.
    pub surface: Surface,
    /// The axis.
    pub axis: usize,
    /// Whether it is a rotation.
    pub turns: bool,
    motion: Motion,
    load: Option<Value>,
    /// Where it stands in the case, and what it is, in words.
    name: String,
}

/// What an unknown has of the freedoms.
#[derive(Debug, Clone)]
struct Row {
    /// Owned unknown.
    unknown: usize,
    /// Freedoms and their factors.
    terms: Vec<(usize, f64)>,
    /// Whether nothing else is in it.
    is_pure: bool,
    /// Whether its value is not told by the supports.
    is_carried: bool,
}

/// The platens of a case on this rank's nodes.
#[derive(Debug, Clone)]
pub struct Platens {
    /// All motions of all platens.
    pub freedoms: Vec<Freedom>,
    /// Those that follow from loads, by their places.
    pub free: Vec<usize>,
    rows: Vec<Row>,
    /// Turns R^T u into q.
    inverse: DMatrix<f64>,
    /// The largest factor of each freedom.
    pub levers: Vec<f64>,
    /// Loads of the free ones at the time that was set last (N, N m).
    pub load: Vec<f64>,
    /// By how much these jump at the start of the stage.
    pub jump: Vec<f64>,
}

impl Platens {
    /// Of a case; none where it has no platen. Collective.
    ///
    /// # Errors
    /// `Input` where nothing lies on a surface, or a moment turns nothing.
    pub fn new(comm: &Comm, case: &Case, problem: &BoundaryValueProblem) -> Result<Option<Self>> {
        let mut freedoms = Vec::new();
        let mut centroids = vec![[0.0; 3]; case.boundary.len()];
        for (entry, spec) in case.boundary.iter().enumerate() {
            let Some(rigid) = &spec.rigid else { continue };
            centroids[entry] = centroid(comm, case, problem, entry)?;
            freedoms.extend(freedoms_of(case, entry, rigid));
        }
        if freedoms.is_empty() {
            return Ok(None);
        }
        let rows = rows(case, problem, &freedoms, &centroids);
        let mut levers = vec![0.0_f64; freedoms.len()];
        for (freedom, factor) in rows.iter().flat_map(|row| &row.terms) {
            levers[*freedom] = levers[*freedom].max(factor.abs());
        }
        comm.max(&mut levers);
        let size = problem.mesh.facts.size.iter().fold(0.0_f64, |most, length| most.max(*length));
        let acts = |k: usize| levers[k] > NOTHING * if freedoms[k].turns { size } else { 1.0 };
        if let Some(idle) = (0..freedoms.len()).find(|k| freedoms[*k].load.is_some() && !acts(*k)) {
            return Err(Error::Input(format!(
                "{}: moves no point of the surface; leave its load out, or let the platen bind \
                 another component",
                freedoms[idle].name
            )));
        }
        let is_free = |k: &usize| freedoms[*k].motion == Motion::Free && acts(*k);
        let free: Vec<usize> = (0..freedoms.len()).filter(is_free).collect();
        let inverse = inverse(comm, &rows, &levers);
        let load = vec![0.0; free.len()];
        Ok(Some(Self { freedoms, free, rows, inverse, levers, jump: load.clone(), load }))
    }

    /// What a freedom is called in messages.
    pub fn name(&self, freedom: usize) -> &str {
        &self.freedoms[freedom].name
    }

    /// The displacements of owned unknowns for one of a freedom. Local.
    pub fn column(&self, freedom: usize, size: usize) -> Vec<f64> {
        let mut column = vec![0.0; size];
        for row in &self.rows {
            for (_, factor) in row.terms.iter().filter(|(k, _)| *k == freedom) {
                column[row.unknown] += factor;
            }
        }
        column
    }

    /// R^T of owned unknowns, over this rank. Local.
    pub fn times(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        self.sums(|row, factor| factor * of(row.unknown))
    }

    /// As [`Platens::times`], of magnitudes. Local.
    pub fn times_magnitude(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        self.sums(|row, factor| (factor * of(row.unknown)).abs())
    }

    /// The freedoms of a displacement of owned unknowns: those of the rigid motion closest to it.
    /// Collective.
    pub fn motions(&self, comm: &Comm, of: impl Fn(usize) -> f64) -> Vec<f64> {
        let pure =
            |row: &Row, factor: f64| if row.is_pure { factor * of(row.unknown) } else { 0.0 };
        let mut sums = self.sums(pure);
        comm.sum(&mut sums);
        (&self.inverse * DVector::from_vec(sums)).as_slice().to_vec()
    }

    /// Sums over this rank's unknowns for each freedom, with its factor in them. Local.
    fn sums(&self, part: impl Fn(&Row, f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.freedoms.len()];
        for row in &self.rows {
            row.terms.iter().for_each(|(k, factor)| sums[*k] += part(row, *factor));
        }
        sums
    }

    /// Adds what the free motions make of owned unknowns to `x`, with the motions `now`. Local.
    pub fn add_free(&self, x: &mut [f64], now: &[f64]) {
        for row in self.rows.iter().filter(|row| row.is_carried) {
            let terms = row.terms.iter().filter(|(k, _)| self.free.binary_search(k).is_ok());
            x[row.unknown] += terms.map(|(k, factor)| factor * now[*k]).sum::<f64>();
        }
    }

    /// Writes the displacements of carried unknowns into `x`, where the platens are at `now`: what
    /// is prescribed of their motions is made what it is at `time`, with `part` of its jump from
    /// `before` at the start, when the stage `began`, and everything else stays. Local.
    pub fn write(
        &self,
        x: &mut [f64],
        now: &[f64],
        (before, began): (&[f64], f64),
        (time, part): (f64, f64),
    ) {
        let mut change = vec![0.0; now.len()];
        for (k, freedom) in self.freedoms.iter().enumerate() {
            if let Motion::Given(value) = &freedom.motion {
                let [value, jump] = [time, began].map(|time| value.at([0.0; 3], time));
                change[k] = value - (1.0 - part) * (jump - before[k]) - now[k];
            }
        }
        for row in self.rows.iter().filter(|row| row.is_carried) {
            let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
                row.terms.iter().map(|(k, factor)| factor * of(*k)).sum()
            };
            // Where something else is prescribed too, the supports have written that.
            x[row.unknown] += match row.is_pure {
                true => sum(&|k| change[k]),
                false => sum(&|k| now[k] + change[k]),
            };
        }
    }

    /// Whether the supports do not tell the value of an owned unknown, or not all of it: it stays
    /// what it is until [`Platens::write`]. Local.
    pub fn carried(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().filter(|row| row.is_carried && row.is_pure).map(|row| row.unknown)
    }

    /// Sets the loads to those at `time`. Local.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub fn set_load(&mut self, time: f64) -> Result<()> {
        for (load, k) in self.load.iter_mut().zip(&self.free) {
            let freedom = &self.freedoms[*k];
            *load = freedom.load.as_ref().map_or(0.0, |value| value.at([0.0; 3], time));
            if !load.is_finite() {
                return Err(Error::Input(format!(
                    "{}: its load is {load} at time {time}; the formula must give finite numbers at \
                     every instant",
                    freedom.name
                )));
            }
        }
        Ok(())
    }
}

/// The motions of a platen.
fn freedoms_of(case: &Case, entry: usize, rigid: &RigidSpec) -> Vec<Freedom> {
    let mut freedoms = Vec::new();
    let surface = case.boundary[entry].on.name();
    let kinds = [(&rigid.along, &rigid.force, false), (&rigid.about, &rigid.moment, true)];
    for (motions, loads, turns) in kinds {
        for (axis, motion) in motions.iter().enumerate() {
            let Some(motion) = motion else { continue };
            let word = if turns { "rotation about" } else { "translation along" };
            let axis_name = ["x", "y", "z"][axis];
            freedoms.push(Freedom {
                entry,
                surface: case.boundary[entry].on.clone(),
                axis,
                turns,
                motion: motion.clone(),
                load: loads[axis].clone(),
                name: format!("boundary.{entry} ({surface}): rigid: {word} {axis_name}"),
            });
        }
    }
    freedoms
}

/// The centroid of the surface of an entry (m); of a group without facets the mean of its nodes.
/// Collective.
fn centroid(
    comm: &Comm,
    case: &Case,
    problem: &BoundaryValueProblem,
    entry: usize,
) -> Result<[f64; 3]> {
    let nodes = &problem.all.nodes;
    let surface = case.surface_bit(&case.boundary[entry].on);
    let mut sums = [0.0; 8];
    let mut add = |point: [f64; 3], weight: f64, at: usize| {
        (0..3).for_each(|i| sums[at + i] += weight * point[i]);
        sums[at + 3] += weight;
    };
    let area = Loads::area(&problem.mesh, surface).add(0.0, |name, _, weight| {
        let node = nodes.local(name).expect("a node of the rank's own cell") as usize;
        add(nodes.points[node], weight, 0);
    });
    for node in (0..nodes.owned).filter(|node| nodes.marks[*node].is_on(surface)) {
        add(nodes.points[node], 1.0, 4);
    }
    comm.agree(area)?;
    comm.sum(&mut sums);
    let of = |at: usize| -> [f64; 3] { std::array::from_fn(|i| sums[at + i] / sums[at + 3]) };
    if sums[7] == 0.0 {
        return Err(Error::Input(format!(
            "boundary.{entry} ({}): no node lies on the surface that is to move as a rigid body",
            case.boundary[entry].on.name()
        )));
    }
    Ok(of(if sums[3] > 0.0 { 0 } else { 4 }))
}

/// What this rank's unknowns have of the freedoms.
fn rows(
    case: &Case,
    problem: &BoundaryValueProblem,
    freedoms: &[Freedom],
    centroids: &[[f64; 3]],
) -> Vec<Row> {
    let (all, mut rows) = (&problem.all, Vec::new());
    for node in 0..all.nodes.owned {
        for c in (0..all.dim).filter(|c| all.prescribed[node][*c]) {
            let (of, is_pure) = problem.supports.of_platens(&all.nodes, node, c, case.axes);
            if of.is_empty() {
                continue;
            }
            let mut terms = vec![0.0; freedoms.len()];
            for term in &of {
                let lever = std::array::from_fn(|i| term.point[i] - centroids[term.entry][i]);
                for (sum, freedom) in terms.iter_mut().zip(freedoms) {
                    let moved = match freedom.turns {
                        true => turned(freedom.axis, term.axis, lever),
                        false => f64::from(u8::from(freedom.axis == term.axis)),
                    };
                    let is_own = freedom.entry == term.entry;
                    *sum += if is_own { term.factor * moved } else { 0.0 };
                }
            }
            let terms = terms.into_iter().enumerate().filter(|(_, factor)| *factor != 0.0);
            rows.push(Row {
                unknown: node * all.dim + c,
                terms: terms.collect(),
                is_pure,
                is_carried: of.iter().any(|term| term.is_carried),
            });
        }
    }
    rows
}

/// What turns R^T u into the freedoms of the closest rigid motion. Collective.
fn inverse(comm: &Comm, rows: &[Row], levers: &[f64]) -> DMatrix<f64> {
    let size = levers.len();
    let scale = |k: usize| if levers[k] > 0.0 { levers[k].recip() } else { 0.0 };
    let mut gram = DMatrix::<f64>::zeros(size, size);
    for row in rows.iter().filter(|row| row.is_pure) {
        for (i, a) in &row.terms {
            for (j, b) in &row.terms {
                gram[(*i, *j)] += a * scale(*i) * b * scale(*j);
            }
        }
    }
    comm.sum(gram.as_mut_slice());
    let inverse = pseudo_inverse(gram);
    DMatrix::from_fn(size, size, |i, j| scale(i) * inverse[(i, j)] * scale(j))
}

/// The inverse of a symmetric matrix, where it has one. The singular vectors of a matrix with equal
/// singular values are less exact.
fn pseudo_inverse(gram: DMatrix<f64>) -> DMatrix<f64> {
    let size = gram.nrows();
    let eigen = SymmetricEigen::new(gram);
    let least = LEAST * eigen.eigenvalues.amax();
    let mut inverse = DMatrix::<f64>::zeros(size, size);
    for i in (0..size).filter(|i| eigen.eigenvalues[*i] > least) {
        let vector = eigen.eigenvectors.column(i);
        inverse += vector * vector.transpose() / eigen.eigenvalues[i];
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_of_a_flat_surface_are_told_apart() {
        // Translations, then rotations, of a grid of points in the plane z = 0.
        for [rows, columns] in [[1, 4], [3, 3], [5, 5], [5, 9]] {
            let mut gram = DMatrix::<f64>::zeros(6, 6);
            let mut size = 0.0;
            for at in 0..rows * columns {
                let along = |i: usize, of: usize| i as f64 - 0.5 * (of as f64 - 1.0);
                let lever = [along(at / columns, rows), along(at % columns, columns), 1e-19];
                for axis in 0..3 {
                    let moved = |k: usize| match k {
                        0..3 => f64::from(u8::from(k == axis)),
                        _ => turned(k - 3, axis, lever),
                    };
                    let row = DVector::from_fn(6, |k, _| moved(k));
                    gram += &row * row.transpose();
                }
                size += 1.0;
            }
            let inverse = pseudo_inverse(gram.clone() / size);
            // Points in a line do not turn about it.
            let about_y = if rows == 1 { 0.0 } else { 0.7 };
            let motion = DVector::from_vec(vec![0.3, -2.0, 1.0, 0.0, about_y, -0.2]);
            let found = inverse * (gram / size) * &motion;
            assert!((found - &motion).amax() < 1e-12, "{rows} x {columns}: {motion}");
        }
    }
}
