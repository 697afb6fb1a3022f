//! Whether an accepted state is stable: the lowest eigenvalue of its tangent.
//!
//! Factors tell the number of negative eigenvalues by their pivots. Without factors, and for the mode
//! itself, the lowest eigenvalue is sought by LOBPCG (Knyazev, SIAM J. Sci. Comput. 23, 2001) from a
//! vector that is random on the interfaces: a symmetric one would hide a mode that tilts.

use nalgebra::{DMatrix, SymmetricEigen};

use super::condensed;
use super::interfaces::InterfaceState;
use crate::assembly::Discretization;
use crate::case::Case;
use crate::comm::Comm;
use crate::error::Result;
use crate::partition::mix;
use crate::petsc::TangentAt;

/// At least and at most so many iterations.
const ITERATIONS: [usize; 2] = [8, 60];
/// A positive eigenvalue that changes by less than this part of itself is taken as found.
const SETTLED: f64 = 1e-3;
/// Directions that add less than this to the span of the others are left out.
const DEPENDENT: f64 = 1e-12;

/// An accepted state that is not stable.
#[derive(Debug, Clone, PartialEq)]
pub struct Instability {
    /// Its time.
    pub time: f64,
    /// What the test found.
    pub found: Stability,
}

impl Instability {
    /// Whether a smaller step may lead to another state: an even state of which a mode that tilts is
    /// unstable is reached by steps of any size.
    pub fn may_depend_on_the_step(&self) -> bool {
        self.found.mode.is_none_or(|(_, kind)| kind != TILTING)
    }

