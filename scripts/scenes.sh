#!/usr/bin/env bash
# Holds random scenes against relations that must not matter and against closed forms:
#
#     scripts/scenes.sh [--seed N] [--count N] [--minutes N] [--relation NAME] [--choice] [--as-found] [--cases] [--workers N]
#
# Scenes N, N + 1, ... (from 1000): as many as --count says (100), or until the minutes have passed. Each is told with the
# relations that held, that said nothing and why, and that are broken. Exit status 1: something was found. It is shrunk and written to
# results/scenes as a case (two where the other one has another text), with the commands and what was seen in its head.
# --relation: that one alone; --choice: those that the usual tests hold; --as-found: not shrunk;
# --cases: the cases of the scenes are written there, and nothing is run; --workers: as many scenes at a time (2).
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/setup.sh
. scripts/setup.sh
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
setup_packages
setup_cargo

exec cargo test --release --quiet --test scenes -- look "$@"
