"""hertz_cylinder.py [CELLS [ORDER [NAME]]]: writes NAME.msh, a quarter of a cylinder of radius 1 m on a flat block.

CELLS is the number of facets over the half width of the contact, 0.02 m, on the cylinder; the block has three for every four.
"""
import math
import sys

import gmsh

cells = int(sys.argv[1]) if len(sys.argv) > 1 else 6
order = int(sys.argv[2]) if len(sys.argv) > 2 else 2
name = sys.argv[3] if len(sys.argv) > 3 else "hertz_cylinder"
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
model, geo = gmsh.model, gmsh.model.geo
width, fine = 0.02, 0.02 / cells


def on_circle(x):
    return x, 1.0 - math.sqrt(1.0 - x * x)


near, far, wide = 2 * width, 0.12, 0.15  # the fine part of the lips, where that which may touch ends, and the block
cylinder = [geo.addPoint(*at, 0) for at in [(0, 0), on_circle(near), on_circle(far), (1, 1), (0, 1)]]
arcs = [geo.addCircleArc(cylinder[i], cylinder[4], cylinder[i + 1]) for i in range(3)]
top = geo.addLine(cylinder[3], cylinder[4])
axis = geo.addLine(cylinder[4], cylinder[0])
disc = geo.addPlaneSurface([geo.addCurveLoop(arcs + [top, axis])])
block = [geo.addPoint(*at, 0) for at in [(0, -0.2), (wide, -0.2), (wide, 0), (near, 0), (0, 0)]]
edge = [geo.addLine(block[i], block[(i + 1) % 5]) for i in range(5)]
plate = geo.addPlaneSurface([geo.addCurveLoop(edge)])
for line, count in [(arcs[0], 2 * cells), (edge[3], 3 * cells // 2)]:
    geo.mesh.setTransfiniteCurve(line, count + 1)
geo.synchronize()
model.mesh.field.add("MathEval", 1)  # grows with the distance from the contact
model.mesh.field.setString(1, "F", f"{fine} + 0.4*Max(0, Sqrt(x*x + y*y) - {near})")
model.mesh.field.setAsBackgroundMesh(1)
for group, dim, tags in [
    ("cylinder", 2, [disc]), ("block", 2, [plate]), ("lip", 1, arcs[:2]), ("face", 1, edge[2:4]), ("top", 1, [top]),
    ("axis", 1, [axis, edge[4]]), ("base", 1, edge[:2]),
]:
    model.addPhysicalGroup(dim, tags, name=group)
model.mesh.generate(2)
model.mesh.setOrder(order)
gmsh.write(name + ".msh")
