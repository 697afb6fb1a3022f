/* One linear elastic solve with plain PETSc: the bound that a general program is measured against.
 *
 *     mpirun -n 2 raw_elastic -n 16 -solver boomeramg
 *
 * Column of 1 x 1 x 5 m, n x n x 5n hexahedra with 2 x 2 x 2 Gauss points, E = 5.8e9; bottom held, every
 * component prescribed on top. Options (all others go to PETSc):
 *   -n 8 | -cells nx,ny,nz    -nu 0.3    -top 1e-3,0,1.7e-3    -solver boomeramg|gamg|mumps
 *   -blocked         MatSetValuesBlocked in place of MatSetValues
 *   -assembly_only   assembles three times, does not solve, prints the best speed
 *   -triad           measures the memory bandwidth of all ranks together after the run
 * Prints one line of JSON. Each time is that of the slowest rank. */
#include <petscksp.h>
#include <sys/resource.h>

#include "raw_common.h"
#include "raw_hex.h"

/* Held nodes keep their block of rows, with the identity on the diagonal: exact counts for that. */
static PetscErrorCode matrix_create(const Mesh *m, Mat *matrix)
{
    const PetscInt rows = m->plane * (m->end - m->first), nx = m->cells[0], ny = m->cells[1], nz = m->cells[2];
    PetscInt *inside, *outside, row = 0;
    PetscFunctionBeginUser;
    PetscCall(PetscMalloc2(rows, &inside, rows, &outside));
    for (PetscInt k = m->first; k < m->end; k++)
        for (PetscInt j = 0; j <= ny; j++)
            for (PetscInt i = 0; i <= nx; i++, row++) {
                const PetscInt across = (1 + (i > 0) + (i < nx)) * (1 + (j > 0) + (j < ny));
                inside[row] = outside[row] = 0;
                if (k == 0 || k == nz) {
                    inside[row] = 1;
                    continue;
                }
                for (PetscInt l = PetscMax(k - 1, 1); l <= PetscMin(k + 1, nz - 1); l++)
                    *(l >= m->first && l < m->end ? &inside[row] : &outside[row]) += across;
            }
    PetscCall(MatCreate(PETSC_COMM_WORLD, matrix));
    PetscCall(MatSetSizes(*matrix, 3 * rows, 3 * rows, PETSC_DETERMINE, PETSC_DETERMINE));
    PetscCall(MatSetBlockSize(*matrix, 3));
    PetscCall(MatSetType(*matrix, MATAIJ));
    PetscCall(MatSetFromOptions(*matrix));
    PetscCall(MatXAIJSetPreallocation(*matrix, 3, inside, outside, NULL, NULL));
    PetscCall(MatSetOption(*matrix, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_TRUE));
    PetscCall(MatSetOption(*matrix, MAT_SPD, PETSC_TRUE));
    PetscCall(PetscFree2(inside, outside));
    PetscFunctionReturn(0);
}

/* Prescribed values leave the matrix cell by cell, symmetrically: PETSc skips negative indices, and what they
 * would have contributed goes to the right-hand side. `held` becomes this rank's part of g.Kg, with g the prescribed
 * values: the part of the energy that the eliminated matrix no longer knows. */
