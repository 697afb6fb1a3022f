/* One linear elastic solve of any mesh with plain PETSc: the bound for meshes from files.
 *
 *     mpirun -n 2 raw_mesh -mesh column.cells -solver gamg
 *
 * The mesh is written by scripts/bench_files.py: four 32-bit numbers (nodes per cell, nodes, cells, 0), then
 * the points (3 doubles each), the nodes of the cells (32 bits, VTK's order), one byte per node (1 held, 2 moved).
 * Hexahedra of 8 nodes with 2 x 2 x 2 Gauss points, straight tetrahedra of 10 with 4. E = 5.8e9, nu = 0.3.
 * -solver boomeramg|gamg; all other options go to PETSc. Ranks own runs of nodes: they are sorted by height.
 * Prints one line of JSON. Each time is that of the slowest rank. */
#include <petscksp.h>
#include <stdio.h>
#include <sys/resource.h>

#include "raw_common.h"

static const PetscReal YOUNG = 5.8e9, NU = 0.3;
enum { MOST = 10 };

typedef struct {
    int per_cell, nodes, cells;
    double *x;
    int *cell;
    unsigned char *held;
} Mesh;

typedef struct {
    int points;
    double weight[8], slope[8][3][MOST];
} Rule;

static PetscErrorCode mesh_read(const char *path, Mesh *m)
{
    int head[4];
    size_t read = 0;
    PetscFunctionBeginUser;
    FILE *file = fopen(path, "rb");
    PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s", path);
    PetscCheck(fread(head, sizeof head, 1, file) == 1, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "%s", path);
    m->per_cell = head[0], m->nodes = head[1], m->cells = head[2];
    const size_t connected = (size_t)m->per_cell * m->cells;
    PetscCall(PetscMalloc3(3 * (size_t)m->nodes, &m->x, connected, &m->cell, m->nodes, &m->held));
    read += fread(m->x, sizeof *m->x, 3 * (size_t)m->nodes, file);
    read += fread(m->cell, sizeof *m->cell, connected, file);
    read += fread(m->held, 1, m->nodes, file);
    fclose(file);
    PetscCheck(read == 4 * (size_t)m->nodes + connected, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "%s", path);
    PetscFunctionReturn(0);
}

