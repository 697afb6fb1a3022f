#!/usr/bin/env bash
# Makes the machine ready, builds in release and runs a case:
#
#     scripts/run.sh CASE.yaml [options of column-hpc]        RANKS=4 scripts/run.sh ...
#
# The exit status is the program's.
set -euo pipefail

if [ $# -eq 0 ]; then
    printf 'usage: [RANKS=2] %s CASE.yaml [options of column-hpc]\n' "$0" >&2
    exit 2
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
# shellcheck source=scripts/mpi_env.sh
. "$root/scripts/mpi_env.sh"
setup_packages
setup_cargo
# In the package's own directory, where cargo reads .cargo/config.toml.
(cd "$root" && cargo build --release) || exit 4
status=0
# Quiet: the program has said what went wrong, mpirun need not add its banner.
OMPI_MCA_orte_execute_quiet=1 mpirun -n "${RANKS:-2}" \
    "${CARGO_TARGET_DIR:-$root/target}/release/column-hpc" "$@" || status=$?
if [ "$status" -gt 101 ]; then
    printf 'run: mpirun ended with status %d: not started, or killed by signal %d (9: out of memory?)\n' \
        "$status" $((status - 128)) >&2
fi
exit "$status"
