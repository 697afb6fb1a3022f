#!/usr/bin/env python3
"""Writes the small MED files of tests/meshes with MEDCoupling, whose writer is that of SALOME.

    python3 -m venv .venv && .venv/bin/pip install medcoupling==9.15.0 numpy
    .venv/bin/python scripts/meshes_med.py tests/meshes

The tests know the counts, the groups and the volumes. Second-order meshes are made from first-order ones by
MEDCoupling, which sets the middle nodes by MED's own order of nodes. All are sheared, so that no two axes are alike.
"""

import pathlib
import sys

import medcoupling as mc

HEX, TET, PRISM, PYRAMID = mc.NORM_HEXA8, mc.NORM_TETRA4, mc.NORM_PENTA6, mc.NORM_PYRA5
QUAD, TRI, LINE, POINT = mc.NORM_QUAD4, mc.NORM_TRI3, mc.NORM_SEG2, mc.NORM_POINT1

# Two boxes of 1 x 2 x 1.5, one on top of the other: four corners, counter-clockwise from above, on each of three levels.
BOXES = [(x, y, z) for z in (0.0, 1.5, 3.0) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0))]


def sheared(points):
    """Of the same volumes."""
    return [(x + 0.2 * y + 0.1 * z, y + 0.3 * z, z) if len(p) == 3 else (x + 0.2 * y, y)
            for p in points for x, y, z in [(*p, 0.0)[:3]]]


def grid(dim, points, cells):
    mesh = mc.MEDCouplingUMesh("part", dim)
    coordinates = mc.DataArrayDouble(sheared(points))
    coordinates.setInfoOnComponents(["X [m]", "Y [m]", "Z [m]"][: len(points[0])])
    mesh.setCoords(coordinates)
    mesh.allocateCells()
    for kind, nodes in cells:
        mesh.insertNextCell(kind, nodes)
    mesh.finishInsertingCells()
    if dim == 3:
        # MEDCoupling's word that the cells have MED's orientation.
        assert len(mesh.findAndCorrectBadOriented3DCells()) == 0
        assert all(volume > 0 for volume in mesh.getMeasureField(False).getArray().getValues()), "volumes"
    return mesh


def file_of(levels, groups):
    """`levels` are meshes over the same points from the highest dimension down; `groups` maps a level (0, -1, and so
    on, and 1 for nodes) to names with the numbers of the cells or nodes."""
    file = mc.MEDFileUMesh()
    for mesh in levels:
        mesh.setCoords(levels[0].getCoords())
        file.setMeshAtLevel(mesh.getMeshDimension() - levels[0].getMeshDimension(), mesh)
    file.setName("part")
    for level, named in groups.items():
        arrays = [mc.DataArrayInt(numbers) for numbers in named.values()]
        for array, name in zip(arrays, named):
            array.setName(name)
        file.setGroupsAtLevel(level, arrays)
    return file


def second_order(mesh, centres):
    """The same mesh with middle nodes, for hexahedra and prisms also in faces and cells with `centres`."""
    mesh.convertLinearCellsToQuadratic(1 if centres else 0)
    return mesh


def on_sides(mesh, kind):
    """The sides of a mesh on its boundary, of one kind, with the same points."""
    sides = mesh.computeSkin()
    keep = [i for i in range(sides.getNumberOfCells()) if sides.getTypeOfCell(i) == kind]
    return sides[keep]