static void rule_of_cube(Rule *rule)
{
    static const int side[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                   {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    rule->points = 8;
    for (int q = 0; q < 8; q++) {
        rule->weight[q] = 1;
        for (int a = 0; a < 8; a++)
            for (int i = 0; i < 3; i++) {
                double v = 0.125;
                for (int k = 0; k < 3; k++) v *= k == i ? side[a][k] : 1 + side[a][k] * side[q][k] / PetscSqrtReal(3);
                rule->slope[q][i][a] = v;
            }
    }
}

static void rule_of_simplex(Rule *rule)
{
    static const int ends[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    static const double slope[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double far = (5 + 3 * PetscSqrtReal(5)) / 20, near = (5 - PetscSqrtReal(5)) / 20;
    rule->points = 4;
    for (int q = 0; q < 4; q++) {
        double l[4];
        for (int a = 0; a < 4; a++) l[a] = a == q ? far : near;
        rule->weight[q] = 1.0 / 24;
        for (int i = 0; i < 3; i++) {
            for (int a = 0; a < 4; a++) rule->slope[q][i][a] = (4 * l[a] - 1) * slope[a][i];
            for (int e = 0; e < 6; e++) {
                const int a = ends[e][0], b = ends[e][1];
                rule->slope[q][i][4 + e] = 4 * (l[a] * slope[b][i] + l[b] * slope[a][i]);
            }
        }
    }
}

static void element_matrix(const Mesh *m, const Rule *rule, const int *node, PetscScalar *ke)
{
    const int n = m->per_cell, size = 3 * n;
    const double lambda = YOUNG * NU / ((1 + NU) * (1 - 2 * NU)), mu = YOUNG / (2 * (1 + NU));
    double h[3][3][MOST][MOST] = {0};
    for (int q = 0; q < rule->points; q++) {
        double jac[3][3] = {0}, inv[3][3], g[3][MOST];
        for (int a = 0; a < n; a++)
            for (int i = 0; i < 3; i++)
                for (int k = 0; k < 3; k++) jac[i][k] += rule->slope[q][k][a] * m->x[3 * (size_t)node[a] + i];
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++) {
                const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
                inv[k][i] = jac[i1][k1] * jac[i2][k2] - jac[i1][k2] * jac[i2][k1];
            }
        const double det = jac[0][0] * inv[0][0] + jac[0][1] * inv[1][0] + jac[0][2] * inv[2][0];
        for (int i = 0; i < 3; i++)
            for (int a = 0; a < n; a++) {
                g[i][a] = 0;
                for (int k = 0; k < 3; k++) g[i][a] += rule->slope[q][k][a] * inv[k][i] / det;
            }
        for (int i = 0; i < 3; i++)
            for (int j = i; j < 3; j++)
                for (int a = 0; a < n; a++) {
                    const double scaled = rule->weight[q] * PetscAbsReal(det) * g[i][a];
                    for (int b = 0; b < n; b++) h[i][j][a][b] += scaled * g[j][b];
                }
    }
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            PetscScalar *at = ke + 3 * a * size + 3 * b;
            const double trace = mu * (h[0][0][a][b] + h[1][1][a][b] + h[2][2][a][b]);
            for (int i = 0; i < 3; i++) {
                at[i * size + i] = (lambda + mu) * h[i][i][a][b] + trace;
                for (int j = i + 1; j < 3; j++) {
                    at[i * size + j] = lambda * h[i][j][a][b] + mu * h[i][j][b][a];
                    at[j * size + i] = lambda * h[i][j][b][a] + mu * h[i][j][a][b];
                }
            }
        }
}

/* Cells around each node of this rank: those of row r are around[start[r]] to around[start[r + 1]]. */
static PetscErrorCode stars(const Mesh *m, PetscInt first, PetscInt end, int **start, int **around)
{
    const size_t connected = (size_t)m->per_cell * m->cells;
    int *filled;
    PetscFunctionBeginUser;
    PetscCall(PetscCalloc1(end - first + 1, start));
    PetscCall(PetscCalloc1(end - first, &filled));
    for (size_t i = 0; i < connected; i++)
        if (m->cell[i] >= first && m->cell[i] < end) (*start)[m->cell[i] - first + 1]++;
    for (PetscInt row = 0; row < end - first; row++) (*start)[row + 1] += (*start)[row];
    PetscCall(PetscMalloc1((*start)[end - first], around));
    for (size_t i = 0; i < connected; i++) {
        const PetscInt row = m->cell[i] - first;
        if (row >= 0 && row < end - first) (*around)[(*start)[row] + filled[row]++] = i / m->per_cell;
    }
    PetscCall(PetscFree(filled));
    PetscFunctionReturn(0);
}

/* Held nodes keep their block of rows, with the identity on the diagonal: exact counts for that. */
static PetscErrorCode matrix_create(const Mesh *m, PetscInt first, PetscInt end, Mat *matrix)
{
    int *start, *around, *seen;
    PetscInt *inside, *outside;
    const PetscInt rows = end - first;
    PetscFunctionBeginUser;
    PetscCall(stars(m, first, end, &start, &around));
    PetscCall(PetscCalloc3(rows, &inside, rows, &outside, m->nodes, &seen));
    for (PetscInt row = 0; row < rows; row++) {
        inside[row] = m->held[first + row] ? 1 : 0;
        if (inside[row]) continue;
        for (int k = start[row]; k < start[row + 1]; k++)
            for (int b = 0; b < m->per_cell; b++) {
                const int node = m->cell[m->per_cell * (size_t)around[k] + b];
                if (seen[node] == row + 1 || m->held[node]) continue;
                seen[node] = row + 1;
                ++*(node >= first && node < end ? &inside[row] : &outside[row]);
            }
    }
    PetscCall(MatCreate(PETSC_COMM_WORLD, matrix));
    PetscCall(MatSetSizes(*matrix, 3 * rows, 3 * rows, PETSC_DETERMINE, PETSC_DETERMINE));
    PetscCall(MatSetBlockSize(*matrix, 3));
    PetscCall(MatSetType(*matrix, MATAIJ));
    PetscCall(MatSetFromOptions(*matrix));
    PetscCall(MatXAIJSetPreallocation(*matrix, 3, inside, outside, NULL, NULL));
    PetscCall(MatSetOption(*matrix, MAT_SPD, PETSC_TRUE));
    PetscCall(PetscFree3(inside, outside, seen));
    PetscCall(PetscFree(around));
    PetscCall(PetscFree(start));
    PetscFunctionReturn(0);
}

/* Prescribed values leave the matrix cell by cell: PETSc skips negative indices, what they would have contributed
 * goes to the right-hand side. A cell is assembled by the rank that owns its first node. `held_energy`: this rank's
 * part of g.Kg, with g the prescribed values. */
static PetscErrorCode assemble(const Mesh *m, PetscInt first, PetscInt end, const PetscReal top[3], Mat matrix, Vec load,
                               PetscReal *held_energy)
{
    const int n = m->per_cell, size = 3 * n;
    PetscScalar ke[9 * MOST * MOST], force[3 * MOST];
    PetscInt node[MOST], dof[3 * MOST];
    Rule rule;
    PetscFunctionBeginUser;
    *held_energy = 0;
    if (n == 8) rule_of_cube(&rule);
    else rule_of_simplex(&rule);
    for (int cell = 0; cell < m->cells; cell++) {
        const int *of_cell = m->cell + (size_t)n * cell;
        if (of_cell[0] < first || of_cell[0] >= end) continue;
        element_matrix(m, &rule, of_cell, ke);
        PetscBool lifted = PETSC_FALSE;
        for (int a = 0; a < n; a++) {
            const unsigned char held = m->held[of_cell[a]];
            lifted = lifted || held == 2;
            node[a] = held ? -1 : of_cell[a];
            for (int i = 0; i < 3; i++) dof[3 * a + i] = held ? -1 : 3 * of_cell[a] + i;
        }
        PetscCall(MatSetValuesBlocked(matrix, n, node, n, node, ke, ADD_VALUES));
        if (!lifted) continue;
        for (int r = 0; r < size; r++) {
            force[r] = 0;
            for (int b = 0; b < n; b++)
                for (int i = 0; i < 3; i++)
                    if (m->held[of_cell[b]] == 2) force[r] -= ke[r * size + 3 * b + i] * top[i];
            if (m->held[of_cell[r / 3]] == 2) *held_energy -= force[r] * top[r % 3];
        }
        PetscCall(VecSetValues(load, size, dof, force, ADD_VALUES));
    }
    const PetscScalar one[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (PetscInt id = first; id < end; id++)
        if (m->held[id]) PetscCall(MatSetValuesBlocked(matrix, 1, &id, 1, &id, one, ADD_VALUES));
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(VecAssemblyBegin(load));
    PetscCall(VecAssemblyEnd(load));
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(0);
}

static PetscErrorCode solver_create(const Mesh *m, PetscInt first, PetscInt end, Mat matrix, const char *name, KSP *ksp)
{
    PetscFunctionBeginUser;
    PetscCheck(!strcmp(name, "gamg") || !strcmp(name, "boomeramg"), PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "-solver boomeramg|gamg, not %s", name);
    PetscCall(KSPCreate(PETSC_COMM_WORLD, ksp));
    PetscCall(KSPSetOperators(*ksp, matrix, matrix));
    PetscCall(KSPSetErrorIfNotConverged(*ksp, PETSC_TRUE));
    PetscCall(KSPSetType(*ksp, KSPCG));
    PetscCall(KSPSetNormType(*ksp, KSP_NORM_UNPRECONDITIONED));
    PetscCall(KSPSetTolerances(*ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
    if (!strcmp(name, "gamg")) {
        Vec coordinates;
        MatNullSpace modes;
        PetscCall(VecCreateMPIWithArray(PETSC_COMM_WORLD, 3, 3 * (end - first), PETSC_DETERMINE,
                                        m->x + 3 * (size_t)first, &coordinates));
        PetscCall(MatNullSpaceCreateRigidBody(coordinates, &modes));
        PetscCall(MatSetNearNullSpace(matrix, modes));
        PetscCall(MatNullSpaceDestroy(&modes));
        PetscCall(VecDestroy(&coordinates));
        PetscCall(defaults(gamg));
    } else {
        PetscCall(defaults(boomeramg));
    }
    PetscCall(KSPSetFromOptions(*ksp));
    PetscCall(KSPSetUp(*ksp));
    PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
    const double start = now();
    PetscReal top[3] = {0, 0, 1e-3};
    PetscInt three = 3, its;
    char solver[32] = "gamg", path[PETSC_MAX_PATH_LEN] = "";
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    PetscCall(PetscOptionsGetRealArray(NULL, NULL, "-top", top, &three, NULL));
    PetscCall(PetscOptionsGetString(NULL, NULL, "-solver", solver, sizeof solver, NULL));
    PetscCall(PetscOptionsGetString(NULL, NULL, "-mesh", path, sizeof path, NULL));

    Mesh mesh;
    PetscMPIInt rank, size;
    PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
    PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
    PetscCall(mesh_read(path, &mesh));
    const PetscInt first = (PetscInt64)mesh.nodes * rank / size, end = (PetscInt64)mesh.nodes * (rank + 1) / size;
    const double mesh_s = slowest(now() - start);

    Mat matrix;
    Vec u, load;
    double held, all_held, t = now();
    PetscCall(matrix_create(&mesh, first, end, &matrix));
    PetscCall(MatCreateVecs(matrix, &u, &load));
    PetscCall(VecSetOption(load, VEC_IGNORE_NEGATIVE_INDICES, PETSC_TRUE));
    PetscCall(assemble(&mesh, first, end, top, matrix, load, &held));
    const double assembly_s = slowest(now() - t);

    KSP ksp;
    t = now();
    PetscCall(solver_create(&mesh, first, end, matrix, solver, &ksp));
    const double setup_s = slowest(now() - t);
    t = now();
    PetscCall(KSPSolve(ksp, load, u));
    const double solve_s = slowest(now() - t), total_s = slowest(now() - start);

    struct rusage usage;
    double bytes, memory;
    PetscScalar quadratic, linear;
    Vec product;
    getrusage(RUSAGE_SELF, &usage);
    bytes = 1024.0 * usage.ru_maxrss;
    PetscCallMPI(MPI_Reduce(&bytes, &memory, 1, MPI_DOUBLE, MPI_SUM, 0, PETSC_COMM_WORLD));
    PetscCall(KSPGetIterationNumber(ksp, &its));
    /* With g the prescribed values and u the free ones, 2W = u.Ku + 2 u.Kg + g.Kg, and the load is -Kg. */
    PetscCall(VecDuplicate(u, &product));
    PetscCall(MatMult(matrix, u, product));
    PetscCall(VecDot(u, product, &quadratic));
    PetscCall(VecDot(u, load, &linear));
    PetscCallMPI(MPI_Allreduce(&held, &all_held, 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
    PetscCall(VecDestroy(&product));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                          "{\"unknowns\":%d,\"ranks\":%d,\"solver\":\"%s\",\"iterations\":%d,\"energy\":%.10g,"
                          "\"mesh_s\":%.4f,\"assembly_s\":%.4f,\"setup_s\":%.4f,\"solve_s\":%.4f,\"total_s\":%.4f,"
                          "\"peak_memory_bytes\":%.0f}\n",
                          3 * mesh.nodes, size, solver, (int)its, 0.5 * (quadratic - 2 * linear + all_held), mesh_s, assembly_s, setup_s, solve_s, total_s,
                          memory));
    PetscCall(KSPDestroy(&ksp));
    PetscCall(MatDestroy(&matrix));
    PetscCall(VecDestroy(&u));
    PetscCall(VecDestroy(&load));
    PetscCall(PetscFree3(mesh.x, mesh.cell, mesh.held));
    PetscCall(PetscFinalize());
    return 0;
}
