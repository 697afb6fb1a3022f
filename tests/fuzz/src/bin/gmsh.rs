#![no_main]

#[path = "../peak.rs"]
mod peak;

use column_hpc_fuzz::mesh::gmsh;
use peak::Peak;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gmsh(bytes, &Peak(0.into())));
