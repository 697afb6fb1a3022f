#!/usr/bin/env python3
"""Makes the mesh files below tests/meshes with Gmsh (pip install gmsh==4.15.2).

    python3 scripts/meshes.py

The files stay in the repository: the tests read them without Gmsh. Expected counts and volumes are
in src/mesh/import/gmsh/tests/files.rs.
"""

from pathlib import Path

import gmsh

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "meshes"


def write(name, version, binary=0, **options):
    """Writes the mesh; options are those of Gmsh's `Mesh.`, for this file only."""
    options = {"SaveAll": 0, "SaveParametric": 0} | options
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    for option, value in options.items():
        gmsh.option.setNumber(f"Mesh.{option}", value)
    gmsh.write(str(FOLDER / f"{name}.msh"))


def start(size, order=1, incomplete=0):
    """An empty model."""
    gmsh.clear()
    gmsh.model.add("mesh")
    for option, value in (
        ("MeshSizeMin", size),
        ("MeshSizeMax", size),
        ("ElementOrder", order),
        ("SecondOrderIncomplete", incomplete),
    ):
        gmsh.option.setNumber(f"Mesh.{option}", value)


def square():
    """Two rectangles of 1 x 1 beside each other; entities of two groups, a negative tag."""
    start(0.5)
    occ = gmsh.model.occ
    left, right = occ.addRectangle(0, 0, 0, 1, 1), occ.addRectangle(1, 0, 0, 1, 1)
    occ.fragment([(2, left)], [(2, right)])
    occ.synchronize()

    def lines(x0, y0, x1, y1):
        found = gmsh.model.getEntitiesInBoundingBox(
            x0 - 1e-3, y0 - 1e-3, -1e-3, x1 + 1e-3, y1 + 1e-3, 1e-3, 1
        )
        return [tag for _, tag in found]

    group = gmsh.model.addPhysicalGroup
    group(1, lines(0, 0, 0, 1), 11, "left")
    group(1, lines(2, 0, 2, 1), 12, "right")
    group(1, lines(0, 0, 0, 1) + lines(2, 0, 2, 1), 13, "sides")
    group(1, [-tag for tag in lines(0, 0, 2, 0)], 14, "bottom")
    group(1, lines(1, 0, 1, 1), 15, "joint")
    group(2, [left], 11, "left")
    group(2, [right], 21)
    group(2, [left, right], 30, "all of it")
    (_, corner), *_ = gmsh.model.getEntitiesInBoundingBox(-0.1, -0.1, -0.1, 0.1, 0.1, 0.1, 0)
    group(0, [corner], 1, "pin")
    gmsh.model.mesh.generate(2)
    for version in (2.2, 4.1):
        write(f"square-{version}", version)
        write(f"square-{version}-binary", version, 1)


def box(name, order, version, binary, **options):
    """A box of 1 x 2 x 3 of tetrahedra; its surface x = 0 reversed."""
    start(1.5, order)
    body = gmsh.model.occ.addBox(0, 0, 0, 1, 2, 3)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [body], 1, "body")
    gmsh.model.addPhysicalGroup(2, [-1], 2, "left")
    gmsh.model.addPhysicalGroup(2, [2], 3, "right")
    gmsh.model.mesh.generate(3)
    write(name, version, binary, **options)


def extruded(name, order, incomplete, recombine, version, binary):
    """A skewed quadrilateral, extruded by 2 in two layers of hexahedra or prisms; periodic."""
    start(1.0, order, incomplete)
    geo = gmsh.model.geo
    corners = [(0, 0), (2, 0), (2, 1), (0.5, 1)]
    points = [geo.addPoint(x, y, 0) for x, y in corners]
    lines = [geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    for line in lines:
        geo.mesh.setTransfiniteCurve(line, 2)
    geo.mesh.setTransfiniteSurface(surface)
    if recombine:
        geo.mesh.setRecombine(2, surface)
    made = geo.extrude([(2, surface)], 0, 0, 2, numElements=[2], recombine=True)
    geo.synchronize()
    (_, top), (_, body) = made[0], made[1]
    move = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2, 0, 0, 0, 1]
    gmsh.model.mesh.setPeriodic(2, [top], [surface], move)
    gmsh.model.addPhysicalGroup(3, [body], 1, "body")
    gmsh.model.addPhysicalGroup(2, [surface], 2, "bottom")
    gmsh.model.addPhysicalGroup(2, [top], 3, "top")
    gmsh.model.mesh.generate(3)
    write(name, version, binary)


def arc():
    """A quarter of a disc of radius 1, whose centre is no node of it, with all entities saved."""
    start(1.0)
    geo = gmsh.model.geo
    centre = geo.addPoint(0, 0, 0)
    inner = [geo.addPoint(0.5, 0, 0), geo.addPoint(0, 0.5, 0)]
    outer = [geo.addPoint(1, 0, 0), geo.addPoint(0, 1, 0)]
    lines = [
        geo.addLine(inner[0], outer[0]),
        geo.addCircleArc(outer[0], centre, outer[1]),
        geo.addLine(outer[1], inner[1]),
        geo.addCircleArc(inner[1], centre, inner[0]),
    ]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], 1, "ring")
    gmsh.model.mesh.generate(2)
    write("arc-2.2", 2.2, SaveAll=1)
    write("arc-4.1", 4.1, SaveAll=1)


def add_every_type():
    """Adds one element of every type that is read, at its reference points, each 10 m from the other.

    Returns dimension, entity and type of each.
    """
    number, made = 0, []
    for index, kind in enumerate(range(1, 20)):
        _, dim, _, count, points, _ = gmsh.model.mesh.getElementProperties(kind)
        entity = gmsh.model.addDiscreteEntity(dim)
        flat = []
        for i in range(count):
            point = list(points[i * dim : (i + 1) * dim]) + [0.0] * (3 - dim)
            flat += [point[0] + 10 * index, point[1], point[2]]
        # Gaps between the numbers.
        tags = [number + 3 * i + 5 for i in range(count)]
        number = tags[-1]
        gmsh.model.mesh.addNodes(dim, entity, tags, flat)
        gmsh.model.mesh.addElementsByType(entity, kind, [], tags)
        made.append((dim, entity, kind))
    return made


def every_type():
    """The same as a file."""
    start(1.0)
    add_every_type()
    write("every-type-4.1", 4.1, SaveAll=1)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    square()
    box("tet4-2.2-binary", 1, 2.2, 1, SaveParametric=1)
    box("tet10-4.1-binary", 2, 4.1, 1, SaveParametric=1)
    extruded("hex20-4.1", 2, 1, True, 4.1, 0)
    extruded("hex27-2.2", 2, 0, True, 2.2, 0)
    extruded("prism15-4.1-binary", 2, 1, False, 4.1, 1)
    arc()
    every_type()
    gmsh.finalize()


if __name__ == "__main__":
    main()
