#!/usr/bin/env python3
"""Compares the values in the field files of finished runs with their histories and exact solutions.

    scripts/python.sh scripts/check_fields.py DIR...

Each DIR is the output directory of a run of a case in which the stress is uniform: exact stress,
jump and displacement follow from the values that the case expects (report.json), not from what was computed.
Prints one line for each failure and `N passed, N failed` at the end. Exit status 1 if any failed.
"""

import json
import sys
from pathlib import Path

import numpy
from verify_fields import TOLERANCE, read_grid, read_history, summary
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkFiltersCore import vtkCellCenters
from vtkmodules.vtkFiltersExtraction import vtkExtractTensorComponents

# History quantity to array and component of an interface file.
INTERFACE = {
    "normal_traction": ("traction", 2),
    "shear_traction_x": ("traction", 0),
    "shear_traction_y": ("traction", 1),
    "normal_jump": ("jump", 2),
    "sliding_x": ("jump", 0),
    "sliding_y": ("jump", 1),
    "damage": ("damage", 0),
}
EXACT = 1.0e-9


class Checks:
    """Counts what held and what did not, and says where."""

    def __init__(self):
        self.passed = self.failed = 0

    def __call__(self, holds, what):
        if holds:
            self.passed += 1
        else:
            self.failed += 1
            print(f"FAILED {what}")

    def near(self, found, exact, scale, what, tolerance=EXACT):
        """Whether two arrays agree within `tolerance` of `scale`."""
        found, exact = numpy.broadcast_arrays(found, exact)
        error = float(numpy.abs(found - exact).max()) if found.size else float("inf")
        self(error <= tolerance * scale, f"{what}: off by {error:.3e}, allowed {tolerance * scale:.3e}")


def array(attributes, name):
    """An array by name, as rows of components."""
    values = vtk_to_numpy(attributes.GetArray(name))
    return values.reshape(len(values), -1)


def expected(report, quantity, time):
    """The exact value that the case states for a quantity at a time; 0 if it states none."""
    values = [e["equals"] for e in report["case"].get("expect", []) if (e["quantity"], e["at"]) == (quantity, time)]
    return values[0] if values else 0.0


def component(grid, row, column, name="stress"):
    """A component of the cells' stress as VTK itself takes it out of the six that were written."""
    copy = grid.NewInstance()
    copy.ShallowCopy(grid)
    copy.GetCellData().SetActiveTensors(name)
    to_points = vtkCellCenters()
    to_points.SetInputData(copy)
    extract = vtkExtractTensorComponents()
    extract.SetInputConnection(to_points.GetOutputPort())
    extract.ExtractScalarsOn()
    extract.ScalarIsComponent()
    extract.SetScalarComponents(row, column)
    extract.Update()
    return vtk_to_numpy(extract.GetOutput().GetPointData().GetScalars())


def cell_sides(grid, height):
    """For every point, whether its cells lie above `height`; the two sides of an interface share none."""
    points = vtk_to_numpy(grid.GetPoints().GetData())
    connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    ends = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    above = numpy.zeros(len(points), dtype=bool)
    for first, end in zip(ends[:-1], ends[1:]):
        nodes = connectivity[first:end]
        if points[nodes, 2].mean() > height:
            above[nodes] = True
    return points, above


def column_state(report, time, points, above):
    """Exact displacement and stress of a column with nu = 0 that stands on its fixed bottom."""
    case = report["case"]
    (material,) = case["materials"].values()
    young = material["elastic"]["young_modulus"]
    name = case["interfaces"][0]["name"]
    exact = {q: expected(report, f"{name}.{q}", time) for q in INTERFACE}
    normal, shear = exact["normal_traction"], exact["shear_traction_x"]
    displacement = numpy.zeros_like(points)
    displacement[:, 2] = normal / young * points[:, 2] + above * exact["normal_jump"]
    displacement[:, 0] = 2.0 * shear / young * points[:, 2] + above * exact["sliding_x"]
    return displacement, [[0.0, 0.0, shear], [0.0, 0.0, 0.0], [shear, 0.0, normal]]


def patch_state(points):
    """Exact displacement and stress of cases/patch_bulk."""
    gradient = numpy.array([[1.0, 1.0, 2.0], [1.0, 2.0, 1.5], [1.0, 2.0, 3.0]]) * 1.0e-4
    strain = (gradient + gradient.T) / 2
    return points @ gradient.T, 3.0e9 * numpy.trace(strain) * numpy.eye(3) + 4.0e9 * strain


def check_porous(check, path, report):
    """A column with nu = 0 and biot 1 between smooth walls, through which the fluid flows steadily from its base."""
    where = f"{path.parent.parent.name}/{path.name}"
    grid = read_grid(path)
    case = report["case"]
    (material,) = case["materials"].values()
    young, porous = material["elastic"]["young_modulus"], material["porous"]
    height = case["mesh"]["column"]["size"][-1]
    base = next(b["pressure"] for b in case["boundary"] if b["on"] == "bottom")
    total = next(b["traction"]["z"] for b in case["boundary"] if b["on"] == "top")
    mobility = porous["permeability"] / porous["viscosity"]
    points = vtk_to_numpy(grid.GetPoints().GetData())
    z = points[:, 2]
    displacement = numpy.zeros_like(points)
    displacement[:, 2] = (total * z + base * (z - z * z / (2 * height))) / young
    data, cells = grid.GetPointData(), grid.GetCellData()
    check.near(array(data, "displacement"), displacement, abs(displacement).max(), f"{where}: displacement")
    check.near(array(data, "pressure")[:, 0], base * (1 - z / height), base, f"{where}: pressure")
    centers = vtkCellCenters()
    centers.SetInputData(grid)
    centers.Update()
    pressure = base * (1 - vtk_to_numpy(centers.GetOutput().GetPoints().GetData())[:, 2] / height)
    for row, column in numpy.ndindex(3, 3):
        axes = "xyz"[row] + "xyz"[column]
        effective = (total + pressure) * ((row, column) == (2, 2))
        own = effective - pressure * (row == column)
        for name, exact in (("stress", own), ("effective_stress", effective)):
            check.near(component(grid, row, column, name), exact, abs(total), f"{where}: {name} {axes}")
    flux = [0.0, 0.0, porous["fluid_density"] * mobility * base / height]
    check.near(array(cells, "fluid_flux"), flux, flux[2], f"{where}: fluid_flux")
    porosity = 1 - (1 - porous["porosity"]) * numpy.exp(-(total + pressure) / young)
    check.near(array(cells, "porosity")[:, 0], porosity, 1.0, f"{where}: porosity")


