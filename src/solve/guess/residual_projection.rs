//! Starts coupled linear solves from earlier corrections.
//!
//! Pores and bulk answer almost linearly: the next correction lies close to the span of those
//! before, be it that the load grows on or that the pressure decays. The start is the element of
//! that span which leaves the smallest residual. [`crate::solve::guess::energy_projection`] is the
//! like for the mechanical problem, in its energy norm, which the indefinite coupled matrix has
//! not.

use super::energy_projection::{best_weights, dot};
use crate::comm::Comm;

/// Corrections that are kept.
const KEPT: usize = 8;

/// A correction of displacements and scaled pressures, owned entries.
struct Correction {
    /// Of the displacements themselves, whatever the unknowns are.
    values: Vec<f64>,
    /// Its product with the present matrix, once that is wanted.
    product: Option<Vec<f64>>,
}

/// The last corrections of one rank.
#[derive(Default)]
pub struct ResidualProjection {
    kept: Vec<Correction>,
}

impl ResidualProjection {
    /// Keeps a correction. Local.
    pub fn keep(&mut self, values: &[f64]) {
        if self.kept.len() == KEPT {
            self.kept.remove(0);
        }
        self.kept.push(Correction { values: values.to_vec(), product: None });
    }

    /// Tells that the matrix has changed. Local.
    pub fn forget_products(&mut self) {
        self.kept.iter_mut().for_each(|kept| kept.product = None);
    }

    /// Adds the best start to `guess`, whose product with the matrix has been taken off `rhs`.
    /// `unknowns` turns a correction into one of the present unknowns, 0 where rows are the
    /// identity; `multiply` is the product with the matrix. Collective.
    pub fn add_best(
        &mut self,
        comm: &Comm,
        unknowns: impl Fn(&mut [f64]),
        multiply: impl Fn(&[f64], &mut [f64]),
        rhs: &[f64],
        guess: &mut [f64],
    ) {
        let n = self.kept.len();
        for kept in self.kept.iter_mut().filter(|kept| kept.product.is_none()) {
            let mut x = kept.values.clone();
            unknowns(&mut x);
            let mut product = vec![0.0; x.len()];
            multiply(&x, &mut product);
            kept.product = Some(product);
        }
        let products: Vec<&[f64]> = self.kept.iter().filter_map(|k| k.product.as_deref()).collect();
        let mut sums = Vec::with_capacity(n * (n + 3) / 2);
        for (j, b) in products.iter().enumerate() {
            sums.extend(products[..=j].iter().map(|a| dot(a, b)));
            sums.push(dot(b, rhs));
        }
        comm.sum(&mut sums);
        let Some(weights) = best_weights(n, &sums) else { return };
        let mut sum = vec![0.0; guess.len()];
        for (weight, kept) in weights.iter().zip(&self.kept) {
            sum.iter_mut().zip(&kept.values).for_each(|(s, v)| *s += weight * v);
        }
        unknowns(&mut sum);
        guess.iter_mut().zip(&sum).for_each(|(g, s)| *g += s);
    }
}
