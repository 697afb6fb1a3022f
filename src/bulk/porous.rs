//! Saturated porous media: the fluid that a cell stores, and its flow.
//!
//! Pressures are those above the reference pressure of the material, at which the undeformed skeleton
//! carries nothing. Masses are divided by the reference density of the fluid: volumes in m3 (2D: per
//! metre of thickness).

use crate::case::{Material, Porous};
use crate::element::{Shape, gauss};
use crate::mesh::{Prototype, axes};

/// Corners of the largest cell.
pub const MAX_CORNERS: usize = 8;

/// The constants of one material.
#[derive(Debug, Clone, Copy)]
pub struct PorousMedium {
    /// Biot coefficient b.
    pub biot: f64,
    /// Porosity phi_0 of the undeformed state.
    pub porosity: f64,
    /// Compressibility 1/K_w of the fluid (1/Pa).
    pub fluid: f64,
    /// Compressibility 1/K_s of the grains (1/Pa).
    pub grains: f64,
    /// Permeability over viscosity k/mu (m2/(Pa s)).
    pub mobility: f64,
    /// Density of the fluid at the reference pressure (kg/m3).
    pub density: f64,
    /// Reference pressure (Pa).
    pub reference: f64,
    /// Oedometric modulus lambda + 2 mu of the skeleton (Pa).
    pub oedometric: f64,
    /// Drained bulk modulus of the skeleton (Pa), in 2D that of plane strain, lambda + mu.
    pub drained: f64,
}

/// The fluid in a volume that was 1 when undeformed, beyond what it held then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Content {
    /// Change of rho phi (1 + eps) over the reference density.
    pub change: f64,
    /// Its derivative by the volumetric strain eps.
    pub by_strain: f64,
    /// Its derivative by the pressure (1/Pa).
    pub by_pressure: f64,
}

impl PorousMedium {
    /// The constants of a material with porous data, in 2 or 3 dimensions.
    pub fn new(material: &Material, porous: &Porous, dim: usize) -> Self {
        let (young, nu) = (material.young_modulus, material.poisson_ratio);
        let lambda = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let mu = young / (2.0 * (1.0 + nu));
        Self {
            biot: porous.biot,
            porosity: porous.porosity,
            fluid: porous.fluid_compressibility,
            grains: (1.0 - porous.biot) * 3.0 * (1.0 - 2.0 * nu) / young,
            mobility: porous.permeability / porous.viscosity,
            density: porous.fluid_density,
            reference: porous.reference_pressure,
            oedometric: lambda + 2.0 * mu,
            drained: lambda + 2.0 * mu / dim as f64,
        }
    }

    /// phi = b - (b - phi_0) exp(-eps - p/K_s) at volumetric strain and pressure.
    pub fn porosity_at(&self, strain: f64, pressure: f64) -> f64 {
        self.porosity + self.widening(strain, pressure)
    }

    /// phi - phi_0, without cancellation.
    fn widening(&self, strain: f64, pressure: f64) -> f64 {
        -(self.biot - self.porosity) * (-strain - pressure * self.grains).exp_m1()
    }

    /// rho / rho_0 = exp(p/K_w).
    pub fn density_ratio(&self, pressure: f64) -> f64 {
        (pressure * self.fluid).exp()
    }

    /// The content at volumetric strain and pressure, without cancellation for small changes.
    pub fn content(&self, strain: f64, pressure: f64) -> Content {
        let denser = (pressure * self.fluid).exp_m1();
        let wider = self.widening(strain, pressure);
        let grown = denser + strain + denser * strain;
        let ratio = 1.0 + denser;
        let (porosity, stretch) = (self.porosity + wider, 1.0 + strain);
        Content {
            change: ratio * stretch * wider + self.porosity * grown,
            by_strain: ratio * ((self.biot - porosity) * stretch + porosity),
            by_pressure: ratio
                * stretch
                * (porosity * self.fluid + (self.biot - porosity) * self.grains),
        }
    }

