#!/usr/bin/env python3
"""Writes docs/stability.md from the logs of scripts/stability.sh: scripts/stability.py page LOGS | self-test.

Errors near round-off are shown as bounds, so that two machines give the same text. Standard library only.
"""

import math
import sys
import unittest
from pathlib import Path

from stability_read import Wrong, order, read

PAGE = Path(__file__).resolve().parent.parent / "docs" / "stability.md"


def bound(value):
    """An error: what is below 1e-9 as a power of ten not below 1e-12, the rest with two digits."""
    if value >= 1e-9:
        return f"{value:.1e}"
    exponent = -12
    while value > 10.0**exponent:
        exponent += 1
    return f"≤ 1e{exponent}"


def count(value):
    """A number of iterations, or that there is none."""
    return "fails" if value is None else f"{value:.0f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def last(rows):
    return rows[-1]


def order_of(errors):
    """The observed order between the last two levels."""
    return f"{math.log2(errors[-2] / errors[-1]):.2f}"


def summary(f):
    """One row for each experiment: the failing method and the right one, each with its number."""
    penalty, (_, exact) = {r[0]: r for r in f["1.penalty"]}, f["1.exact"]
    contrast, slivers = last(f["3.contrast"]), last(f["4.slivers"])
    bending, locking = f["5.bending"], last(f["6.locking"])
    fails = [r for r in f["7.snap_back"] if r[1] is None]
    off, follow = f["8.branches"][0], f["8.branches"][2]
    steps = {r[0]: r for r in f["12.steps"]}
    least = f["11.cycles"][0]
    ten = next(r for r in f["11.cycles"] if r[0] == 10.0)
    facets, dual = f["inf_sup"]["constants on facets"], f["inf_sup"]["3D, orders [1, 1], [1, 1]"]
    tilt = f["8.tilt"]
    stiff, soft = ([count(c) for c in side] for side in contrast[4])
    null = {name[:2]: kept for name, kept, _ in f["null"]}
    unique = [r for r in f["ranks"] if r[3]]
    reclosed = f["19.reclosure"]
    return [
        (1, "penalty or exact adherence", f"penalty of 1e4 E/h: opens by {penalty[1e4][1]:.2e} of the displacement, gamg "
         f"{count(penalty[1e4][2][0])} iterations; at {f['1.fails_at']:.0e} E/h no convergence",
         f"opening {f['1.exact'][0]:g}, gamg {count(exact[0])}, hypre {count(exact[1])}, multigrid {count(exact[2])} iterations"),
        (2, "multipliers on prescribed edges", f"kept: {null['2D']} null singular values at one edge in 2D, {null['3D']} in 3D",
         f"dropped: none; MUMPS finds {f['2.null_pivots']} null pivots, tractions off by {bound(f['2.traction_error'])}"),
        (3, "ratio and contrast", f"multipliers on the stiff, coarse side, contrast {contrast[1]:.0e}: gamg {stiff[0]}, hypre {stiff[1]}, "
         f"multigrid {stiff[2]}; points of the secondary facets: nodal forces off by {bound(f['3.contrast'][0][3])} (12 : 8)",
         f"on the soft, fine side: {soft[0]}, {soft[1]}, {soft[2]}; tractions off by {bound(contrast[2])}"),
        (4, "slivers", f"{slivers[0]} : {slivers[0] + 1}, points of the secondary facets: nodal forces off by {bound(slivers[2])}",
         f"tractions off by {bound(slivers[3])}, gamg {count(slivers[4][0])} iterations, {count(slivers[5][0])} on matching cells"),
        (5, "order and shape", f"first order, cells of 1 : {bending[4][0]:.0f} across the depth: {bending[4][2]:.1f} times too stiff in bending; "
         f"of 1 : 20 a false damage of {f['5.damage'][0]:.2f}", f"second order: {bending[5][2]:.6f}, damage {f['5.damage'][1]:.0f}"),
        (6, "ν → 1/2", f"full integration, ν = {locking[0]}: {locking[1][0]:.1f} times too stiff (order 1), {locking[1][2]:.2f} (order 2)",
         f"B-bar: {locking[1][1]:.3f} and {locking[1][3]:.3f}"),
        (7, "snap-back", f"prescribed displacement, L = {', '.join(f'{r[0]:g}' for r in fails)} Lc: no solution past the peak, told in words",
         f"prescribed dissipation: the closed form to {bound(max(r[2] for r in f['7.snap_back']))}, 900 J at rupture"),
        (8, "equal interfaces, tilting", f"`off`: both open, damage {off[3][0]:.4f} and {off[3][1]:.4f}, {off[4]:.1f} J, without a word; column of 8.4 m: even",
         f"`follow`: damage {follow[3][0]:.4f} and {follow[3][1]:.4f}, {follow[4]:.1f} J, reported as not unique; column: {tilt[1][0]:.2f} to {tilt[1][1]:.2f}"),
        (9, "small time steps of coupled flow", "shown by `cases/terzaghi`", "its first step, in cells of both orders"),
        (11, "Newton's cycles", f"r = {2 * least[0]:.2f} h: {count(least[1])} corrections, {least[2][0]} cycles, {least[2][1]} cut steps; r ≤ h is refused",
         f"r = {2 * ten[0]:.0f} h: {count(ten[1])} corrections, {ten[2][0]} cycles, {ten[2][1]} cut steps; the same numbers"),
        (12, "length of the steps", "two energies of rupture (Benzeggagh and Kenane), sheared, then opened too: "
         + ", ".join(f"{steps[n][5][1]:.0f} J in {n}" for n in (1, 10, 100)) + " steps",
         f"one energy: 900 J to {bound(max(abs(r[1] / 900 - 1) for r in f['12.steps']))} in 1 to 1000 steps"),
        (13, "ranks", "which of two equal interfaces opens is a choice: reported as not unique on 1, 2, 3, 4 and 7 ranks, and the same on each",
         f"{len(unique)} cases that are unique differ by {bound(max(r[2] for r in unique))}; cells scattered {bound(max(r[2] for r in f['13.scattered']))}"),
        (14, "units", "an absolute tolerance would show as a change of iterations: none found",
         "; ".join(f"{s}: " + ", ".join(f"{count(r[3])}" for r in f["14.units"] if r[0] == s) for s in ("mumps", "gamg"))
         + " linear iterations in N-m, N-mm, GN-m"),
        (15, "inf-sup", f"constants on facets, 2 to 16 cells: {facets[0]:.2f} → {facets[-1]:.2f}, as h",
         f"dual, 2 to 8 cells in 3D: {dual[0]:.2f} → {dual[-1]:.2f}"),
        (19, "closed after shear while open", "no law of the program keeps a traction: not shown",
         f"−116000 Pa to {bound(max(r[1] for r in reclosed) / 116000)} and shear below {bound(max(r[2] for r in reclosed))} Pa, r from {2 * reclosed[0][0]:.2f} h to {2 * last(reclosed)[0]:.0f} h"),
    ]


