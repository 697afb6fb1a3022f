//! Cells whose Jacobian changes from point to point.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use std::marker::PhantomData;

use super::basis::Basis;
use super::group::Pass;
use super::lanes::{
    LANES, Lanes, Matrix, Moduli, Target, ZERO, adjugate, gather, product, product_transposed,
    to_stress,
};
use crate::bulk::{General, RulePoint};
use crate::simd::Kernel;

/// A pass in `DIM` dimensions over cells of at most `N` nodes with no more than `Q` points.
pub struct Isoparametric<'s, B, const DIM: usize, const N: usize, const Q: usize> {
    pass: Pass<'s>,
    basis: PhantomData<B>,
}

impl<'s, B, const DIM: usize, const N: usize, const Q: usize> Isoparametric<'s, B, DIM, N, Q> {
    pub fn new(pass: Pass<'s>) -> Self {
        let of = pass.general;
        assert!(of.shape().nodes() <= N && of.rule().len() <= Q, "no room for a {:?}", of.shape());
        Self { pass, basis: PhantomData }
    }
}

/// Numbers of one batch.
struct Work<const DIM: usize, const N: usize, const Q: usize> {
    /// Positions of the nodes, counted from the first one (m).
    position: [[Lanes; N]; DIM],
    /// Displacements, then forces of the nodes.
    value: [[Lanes; N]; DIM],
    /// The inverse of the Jacobian times its determinant.
    adjugate: [Matrix<DIM>; Q],
    /// Displacement gradients, then what the stress does to their reference coordinates.
    gradient: [Matrix<DIM>; Q],
    /// Weight times determinant (m^dim).
    volume: [Lanes; Q],
}

impl<B: Basis<DIM, N, Q>, const DIM: usize, const N: usize, const Q: usize> Kernel
    for Isoparametric<'_, B, DIM, N, Q>
{
    #[inline(always)]
    fn run(self) {
        let Pass { group, general, field, force, magnitude } = self.pass;
        let (u, rule) = (field.u.as_chunks::<DIM>().0, general.rule());
        let (trace, on_projection) = general.lame(general.is_b_bar());
        let moduli = Moduli { trace, mu: general.elastic().mu };
        let mut target = Target::<DIM>::new(group.cells, force, magnitude);
        let mut work = Work::<DIM, N, Q>::default();
        let [n, points] = B::sizes(rule);
        for nodes in group.nodes.chunks_exact(n * LANES) {
            gather(field.points, nodes, &mut work.position);
            gather(u, nodes, &mut work.value);
            work.count_from_first_node(n);
            B::gradients(rule, &work.position, &mut work.adjugate);
            B::gradients(rule, &work.value, &mut work.gradient);
            for (q, point) in rule.iter().enumerate().take(points) {
                work.set_gradient(q, point.weight);
            }
            if general.is_b_bar() {
                let pressure = Pressure::new(&work, general, points, on_projection);
                for (q, point) in rule.iter().enumerate().take(points) {
                    let at = pressure.at(&work.position, point);
                    work.set_force(q, point.weight, moduli, &at);
                }
            } else {
                for (q, point) in rule.iter().enumerate().take(points) {
                    work.set_force(q, point.weight, moduli, &ZERO);
                }
            }
            B::transposed(rule, &work.gradient, &mut work.value);
            target.scatter(nodes, &work.value);
        }
    }
}

impl<const DIM: usize, const N: usize, const Q: usize> Default for Work<DIM, N, Q> {
    #[inline(always)]
    fn default() -> Self {
        Self {
            position: [[ZERO; N]; DIM],
            value: [[ZERO; N]; DIM],
            adjugate: [[[ZERO; DIM]; DIM]; Q],
            gradient: [[[ZERO; DIM]; DIM]; Q],
            volume: [ZERO; Q],
        }
    }
}

impl<const DIM: usize, const N: usize, const Q: usize> Work<DIM, N, Q> {
    /// Small numbers lose fewer digits in differences.
    #[inline(always)]
    fn count_from_first_node(&mut self, n: usize) {
        for i in 0..DIM {
            let first = self.position[i][0];
            for a in 0..n {
                for l in 0..LANES {
                    self.position[i][a][l] -= first[l];
                }
            }
        }
    }

    /// Jacobian and reference gradient of a point to what [`Work`] holds.
    #[inline(always)]
    fn set_gradient(&mut self, q: usize, weight: f64) {
        let determinant = adjugate(&mut self.adjugate[q]);
        let mut gradient = product(&self.gradient[q], &self.adjugate[q]);
        let mut inverse = ZERO;
        for l in 0..LANES {
            inverse[l] = 1.0 / determinant[l];
            self.volume[q][l] = weight * determinant[l];
        }
        for row in &mut gradient {
            for h in row {
                for l in 0..LANES {
                    h[l] *= inverse[l];
                }
            }
        }
        self.gradient[q] = gradient;
    }

