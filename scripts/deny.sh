#!/usr/bin/env bash
# Checks the dependencies by deny.toml: licences, bans and sources. Needs no network once the
# registry is at hand; `scripts/deny.sh advisories` asks for known faults too, which does.
#
# cargo-deny takes minutes to build, so that this is not one of the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
version=0.20.2
if ! cargo deny --version 2>/dev/null | grep -qF "$version"; then
    cargo install --locked --version "$version" cargo-deny
fi
cargo deny --all-features check licenses bans sources "$@"
