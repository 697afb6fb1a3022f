//! The fence of processor features: the same code, compiled for what the processor has.
#![allow(unsafe_code)]

/// Work that profits from wide vectors. `run` and all it calls must be `#[inline(always)]`: what is
/// not inlined is compiled for the oldest processor.
pub trait Kernel {
    /// Does the work.
    fn run(self);
}

/// Runs `kernel` compiled for the widest vectors that the processor has.
pub fn widest(kernel: impl Kernel) {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512f") {
            // SAFETY: the processor has the feature.
            return unsafe { with_avx512(kernel) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has the feature.
            return unsafe { with_avx2(kernel) };
        }
    }
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2(kernel: impl Kernel) {
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn with_avx512(kernel: impl Kernel) {
    kernel.run();
}
