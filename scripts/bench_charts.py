#!/usr/bin/env python3
"""Draws the results of scripts/bench.sh as SVG and PNG: scripts/bench_charts.py DIR. Needs matplotlib.

cost.svg: wall clock over unknowns for the cubes, a line for each preset of presets.csv and one for the bare
PETSc solve of bench.csv. accuracy.svg: errors over core-seconds, from accuracy.csv.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # there may be no screen
import matplotlib.pyplot as plot  # noqa: E402

import bench_tables as tables  # noqa: E402

# Okabe and Ito's colours, which colour-blind readers can tell apart.
COLOURS = {"multigrid": "#0072b2", "hypre": "#d55e00", "gamg": "#009e73", "mumps": "#cc79a7", "raw": "#222222"}
MARKERS = {"multigrid": "o", "hypre": "s", "gamg": "^", "mumps": "D", "raw": "x"}


def finish(figure, path):
    figure.tight_layout()
    for ending in ("svg", "png"):
        # No date in the file: the same figures give the same file.
        figure.savefig(path.with_suffix(f".{ending}"), dpi=150, metadata={"Date": None} if ending == "svg" else {})
        print(path.with_suffix(f".{ending}"))
    plot.close(figure)


def line(axes, points, name, label):
    points = sorted(points)
    if points:
        axes.plot(*zip(*points), label=label, color=COLOURS.get(name), marker=MARKERS.get(name, "."), markersize=5,
                  linestyle="--" if name == "raw" else "-")


def cost(directory):
    presets = tables.read_csv(directory / "presets.csv") if (directory / "presets.csv").exists() else []
    bench = tables.read_csv(directory / "bench.csv") if (directory / "bench.csv").exists() else []
    presets = [r for r in presets if r["ladder"] and r["wall_s"]]
    bench = [r for r in bench if r["scene"].startswith("cube-") and r["raw_wall_s"]]
    ranks = sorted({int(r["ranks"]) for r in presets + bench})
    if not ranks:
        return
    figure, panels = plot.subplots(1, len(ranks), figsize=(4.6 * len(ranks) + 0.6, 4.4), sharey=True, squeeze=False)
    for n, axes in zip(ranks, panels[0]):
        for name in COLOURS:
            line(axes, [(r["unknowns"], r["wall_s"]) for r in presets if r["ranks"] == n and r["preset"] == name], name,
                 f"eight instants, {name}")
        line(axes, [(r["unknowns"], r["raw_wall_s"]) for r in bench if r["ranks"] == n], "raw",
             "one bare PETSc solve, best")
        axes.set(xscale="log", yscale="log", xlabel="unknowns", title=f"{n} rank{'s' if n > 1 else ''}")
        axes.grid(True, which="both", color="#e4e4e4", linewidth=0.6)
    panels[0][0].set_ylabel("wall clock of the process (s)")
    # One legend for all panels, whichever of them has a line.
    lines = {label: handle for axes in panels[0] for handle, label in zip(*axes.get_legend_handles_labels())}
    panels[0][0].legend(lines.values(), lines.keys(), fontsize=8)
    finish(figure, directory / "cost")


def accuracy(directory):
    if not (directory / "accuracy.csv").exists():
        return
    rows = sorted(tables.read_csv(directory / "accuracy.csv"), key=lambda r: r["n"])
    figure, axes = plot.subplots(figsize=(6.4, 4.6))
    for ranks, colour in zip(sorted({int(r["ranks"]) for r in rows}), ("#0072b2", "#d55e00", "#009e73", "#cc79a7")):
        mine = [r for r in rows if r["ranks"] == ranks]
        for quantity, style, marker in (("traction", "-", "o"), ("extreme_traction", ":", "^"), ("reaction", "--", "s")):
            label = {"traction": "mean traction", "extreme_traction": "largest and smallest traction"}.get(quantity, quantity)
            axes.plot([r["core_s"] for r in mine], [r[quantity] for r in mine], linestyle=style, marker=marker,
                      markersize=5, color=colour, label=f"{label}, {ranks} rank{'s' if ranks > 1 else ''}")
    for r in rows:
        if r["ranks"] == rows[0]["ranks"]:
            axes.annotate(f"n = {r['n']:.0f}", (r["core_s"], r["traction"]), textcoords="offset points", xytext=(5, 5),
                          fontsize=8)
    axes.margins(0.12)
    axes.set(xscale="log", yscale="log", xlabel="core-seconds", ylabel="largest error over largest value",
             title="Mixed mode: error over cost")
    axes.grid(True, which="both", color="#e4e4e4", linewidth=0.6)
    axes.legend(fontsize=8)
    finish(figure, directory / "accuracy")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: scripts/bench_charts.py DIR")
    directory = Path(sys.argv[1])
    cost(directory)
    accuracy(directory)


if __name__ == "__main__":
    main()
