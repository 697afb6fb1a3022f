#!/usr/bin/env bash
# A reversed member of a physical group comes out in three different ways from
# one gmsh model: MSH 2.2, MSH 4.1 and MED disagree on both the orientation and
# the name of the group.
#
# Versions: gmsh 4.15.2, meshio 5.3.5, h5py 3.16.0, numpy 2.4.6.
#
# Input: two quadrangles side by side. Group 21 "plain" holds surface 1. Group 22
# "turned" holds surface 2 with a minus sign, which asks for the opposite
# orientation. All three files are written from this one model in one go.
#
# Expected: the three files describe the same mesh. Each has a group "turned"
# whose one facet has its nodes in the same order in all three.
#
# What happens instead:
#   MSH 2.2  The facet is turned round. The group is 22, and its name is found.
#            The node order is the only trace of the minus sign in the file.
#   MSH 4.1  The facet is NOT turned round. The surface carries the tag -22, while
#            the name section says 22. Nothing in the file is called -22. meshio
#            reads the cell data as -22 and makes a cell set "turned" that is empty.
#   MED      The facet is NOT turned round. No group "turned" is in the file. There
#            is a group "G_2D_-22" in its place.
# And it does not survive a second trip. gmsh reads the 2.2 file back as an
# unsigned group, and writes MSH 4.1 from it with the facet turned and tag 22.
#
# Output seen:
#   MSH 2.2: facets in plain [[1, 2, 5, 6]], in turned [[2, 5, 4, 3]], tags [21, 22]
#   MSH 4.1: facets in plain [[1, 2, 5, 6]], in turned [], tags [-22, 21]
#   MSH 4.1: the facet of surface 2 is [2, 3, 4, 5], entity tag -22, named tags [21, 22]
#   MED: facets [[1, 2, 5, 6], [2, 3, 4, 5]], groups ['G_2D_-22', 'plain']
#   2.2 -> gmsh -> 4.1: facets in turned [[2, 5, 4, 3]], tags [21, 22]
#
# Why it matters: a boundary load along the normal, read from the 2.2 file, has
# the other sign from the same load read from the 4.1 file, if the reader takes
# the node order as it stands. A reader of MSH 4.1 has to look up the name under
# the absolute value of the tag and must itself turn the element when the tag is
# below zero. A reader of MSH 2.2 must not do so. In a MED file the name is lost,
# so a condition given by name finds no facet at all.
set -euo pipefail

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
{ python3 -m venv "$tmp/venv" &&
  "$tmp/venv/bin/python" -m pip install -q --disable-pip-version-check \
    gmsh==4.15.2 meshio==5.3.5 h5py==3.16.0 numpy==2.4.6; } ||
  { echo "could not make the Python environment (needs Python 3.11 or newer)"; exit 2; }
cd "$tmp"
"$tmp/venv/bin/python" -c 'import gmsh' 2>import.log ||
  { echo "gmsh cannot be loaded; it needs system libraries such as libGLU.so.1:"; tail -n 1 import.log; exit 2; }

cat >look.py <<'PY'
import contextlib
import io
import sys

import gmsh
import h5py
import meshio
import numpy as np

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
g = gmsh.model
g.add("two")
for surface in (1, 2):
    g.addDiscreteEntity(2, surface)
corners = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
g.mesh.addNodes(2, 1, range(1, 7), [v for x, y in corners for v in (x, y, 0)])
QUAD = 3
g.mesh.addElementsByType(1, QUAD, [1], [1, 2, 5, 6])
g.mesh.addElementsByType(2, QUAD, [2], [2, 3, 4, 5])
g.addPhysicalGroup(2, [1], 21, name="plain")
g.addPhysicalGroup(2, [-2], 22, name="turned")


def write(version, name):
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.write(name)


def numbers(m, row):
    """Numbers of the model's nodes, found by place: a file may renumber them."""
    return [corners.index((x, y)) + 1 for x, y, _ in m.points[row].tolist()]


def by_group(name):
    """Facets of each named group, and the tags the elements carry."""
    with contextlib.redirect_stdout(io.StringIO()):  # meshio prints blank lines
        m = meshio.read(name)
    tags = sorted({int(t) for block in m.cell_data["gmsh:physical"] for t in block})
    out = {}
    for group in ("plain", "turned"):
        if group in m.cell_sets:
            picks = m.cell_sets[group]
        else:  # MSH 2.2 has no cell sets, only the tag of each element
            want = m.field_data[group][0]
            picks = [np.flatnonzero(b == want) for b in m.cell_data["gmsh:physical"]]
        out[group] = [
            numbers(m, row)
            for block, pick in zip(m.cells, picks)
            for row in block.data[np.asarray(pick, dtype=int)]
        ]
    return out, tags, m


write(2.2, "v2.msh")
write(4.1, "v4.msh")
gmsh.write("m.med")
gmsh.clear()
gmsh.open("v2.msh")
write(4.1, "v2to4.msh")
gmsh.finalize()

v2, tags2, _ = by_group("v2.msh")
print(f"MSH 2.2: facets in plain {v2['plain']}, in turned {v2['turned']}, tags {tags2}")

v4, tags4, m4 = by_group("v4.msh")
print(f"MSH 4.1: facets in plain {v4['plain']}, in turned {v4['turned']}, tags {tags4}")
block = next(i for i, t in enumerate(m4.cell_data["gmsh:geometrical"]) if t[0] == 2)
facet4 = numbers(m4, m4.cells[block].data[0])
tag4 = int(m4.cell_data["gmsh:physical"][block][0])
named = sorted(int(v[0]) for v in m4.field_data.values())
print(f"MSH 4.1: the facet of surface 2 is {facet4}, entity tag {tag4}, named tags {named}")

med = meshio.read("m.med")
facets_med = [numbers(med, r) for b in med.cells if b.type == "quad" for r in b.data]
groups_med = set()


def collect(path, item):
    # each row is a fixed-length name padded with zero bytes
    if path.endswith("GRO/NOM"):
        for row in item[()]:
            groups_med.add(bytes(np.asarray(row, dtype="u1")).rstrip(b"\0 ").decode())


with h5py.File("m.med") as f:
    f["FAS"].visititems(collect)
groups_med = sorted(groups_med)
print(f"MED: facets {facets_med}, groups {groups_med}")

again, tags_again, _ = by_group("v2to4.msh")
print(f"2.2 -> gmsh -> 4.1: facets in turned {again['turned']}, tags {tags_again}")

ok = (
    v2 == {"plain": [[1, 2, 5, 6]], "turned": [[2, 5, 4, 3]]}
    and tags2 == [21, 22]
    and v4 == {"plain": [[1, 2, 5, 6]], "turned": []}
    and (facet4, tag4, named) == ([2, 3, 4, 5], -22, [21, 22])
    and facets_med == [[1, 2, 5, 6], [2, 3, 4, 5]]
    and groups_med == ["G_2D_-22", "plain"]
    and again["turned"] == [[2, 5, 4, 3]]
    and tags_again == [21, 22]
)
print("as stated" if ok else "NOT as stated")
sys.exit(0 if ok else 1)
PY
"$tmp/venv/bin/python" look.py
