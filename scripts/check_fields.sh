#!/usr/bin/env bash
# Runs cases on 3 ranks and compares the fields they write, as VTK reads them, with exact values.
#
#     scripts/check_fields.sh                         with the reader of ParaView 5.11 (vtk 9.2.6)
#     VTK_VERSION=newest scripts/check_fields.sh      with the newest wheel
#
# The wheel comes from the package index, into an environment below the target directory; where it cannot
# be had, the check fails. COLUMN_HPC names the program; without it the release build is taken.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
if [ -z "${COLUMN_HPC:-}" ]; then
    cargo build --release || exit 4
    COLUMN_HPC="${CARGO_TARGET_DIR:-$root/target}/release/column-hpc"
fi
scripts/python.sh -c 'import vtkmodules' || {
    printf 'check_fields: FAILED: there is no vtk wheel to read the fields with; the reason is above\n' >&2
    exit 1
}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
directories=()
plain=(wtnv146/case wtnv146/case_2d ssnp121/case mixed_mode/case patch_bulk/case)
second_order=(wtnv146/case_2d mixed_mode/case patch_bulk/case)
porous=(porous:terzaghi/case porous2:terzaghi/case)
# Steady flow from the base to the drained top, long after the load.
steady=(--set boundary.0.pressure=1.0e4 --set boundary.3.traction.z=-2.0e4 --set time.instants=[1.0e14]
    --set time.tolerance= --set expect= --set solver.tolerance=1.0e-12)
for case in "${plain[@]}" "${second_order[@]/#/2:}" mixed:ssnp121/case "${porous[@]}"; do
    settings=()
    case $case in
    porous:*) settings=("${steady[@]}") ;;
    porous2:*) settings=("${steady[@]}" --set mesh.order=2) ;;
    2:*) settings=(--set mesh.order=2) ;;
    mixed:*) settings=(--set mesh.column.bodies.0.order=2) ;;
    esac
    directory="$scratch/${case//\//_}" case=${case#*:}
    mpirun -n 3 --quiet "$COLUMN_HPC" "cases/$case.yaml" --quiet --set reduce=never --output "$directory" \
        "${settings[@]}" || {
        printf 'check_fields: FAILED: cases/%s.yaml ended with status %d\n' "$case" $? >&2
        exit 1
    }
    directories+=("$directory")
done
scripts/python.sh scripts/check_fields.py "${directories[@]}"
