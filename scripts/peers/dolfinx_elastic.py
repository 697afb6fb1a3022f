#!/usr/bin/env python3
"""One elastic solve of the column of raw_elastic.c with dolfinx 0.5 (Debian: python3-dolfinx-real).

    mpirun -n 2 /usr/bin/python3 dolfinx_elastic.py -n 16 --solver boomeramg|gamg|mumps

Prints one line of JSON. `jit_s` is the compilation of the forms, short when they are in dolfinx's cache (their
names are not quite stable from run to run): no part of `run_s` and `total_s`.
"""
import time

START = time.perf_counter()

import argparse
import json
import logging
import resource
import sys

import numpy as np
import ufl
from dolfinx import fem, la, mesh
from dolfinx.fem.petsc import apply_lifting, assemble_matrix, create_matrix, set_bc
from mpi4py import MPI
from petsc4py import PETSc

SIZE = (1.0, 1.0, 5.0)
YOUNG = 5.8e9
SOLVERS = {
    "boomeramg": {
        "pc_type": "hypre",
        "pc_hypre_type": "boomeramg",
        "pc_hypre_boomeramg_strong_threshold": 0.5,
        "pc_hypre_boomeramg_agg_nl": 1,
        "pc_hypre_boomeramg_relax_type_all": "Chebyshev",
    },
    "gamg": {
        "pc_type": "gamg",
        "pc_gamg_threshold": 0.02,
        "pc_gamg_agg_nsmooths": 1,
        "mg_levels_ksp_type": "chebyshev",
        "mg_levels_pc_type": "jacobi",
    },
    "mumps": {"ksp_type": "preonly", "pc_type": "cholesky", "pc_factor_mat_solver_type": "mumps"},
}
# The generated kernels are plain C: without these they are compiled at -O2 for any processor.
JIT = {"cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math"], "cffi_libraries": ["m"]}


def column(comm, cells):
    return mesh.create_box(
        comm, [np.zeros(3), np.array(SIZE)], cells, mesh.CellType.hexahedron, ghost_mode=mesh.GhostMode.none
    )


class Forms:
    """The compiled forms of one mesh."""

    def __init__(self, space, nu):
        domain = space.mesh
        lame = YOUNG * nu / ((1 + nu) * (1 - 2 * nu))
        shear = YOUNG / (2 * (1 + nu))
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
        dx = ufl.Measure("dx", domain, metadata={"quadrature_degree": 2})
        self.solution = fem.Function(space)

        def stress(w):
            return lame * ufl.div(w) * ufl.Identity(3) + 2 * shear * ufl.sym(ufl.grad(w))

        def product(w, z):
            return ufl.inner(stress(w), ufl.sym(ufl.grad(z))) * dx

        self.stiffness = fem.form(product(u, v), jit_params=JIT)
        self.energy = fem.form(0.5 * product(self.solution, self.solution), jit_params=JIT)


def displacements(domain):
    return fem.VectorFunctionSpace(domain, ("Lagrange", 1))


def held(space, z, value):
    facets = mesh.locate_entities_boundary(space.mesh, 2, lambda x: np.isclose(x[2], z))
    return fem.dirichletbc(np.array(value), fem.locate_dofs_topological(space, 2, facets), space)


def rigid_modes(space):
    x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    coordinates = PETSc.Vec().createWithArray(np.ascontiguousarray(x).ravel(), bsize=3, comm=space.mesh.comm)
    return PETSc.NullSpace().createRigidBody(coordinates)


def make_solver(matrix, space, name):
    solver = PETSc.KSP().create(matrix.comm)
    solver.setOptionsPrefix("peer_")
    options = PETSc.Options("peer_")
    for key, value in SOLVERS[name].items():
        options[key] = value
    matrix.setOption(PETSc.Mat.Option.SPD, True)
    if name == "gamg":
        matrix.setNearNullSpace(rigid_modes(space))
    solver.setOperators(matrix)
    solver.setType("cg")
    if name != "mumps":
        solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        solver.setTolerances(rtol=1e-8, max_it=1000)
    solver.setErrorIfNotConverged(True)
    solver.setFromOptions()
    solver.setUp()
    return solver


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("-n", type=int, default=8, help="n x n x 5n cells")
    arguments.add_argument("--solver", choices=SOLVERS, default="boomeramg")
    arguments.add_argument("--nu", type=float, default=0.3)
    arguments.add_argument("--top", type=float, nargs=3, default=[1e-3, 0.0, 1.7e-3])
    given = arguments.parse_args()
    logging.disable(logging.INFO)  # of the compiler
    comm = MPI.COMM_WORLD
    clock, seconds = time.perf_counter, {}

    def lap(name):
        nonlocal mark
        seconds[name] = seconds.get(name, 0.0) + comm.allreduce(clock() - mark, op=MPI.MAX)
        mark = clock()

    mark = START
    lap("import_s")
    # Compiles the element apart from the numbering of the unknowns of the real mesh.
    if comm.rank == 0:
        displacements(column(MPI.COMM_SELF, [1, 1, 1]))
    lap("jit_s")
    cells = [given.n, given.n, 5 * given.n]
    space = displacements(column(comm, cells))
    lap("mesh_s")
    forms = Forms(space, given.nu)
    lap("jit_s")
    bcs = [held(space, 0.0, [0.0, 0.0, 0.0]), held(space, SIZE[2], given.top)]
    matrix = create_matrix(forms.stiffness)
    load = la.create_petsc_vector(space.dofmap.index_map, 3)
    assemble_matrix(matrix, forms.stiffness, bcs=bcs)
    matrix.assemble()
    with load.localForm() as local:
        local.set(0.0)
    apply_lifting(load, [forms.stiffness], [bcs])
    load.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    # The held rows are solved for zero and filled in later, so that they do not enter the norm of the residual.
    set_bc(load, bcs, scale=0.0)
    lap("assembly_s")
    solver = make_solver(matrix, space, given.solver)
    lap("setup_s")
    solver.solve(load, forms.solution.vector)
    set_bc(forms.solution.vector, bcs)
    forms.solution.x.scatter_forward()
    lap("solve_s")
    run = sum(seconds[name] for name in ("mesh_s", "assembly_s", "setup_s", "solve_s"))
    memory = comm.reduce(1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    energy = comm.allreduce(fem.assemble_scalar(forms.energy))
    if comm.rank == 0:
        report = {
            "n": cells,
            "unknowns": matrix.size[0],
            "ranks": comm.size,
            "solver": given.solver,
            "iterations": solver.its,
            "energy": energy,
            **{key: round(value, 6) for key, value in seconds.items()},
            "run_s": round(run, 6),
            "total_s": round(seconds["import_s"] + run, 6),
            "peak_memory_bytes": memory,
        }
        json.dump(report, sys.stdout, separators=(",", ":"))
        print()


if __name__ == "__main__":
    main()
