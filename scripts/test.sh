#!/usr/bin/env bash
# Makes the machine ready and runs every test. All steps run; the exit status is 1 if any failed.
#
# Tests run the release: cases on 1 to 4 ranks would be slow without optimisation.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/setup.sh
. scripts/setup.sh
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
setup_packages python3-venv chromium
setup_cargo

scratch=
lane=
log=$(mktemp)
# Where this ends before its time, nothing runs on alone: what runs beside has a process group of its own.
trap '[ -z "$lane" ] || kill -- "-$lane" || true; rm -rf "$log" ${scratch:+"$scratch"}' EXIT

# Runs a function beside what follows, until `joined` waits for it and shows what it said.
beside() {
    set -m
    "$@" >"$log" 2>&1 </dev/null &
    lane=$!
    set +m
}
joined() {
    local status=0
    wait "$lane" || status=$?
    lane=
    cat "$log"
    return $status
}

failed=()
step() {
    local name=$1 start=$SECONDS
    shift
    printf '\n== %s: %s\n' "$name" "$*"
    if "$@"; then
        printf '== %s: passed in %d s\n' "$name" $((SECONDS - start))
    else
        printf '== %s: FAILED (status %d) after %d s\n' "$name" $? $((SECONDS - start))
        failed+=("$name")
    fi
}

# The program that is handed out holds no faults.
no_faults() {
    local program="${CARGO_TARGET_DIR:-$root/target}/release/column-hpc"
    [ -x "$program" ] && ! grep -q COLUMN_HPC_FAULT "$program"
}

step format cargo fmt --check
# Compilers of one crate leave a core idle for long: the lints have a build directory of their own, and run beside.
lints() {
    local status=0
    export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$root/target}/lints"
    cargo clippy --all-targets -- -D warnings || status=1
    RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --document-private-items || status=1
    return $status
}
beside lints
# A third of the time of the compiler goes into inlining between parts of the library, which moves no number.
# Those who use the program keep it: runs take a tenth less time.
export CARGO_PROFILE_RELEASE_LTO=off
tests=(cargo test --release)
others=()
for file in tests/*.rs tests/*/main.rs; do
    name=$(basename "${file%/main.rs}" .rs)
    [ "$name" = acceptance ] || others+=(--test "$name")
done
step tests_build "${tests[@]}" --no-run --bins --test acceptance "${others[@]}"
step lints joined
# Compiling the library once more with all its optimisation takes far longer than the unit tests run without (35 s);
# with none of it they take minutes. Its dependencies are those of the release.
unit=("${tests[@]}" --config 'profile.release.package.column-hpc.opt-level=1' --lib)
# Many tests wait, for a signal or for the end of a run, and leave a core idle. The acceptance tests are the longest:
# the others run beside them. Their launches share the cores (tests/common/cores.rs).
# (nproc counts threads of OpenMP, which scripts/mpi_env.sh sets to 1.)
export RUST_TEST_THREADS="${RUST_TEST_THREADS:-$(getconf _NPROCESSORS_ONLN)}"
other_tests() {
    local status=0
    "${tests[@]}" --no-fail-fast --bins "${others[@]}" || status=1
    "${tests[@]}" --doc || status=1
    scripts/slurm/self_test.sh || status=1
    "${unit[@]}" || status=1
    return $status
}
# Runs wait until what must not be lost is on disk, and ranks talk through files in the temporary folder: in memory,
# where there is enough of it, small runs take two thirds of the time.
if [ -z "${TMPDIR:-}" ] && [ -w /dev/shm ] && [ "$(df --output=avail -k /dev/shm | tail -n 1)" -ge 4000000 ]; then
    scratch=$(mktemp -d /dev/shm/column-hpc.XXXXXX)
    export TMPDIR="$scratch" COLUMN_HPC_TEST_SCRATCH="$scratch"
fi
# A fifth of the time that a launch takes is a look at the cards of the machine.
export HWLOC_COMPONENTS=-pci
beside other_tests
step acceptance env RUST_TEST_THREADS="${ACCEPTANCE_THREADS:-$((2 * RUST_TEST_THREADS))}" "${tests[@]}" --test acceptance
step other_tests joined
step no_faults no_faults
if [ -x scripts/check_fields.sh ]; then
    step fields scripts/check_fields.sh
fi
step plot python3 scripts/plot_history.py --self-test
step stability scripts/stability.sh self-test

printf '\n'
if [ ${#failed[@]} -gt 0 ]; then
    printf 'FAILED: %s (%d s)\n' "${failed[*]}" "$SECONDS"
    exit 1
fi
printf 'all steps passed (%d s)\n' "$SECONDS"
