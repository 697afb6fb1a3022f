//! Derivatives by the reference coordinates at the points of a rule, and their transpose.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use super::lanes::{LANES, Lanes, Matrix, ZERO};
use crate::bulk::RulePoint;

/// What a basis of at most `N` functions does at no more than `Q` points.
pub trait Basis<const DIM: usize, const N: usize, const Q: usize> {
    /// The number of functions, and of points of the rule: known to the compiler where code of its
    /// own pays.
    fn sizes(rule: &[RulePoint]) -> [usize; 2];

    /// `out[q][i][d]`: the derivative of component i by coordinate d at point q.
    fn gradients(rule: &[RulePoint], value: &[[Lanes; N]; DIM], out: &mut [Matrix<DIM>; Q]);

    /// The transpose of [`Basis::gradients`].
    fn transposed(rule: &[RulePoint], at_points: &[Matrix<DIM>; Q], out: &mut [[Lanes; N]; DIM]);
}

/// Any basis, by the table of its gradients.
pub struct Table;

/// The products of linear functions of one coordinate each, at the points of the Gauss rule of two
/// points per direction: a derivative is the same at both points along its own coordinate, and few
/// sums and differences make it.
pub struct Corners;

impl<const DIM: usize, const N: usize, const Q: usize> Basis<DIM, N, Q> for Table {
    #[inline(always)]
    fn sizes(rule: &[RulePoint]) -> [usize; 2] {
        [rule.first().map_or(0, |point| point.gradients.len()), rule.len()]
    }

    // One component at a time: its sums stay in registers.
    #[inline(always)]
    fn gradients(rule: &[RulePoint], value: &[[Lanes; N]; DIM], out: &mut [Matrix<DIM>; Q]) {
        for (out, point) in out.iter_mut().zip(rule) {
            for i in 0..DIM {
                let mut sum = [ZERO; DIM];
                for (slope, value) in point.gradients.iter().zip(&value[i]) {
                    for d in 0..DIM {
                        for l in 0..LANES {
                            sum[d][l] += slope[d] * value[l];
                        }
                    }
                }
                out[i] = sum;
            }
        }
    }

    #[inline(always)]
    fn transposed(rule: &[RulePoint], at_points: &[Matrix<DIM>; Q], out: &mut [[Lanes; N]; DIM]) {
        *out = [[ZERO; N]; DIM];
        for (at, point) in at_points.iter().zip(rule) {
            for i in 0..DIM {
                let at = at[i];
                for (slope, out) in point.gradients.iter().zip(&mut out[i]) {
                    for d in 0..DIM {
                        for l in 0..LANES {
                            out[l] += slope[d] * at[d][l];
                        }
                    }
                }
            }
        }
    }
}

/// The node at each corner: bit d of the index says whether it lies at the upper end along d.
const NODE: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// The powers 1, 2, 3 of the coordinate of the points of the rule along each axis, 1/sqrt(3), less
/// one, by the bits of a mode: the value of the product of its coordinates but one there.
const AT: [f64; 8] = {
    const X: f64 = 0.577_350_269_189_625_8;
    const Y: f64 = X * X;
    [0.0, 1.0, 1.0, X, 1.0, X, X, Y]
};

impl<const DIM: usize, const N: usize> Basis<DIM, N, N> for Corners {
    #[inline(always)]
    fn sizes(_: &[RulePoint]) -> [usize; 2] {
        [N, N]
    }

    #[inline(always)]
    fn gradients(_: &[RulePoint], value: &[[Lanes; N]; DIM], out: &mut [Matrix<DIM>; N]) {
        for i in 0..DIM {
            let mut mode = [ZERO; N];
            for a in 0..N {
                mode[a] = value[i][NODE[a]];
            }
            // Mode m: N times the coefficient of the product of the coordinates of its bits.
            for d in 0..DIM {
                for m in 0..N {
                    if m >> d & 1 == 0 {
                        sum_and_difference(&mut mode, m, m | 1 << d);
                    }
                }
            }
            for d in 0..DIM {
                let mut part = mode;
                for m in 0..N {
                    for l in 0..LANES {
                        part[m][l] *= AT[m] / N as f64;
                    }
                }
                // To the points, over the other coordinates.
                for e in 0..DIM {
                    for m in 0..N {
                        if e != d && m >> d & 1 == 1 && m >> e & 1 == 0 {
                            to_ends(&mut part, m, m | 1 << e);
                        }
                    }
                }
                for q in 0..N {
                    out[q][i][d] = part[q | 1 << d];
                }
            }
        }
    }

    #[inline(always)]
    fn transposed(_: &[RulePoint], at_points: &[Matrix<DIM>; N], out: &mut [[Lanes; N]; DIM]) {
        for i in 0..DIM {
            let mut mode = [ZERO; N];
            for d in 0..DIM {
                let mut part = [ZERO; N];
                for m in 0..N {
                    if m >> d & 1 == 1 {
                        for l in 0..LANES {
                            part[m][l] = at_points[m][i][d][l] + at_points[m ^ 1 << d][i][d][l];
                        }
                    }
                }
                for e in 0..DIM {
                    for m in 0..N {
                        if e != d && m >> d & 1 == 1 && m >> e & 1 == 0 {
                            sum_and_difference(&mut part, m, m | 1 << e);
                        }
                    }
                }
                for m in 0..N {
                    if m >> d & 1 == 1 {
                        for l in 0..LANES {
                            mode[m][l] += AT[m] / N as f64 * part[m][l];
                        }
                    }
                }
            }
            for d in 0..DIM {
                for m in 0..N {
                    if m >> d & 1 == 0 {
                        to_ends(&mut mode, m, m | 1 << d);
                    }
                }
            }
            for a in 0..N {
                out[i][NODE[a]] = mode[a];
            }
        }
    }
}

/// Values at both ends to their sum and difference.
#[inline(always)]
fn sum_and_difference<const N: usize>(v: &mut [Lanes; N], lower: usize, upper: usize) {
    let (low, high) = (v[lower], v[upper]);
    for l in 0..LANES {
        v[lower][l] = low[l] + high[l];
        v[upper][l] = high[l] - low[l];
    }
}

/// The transpose of [`sum_and_difference`].
#[inline(always)]
fn to_ends<const N: usize>(v: &mut [Lanes; N], sum: usize, step: usize) {
    let (s, d) = (v[sum], v[step]);
    for l in 0..LANES {
        v[sum][l] = s[l] - d[l];
        v[step][l] = s[l] + d[l];
    }
}
