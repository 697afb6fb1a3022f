#![no_main]

use std::cell::OnceCell;

use column_hpc_fuzz::checkpoint::Bench;

thread_local! {
    static BENCH: OnceCell<Bench> = const { OnceCell::new() };
}

libfuzzer_sys::fuzz_target!(|recipe: &[u8]| {
    BENCH.with(|bench| {
        let bench = bench.get_or_init(|| {
            let bench = Bench::new();
            // A panic ends the process as libFuzzer wants it, not by MPI.
            std::panic::set_hook(Box::new(|info| {
                eprintln!("{info}");
                std::process::abort();
            }));
            bench
        });
        bench.restart(recipe);
    });
});
