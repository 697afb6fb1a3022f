#!/usr/bin/env bash
# The MED files of gmsh and of meshio hold opposite solids for one and the same
# mesh, while their surface elements agree. Each of the two reads its own file
# back without a fault.
#
# Versions: gmsh 4.15.2, meshio 5.3.5, medcoupling 9.15.0, h5py 3.16.0,
# numpy 2.4.6.
#
# Input: for each of tetrahedron, hexahedron, prism and pyramid, one solid with
# its nodes in the MSH order (positive volume) and its base as a facet whose
# normal points out of it. gmsh writes this as MSH 4.1 and as MED. meshio reads
# the MSH file and writes a second MED file.
#
# Expected: the node order of a linear solid has one meaning in a MED file, so
# the two MED files hold the same elements. Or at least, if one of them differs,
# all elements in it are mirrored together, facets with solids.
#
# What happens instead: gmsh renumbers the nodes of every solid on its way into
# MED, and leaves the facets alone. meshio renumbers nothing, in or out.
# Nothing in the file tells which was done. So:
#   - medcoupling measures a positive volume in the file of gmsh and a negative
#     volume in the file of meshio;
#   - gmsh reads its own MED file right, and finds a negative Jacobian in the
#     file of meshio;
#   - meshio reads its own MED file right, and reads the solids of gmsh inside
#     out (shown as the sign of the volume by the plain VTK and MSH rule);
#   - the facet has the same node order in all of them.
#
# Output seen (sign of the volume as each reader sees it):
#   element     from    medcoupling  gmsh  meshio  facet
#   tetra       gmsh    +            +     -       same as MSH
#   tetra       meshio  -            -     +       same as MSH
#   hexahedron  gmsh    +            +     -       same as MSH
#   hexahedron  meshio  -            -     +       same as MSH
#   wedge       gmsh    +            +     -       same as MSH
#   wedge       meshio  -            -     +       same as MSH
#   pyramid     gmsh    +            +     -       same as MSH
#   pyramid     meshio  -            -     +       same as MSH
#
# Why it matters: a reader of MED must renumber the solids and must not renumber
# the facets. A test that only goes through meshio in both directions passes
# without it. To correct by turning every element of the file round is wrong
# too: outward facets would then point inward. Since both kinds of file exist,
# the sign of the volume has to be looked at, not only the format.
set -euo pipefail

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
{ python3 -m venv "$tmp/venv" &&
  "$tmp/venv/bin/python" -m pip install -q --disable-pip-version-check \
    gmsh==4.15.2 meshio==5.3.5 medcoupling==9.15.0 h5py==3.16.0 numpy==2.4.6; } ||
  { echo "could not make the Python environment (needs Python 3.11 or newer)"; exit 2; }
cd "$tmp"
"$tmp/venv/bin/python" -c 'import gmsh, medcoupling' 2>import.log ||
  { echo "gmsh or medcoupling cannot be loaded; gmsh needs system libraries such as libGLU.so.1:"
    tail -n 1 import.log; exit 2; }

cat >look.py <<'PY'
import contextlib
import io
import sys

import gmsh
import medcoupling
import meshio
import numpy as np

# name: (MSH number of the solid, of its base, base nodes seen from outside)
SOLIDS = {
    "tetra": (4, 2, (0, 2, 1)),
    "hexahedron": (5, 3, (0, 3, 2, 1)),
    "wedge": (6, 2, (0, 2, 1)),
    "pyramid": (7, 3, (0, 3, 2, 1)),
}
sign = {True: "+", False: "-"}


def quiet_read(name):
    with contextlib.redirect_stdout(io.StringIO()):
        return meshio.read(name)


def write_both(kind):
    solid, base, outside = SOLIDS[kind]
    gmsh.clear()
    g = gmsh.model
    g.add(kind)
    g.addDiscreteEntity(2, 1)
    g.addDiscreteEntity(3, 1)
    _, _, _, count, places, _ = g.mesh.getElementProperties(solid)
    g.mesh.addNodes(3, 1, range(1, count + 1), places)
    g.mesh.addElementsByType(1, solid, [1], range(1, count + 1))
    g.mesh.addElementsByType(1, base, [2], [n + 1 for n in outside])
    g.addPhysicalGroup(2, [1], 1, name="base")
    g.addPhysicalGroup(3, [1], 2, name="solid")
    gmsh.write(kind + ".msh")
    gmsh.write(kind + "-gmsh.med")
    m = quiet_read(kind + ".msh")
    meshio.Mesh(m.points, [(b.type, b.data) for b in m.cells]).write(kind + "-meshio.med")
    return np.array(places).reshape(count, 3), list(outside)


def by_gmsh(name):
    """Sign of the Jacobian at the middle of the solid."""
    gmsh.clear()
    gmsh.open(name)
    kinds, _, _ = gmsh.model.mesh.getElements(3)
    _, det, _ = gmsh.model.mesh.getJacobians(kinds[0], [0.25, 0.25, 0.25])
    return sign[bool(det[0] > 0)]


def by_medcoupling(name):
    """Sign of the volume, and the nodes of the facet."""
    m = medcoupling.MEDFileUMesh(name)
    volume = m.getMeshAtLevel(0).getMeasureField(False).getArray().getValues()[0]
    facet = m.getMeshAtLevel(-1)
    places = facet.getCoords().toNumPyArray()[list(facet.getNodeIdsOfCell(0))]
    return sign[volume > 0], places


def by_meshio(name):
    """Sign of the edges' triple product at node 0: +1 in the MSH and VTK order."""
    m = quiet_read(name)
    row = next(b.data[0] for b in m.cells if b.type in SOLIDS)
    last = {4: 3, 8: 4, 6: 3, 5: 4}[len(row)]
    other = {4: 2, 8: 3, 6: 2, 5: 3}[len(row)]
    a, b, c = (m.points[row[k]] - m.points[row[0]] for k in (1, other, last))
    return sign[bool(np.dot(np.cross(a, b), c) > 0)]


gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
ok = True
print("element     from    medcoupling  gmsh  meshio  facet")
for kind in SOLIDS:
    places, outside = write_both(kind)
    ok &= by_meshio(kind + ".msh") == "+"
    for writer, stated in (("gmsh", "++-"), ("meshio", "--+")):
        name = f"{kind}-{writer}.med"
        volume, facet = by_medcoupling(name)
        seen = volume + by_gmsh(name) + by_meshio(name)
        same = np.allclose(facet, places[outside])
        print(f"{kind:12}{writer:8}{seen[0]:13}{seen[1]:6}{seen[2]:8}"
              + ("same as MSH" if same else "NOT as in MSH"))
        ok &= seen == stated and same
gmsh.finalize()
print("as stated" if ok else "NOT as stated")
sys.exit(0 if ok else 1)
PY
"$tmp/venv/bin/python" look.py
