"""notched_beam.py [CELLS [NAME]]: writes NAME.msh, two arms of 100 mm x 2.5 mm, notched over 30 mm, bonded from there on.

CELLS of 4 nodes lie over 10 mm of length, two over the height of an arm. The first 35 mm of the bond are a group of their own.
"""
import sys

import gmsh

cells = int(sys.argv[1]) if len(sys.argv) > 1 else 8
name = sys.argv[2] if len(sys.argv) > 2 else "notched_beam"
height, patch = 2.5e-3, 1.25e-3
at = [0.0, 0.03, 0.05 - patch, 0.05 + patch, 0.065, 0.1]
levels = [-height, -height / 2, 0.0, height / 2, height]
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
point = [[geo.addPoint(x, y, 0) for x in at] for y in levels]
# From right to left, so that the normal of the facets, to the right of their way, points up.
along = [[geo.addLine(row[i + 1], row[i]) for i in range(len(at) - 1)] for row in point]
up = [[geo.addLine(point[j][i], point[j + 1][i]) for i in range(len(at))] for j in range(4)]
arms = [geo.addPlaneSurface([geo.addCurveLoop([-along[j][i], up[j][i + 1], along[j + 1][i], -up[j][i]])])
        for j in range(4) for i in range(len(at) - 1)]
for row in along:
    for i, line in enumerate(row):
        geo.mesh.setTransfiniteCurve(line, round((at[i + 1] - at[i]) * 100 * cells) + 1)
for line in sum(up, []):
    geo.mesh.setTransfiniteCurve(line, 2)
geo.synchronize()
for arm in arms:
    model.mesh.setTransfiniteSurface(arm)
    model.mesh.setRecombine(2, arm)
for group, dim, tags in [
    ("arms", 2, arms), ("notch", 1, along[2][:1]), ("joint", 1, along[2][1:4]), ("rest", 1, along[2][4:]),
    ("end_high", 1, [up[2][0], up[3][0]]), ("middle", 1, [along[4][2]]),
    ("left", 0, [point[1][0]]), ("right", 0, [point[1][-1]]),
]:
    model.addPhysicalGroup(dim, tags, name=group)
model.mesh.generate(2)
gmsh.write(name + ".msh")
