#!/usr/bin/env bash
# Counts on 1 to 8 ranks and a model of more: scripts/scaling.py with the environment it needs.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
if [ -z "${COLUMN_HPC:-}" ]; then
    cargo build --release || exit 4
    COLUMN_HPC="${CARGO_TARGET_DIR:-$root/target}/release/column-hpc"
fi
export COLUMN_HPC
exec python3 scripts/scaling.py "$@"
