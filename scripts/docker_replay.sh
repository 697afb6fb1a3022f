#!/usr/bin/env bash
# Where no container engine runs: replays the Dockerfile in fresh Debian 12 roots.
#
#     scripts/docker_replay.sh [--keep] [--directory DIR] [COMMAND...]
#
# Each FROM starts from the same debootstrap root (package debootstrap, installed if missing); WORKDIR,
# ENV, USER, COPY and RUN are replayed in it. COMMAND runs at the end in the last stage, as its user
# in its WORKDIR; without one, the ENTRYPOINT with the CMD runs. The exit status is that of the line
# that failed, or of COMMAND.
#
# What stands in for what: the host's Rust toolchain for that of the `rust:` base image, the host's
# sources and certificates for apt. DIR (default: a new temporary directory) is removed at the end
# unless --keep is given. Needs root: chroot and mounts, in a mount namespace of its own.
set -euo pipefail

fail() {
    printf 'docker_replay: %s\n' "$1" >&2
    exit 4
}

[ "$(id -u)" -eq 0 ] || fail "needs root"
if [ "${REPLAY_NAMESPACE:-}" != own ]; then
    # Mounts then vanish with this process, however it ends.
    REPLAY_NAMESPACE=own exec unshare --mount --propagation private -- "$0" "$@"
fi

keep=no directory=""
while [ $# -gt 0 ]; do
    case $1 in
    --keep) keep=yes ;;
    --directory)
        directory=${2:?--directory needs a value}
        shift
        ;;
    --)
        shift
        break
        ;;
    *) break ;;
    esac
    shift
done
context=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ -z "$directory" ]; then
    directory=$(mktemp -d)
else
    mkdir -p "$directory"
    directory=$(cd "$directory" && pwd)
fi
stages=() # names and numbers of the stages so far, at the index of their root

finish() {
    local status=$?
    local root
    for root in "$directory"/stage*; do
        # Not every stage has every mount.
        umount -qR "$root/proc" "$root/sys" "$root/dev" "$root/opt/rust" 2>/dev/null || true
    done
    if [ "$keep" = yes ]; then
        printf 'docker_replay: kept in %s\n' "$directory" >&2
    else
        # One file system: should a mount have stayed, the host's files behind it do.
        rm -rf --one-file-system "$directory"
    fi
    exit "$status"
}
trap finish EXIT

# The first address from which this machine's apt takes Debian 12.
mirror() {
    # shellcheck disable=SC2016  # the format is apt-get's
    apt-get indextargets --format '$(CREATED_BY) $(CODENAME) $(REPO_URI)' |
        awk '$1 == "Packages" && $2 == "bookworm" { print $3; exit }'
}

copy_if_there() { # the same path of the host into the root $1
    local root=$1 path
    shift
    for path in "$@"; do
        [ -e "$path" ] || continue
        mkdir -p "$root$(dirname "$path")"
        rm -rf "${root:?}$path"
        cp -aL "$path" "$root$path"
    done
}

make_base() {
    [ ! -e "$directory/base/complete" ] || return 0
    rm -rf --one-file-system "$directory/base"
    if ! command -v debootstrap >/dev/null 2>&1; then
        apt-get -q update >/dev/null
        apt-get -q -y install --no-install-recommends debootstrap >/dev/null
    fi
    local from
    from=$(mirror)
    debootstrap --variant=minbase --include=ca-certificates bookworm "$directory/base" \
        "${from:-http://deb.debian.org/debian}" >"$directory/debootstrap.log" 2>&1 ||
        fail "debootstrap failed: $(tail -n 3 "$directory/debootstrap.log")"
    rm -f "$directory/base/etc/apt/sources.list"
    copy_if_there "$directory/base" /etc/apt/sources.list /etc/apt/sources.list.d /etc/apt/apt.conf.d \
        /etc/apt/trusted.gpg.d /etc/apt/keyrings /usr/share/keyrings /etc/ssl/certs \
        /usr/local/share/ca-certificates /etc/resolv.conf /etc/hosts
    touch "$directory/base/complete"
}

