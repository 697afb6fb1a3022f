//! Numbers of the cells of a batch side by side.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

/// Cells of a batch.
pub const LANES: usize = 8;

/// A number of each cell of a batch.
pub type Lanes = [f64; LANES];

/// A matrix of each cell of a batch.
pub type Matrix<const DIM: usize> = [[Lanes; DIM]; DIM];

/// Zero in every cell.
pub const ZERO: Lanes = [0.0; LANES];

/// Appends the numbers `of` each cell of a batch, number by number; the first cell stands for those
/// that lack. All have as many numbers.
pub fn to_lanes<C: AsRef<[T]>, T: Copy>(
    batch: &[C],
    of: impl Fn(&[T], usize) -> T,
    out: &mut Vec<T>,
) {
    for i in 0..batch[0].as_ref().len() {
        let lane = |lane: usize| of(batch.get(lane).unwrap_or(&batch[0]).as_ref(), i);
        out.extend((0..LANES).map(lane));
    }
}

/// Takes the values at the nodes of a batch, which stand node by node.
#[inline(always)]
pub fn gather<const W: usize, const DIM: usize, const N: usize>(
    from: &[[f64; W]],
    nodes: &[u32],
    out: &mut [[Lanes; N]; DIM],
) {
    for (a, nodes) in nodes.as_chunks::<LANES>().0.iter().enumerate().take(N) {
        for lane in 0..LANES {
            let of_node = &from[nodes[lane] as usize];
            for c in 0..DIM {
                out[c][a][lane] = of_node[c];
            }
        }
    }
}

/// Where the forces go.
pub struct Target<'s, const DIM: usize> {
    first: &'s mut [[f64; DIM]],
    others: &'s mut [[f64; DIM]],
    magnitude: Option<&'s mut [f64]>,
    /// Cells that are still to come.
    left: usize,
}

impl<'s, const DIM: usize> Target<'s, DIM> {
    /// Of a pass over so many cells.
    #[inline(always)]
    pub fn new(cells: usize, force: [&'s mut [f64]; 2], magnitude: Option<&'s mut [f64]>) -> Self {
        let [first, others] = force.map(|part| part.as_chunks_mut::<DIM>().0);
        Self { first, others, magnitude, left: cells }
    }

    /// Adds the forces at the nodes of the next batch.
    #[inline(always)]
    pub fn scatter<const N: usize>(&mut self, nodes: &[u32], force: &[[Lanes; N]; DIM]) {
        let cells = self.left.min(LANES);
        self.left -= cells;
        for (a, nodes) in nodes.as_chunks::<LANES>().0.iter().enumerate().take(N) {
            for lane in 0..cells {
                let node = nodes[lane] as usize;
                let target = if node < self.first.len() {
                    &mut self.first[node]
                } else {
                    &mut self.others[node - self.first.len()]
                };
                for c in 0..DIM {
                    target[c] += force[c][a][lane];
                }
            }
            if let Some(magnitude) = &mut self.magnitude {
                for lane in 0..cells {
                    let square: f64 = (0..DIM).map(|c| force[c][a][lane].powi(2)).sum();
                    magnitude[nodes[lane] as usize] += square.sqrt();
                }
            }
        }
    }
}

/// Lamé's constants in the share of the stress that follows the strain at a point (Pa).
#[derive(Clone, Copy)]
pub struct Moduli {
    /// Of the trace.
    pub trace: f64,
    /// Shear modulus.
    pub mu: f64,
}

/// The stress from the displacement gradient in its place; `pressure` is added to the normal
/// components.
#[inline(always)]
pub fn to_stress<const DIM: usize>(h: &mut Matrix<DIM>, moduli: Moduli, pressure: &Lanes) {
    let Moduli { trace: lambda, mu } = moduli;
    let mut normal = ZERO;
    for i in 0..DIM {
        for l in 0..LANES {
            normal[l] += h[i][i][l];
        }
    }
    for l in 0..LANES {
        normal[l] = lambda * normal[l] + pressure[l];
    }
    for i in 0..DIM {
        for l in 0..LANES {
            h[i][i][l] = 2.0 * mu * h[i][i][l] + normal[l];
        }
        for j in 0..i {
            for l in 0..LANES {
                let shear = mu * (h[i][j][l] + h[j][i][l]);
                h[i][j][l] = shear;
                h[j][i][l] = shear;
            }
        }
    }
}

/// a b.
#[inline(always)]
pub fn product<const DIM: usize>(a: &Matrix<DIM>, b: &Matrix<DIM>) -> Matrix<DIM> {
    let mut out = [[ZERO; DIM]; DIM];
    for i in 0..DIM {
        for j in 0..DIM {
            for k in 0..DIM {
                for l in 0..LANES {
                    out[i][j][l] += a[i][k][l] * b[k][j][l];
                }
            }
        }
    }
    out
}

/// a b^T.
#[inline(always)]
pub fn product_transposed<const DIM: usize>(a: &Matrix<DIM>, b: &Matrix<DIM>) -> Matrix<DIM> {
    let mut out = [[ZERO; DIM]; DIM];
    for i in 0..DIM {
        for j in 0..DIM {
            for k in 0..DIM {
                for l in 0..LANES {
                    out[i][j][l] += a[i][k][l] * b[j][k][l];
                }
            }
        }
    }
    out
}

/// The transposed cofactors of a matrix, in its place: its inverse times the determinant, which is
/// handed back.
#[inline(always)]
pub fn adjugate<const DIM: usize>(j: &mut Matrix<DIM>) -> Lanes {
    let a = *j;
    let mut determinant = ZERO;
    if DIM == 2 {
        for l in 0..LANES {
            (j[0][0][l], j[1][1][l]) = (a[1][1][l], a[0][0][l]);
            (j[0][1][l], j[1][0][l]) = (-a[0][1][l], -a[1][0][l]);
            determinant[l] = a[0][0][l] * a[1][1][l] - a[0][1][l] * a[1][0][l];
        }
    } else {
        cofactors(&a, j);
        for l in 0..LANES {
            determinant[l] =
                a[0][0][l] * j[0][0][l] + a[0][1][l] * j[1][0][l] + a[0][2][l] * j[2][0][l];
        }
    }
    determinant
}

/// The transposed cofactors of a matrix of three rows.
#[inline(always)]
fn cofactors<const DIM: usize>(a: &Matrix<DIM>, out: &mut Matrix<DIM>) {
    const NEXT: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];
    for d in 0..DIM {
        for i in 0..DIM {
            let ([i1, i2], [d1, d2]) = (NEXT[i], NEXT[d]);
            for l in 0..LANES {
                out[d][i][l] = a[i1][d1][l] * a[i2][d2][l] - a[i1][d2][l] * a[i2][d1][l];
            }
        }
    }
}
