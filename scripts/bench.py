#!/usr/bin/env python3
"""The benchmark: eight instants against one elastic instant and one bare PETSc solve. Called by scripts/bench.sh."""

import argparse
import json
import re
import sys
import unittest
from pathlib import Path
from statistics import median

import bench_check
import bench_flow
import bench_tables as tables
from bench_measure import Bench, Failed
from bench_scenes import FULL, QUICK, tilted

PAGE = Path(__file__).resolve().parent.parent / "docs" / "performance.md"
MARKS = ("<!-- bench -->", "<!-- /bench -->")
# Elimination is hopeless beyond these sizes, and gamg, which has never won, would eat the budget.
RAW_MUMPS = 60_000
LIMITS = {"multigrid": 10_000_000, "hypre": 10_000_000, "gamg": 300_000, "mumps": 80_000}
SIZES = (4, 6, 8, 12, 16, 24, 32)


def raw_solves(bench, scene, ranks, number):
    """The bare solve of the scene's mesh with every solver that may win."""
    cells = scene.raw_cells
    unknowns = 3 * (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1)
    solvers = ["boomeramg", "gamg"] + ["mumps"] * (unknowns < RAW_MUMPS)
    before = [r for r in bench.records if "solver" in r and r["ranks"] == ranks]
    mine = [r for r in before if r["scene"] == scene.name]
    if mine:
        # What lost clearly is not run again.
        best = min(r["wall"] for r in mine)
        solvers = [s for s in solvers if any(r["solver"] == s and r["wall"] < 1.5 * best for r in mine)]
    elif scene.once and before:
        # The largest mesh gets one solver: the one that won on the largest mesh before it.
        largest = max(r["unknowns"] for r in before)
        solvers = [min((r for r in before if r["unknowns"] == largest), key=lambda r: r["wall"])["solver"]]
    for solver in solvers:
        bench.attempt(f"{scene.name} raw with {solver} on {ranks} rank(s)", f"raw-{solver}", ranks, unknowns, number,
                      lambda s=solver: bench.raw(scene, ranks, s, number))


def ladder(options):
    bench = Bench(options.keep, options.budget or (120 if options.quick else 1020), options.limit)
    scenes = chosen(options)
    triads = {}
    for ranks in options.ranks:
        try:
            triads[ranks] = bench.triad(ranks, 1 if options.quick else 3)
        except Failed as error:
            bench.note(f"STREAM triad on {ranks} rank(s): {error}")
    # Round by round, so that a slow spell of the machine meets all, and a short budget costs repeats alone.
    for number in range(1, (options.repeats or (1 if options.quick else 3)) + 1):
        for scene in scenes:
            if number > 1 and scene.once:
                continue
            # What is divided by each other runs in a row. Most ranks first: where the budget ends, the slowest is missing.
            for ranks in sorted(options.ranks, reverse=True):
                linear = options.linear
                for kind in ("eight", "elastic"):
                    settings = [f"solver.linear={linear}"] + (scene.elastic if kind == "elastic" else [])
                    run = bench.attempt(
                        f"{scene.name} {kind} on {ranks} rank(s)", kind, ranks, scene.unknowns, number,
                        lambda k=kind, n=ranks, s=settings: bench.ours(scene, n, k, number, s))
                    if not run:
                        break
                    # The elastic instant is solved as the eight are.
                    linear = run["preset"]
                raw_solves(bench, scene, ranks, number)
        # After every round, so that an interrupted benchmark leaves what it has.
        rows = tables.summary(bench.records, scenes, options.ranks)
        tables.write_csv(bench.directory / "bench.csv", tables.COLUMNS, rows)
        (bench.directory / "runs.json").write_text(json.dumps(bench.records, indent=1) + "\n")
    if bench.repeats_missing:
        bench.note(f"{bench.repeats_missing} repeats, for which the budget was too short")
    heading = bench.heading("medians of the runs, times in s.")
    page = tables.bench(rows, scenes, options.ranks, triads, bench.notes, heading)
    (bench.directory / "bench.md").write_text(page)
    print(page)


