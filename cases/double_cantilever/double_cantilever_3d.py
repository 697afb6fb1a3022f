"""double_cantilever_3d.py [CELLS [ACROSS [NAME]]]: writes NAME.msh, half the width of two arms of 70 mm x 5 mm x 10 mm.

They are notched over 30 mm and bonded from there on. CELLS of 8 nodes lie over 10 mm of length, two over the height of an
arm, ACROSS over half the width; the plane z = 0 halves it.
"""
import sys

import gmsh

cells = int(sys.argv[1]) if len(sys.argv) > 1 else 3
across = int(sys.argv[2]) if len(sys.argv) > 2 else 1
name = sys.argv[3] if len(sys.argv) > 3 else "double_cantilever_3d"
notch, length, height, width = 0.03, 0.07, 0.005, 0.01
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
at = [0.0, notch, length]
levels = [-height, -height / 2, 0.0, height / 2, height]
point = [[geo.addPoint(x, y, 0) for x in at] for y in levels]
# From right to left, so that the normal of the facets points up when the lines are drawn along z.
along = [[geo.addLine(row[i + 1], row[i]) for i in range(2)] for row in point]
up = [[geo.addLine(point[j][i], point[j + 1][i]) for i in range(3)] for j in range(4)]
arms = [geo.addPlaneSurface([geo.addCurveLoop([-along[j][i], up[j][i + 1], along[j + 1][i], -up[j][i]])])
        for j in range(4) for i in range(2)]
for row in along:
    for line, part in zip(row, [notch, length - notch]):
        geo.mesh.setTransfiniteCurve(line, round(part * 100 * cells) + 1)
for line in sum(up, []):
    geo.mesh.setTransfiniteCurve(line, 2)
for arm in arms:
    geo.mesh.setTransfiniteSurface(arm)
    geo.mesh.setRecombine(2, arm)


geo.extrude([(2, arm) for arm in arms], 0, 0, width / 2, numElements=[across], recombine=True)
geo.synchronize()


def within(dim, low, high):
    """The tags of what lies in the box."""
    near = 1e-6
    box = [low[0] - near, low[1] - near, -near, high[0] + near, high[1] + near, width / 2 + near]
    return [tag for _, tag in model.getEntitiesInBoundingBox(*box, dim)]


def line_across(x, y):
    return within(1, (x, y), (x, y))


for group, dim, tags in [
    ("arms", 3, within(3, (0, -height), (length, height))), ("mirror", 2, arms),
    ("notch", 2, within(2, (0, 0), (notch, 0))), ("joint", 2, within(2, (notch, 0), (length, 0))),
    ("end", 2, within(2, (length, -height), (length, height))),
    ("pin_low", 1, line_across(0, -height / 2)), ("pin_high", 1, line_across(0, height / 2)),
]:
    model.addPhysicalGroup(dim, tags, name=group)
model.mesh.generate(3)
gmsh.write(name + ".msh")