    /// phi_0/K_w + (b - phi_0)/K_s (1/Pa): the derivative of the content by the pressure at rest.
    pub fn storage(&self) -> f64 {
        self.porosity * self.fluid + (self.biot - self.porosity) * self.grains
    }

    /// What the skeleton yields to a pressure (1/Pa): b^2 over the geometric mean of the drained bulk
    /// modulus, for motions that are free, and the oedometric one, for motions that are not.
    pub fn yielding(&self) -> f64 {
        self.biot * self.biot / (self.drained * self.oedometric).sqrt()
    }

    /// Consolidation coefficient c_v (m2/s).
    pub fn consolidation(&self) -> f64 {
        self.mobility / (self.storage() + self.biot * self.biot / self.oedometric)
    }
}

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

/// What the cells of one size, material and order have in common.
#[derive(Debug, Clone)]
pub struct PorousCell {
    /// The material.
    pub medium: PorousMedium,
    dim: usize,
    order: usize,
    /// Edge lengths by component (m).
    size: [f64; 3],
    points: Vec<Point>,
    /// Integral of b div v N: row by displacement, column by pressure (m2).
    coupling: Vec<f64>,
    /// Integral of N N: row and column by pressure (m3).
    mass: Vec<f64>,
    /// Integral of the product of the slopes of N along each component (m).
    slopes: Vec<Vec<f64>>,
}