def hexes(folder):
    cells = [(HEX, [0, 3, 2, 1, 4, 7, 6, 5]), (HEX, [4, 7, 6, 5, 8, 11, 10, 9])]
    volume = grid(3, BOXES, cells)
    faces = grid(2, BOXES, [(QUAD, [0, 3, 2, 1]), (QUAD, [8, 9, 10, 11]), (QUAD, [0, 1, 5, 4]), (QUAD, [4, 5, 9, 8])])
    edges = grid(1, BOXES, [(LINE, [0, 4]), (LINE, [4, 8]), (LINE, [1, 5])])
    points = grid(0, BOXES, [(POINT, [0]), (POINT, [11])])
    file = file_of([volume, faces, edges, points], {
        0: {"lower": [0], "rock": [0, 1]},
        -1: {"bottom": [0], "top": [1], "front": [2, 3], "ends": [0, 1]},
        -2: {"edge": [0, 1], "rock": [2]},
        -3: {"corner": [0, 1]},
        1: {"corner": [0, 5], "fixed": [0, 1, 2, 3]},
    })
    file.setRenumFieldArr(1, mc.DataArrayInt([100 + 7 * i for i in range(12)]))
    file.setRenumFieldArr(0, mc.DataArrayInt([41, 17]))
    file.write(str(folder / "med_hex8.med"), 2)
    for name, centres, side in (("hex20", False, mc.NORM_QUAD8), ("hex27", True, mc.NORM_QUAD9)):
        volume = second_order(grid(3, BOXES, cells), centres)
        sides = on_sides(volume, side)
        file = file_of([volume, sides], {0: {"lower": [0]}, -1: {"skin": list(range(sides.getNumberOfCells()))}})
        file.write(str(folder / f"med_{name}.med"), 2)


def tets(folder):
    # Six around the diagonal from corner 0 to corner 6 of the lower box.
    ring = [1, 2, 3, 7, 4, 5]
    cells = [(TET, [0, ring[i], ring[(i + 1) % 6], 6]) for i in range(6)]
    cells = [(kind, [a, c, b, d]) if signed(a, b, c, d) > 0 else (kind, [a, b, c, d]) for kind, (a, b, c, d) in cells]
    volume = grid(3, BOXES[:8], cells)
    faces = on_sides(volume, TRI)
    groups = {0: {"half": [0, 1, 2], "most": [1, 2, 3, 4, 5]}, -1: {"skin": list(range(12))}}
    file_of([volume, faces], groups).write33(str(folder / "med_tet4_version3.med"), 2)
    volume = second_order(grid(3, BOXES[:8], cells), False)
    faces = on_sides(volume, mc.NORM_TRI6)
    file_of([volume, faces], groups).write(str(folder / "med_tet10.med"), 2)


def signed(*corners):
    """The volume of a tetrahedron, positive for a right-handed one."""
    a, *others = (BOXES[corner] for corner in corners)
    u, v, w = ([x - y for x, y in zip(other, a)] for other in others)
    return sum(u[i] * (v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3]) for i in range(3)) / 6


def mixed(folder):
    # A box, a pyramid on it, a prism at its side, a tetrahedron at the side of the pyramid.
    points = BOXES[:8] + [(0.5, 1.0, 3.0), (2.0, 0.0, 0.0), (2.0, 2.0, 0.0), (2.5, 1.0, 2.0)]
    cells = [
        (TET, [5, 8, 6, 11]),
        (PYRAMID, [4, 7, 6, 5, 8]),
        (PRISM, [1, 9, 5, 2, 10, 6]),
        (HEX, [0, 3, 2, 1, 4, 7, 6, 5]),
    ]
    groups = {0: {"box": [3], "others": [0, 1, 2], "wedge": [2]}}
    file_of([grid(3, points, cells)], groups).write(str(folder / "med_mixed.med"), 2)
    file_of([second_order(grid(3, points, cells), False)], groups).write(str(folder / "med_mixed2.med"), 2)
    prism18(second_order(grid(3, points, cells[2:3]), False)).write(str(folder / "med_prism18.med"), 2)


