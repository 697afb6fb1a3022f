//! The memory that Rust takes, counted. That of HDF5 is bounded by libFuzzer's limit only.

use std::cell::Cell;

use column_hpc_fuzz::mesh::Meter;
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// The memory of the process.
pub struct Peak(pub Cell<usize>);

impl Meter for Peak {
    fn start(&self) {
        ALLOCATOR.reset_peak_usage();
        self.0.set(ALLOCATOR.current_usage());
    }

    fn most(&self) -> usize {
        ALLOCATOR.peak_usage().saturating_sub(self.0.get())
    }
}
