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
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    #[inline(always)]
    fn to_single(self) -> f32 {
        self
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    #[inline(always)]
    fn to_single(self) -> f32 {
        self as f32
    }
}
