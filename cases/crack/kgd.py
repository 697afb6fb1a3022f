"""kgd.py: writes kgd.msh, the right half of a crack of 1 m that grows in a square of 40 m; triangles of first order."""
import sys

import gmsh

size = float(sys.argv[1]) if len(sys.argv) > 1 else 0.1  # of cells along the crack (m)
crack, far = 1.0, 20.0
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.option.setNumber("Mesh.Binary", 1)
model, geo = gmsh.model, gmsh.model.geo
# From right to left, so that the normal of the facets, to the right of their way, points up.
line = [geo.addPoint(x, 0, 0, s) for x, s in [(far, 4.0), (2.2 * crack, size), (crack, size), (0, size)]]
corner = [[geo.addPoint(x, y, 0, 4.0) for x in (0, far)] for y in (-far, far)]
along = [geo.addLine(line[i], line[i + 1]) for i in range(3)]
sides = []
for low, (left, right) in zip([True, False], corner):
    sides.append([geo.addLine(line[3], left), geo.addLine(left, right), geo.addLine(right, line[0])])
loops = [along + sides[0], [-tag for tag in reversed(along + sides[1])]]
halves = [geo.addPlaneSurface([geo.addCurveLoop(loop)]) for loop in loops]
geo.synchronize()
for name, dim, tags in [
    ("rock", 2, halves), ("plane", 1, along), ("middle", 1, [of[0] for of in sides]),
    ("bottom", 1, [sides[0][1]]), ("top", 1, [sides[1][1]]),
]:
    model.addPhysicalGroup(dim, tags, name=name)
model.mesh.generate(2)
gmsh.write("kgd.msh")
