//! Triangles and tetrahedra with straight sides, of first and second order.
//!
//! The Jacobian is constant. The displacement gradient of a cell of second order is linear: it is
//! taken at the corners, where a few nodes make it, and integrated by the mass matrix of the
//! barycentric coordinates, V/((d + 1)(d + 2)) (1 + delta). It is its own projection on the linear
//! functions (on the constants in first order), so that B-bar changes nothing.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use super::group::Pass;
use super::lanes::{
    LANES, Lanes, Matrix, Moduli, Target, ZERO, gather, product, product_transposed, to_stress,
};
use crate::simd::Kernel;

/// A pass in `DIM` dimensions over simplices with `C` corners and `N` nodes.
pub struct Straight<'s, const DIM: usize, const C: usize, const N: usize>(pub Pass<'s>);

/// The middle node of the edge between two corners, in either order.
const fn middle(corners: usize, i: usize, j: usize) -> usize {
    const OF: [[usize; 4]; 4] = [[0, 0, 2, 3], [0, 0, 1, 4], [2, 1, 0, 5], [3, 4, 5, 0]];
    corners + OF[i][j]
}

impl<const DIM: usize, const C: usize, const N: usize> Kernel for Straight<'_, DIM, C, N> {
    #[inline(always)]
    fn run(self) {
        let Pass { group, general, field, force, magnitude } = self.0;
        let u = field.u.as_chunks::<DIM>().0;
        let moduli = Moduli { trace: general.elastic().lambda, mu: general.elastic().mu };
        let mut target = Target::<DIM>::new(group.cells, force, magnitude);
        let mut value = [[ZERO; N]; DIM];
        let geometry = group.geometry.as_chunks::<LANES>().0.chunks_exact(DIM * DIM + 1);
        for (nodes, geometry) in group.nodes.chunks_exact(N * LANES).zip(geometry) {
            gather(u, nodes, &mut value);
            let mut inverse = [[ZERO; DIM]; DIM];
            for d in 0..DIM {
                for i in 0..DIM {
                    inverse[d][i] = geometry[d * DIM + i];
                }
            }
            let volume = &geometry[DIM * DIM];
            if N == C {
                first_order(&mut value, &inverse, volume, moduli);
            } else {
                second_order::<DIM, C, N>(&mut value, &inverse, volume, moduli);
            }
            target.scatter(nodes, &value);
        }
    }
}

/// Displacements to forces.
#[inline(always)]
fn first_order<const DIM: usize, const N: usize>(
    value: &mut [[Lanes; N]; DIM],
    inverse: &Matrix<DIM>,
    volume: &Lanes,
    moduli: Moduli,
) {
    let mut along = [[ZERO; DIM]; DIM];
    for i in 0..DIM {
        for d in 0..DIM {
            for l in 0..LANES {
                along[i][d][l] = value[i][d + 1][l] - value[i][0][l];
            }
        }
    }
    let mut stress = product(&along, inverse);
    to_stress(&mut stress, moduli, &ZERO);
    let force = product_transposed(&stress, inverse);
    for i in 0..DIM {
        let mut sum = ZERO;
        for d in 0..DIM {
            for l in 0..LANES {
                value[i][d + 1][l] = volume[l] * force[i][d][l];
                sum[l] -= volume[l] * force[i][d][l];
            }
        }
        value[i][0] = sum;
    }
}

/// Displacements to forces.
#[inline(always)]
fn second_order<const DIM: usize, const C: usize, const N: usize>(
    value: &mut [[Lanes; N]; DIM],
    inverse: &Matrix<DIM>,
    volume: &Lanes,
    moduli: Moduli,
) {
    let mut stress = [[[ZERO; DIM]; DIM]; C];
    for v in 0..C {
        // Derivatives by the barycentric coordinates k: 3 u_v at v itself, else 4 u_vk - u_k.
        let mut by = [[ZERO; C]; DIM];
        for i in 0..DIM {
            for k in 0..C {
                for l in 0..LANES {
                    by[i][k][l] = if k == v {
                        3.0 * value[i][v][l]
                    } else {
                        4.0 * value[i][middle(C, v, k)][l] - value[i][k][l]
                    };
                }
            }
        }
        let mut along = [[ZERO; DIM]; DIM];
        for i in 0..DIM {
            for d in 0..DIM {
                for l in 0..LANES {
                    along[i][d][l] = by[i][d + 1][l] - by[i][0][l];
                }
            }
        }
        stress[v] = product(&along, inverse);
        to_stress(&mut stress[v], moduli, &ZERO);
    }
    forces_of_stress(&mut stress, inverse, volume, value);
}

/// Forces from the stress at the corners.
#[inline(always)]
fn forces_of_stress<const DIM: usize, const C: usize, const N: usize>(
    stress: &mut [Matrix<DIM>; C],
    inverse: &Matrix<DIM>,
    volume: &Lanes,
    value: &mut [[Lanes; N]; DIM],
) {
    let mut sum = [[ZERO; DIM]; DIM];
    for (v, i, j) in indices::<DIM, C>() {
        for l in 0..LANES {
            sum[i][j][l] += stress[v][i][j][l];
        }
    }
    let mut share = ZERO;
    for l in 0..LANES {
        share[l] = volume[l] / ((DIM + 1) * (DIM + 2)) as f64;
    }
    *value = [[ZERO; N]; DIM];
    for v in 0..C {
        for i in 0..DIM {
            for j in 0..DIM {
                for l in 0..LANES {
                    stress[v][i][j][l] = share[l] * (stress[v][i][j][l] + sum[i][j][l]);
                }
            }
        }
        let along = product_transposed(&stress[v], inverse);
        for i in 0..DIM {
            let mut by = [ZERO; C];
            for d in 0..DIM {
                by[d + 1] = along[i][d];
                for l in 0..LANES {
                    by[0][l] -= along[i][d][l];
                }
            }
            for k in 0..C {
                for l in 0..LANES {
                    if k == v {
                        value[i][v][l] += 3.0 * by[k][l];
                    } else {
                        value[i][middle(C, v, k)][l] += 4.0 * by[k][l];
                        value[i][k][l] -= by[k][l];
                    }
                }
            }
        }
    }
}

/// Corner, row and column.
#[inline(always)]
fn indices<const DIM: usize, const C: usize>() -> impl Iterator<Item = (usize, usize, usize)> {
    (0..C).flat_map(|v| (0..DIM).flat_map(move |i| (0..DIM).map(move |j| (v, i, j))))
}