def presets(options):
    """Every preset on every scene. One that takes three times as long as the best so far is stopped."""
    bench = Bench(options.keep, options.budget or (150 if options.quick else 1080), options.limit)
    rows = []
    for scene in chosen(options):
        if scene.once and not options.scenes:
            continue
        choice = bench.choice(scene)
        for ranks in options.ranks:
            place = []
            for preset, most in LIMITS.items():
                row = {"scene": scene.name, "ladder": int(scene.ladder), "cells": scene.cells, "ranks": ranks,
                       "unknowns": scene.unknowns, "preset": preset, "auto": int(preset == choice)}
                place.append(row)
                if scene.unknowns > most:
                    row["why_not"] = "too large"
                    continue
                best = min((r["wall_s"] for r in place if "wall_s" in r), default=None)
                limit = max(10.0, 3 * best) if best else None
                if bench.left() < 2:
                    row["why_not"] = "budget"
                    continue
                runs = []
                try:
                    for number in range(1, (options.repeats or 1) + 1):
                        runs.append(bench.ours(scene, ranks, preset, number, [f"solver.linear={preset}"], "none", limit))
                except Failed as error:
                    row["why_not"] = str(error)
                    if error.after:
                        row.update(why_not=f"> {error.after:.0f}", at_least_s=error.after)
                if runs:
                    one = runs[0]
                    row.update(wall_s=median(r["wall"] for r in runs), newton=one["newton"], linear=one["linear"],
                               unknowns=one["unknowns"], memory_mb=one["memory"] / 1e6)
            best = min((r["wall_s"] for r in place if "wall_s" in r), default=None)
            for row in place:
                # Of a run that was stopped the least that it lost.
                row["ratio_best"] = tables.ratio(row.get("wall_s") or row.get("at_least_s"), best)
            rows += place
            tables.write_csv(bench.directory / "presets.csv", tables.PRESET_COLUMNS, rows)
    page = tables.presets(rows, bench.heading("eight instants, no fields, wall clock of the whole process."))
    (bench.directory / "presets.md").write_text(page)
    print(page)


def accuracy(options):
    """Error of the mixed-mode scene against its finest mesh, over core-seconds."""
    bench = Bench(options.keep, options.budget or (170 if options.quick else 1080), options.limit)
    reference = options.reference or (24 if options.quick else 48)
    sizes = [n for n in options.sizes or SIZES if n < reference]
    ranks = max(options.ranks)
    linear = [f"solver.linear={options.linear}"]
    # First, since nothing can be said without it.
    finest = bench.ours(tilted(reference), ranks, "accuracy", 1, linear, "none", bench.left())
    exact = bench_check.history(bench.runs / finest["directory"])
    records = {}
    for number in range(1, (options.repeats or 1) + 1):
        for n in sizes:
            for on in options.ranks:
                scene = tilted(n)
                run = bench.attempt(f"{scene.name} on {on} rank(s)", "accuracy", on, scene.unknowns, number,
                                    lambda s=scene, r=on: bench.ours(s, r, "accuracy", number, linear, "none"))
                if run:
                    records.setdefault((n, on), []).append(run)
    rows = []
    for (n, on), runs in records.items():
        mine = bench_check.history(bench.runs / runs[0]["directory"])
        # Apart: the extremes are those of single nodes, and converge far more slowly than the mean.
        means, extremes = (
            bench_check.differences(*({k: v for k, v in h.items() if not k.endswith(left_out)} for h in (mine, exact)))
            for left_out in ((".min", ".max"), (".mean",)))
        rows.append({"n": n, "ranks": on, "unknowns": runs[0]["unknowns"], "preset": runs[0]["preset"],
                     "core_s": on * median(r["wall"] for r in runs), "traction": means["traction"][0],
                     "extreme_traction": extremes["traction"][0], "reaction": means["reaction"][0]})
    columns = ("n", "ranks", "unknowns", "preset", "core_s", "traction", "extreme_traction", "reaction")
    tables.write_csv(bench.directory / "accuracy.csv", columns, rows)
    heading = bench.heading(f"against n = {reference}; no fields; wall clock of the whole process times ranks.")
    page = heading + "\n" + tables.table(
        ["n", "ranks", "unknowns", "preset", "core-seconds", "mean traction", "largest and smallest traction", "reaction"],
        [[str(r["n"]), str(r["ranks"]), str(r["unknowns"]), r["preset"], f"{r['core_s']:.2f}", f"{r['traction']:.1e}",
          f"{r['extreme_traction']:.1e}", f"{r['reaction']:.1e}"] for r in rows])
    if bench.notes:
        page += "\n" + "".join(f"- {note}\n" for note in bench.notes)
    (bench.directory / "accuracy.md").write_text(page)
    print(page)


def flow(options):
    """A pore pressure, known or to be found, against none."""
    bench_flow.flow(options, Bench(options.keep, options.budget or (120 if options.quick else 900), options.limit))


def page(options):
    """Puts the tables of the results directory between the marks of docs/performance.md, the charts beside it.

    What the directory does not hold stays on the page."""
    directory, parts, fresh = Path(options.keep), [], False
    before = PAGE.read_text()
    pattern = re.compile(re.escape(MARKS[0]) + "(.*)" + re.escape(MARKS[1]), re.DOTALL)
    marked = pattern.search(before)
    if not marked:
        sys.exit(f"bench: {PAGE} has no {MARKS[0]} ... {MARKS[1]}")
    old = {part.split("\n", 1)[0]: f"### {part.strip()}\n" for part in re.split(r"^### ", marked[1], flags=re.MULTILINE)}
    for name, title in (("bench", "Cost"), ("check", "The same numbers"), ("presets", "Presets"),
                        ("accuracy", "Speed against accuracy"), ("flow", "Flow")):
        found = directory / f"{name}.md"
        if not found.exists():
            parts += [old[title]] if title in old else []
            continue
        fresh = True
        part = f"### {title}\n\n{found.read_text().strip()}\n"
        chart = directory / f"{'cost' if name == 'presets' else name}.svg"
        if chart.exists():
            copy = PAGE.parent / f"performance_{chart.name}"
            copy.write_text(chart.read_text())
            part += f"\n![{title}]({copy.name})\n"
        parts.append(part)
    if not fresh:
        sys.exit(f"bench: {directory} holds no tables; run scripts/bench.sh first")
    tabled = f"{MARKS[0]}\n\n" + tables.narrowed("\n".join(parts)) + f"\n{MARKS[1]}"
    PAGE.write_text(pattern.sub(lambda _: tabled, before))
    print(PAGE)


