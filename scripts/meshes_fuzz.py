#!/usr/bin/env python3
"""Makes the seeds of the fuzz target `gmsh` with Gmsh (pip install gmsh==4.15.2).

    python3 scripts/meshes_fuzz.py

Each mesh is written in both versions, as text and binary, into tests/fuzz/corpus/gmsh. The seeds of the target `med`
are the files of scripts/meshes_med.py.
"""

from pathlib import Path

import gmsh

from meshes import add_every_type

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "fuzz" / "corpus" / "gmsh"
LINE, TRIANGLE, QUADRILATERAL, TETRAHEDRON, HEXAHEDRON, PRISM, PYRAMID, POINT = 1, 2, 3, 4, 5, 6, 7, 15


def write(name):
    """In all forms."""
    for version, binary in ((2.2, 0), (2.2, 1), (4.1, 0), (4.1, 1)):
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(str(FOLDER / f"{name}-{version}{'-binary' if binary else ''}.msh"))


def mesh(name, points, entities, order=1):
    """Entities are (dimension, type, groups, elements); nodes are numbered from 1 on, with gaps of one."""
    gmsh.clear()
    gmsh.model.add(name)
    gmsh.option.setNumber("Mesh.SaveAll", 0)
    gmsh.option.setNumber("Mesh.ElementOrder", order)
    numbers = {}
    made = [(dim, gmsh.model.addDiscreteEntity(dim), *rest) for dim, *rest in entities]
    dim, first = made[0][:2]
    flat = [float(x) for point in points for x in (*point, 0.0)[:3]]
    gmsh.model.mesh.addNodes(dim, first, [2 * i + 1 for i in range(len(points))], flat)
    for dim, entity, kind, groups, elements in made:
        gmsh.model.mesh.addElementsByType(entity, kind, [], [2 * node + 1 for nodes in elements for node in nodes])
        for group in groups:
            numbers.setdefault((dim, group), []).append(entity)
    for tag, ((dim, group), members) in enumerate(numbers.items(), 3):
        gmsh.model.addPhysicalGroup(dim, members, tag, group)
    if order == 2:
        gmsh.model.mesh.setOrder(2)
    write(name)


def strips():
    """Two squares on each other beside two others that do not touch them, with a line between each pair."""
    points = [(x, y) for y in (0, 1, 2) for x in (0, 1)] + [(x, y) for y in (0, 1, 2) for x in (2, 3)]
    entities = [
        (2, QUADRILATERAL, ["left", "rock"], [[0, 1, 3, 2], [2, 3, 5, 4]]),
        (2, TRIANGLE, ["rock"], [[6, 7, 9], [6, 9, 8], [8, 9, 11], [8, 11, 10]]),
        (1, LINE, ["joint"], [[2, 3]]),
        (1, LINE, ["crack"], [[9, 8]]),
        (1, LINE, ["side", "sides"], [[1, 3], [3, 5]]),
        (1, LINE, ["flank", "sides"], [[8, 6], [10, 8]]),
        (0, POINT, ["corner", "ends"], [[0]]),
        (0, POINT, ["ends"], [[11]]),
    ]
    mesh("strips", points, entities)
    mesh("strips-second", points, entities, 2)


def blocks():
    """Two hexahedra on each other, a pyramid on them, a prism at their side, a tetrahedron at the pyramid's."""
    points = [(x, y, z) for z in (0, 1, 2) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    points += [(0.5, 0.5, 3), (2, 0, 0), (2, 0, 1), (2, 0.5, 2.5)]
    entities = [
        (3, HEXAHEDRON, ["base"], [[0, 1, 2, 3, 4, 5, 6, 7]]),
        (3, HEXAHEDRON, ["top", "upper"], [[4, 5, 6, 7, 8, 9, 10, 11]]),
        (3, PYRAMID, ["upper"], [[8, 9, 10, 11, 12]]),
        (3, PRISM, ["wedge"], [[1, 13, 2, 5, 14, 6]]),
        (3, TETRAHEDRON, ["wedge"], [[9, 15, 10, 12]]),
        (2, QUADRILATERAL, ["joint"], [[4, 5, 6, 7]]),
        (2, TRIANGLE, ["crack"], [[9, 10, 12]]),
        (2, QUADRILATERAL, ["crack"], [[8, 9, 10, 11]]),
        (2, QUADRILATERAL, ["foot"], [[0, 3, 2, 1]]),
        (1, LINE, ["edge"], [[0, 1], [1, 13]]),
        (0, POINT, ["corner"], [[0], [12]]),
    ]
    mesh("blocks", points, entities)
    mesh("blocks-second", points, entities, 2)


def apart():
    """Two tetrahedra whose faces face each other, without common nodes."""
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, -1), (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    mesh("apart", points, [
        (3, TETRAHEDRON, ["low"], [[0, 2, 1, 3]]),
        (3, TETRAHEDRON, ["high"], [[4, 5, 6, 7]]),
        (2, TRIANGLE, ["below"], [[0, 1, 2]]),
        (2, TRIANGLE, ["above"], [[4, 6, 5]]),
    ])


def every_type():
    """One element of every type that is read, each in a group of its own."""
    gmsh.clear()
    gmsh.model.add("every")
    gmsh.option.setNumber("Mesh.SaveAll", 0)
    for tag, (dim, entity, kind) in enumerate(add_every_type(), 1):
        gmsh.model.addPhysicalGroup(dim, [entity], tag, f"type {kind}")
    write("every-type")


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    strips()
    blocks()
    apart()
    every_type()
    gmsh.finalize()


if __name__ == "__main__":
    main()