# Starts a stage: a copy of the base with the kernel's file systems, and the toolchain if asked for.
start_stage() {
    local image=$1 name=${2:-}
    stages+=("$name")
    root="$directory/stage$((${#stages[@]} - 1))"
    user=root workdir=/
    environment=(PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive)
    entrypoint=() arguments=()
    local variable
    for variable in http_proxy https_proxy no_proxy SSL_CERT_FILE SSL_CERT_DIR; do
        [ -z "${!variable:-}" ] || environment+=("$variable=${!variable}")
    done
    rm -rf --one-file-system "$root"
    cp -a --reflink=auto "$directory/base" "$root"
    mount --rbind /proc "$root/proc"
    mount --rbind /sys "$root/sys"
    mount --rbind /dev "$root/dev"
    case $image in
    debian:bookworm* | debian:12*) ;;
    rust:*bookworm*)
        mkdir -p "$root/opt/rust" "$root/usr/local/cargo"
        mount --bind -o ro "$(rustc --print sysroot)" "$root/opt/rust"
        local cargo_home=${CARGO_HOME:-$HOME/.cargo} part
        for part in config.toml registry; do
            [ ! -e "$cargo_home/$part" ] || cp -a "$cargo_home/$part" "$root/usr/local/cargo/"
        done
        chmod -R a+rwX "$root/usr/local/cargo"
        environment[0]="PATH=/opt/rust/bin:${environment[0]#PATH=}"
        environment+=(CARGO_HOME=/usr/local/cargo)
        ;;
    *) fail "no stand-in for the base image $image" ;;
    esac
}

in_stage() {
    local home
    home=$(chroot "$root" getent passwd "$user" | cut -d: -f6)
    # shellcheck disable=SC2016  # expanded by the shell inside
    chroot --userspec="$user" --groups= "$root" /usr/bin/env -i "HOME=$home" "${environment[@]}" \
        /bin/sh -c 'cd "$0" && exec "$@"' "$workdir" "$@"
}

in_workdir() { # a path of the stage, absolute
    case $1 in
    /*) printf '%s' "$1" ;;
    *) printf '%s/%s' "${workdir%/}" "$1" ;;
    esac
}

# COPY [--from=STAGE] [--chown=USER] SOURCE... TARGET
copy() {
    local from="$context" owner=root option number
    while [[ ${1:-} == --* ]]; do
        option=$1
        shift
        case $option in
        --chown=*) owner=${option#--chown=} ;;
        --from=*)
            for number in "${!stages[@]}"; do
                if [ "${stages[$number]}" = "${option#--from=}" ] || [ "$number" = "${option#--from=}" ]; then
                    from="$directory/stage$number"
                fi
            done
            [ "$from" != "$context" ] || fail "COPY: no stage ${option#--from=}"
            ;;
        *) fail "COPY: $option is not replayed" ;;
        esac
    done
    local target source
    target=$root$(in_workdir "${!#}")
    local sources=("${@:1:$#-1}") exclude=()
    mkdir -p "$target"
    if [ "$from" = "$context" ] && [ -f "$context/.dockerignore" ]; then
        mapfile -t exclude < <(sed -n 's|^/\(.*\)|--exclude=./\1|p' "$context/.dockerignore")
    fi
    for source in "${sources[@]}"; do
        if [ -d "$from/$source" ]; then # the contents of a directory, as Docker has it
            tar -C "$from/$source" --anchored "${exclude[@]}" -cf - . |
                tar -C "$target" --no-same-owner -xf -
        else
            cp --preserve=mode "$from/$source" "$target/"
        fi
    done
    local name
    for source in "${sources[@]}"; do
        name=$target
        [ -d "$from/$source" ] || name="$target/$(basename "$source")"
        chroot "$root" chown -R "$owner:" "${name#"$root"}"
    done
}

# ["a", "b"] to the lines a, b.
words_of_list() {
    python3 -c 'import json, sys; print(*json.loads(sys.argv[1]), sep="\n")' "$1"
}

replay() {
    local keyword=$1 rest=$2 words
    printf '== %s %s\n' "$keyword" "$rest"
    read -r -a words <<<"$rest"
    case $keyword in
    FROM) start_stage "${words[0]}" "${words[2]:-}" ;;
    WORKDIR)
        workdir=$(in_workdir "$rest")
        mkdir -p "$root$workdir"
        ;;
    ENV) environment+=("${words[@]}") ;;
    USER) user=$rest ;;
    COPY) copy "${words[@]}" ;;
    RUN) in_stage /bin/sh -c "$rest" ;;
    ENTRYPOINT) mapfile -t entrypoint < <(words_of_list "$rest") ;;
    CMD) mapfile -t arguments < <(words_of_list "$rest") ;;
    *) fail "$keyword is not replayed" ;;
    esac
}

make_base
line=""
while IFS= read -r part <&3; do
    [[ $part =~ ^[[:space:]]*(#|$) ]] && continue
    if [[ $part == *\\ ]]; then
        line+="${part%\\} "
        continue
    fi
    line+=$part
    read -r keyword rest <<<"$line"
    replay "$keyword" "$rest"
    line=""
done 3<"$context/Dockerfile"

if [ $# -eq 0 ]; then
    set -- "${entrypoint[@]}" "${arguments[@]}"
fi
printf '== as %s: %s\n' "$user" "$*"
in_stage "$@"
