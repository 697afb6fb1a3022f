#!/usr/bin/env python3
"""Counts on 1 to 8 ranks and a model of more, for docs/scaling.md.

    scripts/scaling.sh [--cells 16] [--keep DIR] [--page]

Runs eight instants of the column of WTNV146 with nu = 0.3 on 1, 2, 4 and 8 ranks with multigrid, and prints
what does not depend on how many cores there are: iterations, cells, ghosts, neighbours, memory. Then a model built
on them, with its assumptions, for 10^3 to 10^5 ranks. --page puts both into docs/scaling.md.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RANKS = (1, 2, 4, 8)

# Of the machine that is modelled: a cluster of today.
LATENCY = 2e-6  # s per message between two ranks
BANDWIDTH = 5e9  # bytes/s of a rank through the network
FLOPS = 1e10  # operations/s of a rank in the factorisation of a large front
PARALLEL_FRONT = 200  # ranks that a factorisation of the coarsest level keeps busy
UNKNOWNS_PER_RANK = 2e5
# Of the program.
COARSEST_CELLS = 64  # per rank, at least: src/run/mod.rs
EXCHANGES = 12  # per level and iteration: four products with an exchange each way, two transfers with the same
REDUCTIONS = 3  # per iteration of conjugate gradients


def run(program, cells, ranks, directory):
    """The report of one run."""
    settings = [f"mesh.column.cells=[{cells}, {cells}, {5 * cells}]", "materials.rock.elastic.poisson_ratio=0.3",
                "solver.linear=multigrid", "output.fields=none", "expect=[]", "reduce=never"]
    command = [program, str(ROOT / "cases/wtnv146/case.yaml"), "--output", str(directory), "--overwrite", "--quiet"]
    for setting in settings:
        command += ["--set", setting]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks)] + command
    subprocess.run(command, check=True)
    return json.loads((directory / "report.json").read_text())


def row(report):
    """What a number of ranks has: a line of the table of counts."""
    part, unknowns = report["partition"], report["unknowns"]
    ranks = report["ranks"]
    mean = sum(part["cells"]) / ranks
    return [ranks, report["newton_iterations"], report["linear_iterations"], max(part["cells"]),
            f"{max(part['cells']) / mean:.2f}", max(part["interface_nodes"]), max(part["ghosts"]), max(part["neighbours"]),
            f"{24e-3 * max(part['ghosts']):.0f}", part["cut_pairs"], part["cells_before_distribution"],
            f"{report['peak_memory_bytes'] / ranks / 1e6:.0f}", f"{report['peak_memory_bytes'] / unknowns / 1e3:.2f}"]


def table(header, rows):
    lines = [header, ["---"] * len(header)] + [[str(cell) for cell in row] for row in rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def model(ranks, per_unknown, levels_below):
    """Seconds of one linear iteration by part, and of one factorisation of the coarsest level."""
    local = UNKNOWNS_PER_RANK
    work = per_unknown * local
    levels = max(1, round(math.log(local * ranks / 3 / (COARSEST_CELLS * ranks), 8))) + levels_below
    # Six faces of the part of a rank; each level has a quarter of the face and the same messages.
    face = (local / 3) ** (2 / 3)
    messages = EXCHANGES * levels * 6 * LATENCY if ranks > 1 else 0.0
    volume = EXCHANGES * 6 * face * 24 / BANDWIDTH * 4 / 3 if ranks > 1 else 0.0
    reductions = REDUCTIONS * 2 * math.log2(ranks) * LATENCY if ranks > 1 else 0.0
    coarse = 3 * 1.5 * COARSEST_CELLS * ranks  # unknowns; boundary nodes make half as many again
    busy = min(ranks, PARALLEL_FRONT)
    factor = 28 * coarse**2 / (FLOPS * busy)  # compact body, nested dissection
    solve = 2 * 24 * coarse ** (4 / 3) * 8 / (BANDWIDTH * busy) + 2 * math.log2(max(ranks, 2)) * 10 * LATENCY
    return [work, messages + volume, reductions, solve, factor, coarse]


def milliseconds(seconds):
    return f"{1e3 * seconds:.3g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=16)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--page", action="store_true")
    options = parser.parse_args()
    program = os.environ["COLUMN_HPC"]
    with tempfile.TemporaryDirectory() as temporary:
        place = options.keep or Path(temporary)
        reports = [run(program, options.cells, ranks, place / f"ranks-{ranks}") for ranks in RANKS]
    first = reports[0]
    counts = table(["ranks", "Newton", "linear", "most cells", "over the mean", "interface nodes", "ghosts", "neighbours",
                    "kB per exchange", "cut pairs", "cells METIS cut", "MB per rank", "kB per unknown"],
                   [row(report) for report in reports])
    per_unknown = first["timings"]["solve"] / first["linear_iterations"] / first["unknowns"]
    lines = []
    for ranks in (1, 8, 10**3, 10**4, 10**5):
        work, exchange, reductions, solve, factor, coarse = model(ranks, per_unknown, 0)
        total = work + exchange + reductions + solve
        lines.append([f"{ranks:.0e}" if ranks > 8 else ranks, f"{UNKNOWNS_PER_RANK * ranks:.1e}", milliseconds(work),
                      milliseconds(exchange), milliseconds(reductions), f"{coarse:.1e}", milliseconds(solve),
                      f"{factor:.2g}", f"{100 * (model(1, per_unknown, 0)[0]) / total:.0f} %"])
    modelled = table(["ranks", "unknowns", "work ms", "exchange ms", "reductions ms", "coarsest unknowns", "coarsest solve ms",
                      "its factorisation s", "efficiency of an iteration"], lines)
    n = options.cells
    text = (f"\nEight instants, {n} x {n} x {5 * n} cells, {first['unknowns']} unknowns:\n\n{counts}\n"
            f"One linear iteration at {UNKNOWNS_PER_RANK:.0e} unknowns per rank, from {1e9 * per_unknown:.0f} ns per unknown and "
            f"iteration on one rank:\n\n{modelled}\n")
    print(text)
    if options.page:
        page = ROOT / "docs/scaling.md"
        before, rest = page.read_text().split("<!-- counts -->")
        after = rest.split("<!-- /counts -->")[1]
        page.write_text(f"{before}<!-- counts -->\n{text}<!-- /counts -->{after}")


if __name__ == "__main__":
    sys.exit(main())
