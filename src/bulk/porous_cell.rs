//! The cells of a saturated porous medium: what they store, and the flow in them.
//!
//! Pressures and masses as in [`PorousMedium`].

mod general;

use super::PorousMedium;
use super::poro_state::{BalanceSums, PoroState};
use crate::element::{QuadraturePoint, Shape, gauss};

/// Corners of the largest cell.
pub const MAX_CORNERS: usize = 8;

/// Part of the flow that the pressure of each corner alone would drive which counts among the
/// magnitudes. Where nothing flows it cancels up to rounding, which in a long step is more than all
/// that is stored; this part is so small that it counts nowhere else.
pub const CANCELLED: f64 = 1e-3;

/// How a step of time is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowStep {
    /// Its length (s).
    pub length: f64,
    /// Weight of its end, 0.5 to 1.
    pub theta: f64,
    /// Acceleration of gravity by component (m/s2).
    pub gravity: [f64; 3],
    /// Whether each node stores the fluid of its share of the cell by its own pressure.
    pub lumped: bool,
}

impl FlowStep {
    /// Whether the linearised flow of this step serves the other one: instants at equal distances
    /// differ by rounding.
    pub fn serves(&self, other: &Self) -> bool {
        const PART: f64 = 1e-9;
        let rounded = (self.length - other.length).abs() <= PART * other.length.abs();
        rounded && Self { length: other.length, ..*self } == *other
    }
}

/// A point of the Gauss rule of a cell.
#[derive(Debug, Clone)]
struct Point {
    /// Weight times volume (m3).
    volume: f64,
    /// Derivatives of the volumetric strain by the displacements (1/m).
    divergence: Vec<f64>,
    /// Values of the linear shape functions of the pressure.
    values: [f64; MAX_CORNERS],
    /// Their gradients (1/m).
    gradients: [[f64; 3]; MAX_CORNERS],
}

/// A cell, or what boxes of one size, material and order have in common.
#[derive(Debug, Clone)]
pub struct PorousCell {
    /// The material.
    pub medium: PorousMedium,
    dim: usize,
    shape: Shape,
    /// Lengths of the cell along its directions (m): those of the components, and of general cells
    /// with sides that lie across from each other those of the reference coordinates.
    size: [f64; 3],
    points: Vec<Point>,
    /// Integral of b div v N: row by displacement, column by pressure (m2).
    coupling: Vec<f64>,
    /// Its transpose.
    transposed: Vec<f64>,
    /// Integral of N N: row and column by pressure (m3).
    mass: Vec<f64>,
    /// Integral of the product of the slopes of N along each direction (m).
    slopes: Vec<Vec<f64>>,
    /// Integral of the product of the gradients of N (m), where it is not the sum of `slopes`.
    gradients: Option<Vec<f64>>,
}

