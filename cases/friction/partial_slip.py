"""partial_slip.py [CELLS [ORDER [NAME]]]: writes NAME.msh, the lower half of a cylinder of radius 1 m on a block.

CELLS is the number of facets over the half width of the contact, 0.004 m, on the cylinder; the block has three for every four.
"""
import math
import sys

import gmsh

cells = int(sys.argv[1]) if len(sys.argv) > 1 else 8
order = int(sys.argv[2]) if len(sys.argv) > 2 else 2
name = sys.argv[3] if len(sys.argv) > 3 else "partial_slip"
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
model, geo = gmsh.model, gmsh.model.geo
fine = 0.004 / cells
near, far, wide, deep = 0.006, 0.02, 0.5, 0.5  # where the fine facets end, where that which may touch ends, half the block


def on_circle(x):
    return x, 1.0 - math.sqrt(1.0 - x * x)


heart = geo.addPoint(0, 1, 0)
round_ = [geo.addPoint(*at, 0) for at in [(-1, 1)] + [on_circle(x) for x in (-far, -near, near, far)] + [(1, 1)]]
arcs = [geo.addCircleArc(round_[i], heart, round_[i + 1]) for i in range(5)]
half = [geo.addLine(round_[5], heart), geo.addLine(heart, round_[0])]
disc = geo.addPlaneSurface([geo.addCurveLoop(arcs + half)])
flat = [(-wide, 0), (-wide, -deep), (wide, -deep), (wide, 0), (far, 0), (near, 0), (-near, 0), (-far, 0)]
block = [geo.addPoint(*at, 0) for at in flat]
edge = [geo.addLine(block[i], block[(i + 1) % 8]) for i in range(8)]
plate = geo.addPlaneSurface([geo.addCurveLoop(edge)])
facets = round(2 * near / fine)
for line, count in [(arcs[2], facets), (edge[5], 3 * facets // 4)]:
    geo.mesh.setTransfiniteCurve(line, count + 1)
geo.synchronize()
model.mesh.field.add("MathEval", 1)  # grows with the distance from the contact
model.mesh.field.setString(1, "F", f"{fine} + 0.5*Max(0, Sqrt(x*x + y*y) - {near})")
model.mesh.field.setAsBackgroundMesh(1)
for group, dim, tags in [
    ("cylinder", 2, [disc]), ("block", 2, [plate]), ("lip", 1, arcs[1:4]), ("face", 1, edge[4:7]), ("top", 1, half),
    ("base", 1, edge[:3]),
]:
    model.addPhysicalGroup(dim, tags, name=group)
model.mesh.generate(2)
model.mesh.setOrder(order)
gmsh.write(name + ".msh")