impl PorousCell {
    /// Integrates over a box, exactly for what does not depend on the state.
    pub fn new(prototype: &Prototype, medium: PorousMedium, dim: usize) -> Self {
        let shape = Shape::of(dim, prototype.order);
        let corners = shape.corners();
        let mut size = [1.0; 3];
        axes(dim).iter().enumerate().for_each(|(c, axis)| size[c] = prototype.size[*axis]);
        let volume: f64 = size[..dim].iter().product();
        let slope = |g: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|c| 2.0 * g[c] / size[c]) };
        let point = |q: crate::element::QuadraturePoint| {
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
        let points: Vec<Point> = gauss(shape, prototype.order + 1).into_iter().map(point).collect();
        let (rows, np) = (shape.nodes() * dim, corners.nodes());
        let mut coupling = vec![0.0; rows * np];
        let mut mass = vec![0.0; np * np];
        let mut slopes = vec![vec![0.0; np * np]; dim];
        for q in &points {
            for (row, divergence) in coupling.chunks_exact_mut(np).zip(&q.divergence) {
                let factor = medium.biot * q.volume * divergence;
                row.iter_mut().zip(&q.values).for_each(|(k, n)| *k += factor * n);
            }
            for a in 0..np {
                for b in 0..np {
                    mass[a * np + b] += q.volume * q.values[a] * q.values[b];
                    for (c, slopes) in slopes.iter_mut().enumerate() {
                        let product = q.gradients[a][c] * q.gradients[b][c];
                        slopes[a * np + b] += q.volume * product;
                    }
                }
            }
        }
        Self { medium, dim, order: prototype.order, size, points, coupling, mass, slopes }
    }

    /// Corners of the cell.
    pub fn corners(&self) -> usize {
        1 << self.dim
    }

    /// Adds the forces of the pressure on the nodes, b times the integral of div v p (N).
    pub fn add_force(&self, p: &[f64], force: &mut [f64]) {
        let np = self.corners();
        for (force, row) in force.iter_mut().zip(self.coupling.chunks_exact(np)) {
            *force += row.iter().zip(p).map(|(k, p)| k * p).sum::<f64>();
        }
    }

    /// Adds the transpose of [`PorousCell::add_force`] (m3).
    pub fn add_volume(&self, u: &[f64], volume: &mut [f64]) {
        let np = self.corners();
        for (row, u) in self.coupling.chunks_exact(np).zip(u) {
            volume.iter_mut().zip(row).for_each(|(v, k)| *v += k * u);
        }
    }

    /// How much the slopes of the change of the pressure in a step are held back, by component
    /// (m2/Pa), so that the pressures of neighbours never pull the wrong way: cells of first order
    /// in displacement and pressure need b^2 h^2/(4 (lambda + 2 mu)) where nothing flows (Aguilar,
    /// Gaspar, Lisbona, Rodrigo, Int. J. Numer. Methods Engrg. 75, 2008), and h^2/6 of the storage;
    /// what flows within the step counts. Cells of second order get none.
    pub fn held_back(&self, step: &FlowStep) -> [f64; 3] {
        let m = &self.medium;
        if self.order > 1 {
            return [0.0; 3];
        }
        let stored = if step.lumped { 0.0 } else { m.storage() / 6.0 };
        let needed = m.biot * m.biot / (4.0 * m.oedometric) + stored;
        let flows = step.theta * step.length * m.mobility;
        std::array::from_fn(|c| (needed * self.size[c] * self.size[c] - flows).max(0.0))
    }

    /// Whether short steps are [held back](Self::held_back).
    pub fn is_held_back(&self) -> bool {
        self.order == 1
    }

    /// The shortest step (s) in which the pressure of the cell does not oscillate without being held
    /// back: h^2/(6 theta c_v) (Vermeer, Verruijt, Int. J. Numer. Anal. Methods Geomech. 5, 1981).
    pub fn shortest_step(&self, theta: f64) -> f64 {
        let longest = self.size[..self.dim].iter().fold(0.0_f64, |m, h| m.max(*h));
        longest * longest / (6.0 * theta * self.medium.consolidation())
    }

    /// Adds to `rows` what is stored at the end of a step at each node's share, and what flows off in the
    /// weighted part of it; `sizes` gets the sum of the magnitudes, and of what the skeleton yields to the
    /// pressure, which does not vanish where nothing flows (m3). `u` and `p` are those of the end,
    /// `before` the pressures of the start.
    pub fn add_balance(
        &self,
        (u, p, before): (&[f64], &[f64], &[f64]),
        step: &FlowStep,
        rows: &mut [f64],
        sizes: &mut [f64],
    ) {
        let np = self.corners();
        self.add_stored(u, p, step.lumped, rows, sizes);
        self.add_flow(p, &step.gravity, step.theta * step.length, rows, sizes);
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

    /// Adds the change of the stored fluid since the undeformed state at `u` and `p` (m3).
    pub fn add_stored(
        &self,
        u: &[f64],
        p: &[f64],
        lumped: bool,
        rows: &mut [f64],
        sizes: &mut [f64],
    ) {
        let np = self.corners();
        for q in &self.points {
            let strain: f64 = q.divergence.iter().zip(u).map(|(d, u)| d * u).sum();
            let values = &q.values[..np];
            if lumped {
                for a in 0..np {
                    let change = self.medium.content(strain, p[a]).change;
                    rows[a] += q.volume * values[a] * change;
                    sizes[a] += q.volume * values[a] * change.abs();
                }
                continue;
            }
            let at: f64 = values.iter().zip(p).map(|(n, p)| n * p).sum();
            let change = q.volume * self.medium.content(strain, at).change;
            for a in 0..np {
                rows[a] += values[a] * change;
                sizes[a] += values[a] * change.abs();
            }
        }
    }

    /// Adds what flows off in the time `length` at the pressures `p` (m3): Darcy's law with the density
    /// of the fluid.
    pub fn add_flow(
        &self,
        p: &[f64],
        gravity: &[f64; 3],
        length: f64,
        rows: &mut [f64],
        sizes: &mut [f64],
    ) {
        let np = self.corners();
        for q in &self.points {
            let at: f64 = q.values[..np].iter().zip(p).map(|(n, p)| n * p).sum();
            let ratio = self.medium.density_ratio(at);
            let mut flux = self.minus_flux(&q.gradients[..np], p, gravity, ratio);
            flux.iter_mut().for_each(|f| *f *= ratio * length * q.volume);
            for a in 0..np {
                let g = &q.gradients[a];
                let off = g[0] * flux[0] + g[1] * flux[1] + g[2] * flux[2];
                rows[a] += off;
                sizes[a] += off.abs();
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

    /// Derivative of the rows of [`PorousCell::add_balance`] by the pressures, linearised at rest, row
    /// by row (m3/Pa): storage, flow, and what is held back. It is symmetric and the same for every
    /// state; what it leaves out is of the order of the strain and of p/K_w.
    pub fn compressibility(&self, step: &FlowStep) -> Vec<f64> {
        let np = self.corners();
        let held = self.held_back(step);
        let flows = step.theta * step.length * self.medium.mobility;
        let flows = held.map(|held| held + flows);
        let mut matrix = vec![0.0; np * np];
        for a in 0..np {
            for b in 0..np {
                let entry = a * np + b;
                let storage = self.medium.storage() * self.mass[entry];
                let at = if step.lumped { a * np + a } else { entry };
                matrix[at] += storage;
                matrix[entry] += self.held_entry(&flows, entry);
            }
        }
        matrix
    }

    /// What the skeleton yields to a pressure, times the integral of N N (m3/Pa): about the part of the
    /// Schur complement that the displacements make (J. White, R. Borja, Comput. Geosci. 15, 2011).
    pub fn yielding(&self) -> Vec<f64> {
        let factor = self.medium.yielding();
        self.mass.iter().map(|m| factor * m).collect()
    }

    /// Flux of the fluid (kg/m2/s, by component), pressure (Pa above the reference) and porosity at
    /// the centre.
    pub fn at_centre(&self, u: &[f64], p: &[f64], gravity: &[f64; 3]) -> ([f64; 3], f64, f64) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn medium() -> PorousMedium {
        let material = Material {
            name: "rock".into(),
            z: None,
            young_modulus: 2.0,
            poisson_ratio: 0.2,
            porous: None,
        };
        let porous = Porous {
            biot: 0.8,
            porosity: 0.15,
            permeability: 0.3,
            viscosity: 2.0,
            fluid_compressibility: 0.4,
            fluid_density: 3.0,
            density: 5.0,
            reference_pressure: 0.0,
        };
        PorousMedium::new(&material, &porous, 3)
    }

    #[test]
    fn the_content_is_the_product_of_density_porosity_and_volume() {
        let m = medium();
        for (strain, p) in [(0.0, 0.0), (0.02, 0.3), (-0.01, -0.2), (1e-9, 1e-9)] {
            let rho = (m.fluid * p).exp();
            let phi = m.biot - (m.biot - m.porosity) * (-strain - p * m.grains).exp();
            let change = rho * phi * (1.0 + strain) - m.porosity;
            assert!((m.content(strain, p).change - change).abs() < 1e-15);
            assert!((m.porosity_at(strain, p) - phi).abs() < 1e-15);
        }
        let small = m.content(1e-12, 0.0).change;
        assert!((small / (m.biot * 1e-12) - 1.0).abs() < 1e-11, "no cancellation");
    }

    #[test]
    fn derivatives_of_the_content_are_its_differences() {
        let m = medium();
        let step = 1e-6;
        for (strain, p) in [(0.0, 0.0), (0.02, 0.3), (-0.01, -0.2)] {
            let c = m.content(strain, p);
            let by = |a: Content, b: Content| (a.change - b.change) / (2.0 * step);
            let by_strain = by(m.content(strain + step, p), m.content(strain - step, p));
            let by_pressure = by(m.content(strain, p + step), m.content(strain, p - step));
            assert!((c.by_strain - by_strain).abs() < 1e-9);
            assert!((c.by_pressure - by_pressure).abs() < 1e-9);
        }
        let rest = m.content(0.0, 0.0);
        assert!((rest.by_strain - m.biot).abs() < 1e-15);
        assert!((rest.by_pressure - m.storage()).abs() < 1e-15);
    }

    fn cell(dim: usize, order: usize) -> PorousCell {
        let size = if dim == 2 { [0.5, 1.0, 2.0] } else { [0.5, 0.25, 2.0] };
        PorousCell::new(&Prototype { size, material: 0, order }, medium(), dim)
    }

    /// The linearised balance is that of the tangent: central differences at rest.
    #[test]
    fn the_tangent_at_rest_is_the_difference_of_the_balance() {
        for (dim, order, lumped) in
            [(2, 1, false), (3, 1, true), (2, 2, false), (3, 2, true), (3, 1, false)]
        {
            let cell = cell(dim, order);
            let gravity = [0.0; 3];
            let step = FlowStep { length: 0.01, theta: 0.7, gravity, lumped };
            let (np, n) = (cell.corners(), cell.points[0].divergence.len());
            let at = |u: &[f64], p: &[f64]| {
                let (mut rows, mut sizes) = (vec![0.0; np], vec![0.0; np]);
                cell.add_balance((u, p, &vec![0.0; np]), &step, &mut rows, &mut sizes);
                rows
            };
            let h = 1e-6;
            let matrix = cell.compressibility(&step);
            let difference = |change: &dyn Fn(f64) -> Vec<f64>| -> Vec<f64> {
                let pairs = change(h).into_iter().zip(change(-h));
                pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect()
            };
            for b in 0..np {
                let column = difference(&|h| {
                    let mut p = vec![0.0; np];
                    p[b] = h;
                    at(&vec![0.0; n], &p)
                });
                for a in 0..np {
                    assert!(
                        (column[a] - matrix[a * np + b]).abs() < 1e-8,
                        "{dim} {order} {lumped}"
                    );
                }
            }
            for j in 0..n {
                let column = difference(&|h| {
                    let mut u = vec![0.0; n];
                    u[j] = h;
                    at(&u, &vec![0.0; np])
                });
                let mut unit = vec![0.0; n];
                unit[j] = 1.0;
                let mut volume = vec![0.0; np];
                cell.add_volume(&unit, &mut volume);
                for a in 0..np {
                    assert!((column[a] - volume[a]).abs() < 1e-8, "{dim} {order} {lumped}");
                }
            }
        }
    }

    #[test]
    fn a_constant_pressure_pushes_outwards_with_b_p_on_every_face() {
        let cell = cell(3, 2);
        let mut force = vec![0.0; cell.points[0].divergence.len()];
        cell.add_force(&[2.0; 8], &mut force);
        // On the face towards +x: b p times its area, 0.25 x 2.
        let shape = Shape::of(3, 2);
        let right = shape.node_points().iter().enumerate().filter(|(_, x)| x[0] == 1.0);
        let total: f64 = right.map(|(a, _)| force[3 * a]).sum();
        assert!((total - 0.8 * 2.0 * 0.5).abs() < 1e-14, "{total}");
    }

    /// Undrained and without flow, what cells of first order are held back by makes the pressures of a
    /// line of cells independent of each other: the matrix that is left when the displacements are
    /// eliminated has no entry of the wrong sign.
    #[test]
    fn what_is_held_back_makes_a_line_of_cells_monotone() {
        let cell = cell(2, 1);
        let m = cell.medium;
        for lumped in [false, true] {
            let still = FlowStep { length: 0.0, theta: 1.0, gravity: [0.0; 3], lumped };
            let held = cell.held_back(&still)[1];
            // Along z: two pressures; the displacements give b^2/M times 1/4 h everywhere.
            let h = cell.size[1];
            let off = m.biot * m.biot / m.oedometric * 0.25 * h - held / h
                + if lumped { 0.0 } else { m.storage() * h / 6.0 };
            assert!(off.abs() < 1e-14, "{off}");
        }
        let long = FlowStep { length: 1e9, theta: 1.0, gravity: [0.0; 3], lumped: false };
        assert_eq!(cell.held_back(&long), [0.0; 3]);
    }
}
