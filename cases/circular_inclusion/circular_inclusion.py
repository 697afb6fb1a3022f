"""circular_inclusion.py [CELLS [ORDER [NAME]]]: writes NAME.msh, a quarter of a plate of 2 m x 2 m with an inclusion of 1 m.

The two meshes do not match: CELLS facets on the quarter circle of the inclusion, three for every two of them on the hole's.
"""
import math
import sys

import gmsh

cells = int(sys.argv[1]) if len(sys.argv) > 1 else 8
order = int(sys.argv[2]) if len(sys.argv) > 2 else 2
name = sys.argv[3] if len(sys.argv) > 3 else "circular_inclusion"
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo


def quarter(points, lines):
    """Makes the lines between named points, each (from, to, cells, is an arc)."""
    made = {}
    for a, b, count, arc in lines:
        made[a, b] = geo.addCircleArc(points[a], points["centre"], points[b]) if arc else geo.addLine(points[a], points[b])
        geo.mesh.setTransfiniteCurve(made[a, b], count + 1)
    return made


c = math.sqrt(0.5)
core = {k: geo.addPoint(*v, 0) for k, v in {
    "centre": (0, 0), "e": (0.5, 0), "d": (0.45, 0.45), "n": (0, 0.5), "E": (1, 0), "D": (c, c), "N": (0, 1)}.items()}
half = cells // 2
i = quarter(core, [("centre", "e", half, False), ("e", "d", half, False), ("d", "n", half, False), ("n", "centre", half, False),
                   ("e", "E", half, False), ("d", "D", half, False), ("n", "N", half, False),
                   ("E", "D", half, True), ("D", "N", half, True)])
rim = {k: geo.addPoint(*v, 0) for k, v in {
    "centre": (0, 0), "E": (1, 0), "D": (c, c), "N": (0, 1), "e": (2, 0), "d": (2, 2), "n": (0, 2)}.items()}
side = 3 * cells // 4
o = quarter(rim, [("E", "D", side, True), ("D", "N", side, True), ("e", "d", side, False), ("d", "n", side, False),
                  ("E", "e", side, False), ("D", "d", side, False), ("N", "n", side, False)])
loops = {
    "inclusion": [[i["centre", "e"], i["e", "d"], i["d", "n"], i["n", "centre"]],
                  [i["e", "E"], i["E", "D"], -i["d", "D"], -i["e", "d"]],
                  [i["d", "D"], i["D", "N"], -i["n", "N"], -i["d", "n"]]],
    "plate": [[o["E", "e"], o["e", "d"], -o["D", "d"], -o["E", "D"]], [o["D", "d"], o["d", "n"], -o["N", "n"], -o["D", "N"]]],
}
surfaces = {k: [geo.addPlaneSurface([geo.addCurveLoop(loop)]) for loop in v] for k, v in loops.items()}
geo.synchronize()
for tag in sum(surfaces.values(), []):
    model.mesh.setTransfiniteSurface(tag)
    model.mesh.setRecombine(2, tag)
for group, tags in surfaces.items():
    model.addPhysicalGroup(2, tags, name=group)
for group, tags in {
    "inclusion_rim": [i["E", "D"], i["D", "N"]], "hole": [o["E", "D"], o["D", "N"]],
    "outer": [o["e", "d"], o["d", "n"]],
    "axis_x": [i["centre", "e"], i["e", "E"], o["E", "e"]], "axis_y": [i["n", "centre"], i["n", "N"], o["N", "n"]],
}.items():
    model.addPhysicalGroup(1, tags, name=group)
model.mesh.generate(2)
model.mesh.setOrder(order)
gmsh.write(name + ".msh")
