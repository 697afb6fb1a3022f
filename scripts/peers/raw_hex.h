/* The column's mesh and the elastic element of raw_elastic.c. */
#pragma once
#include <petscsys.h>
#include <string.h>

static const PetscReal SIZE[3] = {1.0, 1.0, 5.0};
static const PetscReal YOUNG = 5.8e9;

/* A rank owns the planes of nodes [first, end) and the layers of cells that stand on them. */
typedef struct {
    PetscInt cells[3], plane, first, end, layers, elements;
    PetscReal *x;          /* coordinates of the nodes of the rank's cells */
    PetscInt (*nodes)[8];  /* global numbers, ascending, so that rows are filled from left to right */
} Mesh;

typedef struct {
    PetscReal lambda, mu, top[3];
    PetscBool blocked;
} Problem;

static PetscErrorCode mesh_create(Mesh *m)
{
    PetscMPIInt rank, size;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
    PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
    const PetscInt nx = m->cells[0], ny = m->cells[1], nz = m->cells[2];
    PetscCheck(size <= nz, PETSC_COMM_WORLD, PETSC_ERR_ARG_SIZ, "more ranks than layers of cells");
    m->plane = (nx + 1) * (ny + 1);
    m->first = (nz + 1) * (PetscInt64)rank / size;
    m->end = (nz + 1) * (PetscInt64)(rank + 1) / size;
    m->layers = PetscMin(m->end, nz) - m->first;
    m->elements = m->layers * nx * ny;
    PetscCall(PetscMalloc2(3 * m->plane * (m->end - m->first + 1), &m->x, m->elements, &m->nodes));
    PetscReal *x = m->x;
    for (PetscInt k = m->first; k <= PetscMin(m->end, nz); k++)
        for (PetscInt j = 0; j <= ny; j++)
            for (PetscInt i = 0; i <= nx; i++) {
                *x++ = SIZE[0] * i / nx;
                *x++ = SIZE[1] * j / ny;
                *x++ = SIZE[2] * k / nz;
            }
    PetscInt e = 0;
    for (PetscInt k = m->first; k < m->first + m->layers; k++)
        for (PetscInt j = 0; j < ny; j++)
            for (PetscInt i = 0; i < nx; i++, e++)
                for (PetscInt a = 0; a < 8; a++)
                    m->nodes[e][a] = i + (a & 1) + (nx + 1) * (j + (a >> 1 & 1)) + m->plane * (k + (a >> 2));
    PetscFunctionReturn(0);
}

/* Derivatives of the eight shape functions at the Gauss points: the same for every cell. */
static PetscReal reference[8][3][8];

static void reference_create(void)
{
    const PetscReal g = 1.0 / PetscSqrtReal(3.0);
    for (int q = 0; q < 8; q++)
        for (int a = 0; a < 8; a++)
            for (int i = 0; i < 3; i++) {
                PetscReal v = 0.125;
                for (int k = 0; k < 3; k++) {
                    const PetscReal sign = a >> k & 1 ? 1.0 : -1.0, xi = q >> k & 1 ? g : -g;
                    v *= k == i ? sign : 1.0 + sign * xi;
                }
                reference[q][i][a] = v;
            }
}

static void element_matrix(const Mesh *m, const Problem *p, const PetscInt nodes[8], PetscScalar ke[24][24])
{
    PetscReal x[3][8], h[3][3][8][8];
    for (int a = 0; a < 8; a++)
        for (int i = 0; i < 3; i++) x[i][a] = m->x[3 * (nodes[a] - m->first * m->plane) + i];
    memset(h, 0, sizeof h);
    for (int q = 0; q < 8; q++) {
        PetscReal jac[3][3], inv[3][3], g[3][8];
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++) {
                jac[i][k] = 0;
                for (int a = 0; a < 8; a++) jac[i][k] += reference[q][k][a] * x[i][a];
            }
        for (int i = 0; i < 3; i++) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
            for (int k = 0; k < 3; k++) {
                const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
                inv[k][i] = jac[i1][k1] * jac[i2][k2] - jac[i1][k2] * jac[i2][k1];
            }
        }
        const PetscReal det = jac[0][0] * inv[0][0] + jac[0][1] * inv[1][0] + jac[0][2] * inv[2][0];
        for (int i = 0; i < 3; i++)
            for (int a = 0; a < 8; a++)
                g[i][a] = (reference[q][0][a] * inv[0][i] + reference[q][1][a] * inv[1][i] +
                           reference[q][2][a] * inv[2][i]) / det;
        /* h[i][j] = transpose of h[j][i]: six of the nine are enough. */
        for (int i = 0; i < 3; i++)
            for (int j = i; j < 3; j++)
                for (int a = 0; a < 8; a++) {
                    const PetscReal scaled = det * g[i][a];
                    for (int b = 0; b < 8; b++) h[i][j][a][b] += scaled * g[j][b];
                }
    }
    for (int a = 0; a < 8; a++)
        for (int b = 0; b < 8; b++) {
            const PetscReal trace = p->mu * (h[0][0][a][b] + h[1][1][a][b] + h[2][2][a][b]);
            for (int i = 0; i < 3; i++) {
                ke[3 * a + i][3 * b + i] = (p->lambda + p->mu) * h[i][i][a][b] + trace;
                for (int j = i + 1; j < 3; j++) {
                    ke[3 * a + i][3 * b + j] = p->lambda * h[i][j][a][b] + p->mu * h[i][j][b][a];
                    ke[3 * a + j][3 * b + i] = p->lambda * h[i][j][b][a] + p->mu * h[i][j][a][b];
                }
            }
        }
}
