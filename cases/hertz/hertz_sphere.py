"""hertz_sphere.py [CELLS [NAME]]: writes NAME.msh, an eighth of a ball of radius 1 m on a flat block, under a soft spring.

CELLS is the number of facets over the radius of the contact, 0.05 m; tetrahedra of second order.
"""
import math
import sys

import gmsh

cells = float(sys.argv[1]) if len(sys.argv) > 1 else 4
name = sys.argv[2] if len(sys.argv) > 2 else "hertz_sphere"
radius, cap, wide = 0.05, 0.02, 0.3  # of the contact; height of the part that may touch; width of the block
gmsh.initialize()
for option, value in {"General.Terminal": 0, "Mesh.MshFileVersion": 4.1, "Mesh.MeshSizeExtendFromBoundary": 0,
                      "Mesh.MeshSizeFromPoints": 0, "Mesh.MeshSizeMax": 0.5}.items():
    gmsh.option.setNumber(option, value)
model, occ = gmsh.model, gmsh.model.occ
ball = occ.addSphere(0, 0, 1, 1)
occ.rotate([(3, ball)], 0, 0, 1, 1, 0, 0, math.pi / 2)  # the poles of its map away from the contact
eighth, _ = occ.intersect([(3, ball)], [(3, occ.addBox(0, 0, 0, 1, 1, 1))])
occ.fragment(eighth, [(2, occ.addRectangle(-0.5, -0.5, cap, 2, 2))])
occ.synchronize()
occ.remove([(2, tag) for _, tag in model.getEntities(2) if not model.getAdjacencies(2, tag)[0].size], recursive=True)
occ.synchronize()


def faces(of, axis, place):
    """The faces of bodies in a plane at right angles to an axis (x, y, z: 0, 1, 2)."""
    all_faces = {tag for body in of for _, tag in model.getBoundary([(3, body)], oriented=False)}
    ends = {tag: [model.getBoundingBox(2, tag)[i] for i in (axis, axis + 3)] for tag in all_faces}
    return [tag for tag, place_of in ends.items() if max(abs(end - place) for end in place_of) < 1e-4]


ball = [tag for _, tag in model.getEntities(3)]
low = [tag for tag in ball if occ.getCenterOfMass(3, tag)[2] < cap]
plane = {tag for axis, place in [(0, 0), (1, 0), (2, cap)] for tag in faces(low, axis, place)}
lip = [tag for _, tag in model.getBoundary([(3, low[0])], oriented=False) if tag not in plane]
spring = [tag for dim, tag in occ.extrude([(2, tag) for tag in faces(ball, 2, 1)], 0, 0, 0.5, [1]) if dim == 3]
block = occ.addBox(0, 0, -0.1, wide, wide, 0.1)
occ.synchronize()
for _, tag in model.getBoundary(model.getBoundary([(3, block)]), combined=False, oriented=False):
    x, y, _, far_x, far_y, _ = model.getBoundingBox(1, tag)
    model.mesh.setTransfiniteCurve(tag, 5 if max(far_x - x, far_y - y) > wide / 2 else 2)
for _, tag in model.getBoundary([(3, block)], oriented=False):
    model.mesh.setTransfiniteSurface(tag)
    model.mesh.setRecombine(2, tag)
model.mesh.setTransfiniteVolume(block)
model.mesh.field.add("MathEval", 1)  # grows with the distance from the contact
model.mesh.field.setString(1, "F", f"{radius / cells} + 0.5*Max(0, Sqrt(x*x + y*y + z*z) - {1.2 * radius})")
model.mesh.field.setAsBackgroundMesh(1)
bodies = ball + spring + [block]
for group, dim, tags in [
    ("ball", 3, ball), ("spring", 3, spring), ("block", 3, [block]), ("lip", 2, lip), ("face", 2, faces([block], 2, 0)),
    ("base", 2, faces([block], 2, -0.1)), ("top", 2, faces(spring, 2, 1.5)),
    ("plane_x", 2, faces(bodies, 0, 0)), ("plane_y", 2, faces(bodies, 1, 0)),
]:
    model.addPhysicalGroup(dim, tags, name=group)
model.mesh.generate(3)
model.mesh.setOrder(2)
gmsh.write(name + ".msh")
