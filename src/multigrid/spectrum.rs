//! The largest eigenvalue of an operator over its diagonal: where the smoother's interval ends.

use nalgebra::DMatrix;

use crate::assembly::{Precision, TangentOperator};
use crate::comm::Comm;
use crate::hash::mix;
use crate::petsc::LinearOperator;

/// Lanczos steps; ten find the end of such a spectrum to a few percent, from below.
const STEPS: usize = 10;
/// Margin for what they miss.
const MARGIN: f64 = 1.1;

/// An upper estimate of the largest eigenvalue of D^-1 J, by Lanczos' method from a vector that is
/// the same on any number of ranks. Collective.
///
/// The products are those of the precision `T`, which has to hold the operator's entries.
pub fn largest_eigenvalue<T: Precision>(comm: &Comm, operator: &TangentOperator) -> f64 {
    let all = operator.discretization();
    let size = all.nodes.owned * all.dim;
    let mut scale = vec![0.0; size];
    operator.diagonal(&mut scale);
    scale.iter_mut().for_each(|d| *d = d.sqrt().recip());
    let identity = operator.identity_marks();
    let start = |i: usize| {
        let name = all.nodes.names[i / all.dim] * 3 + (i % all.dim) as u64;
        if identity[i] { 0.0 } else { mix(name) as f64 / u64::MAX as f64 - 0.5 }
    };
    let mut v: Vec<f64> = (0..size).map(start).collect();
    let (mut before, mut w) = (vec![0.0; size], vec![0.0; size]);
    let (mut x, mut product) = (vec![T::ZERO; size], vec![T::ZERO; size]);
    let norm = |v: &[f64]| {
        let mut square = [v.iter().map(|v| v * v).sum::<f64>()];
        comm.sum(&mut square);
        square[0].sqrt()
    };
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut beta = norm(&v);
    for _ in 0..STEPS {
        if beta == 0.0 {
            break;
        }
        v.iter_mut().for_each(|v| *v /= beta);
        x.iter_mut().zip(&v).zip(&scale).for_each(|((x, v), s)| *x = T::from_double(v * s));
        operator.multiply_in(&x, &mut product);
        let products = w.iter_mut().zip(&product).zip(&scale);
        products.for_each(|((w, product), s)| *w = product.to_double() * s);
        let back = if diagonal.is_empty() { 0.0 } else { beta };
        let mut alpha = [w.iter().zip(&v).map(|(w, v)| w * v).sum::<f64>()];
        comm.sum(&mut alpha);
        for ((w, v), before) in w.iter_mut().zip(&v).zip(&before) {
            *w -= alpha[0] * v + back * before;
        }
        diagonal.push(alpha[0]);
        beta = norm(&w);
        beside.push(beta);
        std::mem::swap(&mut before, &mut v);
        std::mem::swap(&mut v, &mut w);
    }
    if diagonal.is_empty() {
        // Nothing is free: identity rows alone.
        return MARGIN;
    }
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    };
    let spectrum = DMatrix::from_fn(diagonal.len(), diagonal.len(), entry).symmetric_eigenvalues();
    MARGIN * spectrum.iter().copied().fold(0.0, f64::max)
}