impl PorousCell {
    /// Integrates over a box, exactly for what does not depend on the state. Its `size` is that
    /// along x, y, z (m); displacement components lie along `axes`.
    pub fn new(shape: Shape, size: [f64; 3], medium: PorousMedium, axes: &[usize]) -> Self {
        let dim = axes.len();
        let corners = shape.corners();
        let mut along = [1.0; 3];
        axes.iter().enumerate().for_each(|(c, axis)| along[c] = size[*axis]);
        let size = along;
        let volume: f64 = size[..dim].iter().product();
        let slope = |g: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|c| 2.0 * g[c] / size[c]) };
        let point = |q: QuadraturePoint| {
            let mut reference = vec![[0.0; 3]; shape.nodes()];
            shape.gradients(q.xi, &mut reference);
            let divergence = reference.iter().flat_map(|g| slope(g).into_iter().take(dim));
            let mut values = [0.0; MAX_CORNERS];
            corners.values(q.xi, &mut values);
            let mut of_corners = [[0.0; 3]; MAX_CORNERS];
            corners.gradients(q.xi, &mut of_corners);
            Point {
                volume: q.weight * volume / f64::from(1 << dim),
                divergence: divergence.collect(),
                values,
                gradients: of_corners.map(|g| slope(&g)),
            }
        };
        let points: Vec<Point> = gauss(shape, shape.order() + 1).into_iter().map(point).collect();
        let along: Vec<_> = points.iter().map(|q| q.gradients).collect();
        Self::integrate(shape, size, medium, points, &along)
    }

    /// `along` gives the slopes along the directions of the cell at each point.
    fn integrate(
        shape: Shape,
        size: [f64; 3],
        medium: PorousMedium,
        points: Vec<Point>,
        along: &[[[f64; 3]; MAX_CORNERS]],
    ) -> Self {
        let dim = shape.dim();
        let (rows, np) = (shape.nodes() * dim, shape.corners().nodes());
        let mut coupling = vec![0.0; rows * np];
        let mut mass = vec![0.0; np * np];
        let mut slopes = vec![vec![0.0; np * np]; dim];
        for (q, along) in points.iter().zip(along) {
            for (row, divergence) in coupling.chunks_exact_mut(np).zip(&q.divergence) {
                let factor = medium.biot * q.volume * divergence;
                row.iter_mut().zip(&q.values).for_each(|(k, n)| *k += factor * n);
            }
            for (entry, (a, b)) in entries(np).enumerate() {
                mass[entry] += q.volume * q.values[a] * q.values[b];
                for (c, slopes) in slopes.iter_mut().enumerate() {
                    slopes[entry] += q.volume * (along[a][c] * along[b][c]);
                }
            }
        }
        let by_pressure = |a: usize| coupling.iter().skip(a).step_by(np).copied();
        let transposed = (0..np).flat_map(by_pressure).collect();
        let gradients = None;
        Self { medium, dim, shape, size, points, coupling, transposed, mass, slopes, gradients }
    }

    /// The shape of the cell.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Corners of the cell.
    pub fn corners(&self) -> usize {
        self.shape.corners().nodes()
    }

    /// Integral of b div v N: row by displacement, column by pressure (m2).
    pub fn coupling(&self) -> &[f64] {
        &self.coupling
    }

    /// Its transpose: the forces of each pressure of 1 Pa on the nodes, one after the other (m2).
    pub fn forces(&self) -> &[f64] {
        &self.transposed
    }

    /// Adds the forces of the pressure on the nodes, b times the integral of div v p (N).
    #[inline(always)] // for `simd`
    pub fn add_force(&self, p: &[f64], force: &mut [f64]) {
        for (row, p) in self.transposed.chunks_exact(force.len()).zip(p) {
            for (force, k) in force.iter_mut().zip(row) {
                *force += k * p;
            }
        }
    }

    /// Adds the transpose of [`PorousCell::add_force`] (m3).
    #[inline(always)] // for `simd`
    pub fn add_volume(&self, u: &[f64], volume: &mut [f64; MAX_CORNERS]) {
        match self.corners() {
            3 => self.add_volume_at::<3>(u, volume),
            4 => self.add_volume_at::<4>(u, volume),
            5 => self.add_volume_at::<5>(u, volume),
            6 => self.add_volume_at::<6>(u, volume),
            _ => self.add_volume_at::<MAX_CORNERS>(u, volume),
        }
    }

    #[inline(always)]
    fn add_volume_at<const CORNERS: usize>(&self, u: &[f64], volume: &mut [f64; MAX_CORNERS]) {
        let mut sum = [0.0; CORNERS];
        for (row, u) in self.coupling.as_chunks::<CORNERS>().0.iter().zip(u) {
            for (sum, k) in sum.iter_mut().zip(row) {
                *sum += k * u;
            }
        }
        volume.iter_mut().zip(sum).for_each(|(v, sum)| *v += sum);
    }

    /// How much the slopes of the change of the pressure in a step are held back, by component
    /// (m2/Pa), so that the pressures of neighbours never pull the wrong way: cells of first order
    /// in displacement and pressure need b^2 h^2/(4 (lambda + 2 mu)) where nothing flows (Aguilar,
    /// Gaspar, Lisbona, Rodrigo, Int. J. Numer. Methods Engrg. 75, 2008), and h^2/6 of the storage;
    /// what flows within the step counts. Cells of second order get none.
    pub fn held_back(&self, step: &FlowStep) -> [f64; 3] {
        let m = &self.medium;
        if self.shape.order() > 1 {
            return [0.0; 3];
        }
        let stored = if step.lumped { 0.0 } else { m.storage() / 6.0 };
        let needed = m.biot * m.biot / (4.0 * m.oedometric) + stored;
        let flows = step.theta * step.length * m.mobility;
        std::array::from_fn(|c| (needed * self.size[c] * self.size[c] - flows).max(0.0))
    }

    /// Whether short steps are [held back](Self::held_back).
    pub fn is_held_back(&self) -> bool {
        self.shape.order() == 1
    }

    /// The shortest steps (s) in which the pressure of the cell does not oscillate along its
    /// shortest edge and along any, without being held back: h^2/(6 theta c_v) (Vermeer, Verruijt,
    /// Int. J. Numer. Anal. Methods Geomech. 5, 1981).
    pub fn shortest_steps(&self, theta: f64) -> [f64; 2] {
        let edges = &self.size[..self.dim];
        let shortest = edges.iter().fold(f64::INFINITY, |m, h| m.min(*h));
        let longest = edges.iter().fold(0.0_f64, |m, h| m.max(*h));
        [shortest, longest].map(|h| h * h / (6.0 * theta * self.medium.consolidation()))
    }

    /// Adds to the rows what is stored at the end of a step at each node's share, and what flows
    /// off in the weighted part of it; the sizes get the sum of the magnitudes, and of what the
    /// skeleton yields to the pressure, which does not vanish where nothing flows (m3). `end` is
    /// the state at the end, `before` are the pressures of the start.
    pub fn add_balance(
        &self,
        end: PoroState<'_>,
        before: &[f64],
        step: &FlowStep,
        mut sums: BalanceSums<'_>,
    ) {
        let (np, p) = (self.corners(), end.pressure);
        self.add_stored(end, step.lumped, sums.reborrow());
        self.add_flow(p, &step.gravity, step.theta * step.length, sums.reborrow());
        let BalanceSums { rows, sizes } = sums;
        let yielding = self.medium.yielding();
        for (a, size) in sizes.iter_mut().enumerate() {
            let share: f64 = self.mass[a * np..][..np].iter().sum();
            *size += yielding * share * p[a].abs();
        }
        let held = self.held_back(step);
        if held == [0.0; 3] {
            return;
        }
        for a in 0..np {
            let mut sum = 0.0;
            for b in 0..np {
                let change = p[b] - before[b];
                sum += self.held_entry(&held, a * np + b) * change;
            }
            rows[a] += sum;
            sizes[a] += sum.abs();
        }
    }

    fn held_entry(&self, held: &[f64; 3], entry: usize) -> f64 {
        self.slopes.iter().zip(held).map(|(slopes, held)| held * slopes[entry]).sum()
    }

    /// Adds the change of the stored fluid since the undeformed state (m3).
    pub fn add_stored(&self, state: PoroState<'_>, lumped: bool, sums: BalanceSums<'_>) {
        let PoroState { displacement: u, pressure: p } = state;
        let (np, BalanceSums { rows, sizes }) = (self.corners(), sums);
        for q in &self.points {
            let strain: f64 = q.divergence.iter().zip(u).map(|(d, u)| d * u).sum();
            let values = &q.values[..np];
            if lumped {
                for a in 0..np {
                    let change = self.medium.content(strain, p[a]);
                    rows[a] += q.volume * values[a] * change;
                    sizes[a] += q.volume * values[a] * change.abs();
                }
                continue;
            }
            let at: f64 = values.iter().zip(p).map(|(n, p)| n * p).sum();
            let change = q.volume * self.medium.content(strain, at);
            for a in 0..np {
                rows[a] += values[a] * change;
                sizes[a] += values[a] * change.abs();
            }
        }
    }

    /// Adds what flows off in the time `length` at the pressures `p` (m3): Darcy's law with the
    /// density of the fluid.
    pub fn add_flow(&self, p: &[f64], gravity: &[f64; 3], length: f64, sums: BalanceSums<'_>) {
        let (np, BalanceSums { rows, sizes }) = (self.corners(), sums);
        for q in &self.points {
            let at: f64 = q.values[..np].iter().zip(p).map(|(n, p)| n * p).sum();
            let ratio = self.medium.density_ratio(at);
            let mut flux = self.minus_flux(&q.gradients[..np], p, gravity, ratio);
            let factor = ratio * length * q.volume;
            flux.iter_mut().for_each(|f| *f *= factor);
            let steepness = |g: &[f64; 3]| g.iter().map(|g| g.abs()).sum::<f64>();
            let alone = q.gradients[..np].iter().zip(p).map(|(g, p)| steepness(g) * p.abs());
            let cancelled = CANCELLED * self.medium.mobility * factor * alone.sum::<f64>();
            for a in 0..np {
                let g = &q.gradients[a];
                let off = g[0] * flux[0] + g[1] * flux[1] + g[2] * flux[2];
                rows[a] += off;
                sizes[a] += off.abs() + cancelled * steepness(g);
            }
        }
    }

    /// (k/mu) (grad p - rho g), by component (m/s).
    fn minus_flux(
        &self,
        gradients: &[[f64; 3]],
        p: &[f64],
        gravity: &[f64; 3],
        ratio: f64,
    ) -> [f64; 3] {
        std::array::from_fn(|c| {
            if c >= self.dim {
                return 0.0;
            }
            let slope: f64 = gradients.iter().zip(p).map(|(g, p)| g[c] * p).sum();
            self.medium.mobility * (slope - self.medium.density * ratio * gravity[c])
        })
    }

    /// Derivative of the rows of [`PorousCell::add_balance`] by the pressures, linearised at rest,
    /// row by row (m3/Pa): storage, flow, and what is held back. It is symmetric and the same for
    /// every state; what it leaves out is of the order of the strain and of p/K_w.
    pub fn compressibility(&self, step: &FlowStep) -> Vec<f64> {
        let np = self.corners();
        let held = self.held_back(step);
        let flows = step.theta * step.length * self.medium.mobility;
        let along = held.map(|held| if self.gradients.is_some() { held } else { held + flows });
        let mut matrix = vec![0.0; np * np];
        for a in 0..np {
            for b in 0..np {
                let entry = a * np + b;
                let storage = self.medium.storage() * self.mass[entry];
                let at = if step.lumped { a * np + a } else { entry };
                matrix[at] += storage;
                matrix[entry] += self.held_entry(&along, entry);
                if let Some(gradients) = &self.gradients {
                    matrix[entry] += flows * gradients[entry];
                }
            }
        }
        matrix
    }

    /// What the skeleton yields to a pressure, times the integral of N N (m3/Pa): about the part of
    /// the Schur complement that the displacements make (J. White, R. Borja, Comput. Geosci. 15,
    /// 2011).
    pub fn yielding(&self) -> Vec<f64> {
        let factor = self.medium.yielding();
        self.mass.iter().map(|m| factor * m).collect()
    }

    /// Flux of the fluid (kg/m2/s, by component), pressure (Pa above the reference) and porosity at
    /// the centre.
    pub fn at_centre(&self, state: PoroState<'_>, gravity: &[f64; 3]) -> ([f64; 3], f64, f64) {
        let PoroState { displacement: u, pressure: p } = state;
        let np = self.corners();
        let pressure = p[..np].iter().sum::<f64>() / np as f64;
        let ratio = self.medium.density_ratio(pressure);
        let volume: f64 = self.points.iter().map(|q| q.volume).sum();
        // Averages of the values at the points of the rule.
        let mut strain = 0.0;
        let mut gradients = [[0.0; 3]; MAX_CORNERS];
        for q in &self.points {
            let share = q.volume / volume;
            strain += share * q.divergence.iter().zip(u).map(|(d, u)| d * u).sum::<f64>();
            for (sum, g) in gradients.iter_mut().zip(&q.gradients) {
                (0..3).for_each(|c| sum[c] += share * g[c]);
            }
        }
        let flux = self.minus_flux(&gradients[..np], p, gravity, ratio);
        let density = -self.medium.density * ratio;
        (flux.map(|f| density * f), pressure, self.medium.porosity_at(strain, pressure))
    }
}

/// Row and column of the entries of a matrix between corners.
fn entries(np: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..np).flat_map(move |a| (0..np).map(move |b| (a, b)))
}

#[cfg(test)]
#[path = "porous_tests.rs"]
mod tests;