def page(f):
    alternation = f["11.alternation"]
    orders = {key: f["orders"][(key, (4, 6))] for key in (1, 2)}
    stable = {k: v for k, v in f["inf_sup"].items() if k.startswith("3D")}
    flat = [v for k, v in f["inf_sup"].items() if k.startswith("orders")]
    drop = min(v[-1] / v[1] for v in flat)
    overshoot = next(r for r in f["11.cycles"] if r[0] == 10.0)[3][2]
    parts = [
        """# Where methods fail

Generated by `scripts/stability.sh` from the numbers that `tests/acceptance/suite` and the tests of the inf-sup constant
assert and print. Each experiment is a family of cases around one of `cases/stability/`, whose expectations hold as it stands; the
numbers follow those of a list of twenty, of which the missing ones (10, 16, 17, 18, 20) are no matter of a column.
Errors are relative where no unit is given; E is Young's modulus, h in E/h the height of a cell, else the softening slope.
""",
        table(("", "experiment", "failing method", "right method"), summary(f)),
        f"""
## 1. Penalty or exact adherence

`adherence.yaml`. An interface with a stiffness (law `bilinear`, what most codes have) opens by traction/stiffness where nothing should open, and the
algebra pays for making that small: gamg's iterations grow, and at 1e8 E/h round-off keeps even elimination from the tolerance. hypre and
multigrid hardly feel the stiffness. Exact adherence opens by nothing, and no stiffness costs a solver less.

![Opening and iterations over the stiffness](stability_penalty.svg)
""",
        table(("stiffness · h/E", "opening/displacement", "gamg", "hypre", "multigrid"),
              [(f"{r[0]:.0e}", f"{r[1]:.2e}", *map(count, r[2])) for r in f["1.penalty"]]
              + [("exact adherence", f"{f['1.exact'][0]:g}", *map(count, f["1.exact"][1]))]),
        """
## 2. Multipliers on prescribed edges

`constrained_edges.yaml`: two non-matching interfaces whose edges are prescribed all around. A multiplier on a prescribed component constrains twice; each is a
singular value of the jump that vanishes, two for the end of a line. The failing basis exists in the tests only.
""",
        table(("cells, lower : upper", "null, multipliers kept", "null, dropped and shared out"), f["null"]),
        """
## 3. Ratio of the meshes and contrast

`contrast.yaml`, lower : upper cells per edge. Iterations are for the lower, stiff and coarse side as secondary one, then for the upper, which `auto` takes. *By points* is
the error of nodal forces under a uniform traction where the primary functions are integrated with two Gauss points of each secondary facet instead of on exact segments.

![Iterations over the contrast, and errors where sides nearly match](stability_contrast.svg)
""",
        table(("cells", "contrast", "traction, segments", "by points", "gamg", "hypre", "multigrid"),
              [(f"{r[0][0]} : {r[0][1]}", f"{r[1]:g}", bound(r[2]), bound(r[3]),
                *(f"{count(a)} / {count(b)}" for a, b in zip(*r[4]))) for r in f["3.contrast"]]),
        """
## 4. Slivers

`slivers.yaml`: n against n + 1 cells, whose overlaps go down to 1/(n + 1) of a facet. Iterations beside those of n against n cells. Facets that are covered in part, where
weights vanish, cannot be shown: the two sides of a column always cover each other.
""",
        table(("n", "least overlap", "by points", "traction, segments", "gamg (matching)", "hypre (matching)"),
              [(r[0], f"{r[1]:.4f}", bound(r[2]), bound(r[3]), *(f"{count(a)} ({count(b)})" for a, b in zip(r[4], r[5])))
               for r in f["4.slivers"]]),
        f"""
## 5. Order and shape

`bending.yaml`: pure bending with one cell across the depth. A cell of first order shears where it should bend and is stiffer by 1 + (length/depth)²/2, measured to 1e-7. With cells
of 20 depths the interface gives way, to a damage of {f['5.damage'][0]:.3f}, though the exact traction is a 38th of the strength. Second order is exact whatever the shape. The observed orders of a manufactured solution with
an uneven opening, 4 : 6 cells: displacement {order_of(orders[1]['displacement'])} and {order_of(orders[2]['displacement'])}, energy norm {order_of(orders[1]['energy'])} and {order_of(orders[2]['energy'])}, traction {order_of(orders[1]['traction'])} and {order_of(orders[2]['traction'])} (order 1 and 2).

![Errors under refinement, and inf-sup constants](stability_orders.svg)
""",
        table(("length/depth", "order", "stiffness/exact", "largest traction/exact"),
              [(f"{r[0]:.0f}", r[1], f"{r[2]:.6f}", f"{r[3]:.6f}") for r in f["5.bending"]]),
        """
## 6. Nearly incompressible

`incompressible.yaml`, in the family between rough platens: stiffness over that of 6 x 6 x 6 cells of second order with B-bar, for 4 x 4 x 4 cells of order 1 and
2 x 2 x 2 of order 2. B-bar does not lock, but does not help the algebra: iterations (8 x 8 x 8 cells) grow until solvers fail, which is why `auto` eliminates there.

![Stiffness and iterations over Poisson's ratio](stability_locking.svg)
""",
        table(("ν", "order 1, full", "B-bar", "order 2, full", "B-bar", "gamg", "hypre", "multigrid"),
              [(r[0], *(f"{s:.3f}" for s in r[1]), *map(count, r[2])) for r in f["6.locking"]]),
        """
## 7. Snap-back

`snap_back.yaml`: columns of L/Lc, Lc = E critical jump/strength = 8.628 m. With prescribed displacements the run ends past the peak with status 3 and says that the interface gives way over its whole
area and that `control` follows it; no run converges to a wrong state. Steps of 5 % of the dissipation trace every column.

![Traction over displacement](stability_snap_back.svg)
""",
        table(("L/Lc", "prescribed displacement: corrections", "dissipation: error of the displacement", "dissipated", "corrections"),
              [(f"{r[0]:g}", count(r[1]), bound(r[2]), f"{r[3]:.6f} J", count(r[4])) for r in f["7.snap_back"]]),
        f"""
## 8. Equal interfaces and tilting

`two_equal_interfaces.yaml`, `weaker_by_a_thousandth.yaml`. Both opening alike is an equilibrium that Newton's method finds in silence; the stable answer opens one. The damage is that at time 2, the energy that at time 4.
A column of 8.4 m (4 x 4 x 32 cells) tilts: the damage of its only interface is {f['8.tilt'][0][0]:.3f} everywhere with `off`, {f['8.tilt'][1][0]:.0f} to {f['8.tilt'][1][1]:.0f} with `follow`.

![Force over displacement](stability_branches.svg)
""",
        table(("case", "imperfection", "`stability`", "damage, lower", "upper", "dissipated", "unstable states told", "not unique"),
              [(r[0], "none" if r[1] is None else f"{1 - r[1]:.0e}", r[2], *(f"{d:.6f}" for d in r[3]), f"{r[4]:.4f} J", r[5], r[6])
               for r in f["8.branches"]]),
        """
## 9. Small time steps of coupled flow

Not here: `cases/terzaghi` shows it. Its first step is 1e-4 s long, a 6500th of h²/(6 c_v): cells of first order are held back and stay within 1e-3 of the exact pressure, cells of second order overshoot by 27 %, with a warning.""",
        f"""
## 11. Newton's cycles

`overshoot.yaml`: six steps to 0.5, −0.5, 1.2, −1.2, 1.7, −1.2 times the elastic limit, and single steps from rest. In each cell: corrections, cycles that were met by half steps (`the branches cycle with
period 2` under `--verbose`), cut steps. The tractions are those of the closed form for every r; r ≤ h is refused. A step past rupture from rest costs {overshoot[0]:.0f} corrections and {overshoot[1][1]} cut whatever r is: its first attempt wanders without a
period until `max_newton`. Points that soften without a change of branch can alternate too (`constrained_edges.yaml` with a strength of 1e7: {count(alternation[0])} corrections, {alternation[1][0]} cycles recognised, {alternation[1][1]} cut); the answer is right.

![Corrections over the augmentation, dissipation over steps](stability_steps.svg)
""",
        table(("r/h", "six steps", "one to 0.5", "one to 1.2", "one to 3"),
              [(f"{2 * r[0]:g}", f"{count(r[1])}, {r[2][0]}, {r[2][1]}", *(f"{count(s[0])}, {s[1][0]}, {s[1][1]}" for s in r[3]))
               for r in f["11.cycles"]]),
        """
## 12. Length of the steps

`step_size.yaml`. Where all modes have one energy the dissipation does not know the steps. The external work is a trapezoidal sum and converges. Where the modes differ, a path that turns between them (sheared, then opened too) does depend on the steps. Those that press open lips are cut.
""",
        table(("steps", "dissipated", "external work", "corrections", "turning, one energy", "turning, two energies"),
              [(r[0], f"{r[1]:.6f} J", f"{r[2]:.3f} J", count(r[3]), *((f"{v:.3f} J" for v in r[5]) if r[5] else ("", ""))) for r in f["12.steps"]]),
        """
## 13. Ranks

Every base case on 1, 2, 3, 4 and 7 ranks: the largest difference of any value of `history.csv`, relative to the largest of its kind; the tests allow 1e-8. `partition.yaml` also with every cell on a rank of its own choice.
""",
        table(("case", "expectations met", "largest difference", "unique"),
              [(r[0], r[1], bound(r[2]), "yes" if r[3] else "no, reported on every number of ranks") for r in f["ranks"]]
              + [(f"partition, scattered on {r[0]}, {r[1]} pairs cut", "", bound(r[2]), "yes") for r in f["13.scattered"]]),
        """
## 14. Units

`millimetres.yaml`: WTNV146 with 4 x 4 x 20 cells and ν = 0.25 in three systems. A count of iterations that changed would betray an absolute tolerance.
""",
        table(("solver", "units", "corrections", "linear iterations"), [(r[0], r[1], count(r[2]), count(r[3])) for r in f["14.units"]]),
        f"""
## 15. Inf-sup

`pairs_of_spaces.yaml`, and the constants of all pairs by `cargo test --release --lib inf_sup`: the {len(flat)} pairs in 2D (orders 1 and 2, ratios 1 : 1, 2 : 3, 3 : 2, either side, edges free or prescribed) keep at least {100 * drop:.1f} % of theirs from the second level to the last.
""",
        table(("pair", "level 1", "2", "3", "4"),
              [(k, *(f"{v:.3f}" for v in values)) for k, values in stable.items()]
              + [("2D, constants on facets (fails)", *(f"{v:.3f}" for v in f["inf_sup"]["constants on facets"]))]),
        """
## 19. Closed after shear while open

`sheared_while_open.yaml`: broken, sheared while open, closed with the sliding still there, sheared on. The error of −116000 Pa and the largest shear traction while closed.
No law of the program keeps a traction there, so that a failing method is not shown.
""",
        table(("r/h", "normal traction (Pa)", "shear traction (Pa)", "cut steps"),
              [(f"{2 * r[0]:g}", bound(r[1]), bound(r[2]), r[3][1]) for r in f["19.reclosure"]]),
    ]
    return "\n".join(parts) + "\n"


