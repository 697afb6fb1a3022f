//! Numbers of either precision.

use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// A floating-point number of either precision.
pub trait Real:
    Copy
    + Default
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + SubAssign
{
    /// 0.
    const ZERO: Self;
    /// Rounded to single precision.
    fn to_single(self) -> f32;
    /// In double precision.
    fn to_double(self) -> f64;
    /// Rounded to this precision.
    fn from_double(value: f64) -> Self;
    /// self factor + term, rounded once. Only where [`crate::simd::is_fused`] says that the
    /// processor does so: the rest calls the C library.
    fn mul_add(self, factor: Self, term: Self) -> Self;
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    #[inline(always)]
    fn to_single(self) -> f32 {
        self
    }
    #[inline(always)]
    fn to_double(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn from_double(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        f32::mul_add(self, factor, term)
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    #[inline(always)]
    fn to_single(self) -> f32 {
        self as f32
    }
    #[inline(always)]
    fn to_double(self) -> f64 {
        self
    }
    #[inline(always)]
    fn from_double(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        f64::mul_add(self, factor, term)
    }
}