    /// The displacement gradient of a point to the forces on the reference coordinates.
    #[inline(always)]
    fn set_force(&mut self, q: usize, weight: f64, moduli: Moduli, pressure: &Lanes) {
        let mut stress = self.gradient[q];
        to_stress(&mut stress, moduli, pressure);
        let mut force = product_transposed(&stress, &self.adjugate[q]);
        for row in &mut force {
            for f in row {
                for l in 0..LANES {
                    f[l] *= weight;
                }
            }
        }
        self.gradient[q] = force;
    }
}

/// What the projection of the volumetric strain adds to the normal stresses (Pa), a linear function
/// of the position or a constant.
struct Pressure<const DIM: usize> {
    mean: Lanes,
    /// By the position less `centre` (Pa/m); none in cells of first order.
    slope: Option<[Lanes; DIM]>,
    centre: [Lanes; DIM],
}

impl<const DIM: usize> Pressure<DIM> {
    #[inline(always)]
    fn new<const N: usize, const Q: usize>(
        work: &Work<DIM, N, Q>,
        general: &General,
        points: usize,
        modulus: f64,
    ) -> Self {
        let (mut volume, mut mean) = (ZERO, ZERO);
        let mut trace = [ZERO; Q];
        for q in 0..points {
            for i in 0..DIM {
                for l in 0..LANES {
                    trace[q][l] += work.gradient[q][i][i][l];
                }
            }
            for l in 0..LANES {
                trace[q][l] *= work.volume[q][l];
                volume[l] += work.volume[q][l];
                mean[l] += trace[q][l];
            }
        }
        for l in 0..LANES {
            mean[l] *= modulus / volume[l];
        }
        let mut pressure = Self { mean, slope: None, centre: [ZERO; DIM] };
        if general.shape().order() > 1 {
            pressure.set_slope(work, general.rule(), modulus, &volume, &trace);
        }
        pressure
    }

    #[inline(always)]
    fn set_slope<const N: usize, const Q: usize>(
        &mut self,
        work: &Work<DIM, N, Q>,
        rule: &[RulePoint],
        modulus: f64,
        volume: &Lanes,
        trace: &[Lanes; Q],
    ) {
        let (mut second, mut slope) = ([[ZERO; DIM]; DIM], [ZERO; DIM]);
        for (q, point) in rule.iter().enumerate() {
            let at = position(&work.position, point);
            for i in 0..DIM {
                for l in 0..LANES {
                    self.centre[i][l] += work.volume[q][l] * at[i][l];
                    slope[i][l] += modulus * trace[q][l] * at[i][l];
                }
                for j in 0..DIM {
                    for l in 0..LANES {
                        second[i][j][l] += work.volume[q][l] * at[i][l] * at[j][l];
                    }
                }
            }
        }
        for i in 0..DIM {
            for l in 0..LANES {
                self.centre[i][l] /= volume[l];
                slope[i][l] -= self.mean[l] * volume[l] * self.centre[i][l];
            }
        }
        for i in 0..DIM {
            for j in 0..DIM {
                for l in 0..LANES {
                    second[i][j][l] -= volume[l] * self.centre[i][l] * self.centre[j][l];
                }
            }
        }
        let determinant = adjugate(&mut second);
        let mut solved = [ZERO; DIM];
        for i in 0..DIM {
            for j in 0..DIM {
                for l in 0..LANES {
                    solved[i][l] += second[i][j][l] * slope[j][l] / determinant[l];
                }
            }
        }
        self.slope = Some(solved);
    }

    #[inline(always)]
    fn at<const N: usize>(&self, positions: &[[Lanes; N]; DIM], point: &RulePoint) -> Lanes {
        let mut pressure = self.mean;
        if let Some(slope) = &self.slope {
            let at = position(positions, point);
            for i in 0..DIM {
                for l in 0..LANES {
                    pressure[l] += slope[i][l] * (at[i][l] - self.centre[i][l]);
                }
            }
        }
        pressure
    }
}

/// The place of a point of the rule.
#[inline(always)]
fn position<const DIM: usize, const N: usize>(
    positions: &[[Lanes; N]; DIM],
    point: &RulePoint,
) -> [Lanes; DIM] {
    let mut at = [ZERO; DIM];
    for i in 0..DIM {
        for (n, x) in point.values.iter().zip(&positions[i]) {
            for l in 0..LANES {
                at[i][l] += n * x[l];
            }
        }
    }
    at
}
