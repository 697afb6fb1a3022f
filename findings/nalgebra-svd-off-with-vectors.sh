#!/usr/bin/env bash
# nalgebra's singular value decomposition is off in the third digit where vectors are asked for.
#
# Versions: nalgebra 0.35.0, Rust 1.88 or newer.
#
# Input: a symmetric matrix of condition 4, diag(1/2, 1/2, 2), whose third row and column couple to
# the others by 1e-15, as sums that should cancel leave them. A second one of four rows.
#
# Expected: singular values 2, 1/2, 1/2, and U S V^T the matrix, to some 1e-15; the same values
# whether or not vectors are asked for.
#
# What happens instead: `svd(false, false)` gives 2, 1/2, 1/2. `svd(true, true)` of the same matrix
# gives 2.0074, 0.5018, 0.5, with U and V that are orthogonal to the last digit, and U S V^T is off
# by 0.17. `pseudo_inverse` of this regular matrix is no inverse in its first digit. Without the
# couplings, or with a Matrix3, which has a method of its own, all is well; a Matrix4 is off too.
# `SymmetricEigen` is right for the same matrix.
#
# Output seen:
#   DMatrix, values alone: right
#   DMatrix, values with vectors: off by more than 0.005
#   DMatrix, U and V: orthogonal
#   DMatrix, U S V^T: off by more than 0.1
#   DMatrix, pseudo_inverse: off by more than 0.1
#   DMatrix, U S V^T without couplings: right
#   DMatrix, SymmetricEigen: right
#   Matrix3, U S V^T: right
#   Matrix4, U S V^T: off by more than 0.1
#
# Why it matters: nothing is singular here, nothing large or small, and who checks that the factors
# are orthogonal sees nothing. Matrices of moments, of supports and of fits have equal singular
# values wherever a body is symmetric, and couplings of that size wherever sums are rounded.
set -euo pipefail

script=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/$(basename "${BASH_SOURCE[0]}")
command -v cargo >/dev/null || { echo "cargo is missing"; exit 2; }
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
cd "$tmp"
mkdir src
cat >Cargo.toml <<'TOML'
[package]
name = "factors"
version = "0.0.0"
edition = "2021"
[dependencies]
nalgebra = "=0.35.0"
TOML
cat >src/main.rs <<'RUST'
use nalgebra::{DMatrix, Matrix3, Matrix4, SymmetricEigen};

const RIGHT: f64 = 1e-13;

fn told(off: f64) -> &'static str {
    if off < RIGHT {
        "right"
    } else if off > 0.1 {
        "off by more than 0.1"
    } else if off > 0.005 {
        "off by more than 0.005"
    } else {
        "something else"
    }
}

fn diagonal(coupling: f64) -> DMatrix<f64> {
    let c = coupling;
    DMatrix::from_row_slice(3, 3, &[0.5, 0.0, c, 0.0, 0.5, c, c, c, 2.0])
}

fn main() {
    let one = DMatrix::<f64>::identity(3, 3);
    let a = diagonal(1e-15);
    let svd = a.clone().svd(true, true);
    let [u, v] = [svd.u.clone().unwrap(), svd.v_t.clone().unwrap()];
    let values = |found: &[f64]| {
        let exact = [2.0, 0.5, 0.5];
        (0..3).map(|i| (found[i] - exact[i]).abs()).fold(0.0, f64::max)
    };
    let alone = a.clone().svd(false, false).singular_values;
    println!("DMatrix, values alone: {}", told(values(alone.as_slice())));
    println!("DMatrix, values with vectors: {}", told(values(svd.singular_values.as_slice())));
    let skew = (u.transpose() * &u - &one).amax().max((&v * v.transpose() - &one).amax());
    println!("DMatrix, U and V: {}", told(skew).replace("right", "orthogonal"));
    println!("DMatrix, U S V^T: {}", told((svd.recompose().unwrap() - &a).amax()));
    let inverse = a.clone().pseudo_inverse(1e-12).unwrap();
    println!("DMatrix, pseudo_inverse: {}", told((inverse * &a - &one).amax()));
    let plain = diagonal(0.0);
    let again = plain.clone().svd(true, true).recompose().unwrap();
    println!("DMatrix, U S V^T without couplings: {}", told((again - plain).amax()));
    let again = SymmetricEigen::new(a.clone()).recompose();
    println!("DMatrix, SymmetricEigen: {}", told((again - &a).amax()));
    let a = Matrix3::from_iterator(a.iter().copied());
    println!("Matrix3, U S V^T: {}", told((a.svd(true, true).recompose().unwrap() - a).amax()));
    #[rustfmt::skip]
    let a = Matrix4::new(
        2.0, 0.0, 0.0, 0.0,
        0.0, 0.5, 0.0, 0.0,
        0.0, 1e-16, 2.0, 0.0,
        1e-12, 0.0, 0.0, 0.5,
    );
    println!("Matrix4, U S V^T: {}", told((a.svd(true, true).recompose().unwrap() - a).amax()));
}
RUST
cargo build --quiet 2>build.log || { echo "the program cannot be built:"; tail -n 5 build.log; exit 2; }
target/debug/factors | tee seen.log
sed -n '/^# Output seen:/,/^#$/s/^#   //p' "$script" >expected.log
diff expected.log seen.log && echo "as described"