def prism18(mesh):
    """MEDCoupling makes no prisms of 18 nodes, but knows which of their nodes lie on which side."""
    mesh.zipCoords()
    place = {node: mesh.getCoords().getValuesAsTuple()[node] for node in mesh.getNodeIdsOfCell(0)}
    points = [place[node] for node in mesh.getNodeIdsOfCell(0)] + [(0.0, 0.0, 0.0)] * 3
    prism = mc.MEDCouplingUMesh("part", 3)
    prism.setCoords(mc.DataArrayDouble(points))
    prism.allocateCells()
    prism.insertNextCell(mc.NORM_PENTA18, list(range(18)))
    prism.finishInsertingCells()
    sides = prism.buildDescendingConnectivity()[0]
    for side in range(sides.getNumberOfCells()):
        nodes = sides.getNodeIdsOfCell(side)
        if len(nodes) == 9:
            points[nodes[8]] = tuple(sum(points[node][axis] for node in nodes[:4]) / 4 for axis in range(3))
    prism.setCoords(mc.DataArrayDouble(points))
    return file_of([prism], {0: {"wedge": [0]}})


def plane(folder):
    # The last node is used by nothing.
    points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.0, 2.0), (1.0, 2.0), (2.0, 2.0), (5.0, 5.0)]
    groups = {0: {"left": [0, 1], "right": [2]}, -1: {"bottom": [0, 1], "right": [2]}, 1: {"fixed": [0, 2, 6]}}
    cells = [(TRI, [0, 1, 4]), (TRI, [0, 4, 3]), (QUAD, [1, 2, 5, 4])]
    edges = grid(1, points, [(LINE, [0, 1]), (LINE, [1, 2]), (LINE, [2, 5])])
    file_of([grid(2, points, cells), edges], groups).write(str(folder / "med_plane.med"), 2)
    faces = second_order(grid(2, points, cells), False)
    edges = faces.computeSkin()
    groups = {0: {"left": [0, 1]}, -1: {"rim": list(range(edges.getNumberOfCells()))}}
    file_of([faces, edges], groups).write(str(folder / "med_plane2.med"), 2)


def clockwise(folder):
    """What MEDCoupling makes of a lattice: all quadrilaterals run clockwise, which it counts as positive."""
    lattice = mc.MEDCouplingCMesh("part")
    lattice.setCoords(mc.DataArrayDouble([0.0, 1.0, 3.0]), mc.DataArrayDouble([0.0, 0.5, 1.0]))
    faces = second_order(lattice.buildUnstructured(), False)
    assert all(area > 0 for area in faces.getMeasureField(False).getArray().getValues()), "areas"
    edges = faces.buildDescendingConnectivity()[0]
    edges.setCoords(faces.getCoords())
    middles = edges.computeCellCenterOfMass().getValuesAsTuple()
    at = {"foot": (1, 0.0), "head": (1, 1.0), "left": (0, 0.0), "right": (0, 3.0), "joint": (1, 0.5)}
    groups = {0: {"rock": [0, 1, 2, 3]}, -1: {
        name: [i for i, middle in enumerate(middles) if abs(middle[axis] - where) < 1e-9]
        for name, (axis, where) in at.items()}}
    file_of([faces, edges], groups).write(str(folder / "med_clockwise.med"), 2)


def cut(folder):
    """An inner face to be cut along, and two bodies whose faces lie on each other without common nodes."""
    points = BOXES + [(x, y, z + 3.0) for x, y, z in BOXES[:8]]
    cells = [(HEX, [0, 3, 2, 1, 4, 7, 6, 5]), (HEX, [4, 7, 6, 5, 8, 11, 10, 9]), (HEX, [12, 15, 14, 13, 16, 19, 18, 17])]
    faces = grid(2, points, [(QUAD, [4, 5, 6, 7]), (QUAD, [8, 9, 10, 11]), (QUAD, [12, 15, 14, 13])])
    groups = {0: {"rock": [0, 1], "slab": [2]}, -1: {"joint": [0], "below": [1], "above": [2]}, 1: {"fixed": [0, 1]}}
    file_of([grid(3, points, cells), faces], groups).write(str(folder / "med_cut.med"), 2)


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for write in (hexes, tets, mixed, plane, clockwise, cut):
        write(folder)


if __name__ == "__main__":
    main()
