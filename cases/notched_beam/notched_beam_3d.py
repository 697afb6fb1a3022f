"""notched_beam_3d.py [CELLS [ACROSS [NAME]]]: writes NAME.msh, half the width of the beam of notched_beam.py, 5 mm wide.

CELLS of 8 nodes lie over 10 mm of length, one over the height of an arm, ACROSS over half the width; the plane z = 0 halves it.
"""
import sys

import gmsh

cells = int(sys.argv[1]) if len(sys.argv) > 1 else 4
across = int(sys.argv[2]) if len(sys.argv) > 2 else 1
name = sys.argv[3] if len(sys.argv) > 3 else "notched_beam_3d"
height, patch, width = 2.5e-3, 1.25e-3, 5e-3
at = [0.0, 0.03, 0.05 - patch, 0.05 + patch, 0.065, 0.1]
levels = [-height, 0.0, height]
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
point = [[geo.addPoint(x, y, 0) for x in at] for y in levels]
# From right to left, so that the normal of the facets points up when the lines are drawn along z.
along = [[geo.addLine(row[i + 1], row[i]) for i in range(len(at) - 1)] for row in point]
up = [[geo.addLine(point[j][i], point[j + 1][i]) for i in range(len(at))] for j in range(2)]
arms = [geo.addPlaneSurface([geo.addCurveLoop([-along[j][i], up[j][i + 1], along[j + 1][i], -up[j][i]])])
        for j in range(2) for i in range(len(at) - 1)]
for row in along:
    for i, line in enumerate(row):
        geo.mesh.setTransfiniteCurve(line, round((at[i + 1] - at[i]) * 100 * cells) + 1)
for line in sum(up, []):
    geo.mesh.setTransfiniteCurve(line, 2)
for arm in arms:
    geo.mesh.setTransfiniteSurface(arm)
    geo.mesh.setRecombine(2, arm)
geo.extrude([(2, arm) for arm in arms], 0, 0, width / 2, numElements=[across], recombine=True)
geo.synchronize()


def within(dim, low, high):
    """The tags of what lies between two corners in the plane of the beam, across its whole width."""
    near = 1e-6
    box = [low[0] - near, low[1] - near, -near, high[0] + near, high[1] + near, width / 2 + near]
    return [tag for _, tag in model.getEntitiesInBoundingBox(*box, dim)]


for group, dim, tags in [
    ("arms", 3, within(3, (0, -height), (at[-1], height))), ("mirror", 2, arms),
    ("notch", 2, within(2, (0, 0), (at[1], 0))), ("joint", 2, within(2, (at[1], 0), (at[4], 0))),
    ("rest", 2, within(2, (at[4], 0), (at[5], 0))), ("end_high", 2, within(2, (0, 0), (0, height))),
    ("middle", 2, within(2, (at[2], height), (at[3], height))),
    ("left", 1, within(1, (0, -height), (0, -height))),
    ("right", 1, within(1, (at[-1], -height), (at[-1], -height))),
]:
    model.addPhysicalGroup(dim, tags, name=group)
model.mesh.generate(3)
gmsh.write(name + ".msh")
