#!/usr/bin/env python3
"""Times eight instants of the column, with its mesh from a file, against one bare PETSc solve.

    scripts/bench_files.py --make --meshes DIR        makes the meshes (pip install gmsh==4.15.2)
    scripts/bench_files.py --meshes DIR [--keep DIR] [--ranks 1 2] [--repeats 5] [--scenes hex,tet10,...]

The path is that of WTNV146 with nu = 0.3. Scenes: `hex` of 24 x 24 x 120 hexahedra, `tet10` of tetrahedra of second
order, `hex-refined` and `tet10-refined` with a file four times as coarse and `refine: 2`. The bare solve
(scripts/peers/raw_mesh.c) has the finest mesh of its kind, without the interface, with BoomerAMG and with
GAMG; the faster of the two counts. Every program runs by turns, from the start of its process to the exit.
COLUMN_HPC names the program.
"""

import argparse
import json
import statistics
import struct
import subprocess
import sys
from array import array
from pathlib import Path

from bench_measure import Bench, Failed, raw_best
from bench_scenes import AXIAL

CASE = """title: Benchmark {name}
mesh: {{file: {mesh}{more}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}, on: rock}}}}
interfaces:
  - {{name: joint, on: joint, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0, augmentation: 10.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - on: top
    displacement: {top}
time: {{instants: [1, 2, 3, 4, 5, 6, 7, 8]}}
output: {{fields: all}}
"""
# File, further keys of the mesh, mesh of the bare solve.
SCENES = {
    "hex": ("hex.msh", "", "hex.cells"),
    "tet10": ("tet10.msh", "", "tet10.cells"),
    "hex-refined": ("hex-coarse.msh", ", refine: 2", "hex.cells"),
    "tet10-refined": ("tet10-coarse.msh", ", refine: 2", "tet10-fine.cells"),
}
# Gmsh's kinds of cells, and what of their nodes stands at another place in VTK's order.
HEX8, TET10 = 5, 11


