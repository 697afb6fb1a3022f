"""What flow costs: a run with pore pressure against the mechanical run of the same case. Called by scripts/bench.py."""

import json
from dataclasses import dataclass
from statistics import median

import bench_check
import bench_tables as tables
from bench_measure import Failed
from bench_scenes import AXIAL

POROUS = """porous: {biot: 1.0, porosity: 0.15, permeability: 1.01937e-19, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1.0, density: 2.5}"""
SOIL = """porous: {biot: 1.0, porosity: 0.3, permeability: 1.0e-11, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2000}"""

# The path of WTNV146, where the pressure is 0 at every node; and free, with which nothing flows.
COLUMN = """title: Flow benchmark {name}
mesh: {{order: {order}, column: {{size: [1.0, 1.0, 5.0], cells: [{n}, {n}, {high}]}}}}
materials:
  rock:
    elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.0}}
    {porous}
interfaces:
  - {{name: joint, z: 2.5, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0, augmentation: 10.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - on: top
    displacement: {top}
{known}
time: {{instants: [1, 2, 3, 4, 5, 6, 7, 8]}}
output: {{fields: {fields}}}
"""

# A cube that is pressed and drains upwards and to one side, in steps that grow from undrained to drained.
CUBE = """title: Flow benchmark {name}
mesh: {{order: {order}, column: {{size: [1.0, 1.0, 1.0], cells: [{n}, {n}, {high}]}}}}
materials:
  soil:
    elastic: {{young_modulus: 1.0e7, poisson_ratio: 0.2}}
    {porous}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: left, displacement: {{x: 0}}}}
  - {{on: front, displacement: {{y: 0}}}}
  - {{on: top, traction: {{z: {{formula: "-1000*(1+x+y*y)*min(t, 1)"}}}}}}
{known}
time: {{instants: [0.5, 1, 2, 4, 8, 16, 32, 64]}}
output: {{fields: {fields}}}
"""

# What the case says of the pressure, by the kind of run.
OF_COLUMN = {"mechanics": "", "known": "  - {on: all, pressure: 0}", "flow": ""}
OF_CUBE = {"mechanics": "", "known": "  - {on: all, pressure: 0}",
           "flow": "  - {on: top, pressure: 0}\n  - {on: right, pressure: 0}"}
SETTINGS = {"mechanics": ["physics=mechanics"], "known": [], "flow": []}
KINDS = {"mechanics": "without pressure", "known": "known pressure", "flow": "pressure to be found"}


@dataclass(frozen=True)
class Scene:
    """One case; `kind` says what is known of its pressure."""

    of: str
    text: str
    n: int
    order: int
    kind: str
    checked: bool = True

    @property
    def name(self):
        return f"{self.of}-{self.kind}"

    @property
    def high(self):
        return 5 * self.n if self.text is COLUMN else self.n

    @property
    def cells(self):
        return f"{self.n}x{self.n}x{self.high}, order {self.order}"

    @property
    def unknowns(self):
        x, z = self.n * self.order + 1, self.high * self.order + 1
        return 3 * x * x * z

    def case(self, fields):
        known, porous = (OF_COLUMN, POROUS) if self.text is COLUMN else (OF_CUBE, SOIL)
        return self.text.format(name=self.name, order=self.order, n=self.n, high=self.high, porous=porous, top=AXIAL,
                                known=known[self.kind], fields=fields)


QUICK = [("column-8", COLUMN, 8, 1), ("column-8-second", COLUMN, 4, 2), ("cube-12", CUBE, 12, 1)]
FULL = [("column-16", COLUMN, 16, 1), ("column-16-second", COLUMN, 8, 2),
        ("cube-24", CUBE, 24, 1), ("cube-24-second", CUBE, 12, 2)]
COLUMNS = ("scene", "cells", "ranks", "kind", "runs", "unknowns", "preset", "wall_s", "newton", "linear", "memory_mb",
           "ratio", "difference")
# Elimination, which the numbers are compared with, takes too long beyond.
EXACT = 100_000


