/* What the bare programs have in common: clocks, and their preconditioners. */
#pragma once
#include <petscksp.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static double slowest(double seconds)
{
    double all;
    MPI_Allreduce(&seconds, &all, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
    return all;
}

/* hypre's own defaults are eight times slower here; a near-null space makes it slower still. */
static const char *const boomeramg[][2] = {{"-pc_type", "hypre"},
                                           {"-pc_hypre_type", "boomeramg"},
                                           {"-pc_hypre_boomeramg_strong_threshold", "0.5"},
                                           {"-pc_hypre_boomeramg_agg_nl", "1"},
                                           {"-pc_hypre_boomeramg_relax_type_all", "Chebyshev"},
                                           {NULL, NULL}};
static const char *const gamg[][2] = {{"-pc_type", "gamg"},
                                      {"-pc_gamg_threshold", "0.02"},
                                      {"-pc_gamg_agg_nsmooths", "1"},
                                      {"-mg_levels_ksp_type", "chebyshev"},
                                      {"-mg_levels_pc_type", "jacobi"},
                                      {NULL, NULL}};

/* Sets options that the command line has not set. */
static PetscErrorCode defaults(const char *const pairs[][2])
{
    PetscFunctionBeginUser;
    for (; (*pairs)[0]; pairs++) {
        PetscBool given;
        PetscCall(PetscOptionsHasName(NULL, NULL, (*pairs)[0], &given));
        if (!given) PetscCall(PetscOptionsSetValue(NULL, (*pairs)[0], (*pairs)[1]));
    }
    PetscFunctionReturn(0);
}