def chosen(options):
    scenes = QUICK if options.quick else FULL
    if not options.scenes:
        return scenes
    known = {scene.name: scene for scene in QUICK + FULL}
    wrong = [name for name in options.scenes if name not in known]
    if wrong:
        sys.exit(f"bench: no scene {', '.join(wrong)}; scenes: {', '.join(known)}")
    return [known[name] for name in options.scenes]


class Test(unittest.TestCase):
    """What needs no run."""

    def test_flow_cases_differ_in_the_pressure_alone(self):
        for scene in bench_flow.QUICK + bench_flow.FULL:
            lines = {kind: [line for line in bench_flow.Scene(*scene, kind).case("none").split("\n")[1:]
                            if line and "pressure: 0" not in line] for kind in bench_flow.KINDS}
            self.assertEqual(lines["flow"], lines["mechanics"])
            self.assertEqual(lines["known"], lines["mechanics"])

    def test_exponent(self):
        self.assertAlmostEqual(tables.exponent([(n, 3 * n**1.5) for n in (10, 20, 70)]), 1.5)
        self.assertIsNone(tables.exponent([(10, 3)]))

    def test_unknowns(self):
        by_name = {scene.name: scene for scene in FULL}
        self.assertEqual(by_name["cube-24"].unknowns, 3 * 25 * 25 * 122)
        self.assertEqual(by_name["nonmatching"].unknowns, 3 * (21 * 21 * 51 + 31 * 31 * 76))
        raw = 3 * 27 * 27 * 131
        self.assertLess(abs(raw / by_name["nonmatching"].unknowns - 1), 0.01)

    def test_differences_by_kind(self):
        exact = {"time": [1, 2], "a.normal_traction.max": [10.0, -2.0], "a.shear_traction_x.max": [0.0, 1.0],
                 "newton_iterations": [1, 2], "energy.elastic": [4.0, 0.0]}
        mine = {**exact, "a.shear_traction_x.max": [0.0, 1.5], "newton_iterations": [3, 4]}
        found = bench_check.differences(mine, exact)
        # Half a pascal of the largest traction, which is another component's.
        self.assertEqual(found, {"traction": (0.05, "a.shear_traction_x.max", 2), "energy": (0.0, "", 0)})


def parse():
    parser = argparse.ArgumentParser(prog="scripts/bench.sh", description=__doc__, allow_abbrev=False)
    parser.add_argument("what", nargs="?", choices=("check", "page", "self-test"), help="default: measure")
    parser.add_argument("--quick", action="store_true", help="the small scenes, one repeat")
    parser.add_argument("--presets", action="store_true", help="our presets on every scene")
    parser.add_argument("--accuracy", action="store_true", help="error over core-seconds")
    parser.add_argument("--flow", action="store_true", help="pore pressure, known or to be found, against none")
    parser.add_argument("--charts", action="store_true", help="draw what --keep holds")
    parser.add_argument("--ranks", type=lambda text: [int(n) for n in text.split()], default=[1, 2], metavar='"1 2"')
    parser.add_argument("--repeats", type=int, metavar="N", help="default: 3; 5 with --flow; 1 with --quick, --presets, --accuracy")
    parser.add_argument("--scenes", type=lambda text: text.split(","), metavar="A,B", help="default: all")
    parser.add_argument("--linear", default="auto", metavar="NAME", help="preset of the timed runs (default: auto)")
    parser.add_argument("--budget", type=float, metavar="SECONDS", help="of all runs together; then repeats are left out")
    parser.add_argument("--limit", type=float, default=300, metavar="SECONDS", help="of a single run")
    parser.add_argument("--sizes", type=lambda text: [int(n) for n in text.split(",")], metavar="4,6,8",
                        help="meshes of --accuracy")
    parser.add_argument("--reference", type=int, metavar="N", help="finest mesh of --accuracy (48; 24 with --quick)")
    parser.add_argument("--keep", default="results/bench", metavar="DIR", help="where the results go")
    return parser.parse_args()


def main():
    options = parse()
    if options.what == "self-test":
        unittest.main(argv=[sys.argv[0]])
    action = {"check": bench_check.check, "page": page}.get(options.what)
    if not action:
        action = presets if options.presets else accuracy if options.accuracy else flow if options.flow else ladder
    try:
        sys.exit(action(options))
    except (OSError, Failed, ValueError) as error:
        sys.exit(f"bench: {error}")


if __name__ == "__main__":
    main()
