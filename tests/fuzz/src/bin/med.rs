#![no_main]

#[path = "../peak.rs"]
mod peak;

use std::cell::OnceCell;

use column_hpc_fuzz::mesh::med::Bench;
use peak::Peak;

thread_local! {
    static BENCH: OnceCell<Bench> = const { OnceCell::new() };
}

libfuzzer_sys::fuzz_target!(|recipe: &[u8]| {
    BENCH.with(|bench| bench.get_or_init(Bench::new).read(recipe, &Peak(0.into())));
});
