//! Whether an accepted state is stable: the lowest eigenvalue of its tangent.
//!
//! Factors tell the number of negative eigenvalues by their pivots. Without factors, and for the
//! mode itself, the lowest eigenvalue is sought from a vector that is random on the interfaces: a
//! symmetric one would hide a mode that tilts.

pub(in crate::solve) mod eigen;
pub(in crate::solve) mod held;

use crate::assembly::Discretization;
use crate::case::Case;
use crate::comm::Comm;
use crate::error::Result;
use crate::hash::mix;
use crate::petsc::TangentAt;
use crate::solve::model::interfaces::InterfaceState;
use crate::solve::problem::condensed;
use eigen::{Until, lowest_modes, lowest_of};

/// Modes that are sought together: those with equal eigenvalues then do not slow each other down.
const BLOCK: u64 = 3;
/// Energies of interfaces in a mode that differ by less than this part of the largest are the same.
const SAME_ENERGY: f64 = 1e-2;
/// Eigenvalues smaller than this part of the stiffness of a cell are rounding: those of bodies that
/// nothing holds come out with either sign.
const ROUNDING: f64 = 1e-12;

/// An accepted state that is not stable.
#[derive(Debug, Clone, PartialEq)]
pub struct Instability {
    /// Its time.
    pub time: f64,
    /// What the test found.
    pub found: Stability,
}

impl Instability {
    /// Whether a smaller step may lead to another state: an even state of which a mode that tilts
    /// is unstable is reached by steps of any size.
    pub fn may_depend_on_the_step(&self) -> bool {
        self.found.mode.is_none_or(|(_, kind)| kind != TILTING)
    }

    /// In words.
    pub fn words(&self, case: &Case) -> String {
        let findings = self.findings(case);
        format!("the state at time {} is not stable: its tangent has {findings}", self.time)
    }

    /// Number of negative eigenvalues and the lowest mode, in words.
    pub(super) fn findings(&self, case: &Case) -> String {
        let count = match self.found.negative {
            Some(1) => "one negative eigenvalue".into(),
            Some(n) => format!("{n} negative eigenvalues"),
            None => "a negative eigenvalue".into(),
        };
        let mode = self.found.mode.map_or_else(String::new, |(interface, kind)| {
            format!("; the lowest mode is {kind} of interface {}", case.interfaces[interface].name)
        });
        format!("{count}{mode}")
    }
}

/// A mode in which an interface opens on one side more than on the other.
const TILTING: &str = "tilting";

/// What the test found.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// Number of negative eigenvalues; `None` where only the lowest was sought.
    pub negative: Option<usize>,
    /// The lowest eigenvalue that was found (N/m).
    pub lowest: f64,
    /// Interface and kind of its mode, where it is negative.
    pub mode: Option<(usize, &'static str)>,
}

impl Stability {
    /// Whether the state is a minimum of the energy as far as the test tells.
    pub fn is_stable(&self) -> bool {
        self.negative.unwrap_or(0) == 0 && self.lowest >= 0.0
    }

    /// With the negative eigenvalues of platens that follow their loads, and the lowest of them
    /// with its mode in owned unknowns. Collective.
    pub fn with_platens(
        self,
        comm: &Comm,
        all: &Discretization,
        state: &InterfaceState,
        count: usize,
        (lowest, mode): (f64, Vec<f64>),
    ) -> Self {
        let negative = self.negative.map(|negative| negative + count);
        if self.lowest < lowest {
            return Self { negative, ..self };
        }
        let mode = Some(kind(comm, all, state, &displacement(all, state, mode)));
        Self { negative, lowest, mode }
    }
}

