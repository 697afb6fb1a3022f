#!/usr/bin/env bash
# With mpi_yield_when_idle Open MPI gives the core away at each look for messages, also where nobody
# waits and on one rank alone; MUMPS looks between two fronts.
#
# Versions: Open MPI 4.1.4, MUMPS 5.5.1 (Debian 12).
#
# Input: one rank, which probes for a message a thousand times without blocking (MPI_Iprobe), and
# then has MUMPS solve the five-point Laplacian of 100 x 100 points. The program has a sched_yield
# of its own, which counts the calls and hands them on.
#
# Expected: the parameter is documented for processes that wait: a probe that does not block, and
# elimination on one rank, which has nobody to wait for, keep the core.
#
# What happens instead: each probe that finds nothing calls sched_yield, and the elimination does so
# thousands of times. With the parameter at 0 neither does once. Open MPI sets it to 1 by itself
# where there are more ranks than cores.
#
# Output seen:
#   mpi_yield_when_idle=0: 1000 probes yield 0 times, elimination 0 times
#   mpi_yield_when_idle=1: 1000 probes yield 1000 times, elimination 25857 times
#
# Why it matters: on a core that another process wants each call costs a slice of the scheduler,
# some milliseconds. A factorisation of three seconds took one minute beside a program that
# computed, with a tenth of the core used: it looks like a slow solver or a slow machine. Whoever
# sets the parameter for runs with more ranks than cores slows down all others that share cores.
set -euo pipefail

for tool in mpicc mpirun; do
    command -v "$tool" >/dev/null || { echo "$tool is missing (Debian: libopenmpi-dev)"; exit 2; }
done
[ -e /usr/include/dmumps_c.h ] || { echo "MUMPS is missing (Debian: libmumps-dev)"; exit 2; }
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
cd "$tmp"
cat >probe.c <<'C'
#define _GNU_SOURCE
#include <dmumps_c.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

static long yields;

int sched_yield(void) {
    yields++;
    return syscall(SYS_sched_yield);
}

static long eliminated(int side) {
    int points = side * side, entries = 0;
    int *row = malloc(3 * points * sizeof(int)), *column = malloc(3 * points * sizeof(int));
    double *value = malloc(3 * points * sizeof(double)), *right = malloc(points * sizeof(double));
    for (int i = 0; i < points; i++) {
        int below[] = {i, i % side ? i - 1 : -1, i - side};
        for (int k = 0; k < 3; k++)
            if (below[k] >= 0) {
                row[entries] = i + 1;
                column[entries] = below[k] + 1;
                value[entries++] = k ? -1.0 : 4.0;
            }
        right[i] = 1.0;
    }
    DMUMPS_STRUC_C mumps = {.comm_fortran = -987654, .par = 1, .sym = 1, .job = -1};
    dmumps_c(&mumps);
    for (int i = 0; i < 4; i++) mumps.icntl[i] = 0;
    mumps.n = points, mumps.nz = entries;
    mumps.irn = row, mumps.jcn = column, mumps.a = value, mumps.rhs = right;
    long before = yields;
    mumps.job = 6;
    dmumps_c(&mumps);
    long during = yields - before;
    if (mumps.infog[0]) exit(3);
    mumps.job = -2;
    dmumps_c(&mumps);
    return during;
}

int main(int argc, char **argv) {
    MPI_Init(&argc, &argv);
    long before = yields;
    for (int i = 0, found; i < 1000; i++)
        MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &found, MPI_STATUS_IGNORE);
    long probes = yields - before;
    printf("1000 probes yield %ld times, elimination %ld times\n", probes, eliminated(100));
    MPI_Finalize();
}
C
mpicc -O1 -rdynamic probe.c -o probe -ldmumps
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl=self,vader OMP_NUM_THREADS=1
for yields in 0 1; do
    said=$(mpirun -n 1 --quiet --mca mpi_yield_when_idle $yields ./probe)
    echo "mpi_yield_when_idle=$yields: $said"
    case "$yields $said" in
    "0 1000 probes yield 0 times, elimination 0 times") ;;
    "1 1000 probes yield 1000 times, elimination "[1-9][0-9][0-9]*" times") ;;
    *) echo "it has changed"; exit 1 ;;
    esac
done
