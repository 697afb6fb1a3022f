#!/usr/bin/env python3
"""Draws docs/stability_*.svg from the logs of scripts/stability.sh: scripts/stability_charts.py LOGS [DIR].

With DIR the pictures go there, as PNG too. Needs matplotlib."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # there may be no screen
import matplotlib.pyplot as plot  # noqa: E402

from stability_read import read  # noqa: E402

# Text as text keeps the files small; no date and no random names in them.
plot.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "stability", "font.size": 9, "legend.fontsize": 8,
                      "axes.titlesize": 10})
# Okabe and Ito's colours, which colour-blind readers can tell apart.
BLUE, RED, GREEN, PINK, ORANGE, BLACK = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#222222"
SOLVERS = (("gamg", RED, "^"), ("hypre", GREEN, "s"), ("multigrid", BLUE, "o"))


def panels(count, width=4.4):
    figure, axes = plot.subplots(1, count, figsize=(width * count, 3.5), squeeze=False)
    for each in axes[0]:
        each.grid(True, color="#e4e4e4", linewidth=0.6)
        each.set_axisbelow(True)
    return figure, axes[0]


def finish(figure, directory, name, png):
    figure.tight_layout()
    figure.savefig(directory / f"stability_{name}.svg", metadata={"Date": None})
    if png:
        figure.savefig(directory / f"stability_{name}.png", dpi=110)
    plot.close(figure)


def penalty(found):
    figure, (left, right) = panels(2)
    rows = found["1.penalty"]
    stiffness = [r[0] for r in rows]
    left.plot(stiffness, [r[1] for r in rows], color=RED, marker="^", label="penalty (law bilinear)")
    left.set(xscale="log", yscale="log", ylim=(1e-8, 2), xlabel="stiffness of the interface · cell height / E",
             ylabel="spurious opening / displacement of the top", title="An interface that should be closed")
    left.annotate("exact adherence: no opening", (0.04, 0.06), xycoords="axes fraction", color=BLUE)
    left.legend()
    exact = found["1.exact"][1]
    for index, (name, colour, marker) in enumerate(SOLVERS):
        right.plot(stiffness, [r[2][index] for r in rows], color=colour, marker=marker, label=f"{name}, penalty")
        right.axhline(exact[index], color=colour, linestyle="--", linewidth=1)
    right.plot([], [], color=BLACK, linestyle="--", label="the same, exact adherence")
    right.set(xscale="log", yscale="log", ylim=(8, 700), xlabel="stiffness of the interface · cell height / E",
              ylabel="linear iterations", title="What it costs")
    right.legend()
    return figure


def contrast(found):
    figure, (left, right) = panels(2)
    rows = [r for r in found["3.contrast"] if r[0] == [4, 10]]
    for index, (name, colour, marker) in enumerate(SOLVERS):
        for side, style in ((0, "--"), (1, "-")):
            points = [(r[1], r[4][side][index]) for r in rows if r[4][side][index] is not None]
            left.plot(*zip(*points), color=colour, marker=marker, linestyle=style, label=name if side else None)
    left.plot([], [], color=BLACK, linestyle="--", label="multipliers on the stiff, coarse side")
    left.plot([], [], color=BLACK, label="on the soft, fine side (chosen)")
    left.set(xscale="log", yscale="log", ylim=(8, 4000), xlabel="modulus of the coarse / of the fine body", ylabel="linear iterations",
             title="4 against 10 cells per edge")
    left.legend()
    rows = found["4.slivers"]
    right.plot([r[0] for r in rows], [r[2] for r in rows], color=RED, marker="^", label="nodal forces by points of the secondary facets")
    right.plot([r[0] for r in rows], [r[3] for r in rows], color=BLUE, marker="o", label="exact segments, the whole solution")
    right.set(xscale="log", yscale="log", ylim=(1e-16, 40), xlabel="n cells against n + 1",
              ylabel="error of uniform tractions", title="Sides that nearly match")
    right.legend()
    return figure


def locking(found):
    figure, (left, right) = panels(2)
    rows = found["6.locking"]
    distance = [0.5 - r[0] for r in rows]
    labels = (("order 1, full", RED, "^"), ("order 1, B-bar", BLUE, "o"), ("order 2, full", ORANGE, "v"),
              ("order 2, B-bar", GREEN, "s"))
    for index, (label, colour, marker) in enumerate(labels):
        left.plot(distance, [r[1][index] for r in rows], color=colour, marker=marker, label=label)
    for axes in (left, right):
        axes.set(xscale="log", yscale="log", xlabel="1/2 − Poisson's ratio")
        axes.invert_xaxis()
    left.set(ylabel="stiffness / that of a fine mesh", title="Block between rough platens")
    left.legend()
    for index, (name, colour, marker) in enumerate(SOLVERS):
        points = [(d, r[2][index]) for d, r in zip(distance, rows) if r[2][index] is not None]
        right.plot(*zip(*points), color=colour, marker=marker, label=name)
    right.set(ylabel="linear iterations", title="B-bar, 8 × 8 × 8 cells, order 1")
    right.legend()
    return figure


def snap_back(found):
    figure, (axes,) = panels(1, 6.2)
    for (ratio, _, _, _, _, path), colour in zip(found["7.snap_back"], (BLUE, GREEN, PINK, ORANGE, RED, BLACK)):
        if ratio in (0.9, 1.01):
            continue
        critical = path[-1][0]
        points = [(0.0, 0.0)] + [(u / critical, t / 1.1e6) for u, t in path]
        axes.plot(*zip(*points), color=colour, marker=".", label=f"L = {ratio:g} Lc")
        if ratio > 1:
            axes.plot(*points[1], color=colour, marker="x", markersize=11, markeredgewidth=2, linestyle="none")
    axes.plot([], [], color="#777777", marker="x", markersize=9, markeredgewidth=2, linestyle="none",
              label="prescribed displacement ends here")
    axes.set(xlabel="displacement of the top / critical jump", ylabel="traction / strength", xlim=(0, 5.3), ylim=(0, 1.1),
             title="The whole path, in steps of 5 % of the dissipation")
    axes.legend(loc="lower right")
    return figure


def branches(found):
    figure, (axes,) = panels(1, 6.2)
    for key, colour, marker, label in (("8.path_off", RED, "^", "both open alike (off): an unstable equilibrium"),
                                       ("8.path_follow", BLUE, "o", "one opens (follow)")):
        points = [(0.0, 0.0)] + [(1e3 * u, 1e-6 * f) for u, f in found[key][0]]
        axes.plot(*zip(*points), color=colour, marker=marker, markersize=5, label=label)
    axes.set(xlabel="displacement of the top (mm)", ylabel="force on the top (MN)", xlim=(0, 2.1), ylim=(0, 1.3),
             title="Two equal interfaces in series")
    axes.legend()
    return figure


def steps(found):
    figure, (left, right) = panels(2)
    rows = found["11.cycles"]
    ratio = [2 * r[0] for r in rows]
    left.plot(ratio, [r[1] for r in rows], color=BLUE, marker="o", label="six steps that reverse")
    left.plot(ratio, [r[3][1][0] for r in rows], color=GREEN, marker="s", label="one step to 1.2 × elastic limit")
    left.plot(ratio, [r[3][2][0] for r in rows], color=RED, marker="^", label="one step to 3 × elastic limit")
    left.axvline(1.0, color=BLACK, linestyle=":", linewidth=1)
    left.annotate("refused", (1.0, 1.3), xytext=(-3, 0), textcoords="offset points", ha="right")
    left.set(xscale="log", yscale="log", xlim=(0.12, 4e4), ylim=(1, 2000), xlabel="augmentation r / softening slope h",
             ylabel="Newton corrections", title="Newton's method")
    left.legend()
    rows = found["12.steps"]
    some = [r for r in rows if r[5]]
    right.plot([r[0] for r in rows], [r[1] for r in rows], color=BLUE, marker="o", label="opening to rupture")
    right.plot([r[0] for r in some], [r[5][0] for r in some], color=GREEN, marker="s", linestyle="--",
               label="sheared, then opened: one energy")
    right.plot([r[0] for r in some], [r[5][1] for r in some], color=RED, marker="^",
               label="sheared, then opened: two energies")
    right.set(xscale="log", ylim=(0, 3000), xlabel="steps to rupture", ylabel="dissipated energy (J)",
              title="Length of the steps")
    right.legend()
    return figure


def orders(found):
    figure, (left, right) = panels(2)
    for order, style in ((1, "-"), (2, "--")):
        levels = found["orders"][(order, (4, 6))]
        for name, colour, marker in (("displacement", BLUE, "o"), ("energy", RED, "^"), ("traction", GREEN, "s")):
            n = [6 * 2**level for level in range(len(levels[name]))]
            label = f"{name}, order {order}"
            left.plot(n, levels[name], color=colour, linestyle=style, marker=marker, markersize=5, label=label)
    left.set(xscale="log", yscale="log", ylim=(1e-9, 1), xlabel="cells per edge of the finer side",
             ylabel="relative error", title="Manufactured solution, 4 : 6 cells and finer")
    left.set_xticks(n, [str(each) for each in n])
    left.minorticks_off()
    left.legend(loc="lower left", ncols=2, fontsize=7, handlelength=3.5)
    constants = found["inf_sup"]
    for key, colour, marker, label, sizes in (
            ("3D, orders [1, 1], [1, 1]", BLUE, "o", "first order, dual, 3D", (2, 4, 6, 8)),
            ("3D, orders [2, 2], [1, 1]", GREEN, "s", "second order, dual, 3D", (1, 2, 3, 4)),
            ("constants on facets", RED, "^", "constants on facets, 2D", (2, 4, 8, 16))):
        right.plot(sizes, constants[key], color=colour, marker=marker, label=label)
    right.set(xscale="log", yscale="log", ylim=(0.07, 3), xlabel="cells per edge", ylabel="inf-sup constant",
              title="Stability of displacements and multipliers")
    right.legend()
    return figure


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: scripts/stability_charts.py LOGS [DIR]")
    found = read(sys.argv[1])
    directory = Path(sys.argv[2]) if len(sys.argv) == 3 else Path(__file__).resolve().parent.parent / "docs"
    for chart in (penalty, contrast, locking, snap_back, branches, steps, orders):
        finish(chart(found), directory, chart.__name__, png=len(sys.argv) == 3)


if __name__ == "__main__":
    main()
