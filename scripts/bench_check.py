"""Do the timed runs of the benchmark have the right numbers? Their histories against direct elimination."""

import csv
import json
import math
import sys

import bench_tables as tables
from bench_measure import Bench
from bench_scenes import FULL, QUICK

# Values of a kind are comparable: the largest of them all is the scale of each.
KINDS = (("traction", "traction"), ("jump", "jump"), ("sliding", "jump"), ("damage", "damage"),
         ("displacement", "displacement"), ("reaction", "reaction"), ("energy", "energy"), ("pressure", "pressure"))
TOLERANCE = 1e-8
# The true force residual over the largest reaction.
RESIDUAL = 1e-9


def kind_of(column):
    return next((kind for word, kind in KINDS if word in column), None)


def history(directory):
    """{column: [value, None where empty]} of history.csv."""
    with open(directory / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise ValueError(f"{directory / 'history.csv'} has no rows")
    return {name: [float(row[name]) if row[name] else None for row in rows] for name in rows[0]}


def differences(mine, exact):
    """{kind: (largest difference over the largest value of the kind, column, instant)}."""
    if mine.keys() != exact.keys() or mine["time"] != exact["time"]:
        raise ValueError("the histories differ in their columns or instants")
    largest, worst = {}, {}
    for name, values in exact.items():
        if kind := kind_of(name):
            largest[kind] = max([largest.get(kind, 0.0)] + [abs(v) for v in values if v is not None])
    for name, values in exact.items():
        kind = kind_of(name)
        if not kind:
            continue
        worst.setdefault(kind, (0.0, "", 0))
        for time, own, right in zip(exact["time"], mine[name], values):
            if (own is None) != (right is None):
                raise ValueError(f"{name} is empty in one of the histories")
            if own is None or own == right:
                continue
            error = abs(own - right) / largest[kind] if largest[kind] else float("inf")
            if not error <= worst[kind][0]:  # so that what is not a number counts as well
                worst[kind] = (float("inf") if math.isnan(error) else error, name, time)
    return worst


def residual(directory):
    """Largest 2-norm of the out-of-balance forces at an instant, over the largest component of a reaction."""
    norms = json.loads((directory / "report.json").read_text())["residual_norms"]
    values = [abs(v) for name, column in history(directory).items() if "reaction" in name for v in column if v is not None]
    return max(norms) / max(values)


def check(options):
    """The timed runs that are still in the results directory against MUMPS at a tolerance of 1e-12."""
    bench = Bench(options.keep, options.budget or 150, options.limit)
    records = json.loads((bench.directory / "runs.json").read_text())
    rows = {(r["scene"], int(r["ranks"])): r for r in tables.read_csv(bench.directory / "bench.csv")}
    scenes = {scene.name: scene for scene in QUICK + FULL}
    timed = [r for r in records if r["kind"] == "eight" and r.get("checked")]
    if options.scenes:
        timed = [r for r in timed if r["scene"] in options.scenes]
    settings = ["solver.linear=mumps", "solver.tolerance=1e-12"]
    references, lines, failed, ranks = {}, [], False, max(options.ranks)
    for record in timed:
        name = record["scene"]
        if name not in references:
            scene = scenes[name]
            run = bench.attempt(f"{name} with mumps", "exact", ranks, scene.unknowns, 1,
                                lambda s=scene: bench.ours(s, ranks, "exact", 1, settings, "none"))
            references[name] = history(bench.runs / run["directory"]) if run else None
            failed = failed or run is None  # what was not compared has not passed
    for place, row in rows.items():
        runs = [r for r in timed if (r["scene"], r["ranks"]) == place]
        if not runs or not references[place[0]]:
            continue
        found = [differences(history(bench.runs / r["directory"]), references[place[0]]) for r in runs]
        error, column, time = max(entry for one in found for entry in one.values())
        force = max(residual(bench.runs / r["directory"]) for r in runs)
        failed = failed or not error <= TOLERANCE or not force <= RESIDUAL
        lines.append([place[0], str(place[1]), row["preset"], str(len(runs)), f"{error:.1e}",
                      f"{column} at {time:g}" if column else "-", "yes" if error <= TOLERANCE else "**no**", f"{force:.1e}",
                      tables.text(row["ratio_elastic"]), tables.text(row["ratio_raw"])])
    if not timed:
        print("bench: none of the timed runs is small enough to be compared with direct elimination", file=sys.stderr)
        return 0
    page = ("The history of every timed run against that of MUMPS at a tolerance of 1e-12: the largest difference over the\n"
            "largest value of its kind; and the largest 2-norm of the out-of-balance forces at any instant over the largest\n"
            "reaction.\n\n")
    page += tables.table(["scene", "ranks", "preset", "runs", "worst difference", "where", f"below {TOLERANCE:.0e}", "force residual / reaction",
                          "eight / elastic", "eight / raw"], lines)
    page += "".join(f"\n- {note}" for note in bench.notes)
    (bench.directory / "check.md").write_text(page)
    print(page)
    return 1 if failed else 0