def measure(bench, options):
    """All runs, round by round: those of a scene in a row, since they are divided by each other."""
    scenes = QUICK if options.quick else FULL
    if options.scenes:
        scenes = [scene for scene in QUICK + FULL if scene[0] in options.scenes]
    for number in range(1, (options.repeats or (1 if options.quick else 5)) + 1):
        for scene in scenes:
            for ranks in sorted(options.ranks, reverse=True):
                for kind in KINDS:
                    one = Scene(*scene, kind)
                    bench.attempt(f"{one.name} on {ranks} rank(s)", kind, ranks, one.unknowns, number,
                                  lambda s=one, r=ranks, n=number: bench.ours(s, r, s.kind, n, SETTINGS[s.kind], "none"))
    return scenes


def difference(bench, scene, ranks, run):
    """The largest difference of a run's history from that of elimination at 1e-11, over the largest of its kind."""
    if scene.unknowns > EXACT:
        return None
    exact = bench.attempt(f"{scene.name} with mumps", "exact", ranks, scene.unknowns, 1,
                          lambda: bench.ours(scene, ranks, "exact", 1, [*SETTINGS[scene.kind], "solver.linear=mumps",
                                                                        "solver.tolerance=1e-11"], "none"))
    if not exact:
        return None
    histories = [bench_check.history(bench.runs / one["directory"]) for one in (run, exact)]
    return max(worst for worst, *_ in bench_check.differences(*histories).values())


def flow(options, bench):
    """Measures and writes flow.csv and flow.md."""
    scenes = measure(bench, options)
    rows = []
    for scene in scenes:
        for ranks in options.ranks:
            runs = {kind: {r["number"]: r for r in bench.records if r["kind"] == kind and r["ranks"] == ranks
                           and r["scene"] == Scene(*scene, kind).name} for kind in KINDS}
            for kind, of in runs.items():
                if not of:
                    continue
                one = next(iter(of.values()))
                # Of the two runs of one round, which met the same load of the machine.
                ratios = [r["wall"] / runs["mechanics"][n]["wall"] for n, r in of.items() if n in runs["mechanics"]]
                exact = None
                if kind == "flow" and ranks == max(options.ranks):
                    try:
                        exact = difference(bench, Scene(*scene, kind), ranks, one)
                    except (Failed, ValueError) as error:
                        bench.note(f"{one['scene']}: {error}")
                rows.append({
                    "scene": scene[0], "cells": one["cells"], "ranks": ranks, "kind": KINDS[kind], "runs": len(of),
                    "unknowns": one["unknowns"], "preset": one["preset"], "wall_s": median(r["wall"] for r in of.values()),
                    "newton": one["newton"], "linear": median(r["linear"] for r in of.values()),
                    "memory_mb": median(r["memory"] for r in of.values()) / 1e6,
                    "ratio": median(ratios) if ratios else None, "difference": exact})
    tables.write_csv(bench.directory / "flow.csv", COLUMNS, rows)
    (bench.directory / "flow.json").write_text(json.dumps(bench.records, indent=1) + "\n")
    page = bench.heading("eight instants, no fields, wall clock of the whole process; medians of "
                         f"{max((r['runs'] for r in rows), default=0)} runs, and of their ratios round by round.")
    page += "\n" + tables.table(
        ["scene", "cells", "ranks", "pressure", "unknowns", "wall s", "Newton", "linear", "MB", "/ without pressure",
         "difference"],
        [[r["scene"], r["cells"], str(r["ranks"]), r["kind"], str(r["unknowns"]), tables.text(r["wall_s"]),
          str(r["newton"]), f"{r['linear']:.0f}", tables.text(r["memory_mb"], ".0f"), tables.text(r["ratio"]),
          tables.text(r["difference"], ".1e")] for r in rows])
    page += ("\n`difference`: the largest difference of `history.csv` from that of MUMPS at a tolerance of 1e-11, over the "
             f"largest value of its kind, up to {EXACT} displacements. column-N: the path of WTNV146, nothing drains; "
             "cube-N: pressed, then drained in steps from undrained to drained.\n")
    if bench.notes:
        page += "\nLeft out or failed:\n\n" + "".join(f"- {note}\n" for note in bench.notes)
    (bench.directory / "flow.md").write_text(page)
    print(page)
