//! `docs/verification.md` is what the program gives now.

#[allow(dead_code)] // this program uses a part of it
mod common;

use std::path::Path;
use std::process::Command;

/// Runs `scripts/verify.sh` with this build of the program.
fn verify(options: &[&str]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/verify.sh");
    let output = Command::new(script)
        .args(options)
        .env("COLUMN_HPC", env!("CARGO_BIN_EXE_column-hpc"))
        .envs([common::Cores::variable()])
        .output()
        .expect("bash and python3 run the script");
    assert!(
        output.status.success(),
        "{options:?}: {}\n{}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn the_page_of_verified_quantities_is_not_stale() {
    verify(&["--check", "--by-turns"]);
}

#[test]
fn the_helper_hides_noise_and_shows_misses() {
    verify(&["--self-test"]);
}
