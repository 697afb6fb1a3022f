#!/usr/bin/env bash
# Measures eight instants of the column against one elastic instant and against one bare PETSc solve.
#
#     scripts/bench.sh                 the whole ladder of scenes, on 1 and 2 ranks: below 20 minutes
#     scripts/bench.sh --quick         its small beginning: below 3 minutes
#     scripts/bench.sh --presets       our presets on every scene: is `auto` within 1.3 of the best?
#     scripts/bench.sh --accuracy      error of the mixed-mode scene over core-seconds
#     scripts/bench.sh --flow          pore pressure, known or to be found, against none: below 15 minutes
#     scripts/bench.sh --charts        draws what the results directory holds, as SVG and PNG
#     scripts/bench.sh check           compares the histories of the timed runs with MUMPS at 1e-12
#     scripts/bench.sh page            writes the tables into docs/performance.md
#
# Further options (--ranks "1 2", --repeats N, --scenes a,b, --linear NAME, --budget SECONDS, --keep DIR, ...):
# scripts/bench.sh --help. Results go to results/bench, or to DIR. COLUMN_HPC names the program; without it the
# release build is brought up to date and taken. RAW_ELASTIC names the bare PETSc program; without it
# it is built in scripts/peers.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
target="${CARGO_TARGET_DIR:-$root/target}"
keep=results/bench mode=ladder
for ((i = 1; i <= $#; i++)); do
    case ${!i} in
    --presets | --accuracy | --flow | --charts) mode=${!i#--} ;;
    check | page | self-test) mode=${!i} ;;
    -h | --help) mode=help ;;
    --keep=*) keep=${!i#--keep=} ;;
    --keep)
        next=$((i + 1))
        keep=${!next:-$keep}
        ;;
    esac
done

# The charts need matplotlib, which comes from the package index into an environment of its own: nothing
# else here depends on it, so that a machine without the index can still measure.
charts() {
    local environment="$target/.venv/plot"
    if [ ! -e "$environment/complete" ]; then
        rm -rf "$environment"
        "${PYTHON:-python3}" -m venv "$environment" >&2 &&
            "$environment/bin/python" -m pip install --quiet --disable-pip-version-check matplotlib >&2 || {
            printf 'bench: no charts: matplotlib could not be installed; the reason is above\n' >&2
            return 4
        }
        : >"$environment/complete"
    fi
    "$environment/bin/python" scripts/bench_charts.py "$keep"
}

case $mode in
charts) charts; exit ;;
page | help | self-test) exec python3 scripts/bench.py "$@" ;;
esac
if [ -z "${COLUMN_HPC:-}" ]; then
    cargo build --release || exit 4
    COLUMN_HPC="$target/release/column-hpc"
fi
export COLUMN_HPC
python3 scripts/bench.py "$@"
case $mode in
# The ratio counts only where the timed runs have the right numbers.
ladder) python3 scripts/bench.py check --keep "$keep" ;;
presets | accuracy) charts || true ;;
esac
