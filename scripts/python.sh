#!/bin/sh
# Runs Python with the VTK wheel that reads the field files: scripts/python.sh SCRIPT [ARGUMENTS].
#
# The first call makes a virtual environment below the target directory. VTK_VERSION chooses another
# wheel (9.2.6 is that of ParaView 5.11; `newest` the newest one there is), PYTHON another interpreter.
set -eu

version="${VTK_VERSION:-9.2.6}"
root="$(cd "$(dirname "$0")/.." && pwd)"
environment="${CARGO_TARGET_DIR:-$root/target}/.venv/vtk-$version"
complete="$environment/complete"

if [ ! -e "$complete" ]; then
    rm -rf "$environment"
    "${PYTHON:-python3}" -m venv "$environment" >&2 || {
        echo "python.sh: no virtual environment; on Debian: apt-get install python3-venv" >&2
        exit 4
    }
    # VTK 9.2 was made for NumPy 1.
    case "$version" in
        9.[012].*) numpy="numpy<2" ;;
        *) numpy="numpy" ;;
    esac
    wheel="vtk==$version"
    [ "$version" != newest ] || wheel=vtk
    "$environment/bin/python" -m pip install --quiet --disable-pip-version-check "$wheel" "$numpy" >&2 || {
        echo "python.sh: $wheel could not be installed: the package index is out of reach, or has no wheel for" >&2
        echo "this Python (9.2.6 needs 3.7 to 3.11; set PYTHON); pip's own words are above" >&2
        exit 4
    }
    : > "$complete"
fi
exec "$environment/bin/python" "$@"
