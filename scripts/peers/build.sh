#!/usr/bin/env bash
# Builds raw_elastic, or raw_mesh: scripts/peers/build.sh [where to put it] [which]
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
which=${2:-raw_elastic}
output=${1:-$here/$which}

if pkg-config --exists PETSc 2>/dev/null; then
    read -ra flags <<<"$(pkg-config --cflags PETSc)"
    read -ra libraries <<<"$(pkg-config --libs PETSc)"
else
    # Debian keeps the chosen PETSc behind this link when pkg-config is missing.
    petsc=${PETSC_DIR:-/usr/lib/petsc}
    flags=("-I$petsc/include")
    library=$(find -L "$petsc/lib" -maxdepth 1 -name 'libpetsc*.so' -print -quit 2>/dev/null || true)
    [ -n "$library" ] || { printf 'no PETSc found: apt-get install libpetsc-real3.18-dev\n' >&2; exit 4; }
    libraries=("$library")
fi

mpicc -std=gnu11 -O3 -march=native -Wall -Wextra "${flags[@]}" "$here/$which.c" -o "$output" \
    "${libraries[@]}" -lm