    /// In words.
    pub fn words(&self, case: &Case) -> String {
        let count = match self.found.negative {
            Some(1) => "one negative eigenvalue".into(),
            Some(n) => format!("{n} negative eigenvalues"),
            None => "a negative eigenvalue".into(),
        };
        let mode = self.found.mode.map_or_else(String::new, |(interface, kind)| {
            format!("; the lowest mode is {kind} of interface {}", case.interfaces[interface].name)
        });
        format!("the state at time {} is not stable: its tangent has {count}{mode}", self.time)
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
}

/// Tests the state that was evaluated last, at which `tangent` was set up. Collective.
///
/// # Errors
/// `System` when PETSc fails.
pub fn test(
    comm: &Comm,
    all: &Discretization,
    state: &InterfaceState,
    tangent: &mut TangentAt<'_>,
) -> Result<Stability> {
    if tangent.negative_pivots == Some(0) {
        return Ok(Stability { negative: Some(0), lowest: 0.0, mode: None });
    }
    let (lowest, vector) = lowest_mode(comm, start(all, state), tangent)?;
    let mode = (lowest < 0.0).then(|| mode(comm, all, state, vector));
    Ok(Stability { negative: tangent.negative_pivots, lowest, mode })
}

/// Random at the free components of the nodes of interfaces; the same on any number of ranks.
fn start(all: &Discretization, state: &InterfaceState) -> Vec<f64> {
    let dim = all.dim;
    let free = condensed::free_components(all, state);
    let mut vector = vec![0.0; free.len()];
    for rows in &all.secondary {
        for node in rows.nodes().into_iter().filter(|n| (*n as usize) < all.nodes.owned) {
            for i in (0..dim).map(|c| node as usize * dim + c).filter(|i| free[*i]) {
                let name = all.nodes.names[node as usize] * dim as u64 + (i % dim) as u64;
                vector[i] = mix(name) as f64 / u64::MAX as f64 - 0.5;
            }
        }
    }
    vector
}

/// A vector and the tangent's product with it.
type WithProduct = (Vec<f64>, Vec<f64>);

/// The lowest eigenvalue and its vector; a negative one is a bound from above, which is proof enough.
fn lowest_mode(
    comm: &Comm,
    start: Vec<f64>,
    tangent: &mut TangentAt<'_>,
) -> Result<(f64, Vec<f64>)> {
    // Vectors with their products: the iterate, the preconditioned residual, the last change.
    let product = tangent.multiply(&start)?;
    let mut span = vec![(start, product)];
    let mut lowest = f64::INFINITY;
    for iteration in 0..ITERATIONS[1] {
        let Some((value, weights)) = least(comm, &span) else { break };
        let x = combine(&span, &weights, 0);
        let change = combine(&span, &weights, 1);
        let settled = (value - lowest).abs() <= SETTLED * value.abs();
        lowest = value;
        let found = iteration >= ITERATIONS[0] && (settled || value < 0.0);
        let residual: Vec<f64> = x.1.iter().zip(&x.0).map(|(jx, x)| jx - value * x).collect();
        let moved = span.len() > 1;
        span = vec![x];
        if found {
            break;
        }
        let direction = tangent.precondition(&residual)?;
        let product = tangent.multiply(&direction)?;
        span.push((direction, product));
        if moved {
            span.push(change);
        }
    }
    Ok((lowest, span.swap_remove(0).0))
}

/// The weighted sum of the vectors of a span from one of them on, with its product.
fn combine(span: &[WithProduct], weights: &[f64], from: usize) -> WithProduct {
    let size = span[0].0.len();
    let (mut sum, mut product) = (vec![0.0; size], vec![0.0; size]);
    for ((v, jv), weight) in span.iter().zip(weights).skip(from) {
        sum.iter_mut().zip(v).for_each(|(s, v)| *s += weight * v);
        product.iter_mut().zip(jv).for_each(|(s, v)| *s += weight * v);
    }
    (sum, product)
}

/// The least Rayleigh quotient over a span and the weights of its vector of unit length; none if the
/// span is empty. Collective.
fn least(comm: &Comm, span: &[WithProduct]) -> Option<(f64, Vec<f64>)> {
    let n = span.len();
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut sums = Vec::with_capacity(2 * n * n);
    for (a, _) in span {
        for (b, product) in span {
            sums.extend([dot(a, b), dot(a, product)]);
        }
    }
    comm.sum(&mut sums);
    let at = |kind: usize| {
        DMatrix::from_fn(n, n, |i, j| {
            0.5 * (sums[2 * (i * n + j) + kind] + sums[2 * (j * n + i) + kind])
        })
    };
    let (mass, energy) = (at(0), at(1));
    let scale = DMatrix::from_fn(n, n, |i, j| {
        if i == j && mass[(i, i)] > 0.0 { mass[(i, i)].sqrt().recip() } else { 0.0 }
    });
    let spectrum = SymmetricEigen::new(&scale * mass * &scale);
    let kept: Vec<usize> = (0..n).filter(|i| spectrum.eigenvalues[*i] > DEPENDENT).collect();
    if kept.is_empty() {
        return None;
    }
    let basis = DMatrix::from_fn(n, kept.len(), |i, j| {
        spectrum.eigenvectors[(i, kept[j])] / spectrum.eigenvalues[kept[j]].sqrt()
    });
    let basis = scale * basis;
    let reduced = SymmetricEigen::new(basis.transpose() * energy * &basis);
    let values = &reduced.eigenvalues;
    let best = (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    let weights = basis * reduced.eigenvectors.column(best);
    Some((reduced.eigenvalues[best], weights.iter().copied().collect()))
}

/// The interface that gives the most energy to a mode, and what the mode does there. Collective.
fn mode(
    comm: &Comm,
    all: &Discretization,
    state: &InterfaceState,
    mut vector: Vec<f64>,
) -> (usize, &'static str) {
    let (dim, normal) = (all.dim, all.dim - 1);
    condensed::follow(all, state, &mut vector);
    vector.resize(all.nodes.len() * dim, 0.0);
    all.nodes.update_ghosts(&mut vector, dim);
    // By interface: energy, weight, mean opening, squares of opening and sliding.
    let mut sums = vec![0.0; 5 * state.laws.len()];
    let owned = all.secondary[..all.owned_secondary()].iter().zip(&state.response);
    for (index, (rows, response)) in owned.enumerate() {
        let sums = &mut sums[5 * rows.interface..][..5];
        let w: Vec<f64> = (0..dim).map(|c| all.jump(index, c, &vector)).collect();
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
    let least = (0..by_interface.len())
        .min_by(|a, b| by_interface[*a][0].total_cmp(&by_interface[*b][0]))
        .unwrap_or(0);
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