def column(gmsh, kind, divisions, refine=0, size=None):
    """The column of two blocks that share their face, at the middle of its height."""
    gmsh.clear()
    gmsh.model.add("column")
    occ, model = gmsh.model.occ, gmsh.model
    lower = occ.addBox(0, 0, 0, 1, 1, 2.5)
    upper = occ.addBox(0, 0, 2.5, 1, 1, 2.5)
    occ.fragment([(3, lower)], [(3, upper)])
    occ.synchronize()
    if kind == HEX8:
        for _, curve in model.getEntities(1):
            low, high = model.getBoundingBox(1, curve)[2::3]
            model.mesh.setTransfiniteCurve(curve, (divisions * 5 // 2 if high - low > 1 else divisions) + 1)
        for _, surface in model.getEntities(2):
            model.mesh.setTransfiniteSurface(surface)
            model.mesh.setRecombine(2, surface)
        for _, volume in model.getEntities(3):
            model.mesh.setTransfiniteVolume(volume)
    else:
        for name in ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax"):
            gmsh.option.setNumber(name, size)
    for name, height in (("bottom", 0), ("joint", 2.5), ("top", 5)):
        faces = model.getEntitiesInBoundingBox(-0.1, -0.1, height - 1e-3, 1.1, 1.1, height + 1e-3, 2)
        model.addPhysicalGroup(2, [tag for _, tag in faces], name=name)
    model.addPhysicalGroup(3, [tag for _, tag in model.getEntities(3)], name="rock")
    model.mesh.generate(3)
    for _ in range(refine):
        model.mesh.refine()
    if kind == TET10:
        model.mesh.setOrder(2)


def write_cells(gmsh, kind, path):
    """The mesh for the bare solve, its nodes sorted by height."""
    tags, points, _ = gmsh.model.mesh.getNodes()
    points = [tuple(points[3 * i:3 * i + 3]) for i in range(len(tags))]
    _, connected = gmsh.model.mesh.getElementsByType(kind)
    used = set(connected)
    rows = sorted((i for i in range(len(tags)) if tags[i] in used), key=lambda i: points[i][::-1])
    place = {tags[i]: row for row, i in enumerate(rows)}
    per_cell = 8 if kind == HEX8 else 10
    nodes = array("i", (place[tag] for tag in connected))
    if kind == TET10:
        for first in range(0, len(nodes), 10):
            nodes[first + 8], nodes[first + 9] = nodes[first + 9], nodes[first + 8]
    heights = [points[i][2] for i in rows]
    with open(path, "wb") as file:
        file.write(struct.pack("4i", per_cell, len(rows), len(nodes) // per_cell, 0))
        array("d", (x for i in rows for x in points[i])).tofile(file)
        nodes.tofile(file)
        file.write(bytes(1 if z < 1e-9 else 2 if z > 5 - 1e-9 else 0 for z in heights))


def make_meshes(folder):
    import gmsh

    folder.mkdir(parents=True, exist_ok=True)
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    for name, kind, divisions, refine, size in (
        ("hex", HEX8, 24, 0, None), ("hex-coarse", HEX8, 6, 0, None), ("tet10", TET10, 0, 0, 0.0784),
        ("tet10-coarse", TET10, 0, 0, 0.36), ("tet10-fine", TET10, 0, 2, 0.36),
    ):
        column(gmsh, kind, divisions, refine, size)
        if name != "tet10-fine":
            gmsh.write(str(folder / f"{name}.msh"))
        if "coarse" not in name:
            write_cells(gmsh, kind, folder / f"{name}.cells")
    gmsh.finalize()


class FileBench(Bench):
    """The bench with meshes from files."""

    def __init__(self, folder, meshes, limit):
        super().__init__(folder, 1e6, limit)
        self.meshes = meshes
        self.bare = Path(raw_best.HERE) / "raw_mesh"
        sources = [Path(raw_best.HERE) / name for name in ("raw_mesh.c", "raw_common.h")]
        if not self.bare.exists() or self.bare.stat().st_mtime < max(s.stat().st_mtime for s in sources):
            subprocess.run([raw_best.HERE / "build.sh", self.bare, "raw_mesh"], check=True)

    def run(self, name, ranks, number, settings):
        mesh, more, _ = SCENES[name]
        case, output = self.runs / f"{name}.yaml", self.runs / f"{name}-{ranks}-{number}"
        case.write_text(CASE.format(name=name, mesh=self.meshes / mesh, more=more, top=AXIAL))
        command = [self.program, str(case), "--quiet", "--overwrite", "--output", str(output)]
        for setting in settings:
            command += ["--set", setting]
        wall, cpu, _ = self.timed(command, ranks)
        report = json.loads((output / "report.json").read_text())
        return {"kind": "eight instants", "scene": name, "ranks": ranks, "wall": wall, "cpu": cpu,
                "unknowns": report["unknowns"], "linear": report["linear_iterations"],
                "memory": report["peak_memory_bytes"], "choice": report["linear_solver"]["choice"],
                "timings": report["timings"]}

    def bare_solve(self, name, ranks, solver):
        wall, cpu, output = self.timed([str(self.bare), "-mesh", str(self.meshes / SCENES[name][2]),
                                        "-solver", solver], ranks)
        printed = json.loads(next(line for line in output.splitlines() if line.startswith("{")))
        return {"kind": f"bare {solver}", "scene": name, "ranks": ranks, "wall": wall, "cpu": cpu,
                "unknowns": printed["unknowns"], "linear": printed["iterations"],
                "memory": printed["peak_memory_bytes"], "timings": printed}


def row(records, name, ranks):
    """One line of the table: medians, and the ratio to the faster bare solve of the same turns."""
    def median(kind, key):
        found = [r[key] for r in records if (r["kind"], r["scene"], r["ranks"]) == (kind, name, ranks)]
        return statistics.median(found) if found else float("inf")

    ours, walls = "eight instants", {s: median(f"bare {s}", "wall") for s in ("boomeramg", "gamg")}
    best = min(walls, key=walls.get)
    unknowns = int(median(ours, "unknowns"))
    return (f"| {name} | {unknowns} | {ranks} | {median(ours, 'wall'):.1f} | {median(ours, 'linear'):.0f} | "
            f"{walls['boomeramg']:.1f} | {walls['gamg']:.1f} | {median(ours, 'wall') / walls[best]:.2f} | "
            f"{median(ours, 'memory') / unknowns / 1e3:.2f} |")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--meshes", type=Path, default=Path("results/bench-files/meshes"))
    arguments.add_argument("--make", action="store_true", help="make the meshes only")
    arguments.add_argument("--keep", type=Path, default=Path("results/bench-files"))
    arguments.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    arguments.add_argument("--repeats", type=int, default=5)
    arguments.add_argument("--scenes", default=",".join(SCENES))
    arguments.add_argument("--set", action="append", default=[], dest="settings", help="passed on to the program")
    given = arguments.parse_args()
    if given.make:
        make_meshes(given.meshes.resolve())
        return
    bench = FileBench(given.keep, given.meshes.resolve(), 900)
    print(bench.machine)
    for name in given.scenes.split(","):
        for ranks in given.ranks:
            for number in range(given.repeats):
                try:
                    bench.keep(bench.run(name, ranks, number, given.settings))
                    for solver in ("boomeramg", "gamg"):
                        bench.keep(bench.bare_solve(name, ranks, solver))
                except Failed as error:
                    bench.note(f"{name} on {ranks} rank(s): {error}")
            print(row(bench.records, name, ranks), flush=True)
    (bench.directory / "files.json").write_text(json.dumps(bench.records, indent=1))
    print("\n| scene | unknowns | ranks | eight instants s | linear | BoomerAMG s | GAMG s | ratio | kB per unknown |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in given.scenes.split(","):
        for ranks in given.ranks:
            print(row(bench.records, name, ranks))


if __name__ == "__main__":
    sys.exit(main())
