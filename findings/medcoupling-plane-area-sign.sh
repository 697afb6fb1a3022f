#!/usr/bin/env bash
# MEDCoupling counts the area of a plane cell as positive when its nodes run
# clockwise, and makes such cells itself. gmsh calls the same cells inverted.
#
# Versions: medcoupling 9.15.0, gmsh 4.15.2, numpy 2.4.6.
#
# Input: the unit square, once as four nodes that run counter-clockwise, once as
# MEDCoupling's own lattice of one cell (`MEDCouplingCMesh.buildUnstructured`),
# both in space dimension 2. gmsh gets the same nodes in the same order.
#
# Expected: a signed area (`getMeasureField(False)`) is positive for
# counter-clockwise nodes, as nearly everywhere else, and the cells of a lattice
# run that way. Files of one library pass as valid in the other.
#
# What happens instead:
#   - MEDCoupling's signed area of the counter-clockwise square is -1, that of its
#     own lattice, whose nodes run clockwise, is +1;
#   - the same square in space dimension 3 has the area +1 whichever way it runs,
#     so the sign is gone as soon as a third coordinate is there;
#   - gmsh finds a negative Jacobian in the lattice of MEDCoupling, and a positive
#     one in the square.
#
# Output seen:
#   mesh     nodes              area in 2D  area in 3D  Jacobian in gmsh
#   square   counter-clockwise  -1          1           +
#   lattice  clockwise          1           1           -
#
# Why it matters: plane meshes that SALOME's library makes arrive with all cells
# turned over. A reader that refuses a negative Jacobian refuses valid files of
# this source; one that turns single cells hides broken ones. Whether *all* cells
# run clockwise tells the two apart.
set -euo pipefail

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
{ python3 -m venv "$tmp/venv" &&
  "$tmp/venv/bin/python" -m pip install -q --disable-pip-version-check \
    gmsh==4.15.2 medcoupling==9.15.0 numpy==2.4.6; } ||
  { echo "could not make the Python environment (needs Python 3.11 or newer)"; exit 2; }
cd "$tmp"
"$tmp/venv/bin/python" -c 'import gmsh, medcoupling' 2>import.log ||
  { echo "gmsh or medcoupling cannot be loaded; gmsh needs system libraries such as libGLU.so.1:"
    tail -n 1 import.log; exit 2; }

cat >look.py <<'PY'
import sys

import gmsh
import medcoupling as mc

CORNERS = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def square():
    mesh = mc.MEDCouplingUMesh("square", 2)
    mesh.setCoords(mc.DataArrayDouble(CORNERS))
    mesh.allocateCells()
    mesh.insertNextCell(mc.NORM_QUAD4, [0, 1, 2, 3])
    mesh.finishInsertingCells()
    return mesh


def lattice():
    axes = [mc.DataArrayDouble([0.0, 1.0]) for _ in range(2)]
    mesh = mc.MEDCouplingCMesh("lattice")
    mesh.setCoords(*axes)
    return mesh.buildUnstructured()


def way(mesh):
    """By the cross product of the first two edges."""
    points = mesh.getCoords().getValuesAsTuple()
    a, b, c = (points[node] for node in mesh.getNodeIdsOfCell(0)[:3])
    turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    return "counter-clockwise" if turn > 0 else "clockwise"


def area(mesh):
    return mesh.getMeasureField(False).getArray().getValues()[0]


def by_gmsh(mesh):
    """Sign of the Jacobian of the cell with these nodes in a mesh of gmsh."""
    gmsh.clear()
    model = gmsh.model
    model.add(mesh.getName())
    model.addDiscreteEntity(2, 1)
    points = mesh.getCoords().getValuesAsTuple()
    flat = [x for point in points for x in (*point, 0.0)]
    model.mesh.addNodes(2, 1, range(1, len(points) + 1), flat)
    quadrilateral = model.mesh.getElementType("Quadrangle", 1)
    model.mesh.addElementsByType(1, quadrilateral, [1], [n + 1 for n in mesh.getNodeIdsOfCell(0)])
    jacobian, _, _ = model.mesh.getJacobians(quadrilateral, [0.0, 0.0, 0.0])
    turn = jacobian[0] * jacobian[4] - jacobian[1] * jacobian[3]
    return "+" if turn > 0 else "-"


gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
rows = []
print("mesh     nodes              area in 2D  area in 3D  Jacobian in gmsh")
for mesh in (square(), lattice()):
    raised = mesh.deepCopy()
    raised.changeSpaceDimension(3, 0.0)
    row = [mesh.getName(), way(mesh), area(mesh), area(raised), by_gmsh(mesh)]
    rows.append(row)
    print("{:<8} {:<18} {:<11g} {:<11g} {}".format(*row))
stated = [["square", "counter-clockwise", -1.0, 1.0, "+"], ["lattice", "clockwise", 1.0, 1.0, "-"]]
if rows != stated:
    sys.exit("this is not what was seen before")
PY
"$tmp/venv/bin/python" look.py
