"""brick_wall.py: writes brick_wall.msh, three courses of bricks in running bond, 1 m x 0.45 m, seven bricks and half-bricks."""
import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
columns, rows = [0, 0.25, 0.5, 0.75, 1.0], [0, 0.15, 0.30, 0.45]
point = [[geo.addPoint(x, y, 0) for x in columns] for y in rows]
along = [[geo.addLine(row[i], row[i + 1]) for i in range(4)] for row in point]
up = [[geo.addLine(point[j][i], point[j + 1][i]) for i in range(5)] for j in range(3)]
bricks = []
for j, ends in enumerate([(0, 2, 4), (0, 1, 3, 4), (0, 2, 4)]):
    for a, b in zip(ends, ends[1:]):
        loop = along[j][a:b] + [up[j][b]] + [-line for line in reversed(along[j + 1][a:b])] + [-up[j][a]]
        bricks.append((geo.addPlaneSurface([geo.addCurveLoop(loop)]), [point[j][a], point[j][b], point[j + 1][b], point[j + 1][a]]))
geo.synchronize()
for line in sum(along, []):
    model.mesh.setTransfiniteCurve(line, 3)
for line in sum(up, []):
    model.mesh.setTransfiniteCurve(line, 4)
for brick, corners in bricks:
    model.mesh.setTransfiniteSurface(brick, "Left", corners)
    model.mesh.setRecombine(2, brick)
    model.addPhysicalGroup(2, [brick], name=f"brick_{brick}")
for name, tags in {
    "foot": along[0], "head": along[3], "bed_1": along[1], "bed_2": along[2],
    "heads": [up[0][2], up[1][1], up[1][3], up[2][2]],
}.items():
    model.addPhysicalGroup(1, tags, name=name)
model.addPhysicalGroup(0, [point[0][0]], name="corner")
model.addPhysicalGroup(0, [point[3][0]], name="peg")
model.mesh.generate(2)
gmsh.write("brick_wall.msh")
