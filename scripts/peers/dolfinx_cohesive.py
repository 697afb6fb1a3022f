#!/usr/bin/env python3
"""The cohesive problem WTNV146 with dolfinx 0.5 and a penalty law (Debian: python3-dolfinx-real).

    mpirun -n 2 /usr/bin/python3 dolfinx_cohesive.py -n 8

dolfinx 0.5 can neither break a mesh nor restrict a field to a part of it: two fields live on the whole mesh, one
for each half, and the unknowns of the half that a field does not own are held at zero. Initial stiffness K0
in place of exact adherence: errors of about 1.6e9 / K0. Matrix, residual and MUMPS LU are redone in every iteration.
Prints one line of JSON. `jit_s` is the compilation of the forms, short when they are in dolfinx's cache (their
names are not quite stable from run to run): no part of the other times.
"""
import argparse
import json
import logging
import resource
import sys
import time

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import apply_lifting, assemble_matrix, assemble_vector, create_matrix, create_vector, set_bc
from mpi4py import MPI
from petsc4py import PETSc

SIZE = (1.0, 1.0, 5.0)
YOUNG, STRENGTH, TOUGHNESS = 5.8e9, 1.1e6, 900.0
OPENING = 2 * TOUGHNESS / STRENGTH
# Prescribed u_x and u_z on top, and the exact normal traction, instant by instant.
INSTANTS = [
    (0.0, -1.0e-4, -116000.0),
    (0.0, 1.0e-4, 116000.0),
    (0.0, 1.0e-3, 1017312.0728929382),
    (0.0, 5.0e-4, 508656.0364464691),
    (0.0, 1.2e-3, 697585.4214123009),
    (0.0, 1.7e-3, 0.0),
    (1.0e-3, 1.7e-3, 0.0),
    (0.0, -1.0e-4, -116000.0),
]


def column(comm, cells):
    return mesh.create_box(
        comm, [np.zeros(3), np.array(SIZE)], cells, mesh.CellType.hexahedron, ghost_mode=mesh.GhostMode.shared_facet
    )


def two_fields(domain):
    vector = ufl.VectorElement("Lagrange", domain.ufl_cell(), 1)
    space = fem.FunctionSpace(domain, ufl.MixedElement(vector, vector))
    return space, [space.sub(half).collapse() for half in range(2)]


def traction(jump, history, stiffness):
    """Linear softening with secant unloading, contact with the initial stiffness."""
    start = STRENGTH / stiffness
    opening = ufl.max_value(jump[2], 0.0)
    # The tiny number keeps the derivative of the root finite at rest.
    equivalent = ufl.sqrt(opening**2 + jump[0] ** 2 + jump[1] ** 2 + 1e-40)
    # At the last converged point round-off must not choose the softening branch: most steps begin there.
    largest = ufl.conditional(ufl.gt(equivalent, (1 + 1e-9) * history), equivalent, history)
    strength = STRENGTH * (1 - (largest - start) / (OPENING - start))
    secant = ufl.conditional(ufl.lt(largest, OPENING), strength / largest, 0.0)
    normal = ufl.conditional(ufl.lt(jump[2], 0.0), stiffness * jump[2], secant * jump[2])
    return ufl.as_vector([secant * jump[0], secant * jump[1], normal])


