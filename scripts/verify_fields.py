#!/usr/bin/env python3
"""Reads the field files of an output directory with VTK and compares them with its history.

    scripts/python.sh scripts/verify_fields.py DIR

Opens every file that a series of DIR (or of DIR/fields) names and checks that VTK reads it, that the
grid has sound cells, and that every array is finite and as long as the grid. Where history.csv
has a row at the time of an interface's file, the range of its damage is compared with it.
Prints one JSON object: for each file its time, points, cells, kinds of cells, their total length,
area or volume, bounds, and the smallest and largest value of each component of each array. Exit status: 0 all sound, 1 something is not, with one
line for each fault on stderr; 2 wrong use.
"""

import csv
import json
import math
import sys
from pathlib import Path

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOHDF import vtkHDFReader

TOLERANCE = 1.0e-12


def read_grid(path):
    """The one grid of a file; readers since VTK 9.5 may wrap it in a partitioned data set."""
    reader = vtkHDFReader()
    if not reader.CanReadFile(str(path)):
        raise ValueError("vtkHDFReader cannot read it")
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutputDataObject(0)
    if data is not None and data.IsA("vtkPartitionedDataSet"):
        if data.GetNumberOfPartitions() != 1:
            raise ValueError(f"{data.GetNumberOfPartitions()} partitions where one was written")
        data = data.GetPartition(0)
    if not isinstance(data, vtkUnstructuredGrid):
        raise ValueError(f"{type(data).__name__} where an unstructured grid was written")
    return data


def ranges(attributes, rows, where):
    """Smallest and largest value of each component of each array."""
    found = {}
    for index in range(attributes.GetNumberOfArrays()):
        array = attributes.GetArray(index)
        values = vtk_to_numpy(array).reshape(array.GetNumberOfTuples(), -1)
        if len(values) != rows:
            raise ValueError(f"{array.GetName()}: {len(values)} rows for {rows} {where}")
        if not numpy.isfinite(values).all():
            raise ValueError(f"{array.GetName()}: a value is not finite")
        both = [[low, high] for low, high in zip(values.min(0).tolist(), values.max(0).tolist())] if rows else []
        found[array.GetName()] = both[0] if len(both) == 1 else both
    return found


def second_order_sizes(grid):
    """Lengths, areas or volumes of straight cells with nodes on their edges, which must stand where the
    reader's own numbering has them."""
    sizes = []
    for index in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(index)
        count, dimension = cell.GetNumberOfPoints(), cell.GetCellDimension()
        points = numpy.array([cell.GetPoints().GetPoint(a) for a in range(count)])
        flat = cell.GetParametricCoords()
        places = numpy.array([flat[i] for i in range(3 * count)]).reshape(count, 3)[:, :dimension]
        edges, *_ = numpy.linalg.lstsq(places, points - points[0], rcond=None)
        if abs(points[0] + places @ edges - points).max() > 1e-12 * abs(edges).max():
            raise ValueError(f"the nodes of cell {index} stand elsewhere than their numbers say")
        sizes.append(numpy.linalg.det(edges) if dimension == 3 else numpy.sqrt(numpy.linalg.det(edges @ edges.T)))
    return numpy.array(sizes)


def measure(grid):
    """Sum of the lengths, areas or volumes of all cells; each must be positive."""
    if grid.GetNumberOfCells() and any(not grid.GetCell(i).IsLinear() for i in range(grid.GetNumberOfCells())):
        every = second_order_sizes(grid)
        if not (every > 0).all():
            raise ValueError(f"{int((~(every > 0)).sum())} cells are flat or inside out")
        return float(every.sum())
    sizes = vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.ComputeVertexCountOff()
    sizes.Update()
    data = sizes.GetOutput().GetCellData()
    every = sum(vtk_to_numpy(data.GetArray(name)) for name in ("Length", "Area", "Volume"))
    if not (every > 0).all():
        raise ValueError(f"{int((~(every > 0)).sum())} cells are flat or inside out")
    return float(every.sum())


def summary(path, time):
    grid = read_grid(path)
    points, cells = grid.GetNumberOfPoints(), grid.GetNumberOfCells()
    if cells:
        connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        if connectivity.min() < 0 or connectivity.max() >= points:
            raise ValueError("a cell names a point that does not exist")
        if len(numpy.unique(connectivity)) != points:
            raise ValueError("a point belongs to no cell")
    bounds = []
    if points:
        coordinates = vtk_to_numpy(grid.GetPoints().GetData())
        if not numpy.isfinite(coordinates).all():
            raise ValueError("a coordinate is not finite")
        bounds = [[low, high] for low, high in zip(coordinates.min(0).tolist(), coordinates.max(0).tolist())]
    arrays = ranges(grid.GetPointData(), points, "points")
    arrays.update(ranges(grid.GetCellData(), cells, "cells"))
    kinds = sorted({grid.GetCellType(cell) for cell in range(cells)})
    return {"time": time, "points": points, "cells": cells, "cell_types": kinds,
            "measure": measure(grid) if cells else 0.0, "bounds": bounds, "arrays": arrays}


def read_history(directory):
    """The rows of history.csv by time."""
    path = directory / "history.csv"
    if not path.exists():
        return {}
    with path.open(newline="") as file:
        return {float(row["time"]): row for row in csv.DictReader(file)}


def compare_damage(name, found, row):
    """Faults in the range of damage of an interface at an instant of the history."""
    for end, value in zip(("min", "max"), found):
        expected = row.get(f"{name}.damage.{end}")
        if expected and not math.isclose(value, float(expected), rel_tol=TOLERANCE, abs_tol=TOLERANCE):
            yield f"damage {end} {value!r}, history.csv has {expected}"


def main(arguments):
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        print(__doc__, file=sys.stderr)
        return 2
    directory = Path(arguments[0])
    history = read_history(directory)
    fields = directory / "fields" if (directory / "fields").is_dir() else directory
    files, faults = {}, []
    for series in sorted(fields.glob("*.series")):
        name = series.name[: -len(".vtkhdf.series")]
        for entry in json.loads(series.read_text())["files"]:
            try:
                found = summary(fields / entry["name"], entry["time"])
            except ValueError as fault:
                faults.append(f"{entry['name']}: {fault}")
                continue
            files[entry["name"]] = found
            damage, row = found["arrays"].get("damage"), history.get(entry["time"])
            if damage and row and name != "bulk":
                faults += [f"{entry['name']}: {fault}" for fault in compare_damage(name, damage, row)]
    if not files:
        faults.append(f"{fields}: no series names a readable file")
    print(json.dumps(files, indent=1))
    for fault in faults:
        print(fault, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
