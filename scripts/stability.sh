#!/usr/bin/env bash
# Runs the stability suite and writes docs/stability.md with its pictures, docs/stability_*.svg: below 5 minutes.
#
#     scripts/stability.sh           everything: tests, page, pictures
#     scripts/stability.sh page      page and pictures from what the last run left in results/stability
#     scripts/stability.sh self-test tests of the helper alone
#
# The numbers are those that the tests assert and print; a test that fails ends the script, and the page stays.
# The pictures need matplotlib, which comes from the package index into an environment below the target directory.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
logs=results/stability
environment="${CARGO_TARGET_DIR:-$root/target}/.venv/plot"

case ${1:-all} in
all | page) ;;
self-test) exec python3 scripts/stability.py self-test ;;
*)
    sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 2
    ;;
esac
if [ "${1:-all}" = all ]; then
    mkdir -p "$logs"
    cargo test --release --lib inf_sup -- --nocapture >"$logs/inf_sup.log"
    cargo test --release --test acceptance -- --nocapture --include-ignored suite orders::in_2d >"$logs/suite.log"
fi
if [ ! -e "$environment/complete" ]; then
    rm -rf "$environment"
    "${PYTHON:-python3}" -m venv "$environment" >&2 &&
        "$environment/bin/python" -m pip install --quiet --disable-pip-version-check matplotlib >&2 || {
        printf 'stability: matplotlib could not be installed; the reason is above\n' >&2
        exit 4
    }
    : >"$environment/complete"
fi
"$environment/bin/python" scripts/stability_charts.py "$logs"
exec python3 scripts/stability.py page "$logs"
