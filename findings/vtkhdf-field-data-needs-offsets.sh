#!/usr/bin/env bash
# In a VTKHDF file with time steps, point and cell arrays without offsets are
# constant in time, but one field-data array without offsets is lost, and takes
# other field arrays with it.
#
# Versions: vtk 9.7.2 (its vtkHDFReader), h5py 3.16.0, numpy 2.4.6. The output
# was the same with vtk 9.5.2.
#
# Input: one quadrangle, three time steps, a mesh that stays the same. "fixed" is
# a point array and a cell array with no offsets. The field data have "m_energy",
# one value per step with the offsets 0, 1, 2, and one array of two constants
# with no offsets. The specification lets any of the offset arrays be left out,
# for field data as for point and cell data, and says that the offset of the
# geometry is then taken. That is 0 here in every step.
#
# Expected: "fixed" and the two constants (or the first of them) are read in
# every step, next to the energy of that step.
#
# What happens instead:
#   - The point and cell arrays come back in every step, as expected.
#   - The constants are in no step at all, not even in the first.
#   - With them go all field arrays whose names sort after theirs, although these
#     have offsets. The order of writing plays no part. So the energy is there
#     when the constants are called "z_const", and gone with "a_const".
#   - The array "Time", which the reader itself adds to each step, is gone too.
#   - The error code of the reader stays 0. There are only messages on the error
#     stream.
#   - The same field data in a file with no steps are read in full.
#   - With offsets of 0, 0, 0 and sizes of (1, 2) the constants are read in every
#     step, and nothing else is lost.
#
# Output seen (field arrays of steps 0, 1, 2; point and cell "fixed" in all):
#   a_const, no offsets: step 0 {}, step 1 {}, step 2 {}
#   z_const, no offsets: step 0 {m_energy [7]}, step 1 {m_energy [8]}, step 2 {m_energy [9]}
#   a_const, zero offsets: step 0 {Time [0], a_const [5, 6], m_energy [7]},
#     step 1 {Time [1], a_const [5, 6], m_energy [8]},
#     step 2 {Time [2], a_const [5, 6], m_energy [9]}
#   a_const, file without steps: {a_const [5, 6], m_energy [7, 8, 9]}
#   error code of the reader: 0 in all cases
#
# Why it matters: a solver that adds one constant (a material table, a load
# factor) to its field data the way it may add a constant point array loses
# results that were right before. Which ones depends on their names. The writer
# must give every field array offsets and sizes in such a file, and a test must
# look at the field arrays one by one, since the error code says nothing.
set -euo pipefail

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
{ python3 -m venv "$tmp/venv" &&
  "$tmp/venv/bin/python" -m pip install -q --disable-pip-version-check --no-deps \
    vtk==9.7.2 h5py==3.16.0 numpy==2.4.6; } ||
  { echo "could not make the Python environment (needs Python 3.11 or newer)"; exit 2; }
cd "$tmp"
"$tmp/venv/bin/python" -c 'from vtkmodules.vtkIOHDF import vtkHDFReader' 2>import.log ||
  { echo "vtk cannot be loaded; a system library is missing:"; tail -n 1 import.log; exit 2; }

cat >look.py <<'PY'
import sys

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader

STEPS = 3


def write(name, constant, offsets=None, steps=True):
    with h5py.File(name, "w") as f:
        g = f.create_group("VTKHDF")
        g.attrs["Version"] = (2, 3)
        g.attrs.create("Type", b"UnstructuredGrid", dtype="S16")
        g["NumberOfPoints"], g["NumberOfCells"] = [4], [1]
        g["NumberOfConnectivityIds"] = [4]
        g["Points"] = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
        g["Connectivity"], g["Offsets"] = np.arange(4), np.array([0, 4])
        g["Types"] = np.array([9], "u1")
        g["PointData/fixed"] = np.arange(4.0)
        g["CellData/fixed"] = np.array([4.0])
        g["FieldData/m_energy"] = np.array([7.0, 8.0, 9.0])
        g["FieldData/" + constant] = np.array([5.0, 6.0])
        if not steps:
            return
        s = g.create_group("Steps")
        s.attrs["NSteps"] = STEPS
        s["Values"] = np.arange(float(STEPS))
        s["NumberOfParts"] = np.ones(STEPS, "i8")
        for key in ("PartOffsets", "PointOffsets"):
            s[key] = np.zeros(STEPS, "i8")
        for key in ("CellOffsets", "ConnectivityIdOffsets"):
            s[key] = np.zeros((STEPS, 1), "i8")
        s["FieldDataOffsets/m_energy"] = np.arange(STEPS)
        s["FieldDataSizes/m_energy"] = np.full((STEPS, 2), 1)
        if offsets is not None:
            s["FieldDataOffsets/" + constant] = np.array(offsets)
            s["FieldDataSizes/" + constant] = np.tile([1, 2], (STEPS, 1))


def arrays(data):
    return {
        data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)).ravel().tolist()
        for i in range(data.GetNumberOfArrays())
    }


def read(name, steps=True):
    """Field arrays of each step; whether the fixed arrays were there; error code."""
    reader = vtkHDFReader()
    reader.SetFileName(name)
    fields, fixed, code = [], True, 0
    for step in range(STEPS if steps else 1):
        reader.UpdateTimeStep(float(step)) if steps else reader.Update()
        grid = reader.GetOutputDataObject(0)
        fields.append(arrays(grid.GetFieldData()))
        fixed &= arrays(grid.GetPointData()) == {"fixed": [0, 1, 2, 3]}
        fixed &= arrays(grid.GetCellData()) == {"fixed": [4]}
        code = max(code, reader.GetErrorCode())
    return fields, fixed, code


def show(found):
    inner = ", ".join(f"{k} [{', '.join(f'{x:g}' for x in v)}]" for k, v in sorted(found.items()))
    return "{" + inner + "}"


full = [{"Time": [t], "a_const": [5, 6], "m_energy": [7 + t]} for t in range(STEPS)]
cases = [
    ("a_const, no offsets", ("a_const",), True, [{}, {}, {}]),
    ("z_const, no offsets", ("z_const",), True, [{"m_energy": [7 + t]} for t in range(STEPS)]),
    ("a_const, zero offsets", ("a_const", [0, 0, 0]), True, full),
    ("a_const, file without steps", ("a_const",), False, [{"a_const": [5, 6], "m_energy": [7, 8, 9]}]),
]
ok = True
for number, (title, how, steps, stated) in enumerate(cases):
    name = f"case{number}.vtkhdf"
    write(name, *how, steps=steps)
    fields, fixed, code = read(name, steps)
    per_step = [f"step {i} {show(f)}" for i, f in enumerate(fields)] if steps else [show(fields[0])]
    print(f"{title}: {', '.join(per_step)}; fixed arrays {'there' if fixed else 'LOST'}; error code {code}")
    ok &= fields == stated and fixed and code == 0
print("as stated" if ok else "NOT as stated")
sys.exit(0 if ok else 1)
PY
# The messages of the reader are kept apart from the result.
"$tmp/venv/bin/python" look.py 2>messages.log || { tail -n 20 messages.log; exit 1; }
echo "messages on the error stream: $( [ -s messages.log ] && echo yes || echo none )"
