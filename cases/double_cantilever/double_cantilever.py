"""double_cantilever.py: writes double_cantilever.msh, two arms of 100 mm x 5 mm, bonded from 30 mm on; 8-node cells."""
import sys

import gmsh

density = int(sys.argv[1]) if len(sys.argv) > 1 else 4  # cells over 10 mm of length
notch, length, height = 0.03, 0.1, 0.005
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
at = [0.0, notch, length]
levels = [-height, -height / 2, 0.0, height / 2, height]
point = [[geo.addPoint(x, y, 0) for x in at] for y in levels]
# From right to left, so that the normal of the facets, to the right of their way, points up.
along = [[geo.addLine(row[i + 1], row[i]) for i in range(2)] for row in point]
up = [[geo.addLine(point[j][i], point[j + 1][i]) for i in range(3)] for j in range(4)]
arms = []
for j in range(4):
    for i in range(2):
        arms.append(geo.addPlaneSurface([geo.addCurveLoop([-along[j][i], up[j][i + 1], along[j + 1][i], -up[j][i]])]))
for row in along:
    geo.mesh.setTransfiniteCurve(row[0], 3 * density + 1)
    geo.mesh.setTransfiniteCurve(row[1], 7 * density + 1)
for line in sum(up, []):
    geo.mesh.setTransfiniteCurve(line, 2)
geo.synchronize()
for arm in arms:
    model.mesh.setTransfiniteSurface(arm)
    model.mesh.setRecombine(2, arm)
for name, dim, tags in [
    ("arms", 2, arms), ("notch", 1, along[2][:1]), ("joint", 1, along[2][1:]), ("end", 1, [row[2] for row in up]),
    ("pin_low", 0, [point[1][0]]), ("pin_high", 0, [point[3][0]]),
]:
    model.addPhysicalGroup(dim, tags, name=name)
gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
model.mesh.generate(2)
model.mesh.setOrder(2)
gmsh.write("double_cantilever.msh")
