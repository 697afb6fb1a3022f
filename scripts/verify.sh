#!/usr/bin/env bash
# Runs every case of cases/ on 1 and 3 ranks and writes docs/verification.md.
#
#     scripts/verify.sh            write the page
#     scripts/verify.sh --check    compare with the page that is there: status 1, with the difference, if it is stale
#     scripts/verify.sh --check --by-turns    the same, every case on 1 or on 3 ranks
#     scripts/verify.sh --self-test    tests of the helper alone
#
# COLUMN_HPC names the program; without it the release build is brought up to date and taken.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
if [ -z "${COLUMN_HPC:-}" ]; then
    cargo build --release || exit 4
    COLUMN_HPC="${CARGO_TARGET_DIR:-$root/target}/release/column-hpc"
fi
exec python3 scripts/verify.py --program "$COLUMN_HPC" "$@"