class Model:
    """Spaces, compiled forms and boundary conditions on one mesh."""

    def __init__(self, domain, nu, stiffness):
        self.space, self.halves = two_fields(domain)
        self.u = fem.Function(self.space)
        # A vector of which one component serves: it is then numbered as the displacements are.
        self.history = fem.Function(self.halves[0][0])
        self.start = STRENGTH / stiffness
        self.history.x.array[:] = self.start

        middle = 0.5 * SIZE[2]
        beside = [
            mesh.locate_entities(domain, 3, lambda x: x[2] < middle + 1e-8),
            mesh.locate_entities(domain, 3, lambda x: x[2] > middle - 1e-8),
        ]
        cells = np.concatenate(beside)
        marks = np.repeat(np.array([1, 2], np.int32), [len(part) for part in beside])
        order = np.argsort(cells)
        sides = mesh.meshtags(domain, 3, cells[order], marks[order])
        facets = np.sort(mesh.locate_entities(domain, 2, lambda x: np.isclose(x[2], middle)))
        joint = mesh.meshtags(domain, 2, facets, np.ones(len(facets), np.int32))
        rule = {"quadrature_degree": 2}
        dx = ufl.Measure("dx", domain, subdomain_data=sides, metadata=rule)
        ds = ufl.Measure("dS", domain, subdomain_data=joint, metadata=rule)(1)

        lame, shear = YOUNG * nu / ((1 + nu) * (1 - 2 * nu)), YOUNG / (2 * (1 + nu))

        def work(u, v):
            stress = lame * ufl.div(u) * ufl.Identity(3) + 2 * shear * ufl.sym(ufl.grad(u))
            return ufl.inner(stress, ufl.sym(ufl.grad(v)))

        lower, upper = ufl.split(self.u)
        to_lower, to_upper = ufl.TestFunctions(self.space)
        # Either field goes through the joint without a jump: one side of the facet will do for both.
        force = traction((upper - lower)("+"), self.history("+")[0], stiffness)
        residual = work(lower, to_lower) * dx(1) + work(upper, to_upper) * dx(2)
        residual += ufl.inner(force, (to_upper - to_lower)("+")) * ds
        tangent = ufl.derivative(residual, self.u, ufl.TrialFunction(self.space))
        mark = time.perf_counter()
        self.residual, self.tangent = fem.form(residual), fem.form(tangent)
        self.normal_force, self.shear_force = fem.form(force[2] * ds), fem.form(force[0] * ds)
        self.jit_s = time.perf_counter() - mark

        self.top_value = fem.Function(self.halves[1][0])
        zero = [fem.Function(space) for space, _ in self.halves]
        self.bcs = [self.held(0, 0.0, zero[0]), self.held(1, SIZE[2], self.top_value)]
        for half, (space, numbers) in enumerate(self.halves):
            sub = self.space.sub(half)
            active = fem.locate_dofs_topological((sub, space), 3, beside[half])
            idle = np.setdiff1d(np.arange(len(numbers), dtype=np.int32), active[1])
            dofs = [np.asarray(numbers, np.int32)[idle], idle]
            self.bcs.append(fem.dirichletbc(zero[half], dofs, sub))

    def held(self, half, z, value):
        domain, sub = self.space.mesh, self.space.sub(half)
        facets = mesh.locate_entities_boundary(domain, 2, lambda x: np.isclose(x[2], z))
        return fem.dirichletbc(value, fem.locate_dofs_topological((sub, self.halves[half][0]), 2, facets), sub)

    def prescribe(self, x, z):
        self.top_value.x.array[0::3] = x
        self.top_value.x.array[2::3] = z

    def solve(self, tolerance, limit):
        """Newton's method: the number of iterations."""
        u, bcs = self.u, self.bcs
        matrix, right, step = create_matrix(self.tangent), create_vector(self.residual), u.vector.duplicate()
        solver = PETSc.KSP().create(self.space.mesh.comm)
        solver.setOperators(matrix)
        solver.setType("preonly")
        solver.getPC().setType("lu")
        solver.getPC().setFactorSolverType("mumps")
        solver.setErrorIfNotConverged(True)
        for iteration in range(limit + 1):
            with right.localForm() as local:
                local.set(0.0)
            assemble_vector(right, self.residual)
            if iteration == 0:
                matrix.zeroEntries()
                assemble_matrix(matrix, self.tangent, bcs=bcs)
                matrix.assemble()
                apply_lifting(right, [self.tangent], [bcs], x0=[u.vector], scale=-1.0)
            right.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
            set_bc(right, bcs, u.vector, -1.0)
            if iteration > 0:
                if right.norm() <= tolerance:
                    break
                matrix.zeroEntries()
                assemble_matrix(matrix, self.tangent, bcs=bcs)
                matrix.assemble()
            solver.solve(right, step)
            u.vector.axpy(-1.0, step)
            u.x.scatter_forward()
        else:
            raise RuntimeError(f"no convergence in {limit} iterations: residual {right.norm():.3e} N")
        for thing in (solver, matrix, right, step):
            thing.destroy()
        return iteration

    def mean_tractions(self):
        comm, area = self.space.mesh.comm, SIZE[0] * SIZE[1]
        forms = (self.normal_force, self.shear_force)
        return [comm.allreduce(fem.assemble_scalar(form)) / area for form in forms]

    def accept(self):
        """Makes the converged jumps history: nodal values, so that dolfinx needs no storage on facets."""
        fields = [self.u.x.array[numbers].reshape(-1, 3) for _, numbers in self.halves]
        jump = fields[1] - fields[0]
        jump[:, 2] = np.maximum(jump[:, 2], 0.0)
        largest = np.minimum(np.linalg.norm(jump, axis=1), OPENING)
        self.history.x.array[:] = np.maximum(self.history.x.array, np.repeat(largest, 3))


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("-n", type=int, default=8, help="n x n x 5n cells, n even")
    arguments.add_argument("--cells", type=int, nargs=3, help="in place of -n; the last one even")
    arguments.add_argument("--stiffness", type=float, default=1e13, help="K0 in Pa/m")
    arguments.add_argument("--nu", type=float, default=0.0, help="the exact tractions hold for 0 only")
    given = arguments.parse_args()
    cells = given.cells or [given.n, given.n, 5 * given.n]
    if cells[2] % 2:
        arguments.error("the interface must lie between two layers of cells")
    logging.disable(logging.INFO)  # of the compiler
    comm, clock = MPI.COMM_WORLD, time.perf_counter

    mark = clock()
    # Compiles the elements apart from the numbering of the unknowns of the real mesh.
    if comm.rank == 0:
        two_fields(column(MPI.COMM_SELF, [1, 1, 2]))
    comm.barrier()
    jit, mark = clock() - mark, clock()
    model = Model(column(comm, cells), given.nu, given.stiffness)
    comm.barrier()
    meshing, mark = clock() - mark - model.jit_s, clock()
    iterations, tractions, errors, shear = [], [], [], 0.0
    for x, z, exact in INSTANTS:
        model.prescribe(x, z)
        iterations.append(model.solve(tolerance=1e-8 * STRENGTH * SIZE[0] * SIZE[1], limit=50))
        normal, tangential = model.mean_tractions()
        tractions.append(normal)
        # Broken, the interface carries nothing: the strength is the scale.
        errors.append(abs(normal - exact) / (abs(exact) or STRENGTH))
        shear = max(shear, abs(tangential))
        model.accept()
    solve = clock() - mark
    memory = comm.reduce(1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    if comm.rank == 0:
        report = {
            "n": cells,
            "unknowns": model.space.dofmap.index_map.size_global * model.space.dofmap.index_map_bs,
            "ranks": comm.size,
            "solver": "mumps",
            "stiffness": given.stiffness,
            "iterations": iterations,
            "tractions": tractions,
            "largest_error": max(errors) if given.nu == 0 else None,
            "largest_shear_traction": shear,
            "jit_s": round(jit + model.jit_s, 6),
            "mesh_s": round(meshing, 6),
            "solve_s": round(solve, 6),
            "run_s": round(meshing + solve, 6),
            "peak_memory_bytes": memory,
        }
        json.dump(report, sys.stdout, separators=(",", ":"))
        print()


if __name__ == "__main__":
    main()