/// Tests the state that was evaluated last, at which `tangent` was set up; `stiffness` is that of a
/// cell (N/m). Collective.
///
/// # Errors
/// `Numerics` when the tangent cannot be factored again; `System` when PETSc fails.
pub fn test(
    comm: &Comm,
    all: &Discretization,
    state: &InterfaceState,
    tangent: &mut TangentAt<'_>,
    stiffness: f64,
) -> Result<Stability> {
    let stable = Stability { negative: Some(0), lowest: 0.0, mode: None };
    let rounding = ROUNDING * stiffness;
    if tangent.negative_pivots == Some(0) {
        return Ok(stable);
    }
    let negative = tangent.eigenvalues_below(rounding)?;
    if negative == Some(0) {
        return Ok(stable);
    }
    let start = vec![start(all, state, 0)];
    let found = lowest_modes(comm, start, tangent, Until::Proof(rounding))?.pop();
    let Some((lowest, vector)) = found else {
        return Ok(Stability { negative, lowest: f64::INFINITY, mode: None });
    };
    let lowest = if lowest.abs() <= rounding { 0.0 } else { lowest };
    let mode = (lowest < 0.0).then(|| kind(comm, all, state, &displacement(all, state, vector)));
    Ok(Stability { negative, lowest, mode })
}

