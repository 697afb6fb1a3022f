#!/usr/bin/env bash
# Makes the machine ready: installs the Debian packages that are missing and checks for cargo.
#
# Run on its own it does both and says what it found. run.sh and test.sh source it and call the two
# functions, so that the PATH they change is theirs. Exit status 4: the machine lacks something;
# the message says what.

# Rust: the rust-version of Cargo.toml.
setup_rust_needed=1.89

setup_fail() {
    printf 'setup: %s\n' "$@" >&2
    exit 4
}

# PETSc of this release: 3.18 is tested; a later Debian has a later PETSc under its own name.
setup_petsc_package() {
    local release=""
    # shellcheck source=/dev/null
    release=$(. /etc/os-release 2>/dev/null && printf '%s %s' "${ID:-}" "${VERSION_ID:-}")
    if [ "$release" = "debian 12" ]; then
        printf 'libpetsc-real3.18-dev'
    else
        printf 'libpetsc-real-dev'
    fi
}

# Installs the packages that are missing; arguments: further packages that the caller needs.
# With PETSC_DIR set (a cluster's modules) or without apt nothing is installed, only looked for.
setup_packages() {
    if [ -n "${PETSC_DIR:-}" ] || ! command -v apt-get >/dev/null 2>&1; then
        setup_check_libraries
        return
    fi
    local packages missing=() package status
    packages=(
        gcc libc6-dev make git ca-certificates pkg-config libclang-dev
        "$(setup_petsc_package)" libopenmpi-dev openmpi-bin libmetis-dev libhdf5-openmpi-dev
        libopenblas0-serial # without it MUMPS runs on the reference BLAS, 7 to 20 times slower
        "$@"
    )
    for package in "${packages[@]}"; do
        # shellcheck disable=SC2016  # the format is dpkg-query's
        status=$(dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null | head -n 1) || true
        [ "$status" = installed ] || missing+=("$package")
    done
    [ ${#missing[@]} -gt 0 ] || return 0

    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        if ! command -v sudo >/dev/null 2>&1; then
            setup_fail "these Debian packages are missing: ${missing[*]}" \
                "ask an administrator for: apt-get install --no-install-recommends ${missing[*]}"
        fi
        as_root=(sudo)
        [ -t 0 ] || as_root=(sudo -n) # nobody is there to type a password
    fi
    printf 'setup: installing %s\n' "${missing[*]}" >&2
    local log
    log=$(mktemp)
    if ! {
        "${as_root[@]}" apt-get -q -o DPkg::Lock::Timeout=120 update &&
            "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y \
                -o DPkg::Lock::Timeout=120 install --no-install-recommends "${missing[@]}"
    } >"$log" 2>&1; then
        tail -n 20 "$log" >&2
        rm -f "$log"
        setup_fail "the packages could not be installed; the end of apt-get's output is above" \
            "ask an administrator for: apt-get install --no-install-recommends ${missing[*]}"
    fi
    rm -f "$log"
}

# Where packages are not ours to install: MPI and PETSc must be there already.
setup_check_libraries() {
    local reasons=()
    command -v "${MPICC:-mpicc}" >/dev/null 2>&1 ||
        reasons+=("no ${MPICC:-mpicc} on the PATH: load the MPI module (or set MPICC)")
    command -v mpirun >/dev/null 2>&1 || command -v srun >/dev/null 2>&1 ||
        reasons+=("neither mpirun nor srun on the PATH: load the MPI module")
    if [ -n "${PETSC_DIR:-}" ]; then
        [ -e "$PETSC_DIR/include/petsc.h" ] ||
            reasons+=("PETSC_DIR=$PETSC_DIR holds no include/petsc.h: set PETSC_DIR (and PETSC_ARCH)")
    elif ! pkg-config --exists PETSc 2>/dev/null && ! pkg-config --exists petsc 2>/dev/null; then
        reasons+=("PETSc was not found: load its module, or set PETSC_DIR (and PETSC_ARCH)")
    fi
    [ ${#reasons[@]} -eq 0 ] || setup_fail "${reasons[@]}" "docs/install.md says what is needed where"
}

# Puts cargo on the PATH when rustup installed it for this user, and checks its version.
setup_cargo() {
    if ! command -v cargo >/dev/null 2>&1; then
        PATH="${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"
        export PATH
    fi
    command -v cargo >/dev/null 2>&1 ||
        setup_fail "cargo was not found: install Rust $setup_rust_needed or newer (https://rustup.rs)"
    local found
    found=$(cargo --version | awk '{print $2}')
    if [ "$(printf '%s\n' "$setup_rust_needed" "$found" | sort -V | head -n 1)" != "$setup_rust_needed" ]; then
        setup_fail "cargo $found is too old: Rust $setup_rust_needed or newer is needed (rustup update stable)"
    fi
}

if [ "${BASH_SOURCE[0]}" = "$0" ]; then
    set -euo pipefail
    setup_packages "$@"
    setup_cargo
    printf 'setup: ready (%s)\n' "$(cargo --version)"
fi
