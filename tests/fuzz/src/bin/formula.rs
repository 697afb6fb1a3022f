#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| column_hpc_fuzz::formula(bytes));
