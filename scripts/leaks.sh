#!/usr/bin/env bash
# Looks for memory and objects that are left at the end, on the smallest scenes:
#
#     scripts/leaks.sh
#
# PETSc's own accounting must be empty; valgrind (installed where it can be) must find no invalid access and no
# block that nothing points to, the libraries' start and end aside (scripts/valgrind.supp). COLUMN_HPC names the
# program; without it the release build is taken.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/setup.sh
. scripts/setup.sh
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
command -v valgrind >/dev/null || setup_packages valgrind
# A build of the tests may have left another one.
[ -n "${COLUMN_HPC:-}" ] || cargo build --release
program=${COLUMN_HPC:-${CARGO_TARGET_DIR:-$root/target}/release/column-hpc}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
failed=0

# One scene for each way through the program: elimination, multigrid, a path, the saddle-point form.
scenes=(
    "cases/wtnv146/case_2d.yaml"
    "cases/wtnv146/case_2d.yaml --set solver.linear=multigrid --set mesh.column.cells=[8,40] --set output.checkpoint={every:\ 1\ instant}"
    "cases/snap_back/column_50m_dissipation.yaml"
    "cases/wtnv146/case_2d.yaml --set solver.form=saddle_point --set mesh.order=2"
)
accounting=(-malloc_debug -malloc_dump -objects_dump)

for scene in "${scenes[@]}"; do
    eval "words=($scene)"
    for ranks in 1 2; do
        launch=(mpirun -n "$ranks" --quiet "$program" "${words[@]}" --overwrite --quiet --output "$scratch/out")
        "${launch[@]}" -- "${accounting[@]}" >"$scratch/petsc" 2>&1 || { cat "$scratch/petsc"; failed=1; }
        if grep -qE "^\[[0-9]+\]|[0-9]+ (Mat|Vec|KSP|PC|SNES|IS)" "$scratch/petsc"; then
            printf 'leaks: FAILED: PETSc has objects left after %s on %s rank(s)\n' "$scene" "$ranks" >&2
            head -20 "$scratch/petsc" >&2
            failed=1
        fi
    done
    rm -f "$scratch"/vg.*
    status=0
    mpirun -n 2 --quiet valgrind --quiet --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite \
        --error-exitcode=99 --num-callers=40 --suppressions=/usr/share/openmpi/openmpi-valgrind.supp \
        --suppressions=scripts/valgrind.supp --log-file="$scratch/vg.%p" \
        "$program" "${words[@]}" --overwrite --quiet --output "$scratch/out" >"$scratch/log" 2>&1 || status=$?
    if [ "$status" -ne 0 ]; then
        printf 'leaks: FAILED: valgrind on %s ended with status %s\n' "$scene" "$status" >&2
        cat "$scratch"/vg.* | cut -c1-160 | head -80 >&2
        failed=1
    else
        printf 'leaks: %s: nothing left\n' "$scene"
    fi
done
exit "$failed"