class Test(unittest.TestCase):
    """What the page shows does not depend on noise, and what the tests print is read."""

    def test_bounds(self):
        self.assertEqual([bound(v) for v in (0.0, 3e-15, 4e-11, 0.0123)], ["≤ 1e-12", "≤ 1e-12", "≤ 1e-10", "1.2e-02"])
        self.assertEqual([count(None), count(12.0)], ["fails", "12"])

    def test_orders(self):
        line = ("2D, order 2, [4, 6]: Errors { displacement: 3.00, energy: 2.00 } from [Errors { displacement: 0.8, energy: "
                "0.4, traction: 0.2, checkerboard: 0.1 }, Errors { displacement: 0.1, energy: 0.1, traction: 0.1, checkerboard: 0.1 }]")
        key, levels = order(line)
        self.assertEqual((key, levels["displacement"], order_of(levels["displacement"])), ((2, (4, 6)), [0.8, 0.1], "3.00"))
        self.assertIsNone(order("test orders::in_2d ... ok"))


def main():
    if sys.argv[1:] == ["self-test"]:
        unittest.main(argv=[sys.argv[0]])
    if len(sys.argv) != 3 or sys.argv[1] != "page":
        sys.exit("usage: scripts/stability.py page LOGS | self-test")
    try:
        PAGE.write_text(page(read(sys.argv[2])))
    except (Wrong, KeyError) as error:
        print(f"stability: {error}", file=sys.stderr)
        return 4
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
