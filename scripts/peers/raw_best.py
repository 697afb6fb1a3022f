#!/usr/bin/env python3
"""Runs raw_elastic with its solvers by turns and prints medians and the best as JSON.

    scripts/peers/raw_best.py -n 16 24 --ranks 1 2 --repeats 5

`wall_s` is what a user waits for: from the start of mpirun (of the bare program on one rank) to its exit. The
other times are the program's own. MUMPS is left out from 100 000 unknowns on. The program is built when it is missing;
RAW_ELASTIC names another one.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
MUMPS_LIMIT = 100_000
MEDIANS = ("total_s", "mesh_s", "assembly_s", "setup_s", "solve_s", "peak_memory_bytes")


def mpi_environment():
    """The environment after sourcing the project's settings for Open MPI."""
    script = 'set -a; . "$1"; env -0'
    settings = HERE.parent / "mpi_env.sh"
    output = subprocess.run(["bash", "-c", script, "bash", settings], check=True, stdout=subprocess.PIPE).stdout
    return dict(item.split("=", 1) for item in output.decode().split("\0") if "=" in item)


def program():
    given = os.environ.get("RAW_ELASTIC")
    if given:
        return given
    built = HERE / "raw_elastic"
    sources = [HERE / "raw_elastic.c", HERE / "raw_common.h", HERE / "raw_hex.h"]
    if not built.exists() or built.stat().st_mtime < max(source.stat().st_mtime for source in sources):
        subprocess.run([HERE / "build.sh", built], check=True)
    return str(built)


def run(command, environment):
    start = time.perf_counter()
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True)
    wall = time.perf_counter() - start
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode}: {' '.join(command)}")
    # PETSc and MPI may print lines of their own.
    line = next(line for line in done.stdout.splitlines() if line.startswith("{"))
    return {**json.loads(line), "wall_s": wall}


def summary(runs):
    walls = [one["wall_s"] for one in runs]
    return {
        "iterations": runs[0]["iterations"],
        "energy": runs[0]["energy"],
        "wall_s": round(statistics.median(walls), 4),
        "wall_min_s": round(min(walls), 4),
        **{key: statistics.median(one[key] for one in runs) for key in MEDIANS},
    }


def measure(binary, n, ranks, repeats, extra, environment):
    unknowns = 3 * (n + 1) ** 2 * (5 * n + 1)
    solvers = ["boomeramg", "gamg"] + ["mumps"] * (unknowns < MUMPS_LIMIT)
    launcher = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    runs = {solver: [] for solver in solvers}
    # By turns, so that a slow spell of the machine meets all.
    for _ in range(repeats):
        for solver in solvers:
            command = [*launcher, binary, "-n", str(n), "-solver", solver, *extra]
            runs[solver].append(run(command, environment))
    results = {solver: summary(of_solver) for solver, of_solver in runs.items()}
    best = min(results, key=lambda solver: results[solver]["wall_s"])
    return {
        "n": n,
        "unknowns": unknowns,
        "ranks": ranks,
        "repeats": repeats,
        "best": best,
        "best_wall_s": results[best]["wall_s"],
        "solvers": results,
    }


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("-n", type=int, nargs="+", default=[16], help="n x n x 5n cells")
    arguments.add_argument("--ranks", type=int, nargs="+", default=[1])
    arguments.add_argument("--repeats", type=int, default=3)
    arguments.add_argument("--options", nargs=argparse.REMAINDER, default=[], help="passed on, last: -nu 0 ...")
    given = arguments.parse_args()
    binary, environment = program(), mpi_environment()
    results = [
        measure(binary, n, ranks, given.repeats, given.options, environment) for n in given.n for ranks in given.ranks
    ]
    json.dump(results, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
