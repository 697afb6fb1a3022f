#!/usr/bin/env python3
"""The table of scripts/bench.sh, from the directories NAME-RANKS-NUMBER with report.json and wall."""

import json
import sys
from pathlib import Path
from statistics import median

PHASES = ("mesh", "partition", "assembly", "solve", "output")


def read(directory):
    """{(name, ranks): [report with its wall time]}."""
    runs = {}
    for path in sorted(directory.glob("*-*-*/report.json")):
        name, ranks, _ = path.parent.name.rsplit("-", 2)
        start, end = map(float, (path.parent / "wall").read_text().split())
        runs.setdefault((name, int(ranks)), []).append(json.loads(path.read_text()) | {"wall": end - start})
    return runs


def line(name, ranks, reports):
    """A row: medians over the runs."""
    def middle(value):
        return median(map(value, reports))

    first = reports[0]
    memory = middle(lambda r: r["peak_memory_bytes"] or float("nan"))
    return [name, str(ranks), first["linear_solver"]["choice"], f"{middle(lambda r: r['wall']):.2f}",
            str(first["newton_iterations"]), str(first["linear_iterations"]), f"{memory / 1e6:.0f}",
            f"{memory / first['unknowns'] / 1e3:.2f}",
            *(f"{middle(lambda r, p=p: r['timings'][p]):.2f}" for p in PHASES)]


def main():
    runs = read(Path(sys.argv[1]))
    one = next(iter(runs.values()))
    print(f"{one[0]['title']}: {one[0]['unknowns']} unknowns, medians of {len(one)} run(s); times in s")
    head = ["what", "ranks", "solver", "wall", "newton", "linear", "MB", "kB/unknown", *PHASES]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for (name, ranks), reports in runs.items():
        print("| " + " | ".join(line(name, ranks, reports)) + " |")
    print()
    for ranks in sorted({ranks for _, ranks in runs}):
        elastic = {name: median(r["wall"] for r in reports) for (name, n), reports in runs.items()
                   if n == ranks and name != "eight"}
        best = min(elastic, key=elastic.get)
        eight = median(r["wall"] for r in runs["eight", ranks])
        print(f"{ranks} rank(s): eight instants / one elastic instant ({best}) = "
              f"{eight:.2f} s / {elastic[best]:.2f} s = {eight / elastic[best]:.2f}")


if __name__ == "__main__":
    main()
