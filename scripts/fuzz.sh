#!/usr/bin/env bash
# Feeds hostile input to what reads the user's, guided by coverage (libFuzzer):
#
#     scripts/fuzz.sh [TARGET] [SECONDS]
#
# TARGET: case, formula, set, checkpoint, gmsh, med, or all (the default), one after the other, SECONDS (60) each. Seeds
# are tests/fuzz/corpus, the shipped cases and the meshes of the tests; what leads on is kept in target/fuzz/corpus. Exit
# status 1: something was found; the input is in target/fuzz/found. Mend it and put the input into
# tests/fuzz/corpus/TARGET, which `cargo test --release --test corpus` replays.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/setup.sh
. scripts/setup.sh
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
setup_packages g++
setup_cargo

target=${1:-all} seconds=${2:-60}
targets=("$target")
[ "$target" != all ] || targets=(case formula set checkpoint gmsh med)
work=${CARGO_TARGET_DIR:-$root/target}/fuzz
triple=$(rustc -vV | sed -n 's/^host: //p')

# What cargo-fuzz asks of the compiler, which needs no nightly one: counters of edges and compared values.
coverage="-Cpasses=sancov-module"
for argument in level=4 inline-8bit-counters pc-table trace-compares; do
    coverage+=" -Cllvm-args=-sanitizer-coverage-$argument"
done
# With --target build scripts are not instrumented.
RUSTFLAGS="$coverage" cargo build --release --manifest-path tests/fuzz/Cargo.toml --target "$triple" --target-dir "$work" \
    "${targets[@]/#/--bin=}"

# A checkpoint or a mesh is written and read at each execution: in memory, where there is such a place.
[ ! -d /dev/shm ] || export TMPDIR=${TMPDIR:-/dev/shm}

status=0
for target in "${targets[@]}"; do
    kept=$work/corpus/$target found=$work/found/$target log=$work/$target.log
    mkdir -p "$kept" "$found"
    seeds=("tests/fuzz/corpus/$target")
    [ "$target" != case ] || seeds+=(cases/*/)
    [ "$target" != gmsh ] || seeds+=(tests/meshes tests/meshes/*/)
    options=(-max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=16384 -print_final_stats=1)
    [ ! -f "tests/fuzz/$target.dict" ] || options+=(-dict="tests/fuzz/$target.dict")
    ended=0
    "$work/$triple/release/$target" "${options[@]}" -artifact_prefix="$found/" "$kept" "${seeds[@]}" >"$log" 2>&1 ||
        ended=$?
    executed=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    memory=$(sed -n 's/^stat::peak_rss_mb: *//p' "$log")
    edges=$(grep -o 'cov: [0-9]*' "$log" | tail -n 1 | cut -d ' ' -f 2)
    printf 'fuzz: %s: %s executions, %s edges, %s inputs kept, at most %s MB: ' "$target" "${executed:-?}" \
        "${edges:-?}" "$(find "$kept" -type f | wc -l)" "${memory:-?}"
    if [ "$ended" -eq 0 ]; then
        printf 'nothing found\n'
    else
        printf 'FOUND (status %d)\n' "$ended"
        grep -a -m 12 -E 'panicked|ERROR|SUMMARY|Test unit' "$log" || tail -n 5 "$log"
        status=1
    fi
done
exit "$status"