/// The mode along which a state is left.
pub struct Mode {
    /// Displacement of the owned nodes, with a largest jump of 1 m where there is any.
    pub displacement: Vec<f64>,
    /// Interface and kind.
    pub kind: (usize, &'static str),
    /// Minus its energy over the square of its jumps, integrated (Pa/m): the stiffness against
    /// jumps that would make it stable.
    pub softening: f64,
}

/// The mode of the lowest eigenvalue of the state that was evaluated last, at which `tangent` was
/// set up; `of_platens` are the changes of the unknowns with the motions of platens that follow
/// their loads. Its sign, and which of several modes of the same eigenvalue it is, follow from the
/// sum of the jumps with weights that are random by the names of the nodes: they depend neither on
/// the solver nor on the number of ranks. Collective.
///
/// # Errors
/// `System` when PETSc fails.
pub fn lowest_mode(
    comm: &Comm,
    all: &Discretization,
    state: &InterfaceState,
    tangent: &mut TangentAt<'_>,
    of_platens: Vec<Vec<f64>>,
) -> Result<Mode> {
    let starts = (0..BLOCK).map(|salt| start(all, state, salt)).collect();
    let mut found = lowest_modes(comm, starts, tangent, Until::Exact)?;
    if !of_platens.is_empty() {
        // These have no energy in common with the modes of platens that stand still.
        let vectors = found.into_iter().map(|(_, vector)| vector).chain(of_platens);
        let with_product = |v: Vec<f64>| {
            let nothing = |_: &[f64], _: &mut [f64]| {};
            let product = condensed::linear_forces(comm, all, state, v.clone(), nothing);
            (v, product)
        };
        let span: Vec<_> = vectors.map(with_product).collect();
        found = lowest_of(comm, &span, BLOCK as usize);
    }
    let mut sum = vec![0.0; all.nodes.len() * all.dim];
    let mut energy = 0.0;
    for (value, vector) in found {
        let mode = displacement(all, state, vector);
        let mut weight = [0.0];
        for (index, rows) in all.secondary[..all.owned_secondary()].iter().enumerate() {
            for c in 0..all.dim {
                weight[0] += random(all, rows.node, c, 0) * all.jump(index, c, &mode);
            }
        }
        comm.sum(&mut weight);
        energy += value * weight[0] * weight[0];
        sum.iter_mut().zip(mode).for_each(|(sum, mode)| *sum += weight[0] * mode);
    }
    let size =
        |index: usize| (0..all.dim).map(|c| all.jump(index, c, &sum).powi(2)).sum::<f64>().sqrt();
    let mut largest = [(0..all.owned_secondary()).map(size).fold(0.0, f64::max)];
    comm.max(&mut largest);
    let mut square = [0.0];
    for (index, rows) in all.secondary[..all.owned_secondary()].iter().enumerate() {
        square[0] += rows.law_weight(all.dim) * size(index).powi(2);
    }
    comm.sum(&mut square);
    if largest[0] > 0.0 {
        sum.iter_mut().for_each(|u| *u /= largest[0]);
    }
    let softening = if square[0] > 0.0 { -energy / square[0] } else { 0.0 };
    let kind = kind(comm, all, state, &sum);
    sum.truncate(all.nodes.owned * all.dim);
    Ok(Mode { displacement: sum, kind, softening })
}

/// From -0.5 to 0.5 by the name of a node; the same on any number of ranks.
fn random(all: &Discretization, node: u32, component: usize, salt: u64) -> f64 {
    let name = all.nodes.names[node as usize] * all.dim as u64 + component as u64;
    // Without salt the name alone counts; names are far below 2^56.
    mix(name + (salt << 56)) as f64 / u64::MAX as f64 - 0.5
}

/// Random at the free components of the nodes of interfaces; the same on any number of ranks.
fn start(all: &Discretization, state: &InterfaceState, salt: u64) -> Vec<f64> {
    let dim = all.dim;
    let free = condensed::free_components(all, state);
    let mut vector = vec![0.0; free.len()];
    for rows in &all.secondary {
        for node in rows.nodes().into_iter().filter(|n| (*n as usize) < all.nodes.owned) {
            for c in (0..dim).filter(|c| free[node as usize * dim + c]) {
                vector[node as usize * dim + c] = random(all, node, c, salt);
            }
        }
    }
    vector
}

/// The displacements of all local nodes that belong to a vector of unknowns. Collective.
fn displacement(all: &Discretization, state: &InterfaceState, mut vector: Vec<f64>) -> Vec<f64> {
    condensed::follow(all, state, &mut vector);
    vector.resize(all.nodes.len() * all.dim, 0.0);
    all.nodes.update_ghosts(&mut vector, all.dim);
    vector
}

/// The interface that gives the most energy to a mode, the lowest of equal ones, and what the mode
/// does there; `mode` holds the displacements of all local nodes. Collective.
fn kind(
    comm: &Comm,
    all: &Discretization,
    state: &InterfaceState,
    mode: &[f64],
) -> (usize, &'static str) {
    let (dim, normal) = (all.dim, all.dim - 1);
    // By interface: energy, weight, mean opening, squares of opening and sliding.
    let mut sums = vec![0.0; 5 * state.laws.len()];
    let owned = all.secondary[..all.owned_secondary()].iter().zip(&state.response);
    for (index, (rows, response)) in owned.enumerate() {
        let sums = &mut sums[5 * rows.interface..][..5];
        let w: Vec<f64> = (0..dim).map(|c| all.jump(index, c, mode)).collect();
        let weight = rows.law_weight(dim);
        for (c, d) in (0..dim).flat_map(|c| (0..dim).map(move |d| (c, d))) {
            sums[0] += weight * w[c] * response.state.tangent[c][d] * w[d];
        }
        sums[1] += weight;
        sums[2] += weight * w[normal];
        sums[3] += weight * w[normal] * w[normal];
        sums[4] += weight * w[..normal].iter().map(|w| w * w).sum::<f64>();
    }
    comm.sum(&mut sums);
    let by_interface: Vec<&[f64]> = sums.chunks_exact(5).collect();
    let energies = by_interface.iter().map(|sums| sums[0]);
    let lowest = energies.clone().fold(f64::INFINITY, f64::min);
    let largest = energies.clone().map(f64::abs).fold(0.0, f64::max);
    let is_lowest = |energy: f64| energy <= lowest + SAME_ENERGY * largest;
    let least = energies.clone().position(is_lowest).unwrap_or(0);
    let [_, weight, mean, opening, sliding] = by_interface[least] else { return (least, "jump") };
    let kind = if sliding > opening {
        "sliding"
    } else if mean * mean > 0.5 * opening * weight {
        "opening"
    } else {
        TILTING
    };
    (least, kind)
}
