#!/usr/bin/env bash
# A MED file of MEDCoupling 9.15 is one of version 4.2, which gmsh 4.15 does not
# open: not even its list of meshes. The content is that of 4.1.
#
# Versions: medcoupling 9.15.0, gmsh 4.15.2, h5py 3.16.0, numpy 2.4.6.
#
# Input: one quadrilateral in a group, written by MEDCoupling's `write`, and once more by its
# `write41`.
#
# Expected: a reader of MED 4 reads both, since a minor version of a file format
# adds things that older readers can leave alone; and nothing here needs them.
#
# What happens instead: `write` puts 4.2.0 into the file, whatever the mesh holds.
# The MED library in gmsh refuses every file whose major.minor is above its own,
# and gmsh ends with "Unable to read mesh information". The file of `write41` is
# read. But for the numbers of the version both files hold the same groups,
# datasets and attributes, apart from the random universal name of the mesh.
#
# Output seen:
#   written by  version  gmsh
#   write       4.2.0    not read: Unable to read mesh information
#   write41     4.1.1    1 element
#   differences beside the version: none
#
# Why it matters: meshes that go from SALOME's tools to gmsh, or to what is linked
# with its MED library, have to be written with `write41`. A reader that goes by
# the version alone refuses files that it could read.
set -euo pipefail

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
{ python3 -m venv "$tmp/venv" &&
  "$tmp/venv/bin/python" -m pip install -q --disable-pip-version-check \
    gmsh==4.15.2 medcoupling==9.15.0 h5py==3.16.0 numpy==2.4.6; } ||
  { echo "could not make the Python environment (needs Python 3.11 or newer)"; exit 2; }
cd "$tmp"
"$tmp/venv/bin/python" -c 'import gmsh, medcoupling' 2>import.log ||
  { echo "gmsh or medcoupling cannot be loaded; gmsh needs system libraries such as libGLU.so.1:"
    tail -n 1 import.log; exit 2; }

cat >write.py <<'PY'
import medcoupling as mc

mesh = mc.MEDCouplingUMesh("square", 2)
corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
mesh.setCoords(mc.DataArrayDouble(corners))
mesh.allocateCells()
mesh.insertNextCell(mc.NORM_QUAD4, [0, 1, 2, 3])
mesh.finishInsertingCells()
file = mc.MEDFileUMesh()
file.setMeshAtLevel(0, mesh)
file.setName("square")
group = mc.DataArrayInt([0])
group.setName("rock")
file.setGroupsAtLevel(0, [group])
file.write("write.med", 2)
file.write41("write41.med", 2)
PY
cat >look.py <<'PY'
import sys

import gmsh
import h5py
import numpy as np


def version(name):
    with h5py.File(name, "r") as file:
        of = file["INFOS_GENERALES"].attrs
        return ".".join(str(int(of[part])) for part in ("MAJ", "MIN", "REL"))


def content(name):
    """Every group, dataset and attribute but those of the version."""
    found = {}

    def see(path, thing):
        found[path] = thing[()].tobytes() if isinstance(thing, h5py.Dataset) else b""
        if path != "INFOS_GENERALES":
            # UNV is a name that no two meshes share.
            for key, value in ((k, v) for k, v in thing.attrs.items() if k != "UNV"):
                found[f"{path}@{key}"] = np.asarray(value).tobytes()

    with h5py.File(name, "r") as file:
        file.visititems(see)
    return found


def by_gmsh(name):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        gmsh.open(name)
        _, tags, _ = gmsh.model.mesh.getElements()
        return f"{sum(map(len, tags))} element"
    except Exception as error:
        return f"not read: {error}"
    finally:
        gmsh.finalize()


rows = [[by, version(f"{by}.med"), by_gmsh(f"{by}.med")] for by in ("write", "write41")]
print("written by  version  gmsh")
for row in rows:
    print("{:<11} {:<8} {}".format(*row))
one, other = content("write.med"), content("write41.med")
differ = sorted(key for key in one.keys() | other.keys() if one.get(key) != other.get(key))
print("differences beside the version:", ", ".join(differ) or "none")
stated = [["write", "4.2.0", "not read: Unable to read mesh information"], ["write41", "4.1.1", "1 element"]]
if rows != stated or differ:
    sys.exit("this is not what was seen before")
PY
"$tmp/venv/bin/python" write.py
"$tmp/venv/bin/python" look.py 2>/dev/null
