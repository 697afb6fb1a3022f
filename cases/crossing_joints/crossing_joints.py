"""crossing_joints.py: writes crossing_joints.msh, a block of 2 m x 1.5 m cut by two joints that cross in its middle."""
import math

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.25)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.25)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
half = 0.75 / math.tan(math.radians(40.0))  # the joints lean by 40 degrees
rim = [(half, -0.75), (1, -0.75), (1, 0.75), (half, 0.75), (-half, 0.75), (-1, 0.75), (-1, -0.75), (-half, -0.75)]
p = [geo.addPoint(*at, 0) for at in rim]
middle = geo.addPoint(0, 0, 0)
side = [geo.addLine(p[i], p[(i + 1) % 8]) for i in range(8)]
# Each joint runs from right to left: the normal of its facets, to the right of their way, points up.
rising = [geo.addLine(p[3], middle), geo.addLine(middle, p[7])]
falling = [geo.addLine(p[0], middle), geo.addLine(middle, p[4])]
groups = {
    "right": (side[0:3], [rising[0], falling[0]]),
    "top": (side[3:4], [falling[1], rising[0]]),
    "left": (side[4:7], [rising[1], falling[1]]),
    "bottom": (side[7:8], [rising[1], falling[0]]),
}
blocks = []
for name, (outer, inner) in groups.items():
    blocks.append(geo.addPlaneSurface([geo.addCurveLoop(outer + inner, reorient=True)]))
geo.synchronize()
model.addPhysicalGroup(2, blocks, name="block")
model.addPhysicalGroup(1, rising, name="rising")
model.addPhysicalGroup(1, falling, name="falling")
for name, (outer, _) in groups.items():
    model.addPhysicalGroup(1, outer, name=name)
model.mesh.generate(2)
gmsh.write("crossing_joints.msh")
