#!/usr/bin/env bash
# A closed HDF5 file stays locked while a process lives that was started when it was open.
#
# Versions: h5py 3.14.0 with HDF5 1.14.6, h5py 3.16.0 with HDF5 2.0.0, Python 3.11, Linux.
#
# Input: a file of one dataset, opened for writing. While it is open the process starts another one,
# which has nothing to do with the file: by fork, or by exec with the descriptors kept, as popen()
# and system() of C and std::process of Rust do. Then the file is closed, without error, and opened
# again by the process that had it open.
#
# Expected: the lock of a file goes with its close. It is taken by H5Fopen, and H5Fclose has
# returned.
#
# What happens instead: H5Fopen fails with errno 11, "Resource temporarily unavailable", for reading
# as for writing, in the same process as in others, until the other process has ended. HDF5 locks by
# flock() and lets the close of the descriptor end that. flock() belongs to what was opened and not
# to the descriptor: the copy in the child keeps it. HDF5 opens files without O_CLOEXEC, so that the
# copy also survives an exec. A file that is open for reading alone is locked too, and then refuses
# writers.
#
# Output seen (the same with both versions):
#   child by                    for reading  for writing  once it has ended
#   no child                    opens        opens        opens
#   exec, descriptors closed    opens        opens        opens
#   exec, descriptors kept      errno 11     errno 11     opens
#   fork                        errno 11     errno 11     opens
#   fork, open for reading      opens        errno 11     opens
#   fork, opened unlocked       opens        opens        opens
#
# Why it matters: a program with threads writes a file in one and starts a helper in another, and
# the next opening fails once in a hundred times, far from its cause: it looks as if another program
# wrote the file. A child that reads nothing but a pipe can hold a checkpoint for hours.
set -euo pipefail

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
cd "$tmp"
cat >look.py <<'PY'
import os
import subprocess
import sys

import h5py

os.environ.pop("HDF5_USE_FILE_LOCKING", None)


def opens(mode):
    try:
        h5py.File("data.h5", mode).close()
        return "opens"
    except OSError as error:
        return f"errno {error.errno}"


def by_exec(kept):
    child = subprocess.Popen(["cat"], stdin=subprocess.PIPE, close_fds=not kept)

    def end():
        child.stdin.close()
        child.wait()

    return end


def by_fork():
    mine, other = os.pipe()
    child = os.fork()
    if child == 0:
        # It lives until its parent lets go of the pipe.
        os.close(other)
        os.read(mine, 1)
        os._exit(0)

    def end():
        os.close(other)
        os.waitpid(child, 0)

    return end


ways = [
    ("no child", {"mode": "r+"}, lambda: lambda: None),
    ("exec, descriptors closed", {"mode": "r+"}, lambda: by_exec(False)),
    ("exec, descriptors kept", {"mode": "r+"}, lambda: by_exec(True)),
    ("fork", {"mode": "r+"}, by_fork),
    ("fork, open for reading", {"mode": "r"}, by_fork),
    ("fork, opened unlocked", {"mode": "r+", "locking": False}, by_fork),
]
with h5py.File("data.h5", "w") as file:
    file["x"] = 1.0
print("HDF5", h5py.version.hdf5_version)
print(f"{'child by':<27} {'for reading':<12} {'for writing':<12} once it has ended")
seen = []
for name, how, start in ways:
    file = h5py.File("data.h5", **how)
    end = start()
    file.close()
    row = [opens("r"), opens("r+")]
    end()
    row.append(opens("r+"))
    seen.append(row)
    print(f"{name:<27} {row[0]:<12} {row[1]:<12} {row[2]}")
free, held = ["opens"] * 3, ["errno 11", "errno 11", "opens"]
if seen != [free, free, held, held, ["opens", "errno 11", "opens"], free]:
    sys.exit("this is not what was seen before")
PY
for version in 3.14.0 3.16.0; do
    { python3 -m venv "venv-$version" &&
      "venv-$version/bin/python" -m pip install -q --disable-pip-version-check h5py=="$version"; } ||
      { echo "could not make the Python environment (needs Python 3.11 or newer)"; exit 2; }
    "venv-$version/bin/python" look.py
done
