#!/usr/bin/env python3
"""How many times faster than dolfinx: prints two factors (Debian: python3-dolfinx-real).

    . scripts/mpi_env.sh; scripts/peers/beside_dolfinx.py [--repeats 3]

The cohesive problem of WTNV146 at 8 x 8 x 40 cells against dolfinx_cohesive.py, and, at 24 x 24 x 120 cells, the eight
instants against one elastic solve of dolfinx_elastic.py times the number of our Newton corrections. Ours is the wall
clock of the whole process on one rank, all fields written; theirs is what their programs count as the run: without
the start of Python and without the compilation of forms. By turns; medians.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def ours(program, n, nu, directory):
    """Wall clock of eight instants, and the report."""
    command = [program, str(ROOT / "cases/wtnv146/case.yaml"), "--quiet", "--overwrite", "--output", str(directory),
               "--set", f"mesh.column.cells=[{n}, {n}, {5 * n}]", "--set", f"materials.rock.elastic.poisson_ratio={nu}",
               "--set", "expect=[]"]
    start = time.perf_counter()
    subprocess.run(command, check=True)
    wall = time.perf_counter() - start
    return wall, json.loads((directory / "report.json").read_text())


def theirs(script, n):
    """What a program of dolfinx prints."""
    command = ["/usr/bin/python3", str(HERE / script), "-n", str(n)]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    return json.loads(next(line for line in output.splitlines() if line.startswith("{")))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--program", default=str(ROOT / "target/release/column-hpc"))
    options = parser.parse_args()
    times = {"ours 8": [], "dolfinx 8": [], "ours 24": [], "dolfinx 24": []}
    with tempfile.TemporaryDirectory() as directory:
        directory = pathlib.Path(directory)
        for _ in range(options.repeats):
            times["ours 8"].append(ours(options.program, 8, 0.0, directory / "8")[0])
            times["dolfinx 8"].append(theirs("dolfinx_cohesive.py", 8)["run_s"])
            wall, report = ours(options.program, 24, 0.3, directory / "24")
            times["ours 24"].append(wall)
            times["dolfinx 24"].append(theirs("dolfinx_elastic.py", 24)["run_s"])
    middle = {name: statistics.median(values) for name, values in times.items()}
    newton = report["newton_iterations"]
    factors = [middle["dolfinx 8"] / middle["ours 8"], newton * middle["dolfinx 24"] / middle["ours 24"]]
    print("| cells | this program s | dolfinx s | times faster |\n|---|---|---|---|")
    print(f"| 8 x 8 x 40, eight instants | {middle['ours 8']:.2f} | {middle['dolfinx 8']:.2f} | {factors[0]:.0f} |")
    print(f"| 24 x 24 x 120, eight instants; one elastic solve times {newton} | {middle['ours 24']:.2f} | "
          f"{newton} x {middle['dolfinx 24']:.2f} | {factors[1]:.0f} |")


if __name__ == "__main__":
    sys.exit(main())
