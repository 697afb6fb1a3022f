#!/usr/bin/env python3
"""Makes the mesh files below tests/meshes/turned and tests/meshes/interfaces with Gmsh
(pip install gmsh==4.15.2).

    python3 scripts/meshes_any.py

The files stay in the repository: the tests read them without Gmsh. Turned: the reference column of
1 x 1 x 5 m of two blocks, of cells of all kinds, turned by 30 degrees about (1, 2, 3). Interfaces:
blocks with interfaces that cross, branch and end inside. (leaning.msh, strips.msh, rollers.msh and
corner.msh there were written otherwise, of few cells each.)
"""

import math
from pathlib import Path

import gmsh

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "meshes"
HEIGHT = 2.5


def start(least, most):
    """An empty model with sizes of cells."""
    gmsh.clear()
    gmsh.model.add("mesh")
    gmsh.option.setNumber("Mesh.MeshSizeMin", least)
    gmsh.option.setNumber("Mesh.MeshSizeMax", most)


def write(name, order, dim):
    """Meshes and writes the model."""
    gmsh.model.mesh.generate(dim)
    if order == 2:
        gmsh.model.mesh.setOrder(2)
    if name.startswith("turned"):
        gmsh.model.mesh.affineTransform([x for row in rotation() for x in row + [0.0]])
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.write(str(FOLDER / f"{name}.msh"))


def rotation():
    """By 30 degrees about (1, 2, 3) / sqrt(14)."""
    x, y, z = (k / math.sqrt(14) for k in (1, 2, 3))
    cross = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    axis, c, s = (x, y, z), math.cos(math.pi / 6), math.sin(math.pi / 6)
    return [
        [c * (i == j) + (1 - c) * axis[i] * axis[j] + s * cross[i][j] for j in range(3)]
        for i in range(3)
    ]


def block(low, kind, across, layers):
    """A block from a height on: extruded in layers, or of tetrahedra."""
    occ, model = gmsh.model.occ, gmsh.model
    if kind == "tet":
        box = occ.addBox(0, 0, low, 1, 1, HEIGHT)
        occ.synchronize()
        return box
    base = occ.addRectangle(0, 0, low, 1, 1)
    occ.synchronize()
    for _, curve in model.getBoundary([(2, base)], oriented=False):
        model.mesh.setTransfiniteCurve(curve, across + 1)
    if kind == "hex":
        model.mesh.setTransfiniteSurface(base)
        model.mesh.setRecombine(2, base)
    return extruded(base, layers)


def extruded(base, layers):
    """The volume above a rectangle."""
    made = gmsh.model.occ.extrude([(2, base)], 0, 0, HEIGHT, [layers], recombine=True)
    gmsh.model.occ.synchronize()
    return next(tag for dim, tag in made if dim == 3)


def at_height(volume, z):
    """The faces of a volume at a height."""
    found = []
    for _, face in gmsh.model.getBoundary([(3, volume)], oriented=False):
        box = gmsh.model.getBoundingBox(2, face)
        if abs(box[2] - z) < 1e-3 and abs(box[5] - z) < 1e-3:
            found.append(face)
    return found


def column(name, kinds, order, conforming, across=(2, 2), layers=(2, 2), size=0.55):
    """Two blocks on each other, with one face between them or with two."""
    start(0.45, size)
    below = block(0, kinds[0], across[0], layers[0])
    if conforming and kinds[0] != "tet":
        above = extruded(at_height(below, HEIGHT)[0], layers[1])
    else:
        above = block(HEIGHT, kinds[1], across[1], layers[1])
    if conforming and kinds[0] == "tet":
        gmsh.model.occ.fragment([(3, below)], [(3, above)])
        gmsh.model.occ.synchronize()
        volumes = [tag for _, tag in gmsh.model.getEntities(3)]
        below, above = sorted(volumes, key=lambda v: gmsh.model.getBoundingBox(3, v)[2])
    group = gmsh.model.addPhysicalGroup
    group(3, [below], name="lower")
    group(3, [above], name="upper")
    group(2, at_height(below, 0), name="foot")
    group(2, at_height(above, 2 * HEIGHT), name="head")
    if conforming:
        group(2, at_height(below, HEIGHT), name="joint")
    else:
        group(2, at_height(below, HEIGHT), name="below")
        group(2, at_height(above, HEIGHT), name="above")
    write(f"turned/{name}", order, 3)


def cut(name, lines, order, dim, size, layers=None):
    """A block of 2 x 1.5 (x 0.7) m cut along lines; of prisms in layers, with groups of sides."""
    start(size, size)
    occ, model = gmsh.model.occ, gmsh.model
    base = occ.addRectangle(0, 0, 0, 2, 1.5)
    cuts = [occ.addLine(*(occ.addPoint(*end, 0) for end in line)) for line in lines]
    occ.fragment([(2, base)], [(1, line) for line in cuts])
    occ.synchronize()
    if dim == 3:
        made = {"numElements": [layers], "recombine": True} if layers else {}
        occ.extrude(model.getEntities(2), 0, 0, 0.7, **made)
        occ.synchronize()

    def is_inside(tag):
        low, high = model.getBoundingBox(dim - 1, tag)[:3], model.getBoundingBox(dim - 1, tag)[3:]
        ends = (2, 1.5, 0.7)[:dim]
        return all(h > 1e-4 and l < e - 1e-4 for l, h, e in zip(low, high, ends))

    facets = [tag for _, tag in model.getEntities(dim - 1)]
    model.addPhysicalGroup(dim, [tag for _, tag in model.getEntities(dim)], name="rock")
    for group, wanted in (("outer", False), ("joint", True)):
        tags = [tag for tag in facets if is_inside(tag) == wanted]
        model.addPhysicalGroup(dim - 1, tags, name=group)
    for side, axis, at in (("x0", 0, 0), ("x1", 0, 2), ("y0", 1, 0)) if layers else ():
        boxes = [(tag, model.getBoundingBox(dim - 1, tag)) for tag in facets]
        tags = [tag for tag, b in boxes if max(abs(b[axis] - at), abs(b[axis + 3] - at)) < 1e-4]
        model.addPhysicalGroup(dim - 1, tags, name=side)
    write(f"interfaces/{name}", order, dim)


if __name__ == "__main__":
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    column("hex8", ("hex", "hex"), 1, True)
    column("hex27-apart", ("hex", "hex"), 2, False, (2, 3), (2, 3))
    column("prism18", ("prism", "prism"), 2, True)
    column("tet10", ("tet", "tet"), 2, True)
    column("tet4-apart", ("tet", "tet"), 1, False, size=0.4)
    column("mixed-pair", ("hex", "tet"), 1, False)
    cut("crossing", [((0.3, 0), (1.6, 1.5)), ((0, 1.1), (2, 0.4))], 1, 2, 0.35)
    cut("branching", [((0, 0.5), (2, 0.9)), ((0.8, 0), (0.9, 0.68))], 2, 2, 0.35)
    cut("ending", [((0, 0.4), (1.1, 0.8))], 1, 3, 0.5)
    cut("tee", [((0, 0.5), (2, 0.9)), ((0.8, 0), (0.9, 0.68))], 1, 3, 0.7, layers=1)
    gmsh.finalize()
