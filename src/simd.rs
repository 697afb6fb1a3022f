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
        if is_fused() {
            // SAFETY: the processor has the features.
            return unsafe { with_avx2_and_fma(kernel) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has the feature.
            return unsafe { with_avx2(kernel) };
        }
    }
    kernel.run();
}

/// Whether `mul_add` is one instruction inside [`widest`]. Elsewhere it may call the C library.
pub fn is_fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        cfg!(target_arch = "aarch64")
    }
}

/// Whether [`wide`] may be called.
pub fn has_wide_vectors() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        std::arch::is_x86_feature_detected!("avx2")
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        true
    }
}

/// Runs `kernel` compiled for vectors of four numbers, the only form of it: large kernels take long
/// to compile.
///
/// # Panics
/// On a processor without them: see [`has_wide_vectors`].
pub fn wide(kernel: impl Kernel) {
    assert!(has_wide_vectors(), "a processor without vectors of four numbers");
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: the processor has the feature.
        unsafe { with_avx2(kernel) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        kernel.run();
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2(kernel: impl Kernel) {
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn with_avx2_and_fma(kernel: impl Kernel) {
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn with_avx512(kernel: impl Kernel) {
    kernel.run();
}