def check_bulk(check, path, report, time):
    """Points, cells, ids, displacement and stress of a bulk file."""
    where = f"{path.parent.parent.name}/{path.name}"
    grid = read_grid(path)
    data, cells = grid.GetPointData(), grid.GetCellData()
    check(grid.GetNumberOfCells() == report["cells"], f"{where}: {grid.GetNumberOfCells()} cells, {report['cells']} in report.json")
    nodes = report["unknowns"] // report["model"]["dimension"]
    check(grid.GetNumberOfPoints() == nodes, f"{where}: {grid.GetNumberOfPoints()} points, {nodes} nodes in report.json")
    for attributes, name in ((data, "global_node_id"), (cells, "global_cell_id")):
        ids = array(attributes, name)
        check(len(numpy.unique(ids)) == len(ids), f"{where}: {name} repeats")
    ranks = numpy.unique(array(cells, "rank"))
    check(ranks.tolist() == list(range(report["ranks"])), f"{where}: ranks {ranks.tolist()} of {report['ranks']}")
    check((array(cells, "material") == 0).all(), f"{where}: a material other than the only one")
    interfaces = report["case"].get("interfaces") or []
    if interfaces:
        points, above = cell_sides(grid, interfaces[0]["z"])
        displacement, stress = column_state(report, time, points, above)
    else:
        displacement, stress = patch_state(vtk_to_numpy(grid.GetPoints().GetData()))
    # What is 0 throughout is compared on the scale of a small strain and of its stress.
    young = next(iter(report["case"]["materials"].values()))["elastic"]["young_modulus"]
    check.near(array(data, "displacement"), displacement, max(abs(displacement).max(), 1e-6), f"{where}: displacement")
    scale = max(numpy.abs(stress).max(), 1e-6 * young)
    for row, column in numpy.ndindex(3, 3):
        axes = "xyz"[row] + "xyz"[column]
        check.near(component(grid, row, column), stress[row][column], scale, f"{where}: stress {axes}")


def check_interface(check, path, name, report, time, row):
    """Ids, and every array against the smallest and largest value in history.csv."""
    where = f"{path.parent.parent.name}/{path.name}"
    data = read_grid(path).GetPointData()
    ids = array(data, "global_node_id")
    check(len(numpy.unique(ids)) == len(ids), f"{where}: global_node_id repeats")
    states = array(data, "state")
    check((states >= 0).all(), f"{where}: a state below 0")
    height = {i["name"]: i["z"] for i in report["case"]["interfaces"]}[name]
    check.near(vtk_to_numpy(read_grid(path).GetPoints().GetData())[:, 2], height, 1.0, f"{where}: height")
    for quantity, (array_name, component) in INTERFACE.items():
        values = array(data, array_name)[:, component]
        if f"{name}.{quantity}.min" not in row:
            check.near(values, 0.0, TOLERANCE, f"{where}: {quantity}, which a 2D case has not")
            continue
        ends = [float(row[f"{name}.{quantity}.{end}"]) for end in ("min", "max")]
        scale = max(map(abs, ends)) or 1.0
        check.near([values.min(), values.max()], ends, scale, f"{where}: {quantity} against history.csv", TOLERANCE)


def check_run(check, directory):
    report = json.loads((directory / "report.json").read_text())
    history = read_history(directory)
    instants = report["case"]["time"]["instants"]
    names = [i["name"] for i in report["case"].get("interfaces") or []]
    for name in ["bulk", *names]:
        series = json.loads((directory / "fields" / f"{name}.vtkhdf.series").read_text())["files"]
        times = [entry["time"] for entry in series]
        check(times == instants, f"{directory.name}: series of {name} has {times}, the case {instants}")
        for entry in series:
            path, time = directory / "fields" / entry["name"], entry["time"]
            try:
                summary(path, time)
                if name == "bulk" and report["model"]["physics"] == "hydro_mechanics":
                    check_porous(check, path, report)
                elif name == "bulk":
                    check_bulk(check, path, report, time)
                else:
                    check_interface(check, path, name, report, time, history[time])
            except (AttributeError, KeyError, ValueError) as fault:
                check(False, f"{directory.name}/{path.name}: {type(fault).__name__}: {fault}")


def main(arguments):
    if not arguments or not all(Path(a).is_dir() for a in arguments):
        print(__doc__, file=sys.stderr)
        return 2
    check = Checks()
    for directory in map(Path, arguments):
        check_run(check, directory)
    print(f"read with VTK {vtkVersion.GetVTKVersion()}")
    print(f"{check.passed} passed, {check.failed} failed")
    return 1 if check.failed or not check.passed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
