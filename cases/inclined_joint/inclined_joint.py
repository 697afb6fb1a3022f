"""inclined_joint.py: writes inclined_joint.msh, a block of 1 m x 1 m cut by a joint at 35 degrees through its centre."""
import math

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.15)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.15)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
rise = 0.5 * math.tan(math.radians(35.0))
p = [geo.addPoint(*at, 0) for at in [(0, 0), (1, 0), (1, 0.5 + rise), (1, 1), (0, 1), (0, 0.5 - rise)]]
foot, right_low, right_high, head, left_high, left_low = [geo.addLine(p[i], p[(i + 1) % 6]) for i in range(6)]
joint = geo.addLine(p[2], p[5])  # its normal, to the right of its way, points up
lower = geo.addPlaneSurface([geo.addCurveLoop([foot, right_low, joint, left_low])])
upper = geo.addPlaneSurface([geo.addCurveLoop([right_high, head, left_high, -joint])])
geo.synchronize()
for name, dim, tags in [
    ("block", 2, [lower, upper]), ("joint", 1, [joint]), ("foot", 1, [foot]), ("head", 1, [head]),
    ("lower_rim", 1, [foot, right_low, left_low]), ("upper_rim", 1, [right_high, head, left_high]),
    ("corner", 0, [p[0]]), ("peg", 0, [p[4]]),
]:
    model.addPhysicalGroup(dim, tags, name=name)
model.mesh.generate(2)
gmsh.write("inclined_joint.msh")
