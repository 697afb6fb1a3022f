#!/usr/bin/env bash
# What the nonlinear path costs beside one elastic instant: prints a table.
#
#     scripts/bench.sh [--cells 24] [--runs 1] [--ranks "1 2"] [--linear auto] [--keep DIR]
#
# The column of WTNV146 with N x N x 5N cells and nu = 0.3: eight instants with the cohesive interface, beside
# instant 3 alone with the interface `tied`, on each number of ranks. The elastic instant is run with
# every multigrid preset; the fastest counts. --linear chooses the preset of the eight instants. Runs are interleaved, so that a slow spell of the machine meets all, and
# the medians are shown. Memory is the sum of the ranks' largest. --keep leaves the reports in DIR.
# COLUMN_HPC names the program; without it the release build is brought up to date and taken.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh

usage() {
    printf 'usage: %s [--cells N] [--runs N] [--ranks "1 2"] [--linear auto] [--keep DIR]\n' "$0" >&2
    exit 2
}
cells=24 runs=1 ranks="1 2" linear=auto keep=""
while [ $# -gt 0 ]; do
    [ $# -ge 2 ] || usage
    case $1 in
    --cells) cells=$2 ;;
    --runs) runs=$2 ;;
    --ranks) ranks=$2 ;;
    --linear) linear=$2 ;;
    --keep) keep=$2 ;;
    *) usage ;;
    esac
    shift 2
done
[[ $cells =~ ^[1-9][0-9]*$ && $runs =~ ^[1-9][0-9]*$ && $ranks =~ ^[1-9][0-9\ ]*$ ]] || usage

if [ -z "${COLUMN_HPC:-}" ]; then
    cargo build --release || exit 4
    COLUMN_HPC="${CARGO_TARGET_DIR:-$root/target}/release/column-hpc"
fi
if [ -n "$keep" ]; then
    mkdir -p "$keep"
    results=$(cd "$keep" && pwd)
else
    results=$(mktemp -d)
    trap 'rm -rf "$results"' EXIT
fi

cat >"$results/bench.yaml" <<CASE
title: Column of $cells x $cells x $((5 * cells)) cells, nu = 0.3
mesh: {column: {size: [1.0, 1.0, 5.0], cells: [$cells, $cells, $((5 * cells))]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.3}}}
interfaces:
  - {name: joint, z: 2.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900.0, augmentation: 10.0}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - on: top
    displacement:
      x: {table: [[6, 0], [7, 1.0e-3], [8, 0]]}
      y: 0
      z: {table: [[0, 0], [1, -1.0e-4], [2, 1.0e-4], [3, 1.0e-3], [4, 5.0e-4], [5, 1.2e-3], [6, 1.7e-3], [7, 1.7e-3], [8, -1.0e-4]]}
time: {instants: [1, 2, 3, 4, 5, 6, 7, 8]}
output: {fields: none}
CASE

# run NAME RANKS NUMBER [OPTIONS]: the report and the wall time of one run.
run() {
    local name=$1 number_of_ranks=$2 number=$3 start end
    shift 3
    local directory="$results/$name-$number_of_ranks-$number"
    printf '%s on %s rank(s), run %s\n' "$name" "$number_of_ranks" "$number" >&2
    start=$(date +%s.%N)
    mpirun -n "$number_of_ranks" --quiet "$COLUMN_HPC" "$results/bench.yaml" --quiet --overwrite \
        --output "$directory" "$@" || {
        printf 'bench: %s on %s rank(s) ended with status %d\n' "$name" "$number_of_ranks" $? >&2
        exit 1
    }
    end=$(date +%s.%N)
    printf '%s %s\n' "$start" "$end" >"$directory/wall"
}

elastic=(--set 'interfaces.0.law={tied: {}}' --set 'time.instants=[3]')
for number in $(seq "$runs"); do
    for n in $ranks; do
        run eight "$n" "$number" --set "solver.linear=$linear"
        for preset in gamg hypre; do
            run "elastic-$preset" "$n" "$number" "${elastic[@]}" --set solver.linear=$preset
        done
    done
done
python3 scripts/bench_table.py "$results"