static PetscErrorCode assemble(const Mesh *m, const Problem *p, Mat matrix, Vec load, PetscReal *held)
{
    const PetscInt top = m->plane * m->cells[2];
    PetscScalar ke[24][24], force[24];
    PetscInt node[8], dof[24];
    PetscFunctionBeginUser;
    *held = 0;
    PetscCall(VecSet(load, 0.0));
    for (PetscInt e = 0; e < m->elements; e++) {
        element_matrix(m, p, m->nodes[e], ke);
        PetscBool lifted = PETSC_FALSE;
        for (int a = 0; a < 8; a++) {
            const PetscInt id = m->nodes[e][a];
            const PetscBool fixed = id < m->plane || id >= top;
            lifted = lifted || id >= top;
            node[a] = fixed ? -1 : id;
            for (int i = 0; i < 3; i++) dof[3 * a + i] = fixed ? -1 : 3 * id + i;
        }
        if (p->blocked) PetscCall(MatSetValuesBlocked(matrix, 8, node, 8, node, &ke[0][0], ADD_VALUES));
        else PetscCall(MatSetValues(matrix, 24, dof, 24, dof, &ke[0][0], ADD_VALUES));
        if (!lifted) continue;
        for (int r = 0; r < 24; r++) {
            force[r] = 0;
            for (int b = 4; b < 8; b++)
                for (int i = 0; i < 3; i++) force[r] -= ke[r][3 * b + i] * p->top[i];
            if (r >= 12) *held -= force[r] * p->top[r % 3];
        }
        PetscCall(VecSetValues(load, 24, dof, force, ADD_VALUES));
    }
    const PetscScalar one[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (PetscInt k = m->first; k < m->end; k++)
        if (k == 0 || k == m->cells[2])
            for (PetscInt id = m->plane * k; id < m->plane * (k + 1); id++)
                PetscCall(MatSetValuesBlocked(matrix, 1, &id, 1, &id, one, ADD_VALUES));
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(VecAssemblyBegin(load));
    PetscCall(VecAssemblyEnd(load));
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(0);
}

static PetscErrorCode solver_create(const Mesh *m, Mat matrix, const char *name, KSP *ksp)
{
    static const char *const mumps[][2] = {{"-ksp_type", "preonly"},
                                           {"-pc_type", "cholesky"},
                                           {"-pc_factor_mat_solver_type", "mumps"},
                                           {NULL, NULL}};
    PetscFunctionBeginUser;
    PetscCall(KSPCreate(PETSC_COMM_WORLD, ksp));
    PetscCall(KSPSetOperators(*ksp, matrix, matrix));
    PetscCall(KSPSetErrorIfNotConverged(*ksp, PETSC_TRUE));
    if (!strcmp(name, "mumps")) {
        PetscCall(defaults(mumps));
    } else {
        PetscCall(KSPSetType(*ksp, KSPCG));
        PetscCall(KSPSetNormType(*ksp, KSP_NORM_UNPRECONDITIONED));
        PetscCall(KSPSetTolerances(*ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
        if (!strcmp(name, "boomeramg")) PetscCall(defaults(boomeramg));
        else if (!strcmp(name, "gamg")) {
            Vec coordinates;
            MatNullSpace modes;
            const PetscInt local = 3 * m->plane * (m->end - m->first);
            PetscCall(defaults(gamg));
            PetscCall(VecCreateMPIWithArray(PETSC_COMM_WORLD, 3, local, PETSC_DETERMINE, m->x, &coordinates));
            PetscCall(MatNullSpaceCreateRigidBody(coordinates, &modes));
            PetscCall(MatSetNearNullSpace(matrix, modes));
            PetscCall(MatNullSpaceDestroy(&modes));
            PetscCall(VecDestroy(&coordinates));
        } else SETERRQ(PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "-solver boomeramg|gamg|mumps, not %s", name);
    }
    PetscCall(KSPSetFromOptions(*ksp));
    PetscCall(KSPSetUp(*ksp));
    PetscFunctionReturn(0);
}

/* Best of several passes over arrays that no cache holds; three numbers are moved per entry. */
static double triad(void)
{
    PetscMPIInt size;
    MPI_Comm_size(PETSC_COMM_WORLD, &size);
    const size_t n = 40000000 / size;
    double *a = malloc(n * sizeof *a), *b = malloc(n * sizeof *b), *c = malloc(n * sizeof *c), best = 1e30;
    if (!a || !b || !c) MPI_Abort(PETSC_COMM_WORLD, 4);
    for (size_t i = 0; i < n; i++) a[i] = 0, b[i] = 1, c[i] = i;
    for (int pass = 0; pass < 8; pass++) {
        MPI_Barrier(PETSC_COMM_WORLD);
        const double t = now();
        for (size_t i = 0; i < n; i++) a[i] = b[i] + 3.0 * c[i];
        best = PetscMin(best, slowest(now() - t));
        b[pass] = a[pass + 1]; /* the passes must differ, or the compiler keeps only one */
    }
    free(a), free(b), free(c);
    return 3.0 * sizeof(double) * n * size / best / 1e9;
}

int main(int argc, char **argv)
{
    const double start = now();
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    const double init_s = slowest(now() - start);

    Mesh mesh;
    Problem problem = {.top = {1e-3, 0.0, 1.7e-3}};
    PetscInt n = 8, three = 3, its = 0;
    PetscReal nu = 0.3;
    char solver[32] = "boomeramg";
    PetscBool given, only = PETSC_FALSE, with_triad = PETSC_FALSE;
    PetscCall(PetscOptionsGetInt(NULL, NULL, "-n", &n, NULL));
    mesh.cells[0] = mesh.cells[1] = n, mesh.cells[2] = 5 * n;
    PetscCall(PetscOptionsGetIntArray(NULL, NULL, "-cells", mesh.cells, &three, &given));
    PetscCheck(!given || three == 3, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "-cells nx,ny,nz");
    three = 3;
    PetscCall(PetscOptionsGetRealArray(NULL, NULL, "-top", problem.top, &three, &given));
    PetscCheck(!given || three == 3, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "-top x,y,z");
    PetscCall(PetscOptionsGetReal(NULL, NULL, "-nu", &nu, NULL));
    PetscCall(PetscOptionsGetString(NULL, NULL, "-solver", solver, sizeof solver, NULL));
    PetscCall(PetscOptionsGetBool(NULL, NULL, "-blocked", &problem.blocked, NULL));
    PetscCall(PetscOptionsGetBool(NULL, NULL, "-assembly_only", &only, NULL));
    PetscCall(PetscOptionsGetBool(NULL, NULL, "-triad", &with_triad, NULL));
    problem.lambda = YOUNG * nu / ((1 + nu) * (1 - 2 * nu));
    problem.mu = YOUNG / (2 * (1 + nu));

    double t = now();
    PetscCall(mesh_create(&mesh));
    const double mesh_s = slowest(now() - t);

    Mat matrix;
    Vec u, load, product;
    PetscReal held, free_energy;
    t = now();
    reference_create();
    PetscCall(matrix_create(&mesh, &matrix));
    PetscCall(MatCreateVecs(matrix, &u, &load));
    PetscCall(VecSetOption(load, VEC_IGNORE_NEGATIVE_INDICES, PETSC_TRUE));
    double best = 1e30;
    for (int pass = 0; pass < (only ? 3 : 1); pass++) {
        const double t0 = now();
        if (pass > 0) PetscCall(MatZeroEntries(matrix));
        PetscCall(assemble(&mesh, &problem, matrix, load, &held));
        best = PetscMin(best, slowest(now() - t0));
    }
    const double assembly_s = slowest(now() - t);

    double setup_s = 0, solve_s = 0, energy = 0;
    KSP ksp = NULL;
    if (!only) {
        t = now();
        PetscCall(solver_create(&mesh, matrix, solver, &ksp));
        setup_s = slowest(now() - t);
        t = now();
        PetscCall(KSPSolve(ksp, load, u));
        solve_s = slowest(now() - t);
    }
    const double total_s = slowest(now() - start);

    PetscMPIInt rank, size;
    struct rusage usage;
    double bytes, memory;
    PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
    PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
    getrusage(RUSAGE_SELF, &usage);
    bytes = 1024.0 * usage.ru_maxrss;
    PetscCallMPI(MPI_Reduce(&bytes, &memory, 1, MPI_DOUBLE, MPI_SUM, 0, PETSC_COMM_WORLD));

    PetscInt unknowns;
    PetscCall(MatGetSize(matrix, &unknowns, NULL));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "{\"n\":[%d,%d,%d],\"unknowns\":%d,\"ranks\":%d", (int)mesh.cells[0],
                          (int)mesh.cells[1], (int)mesh.cells[2], (int)unknowns, size));
    if (only) {
        PetscCall(PetscPrintf(PETSC_COMM_WORLD, ",\"blocked\":%s,\"assembly_s\":%.6f,\"assembly_kdof_per_s\":%.1f",
                              problem.blocked ? "true" : "false", best, 1e-3 * unknowns / best));
    } else {
        /* With g the prescribed values and u the free ones, 2W = u.Ku + 2 u.Kg + g.Kg, and the load is -Kg. */
        PetscScalar quadratic, linear;
        PetscCall(KSPGetIterationNumber(ksp, &its));
        PetscCall(VecDuplicate(u, &product));
        PetscCall(MatMult(matrix, u, product));
        PetscCall(VecDot(u, product, &quadratic));
        PetscCall(VecDot(u, load, &linear));
        PetscCallMPI(MPI_Allreduce(&held, &free_energy, 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
        energy = 0.5 * (quadratic - 2 * linear + free_energy);
        PetscCall(VecDestroy(&product));
        PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                              ",\"solver\":\"%s\",\"iterations\":%d,\"energy\":%.12g,\"assembly_s\":%.6f,"
                              "\"setup_s\":%.6f,\"solve_s\":%.6f",
                              solver, (int)its, energy, assembly_s, setup_s, solve_s));
    }
    PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                          ",\"init_s\":%.6f,\"mesh_s\":%.6f,\"total_s\":%.6f,\"peak_memory_bytes\":%.0f",
                          init_s, mesh_s, total_s, memory));
    if (with_triad) PetscCall(PetscPrintf(PETSC_COMM_WORLD, ",\"stream_triad_gbs\":%.2f", triad()));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "}\n"));

    PetscCall(KSPDestroy(&ksp));
    PetscCall(MatDestroy(&matrix));
    PetscCall(VecDestroy(&u));
    PetscCall(VecDestroy(&load));
    PetscCall(PetscFree2(mesh.x, mesh.nodes));
    PetscCall(PetscFinalize());
    return 0;
}
