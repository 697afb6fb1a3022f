#!/usr/bin/env bash
# MPI_Finalize closes every file that HDF5 has open, also those opened without MPI, and gives their
# handles to others: what is written through one that was kept goes into another file.
#
# Versions: HDF5 1.10.8 built for Open MPI, Open MPI 4.1.4 (Debian 12).
#
# Input: one process opens a file with the default properties, as a program without MPI would, and
# keeps the handle. It ends MPI, creates a second file, and writes a number through the first
# handle. HDF5 is used after MPI all the time: nothing in it was collective.
#
# Expected: the first file stays open, as it has nothing to do with MPI; or the handle that was kept
# is refused from then on.
#
# What happens instead: a parallel build of HDF5 hangs the end of the whole library on
# MPI_COMM_SELF, whose attributes MPI_Finalize deletes first. All files, data spaces and property
# lists of the process are closed, and no call says so. The next use starts the library anew, with
# numbers from the start: the second file gets the handle of the first. The write succeeds, in the
# wrong file.
#
# Output seen:
#   MPI goes on: the first handle is open, the second file has another; write: works
#     first.h5 has: before after
#     second.h5 has:
#   MPI ends:    the first handle is closed, the second file has the same; write: works
#     first.h5 has: before
#     second.h5 has: after
#
# Why it matters: a library that ends MPI when it is done, or a test beside others in one process,
# takes the files of everything else in the process away: a reader of meshes, a log, a binding that
# keeps numbers of types and property classes. With threads the files close below a running call.
set -euo pipefail

command -v mpicc >/dev/null || { echo "mpicc is missing (Debian: libopenmpi-dev)"; exit 2; }
[ -e /usr/include/hdf5/openmpi/hdf5.h ] || { echo "HDF5 is missing (Debian: libhdf5-openmpi-dev)"; exit 2; }
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
cd "$tmp"
cat >look.c <<'C'
#include <hdf5.h>
#include <mpi.h>
#include <stdio.h>
#include <string.h>

static const char *NAMES[] = {"before", "after"};

static const char *written(hid_t file, const char *name) {
    double value = 1.0;
    hid_t space = H5Screate(H5S_SCALAR), none = H5P_DEFAULT;
    hid_t set = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, none, none, none);
    herr_t outcome = set < 0 ? -1 : H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, none, &value);
    if (set >= 0) H5Dclose(set);
    H5Sclose(space);
    return outcome < 0 ? "fails" : "works";
}

static void list(const char *path) {
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    printf("  %s has:", path);
    for (int i = 0; i < 2; i++)
        if (H5Lexists(file, NAMES[i], H5P_DEFAULT) > 0) printf(" %s", NAMES[i]);
    printf("\n");
    H5Fclose(file);
}

int main(int argc, char **argv) {
    if (argc > 2) {
        list(argv[1]);
        list(argv[2]);
        return 0;
    }
    int ends = strcmp(argv[1], "ends") == 0;
    MPI_Init(NULL, NULL);
    hid_t first = H5Fcreate("first.h5", H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    written(first, NAMES[0]);
    if (ends) MPI_Finalize();
    const char *is = H5Iis_valid(first) > 0 ? "open" : "closed";
    hid_t second = H5Fcreate("second.h5", H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const char *has = second == first ? "the same" : "another";
    printf("the first handle is %s, the second file has %s; write: %s\n", is, has, written(first, NAMES[1]));
    H5Fclose(second);
    if (!ends) {
        H5Fclose(first);
        MPI_Finalize();
    }
    return 0;
}
C
libraries=/usr/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH 2>/dev/null || gcc -dumpmachine)/hdf5/openmpi
mpicc look.c -o look -I/usr/include/hdf5/openmpi -L"$libraries" -lhdf5
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl=self,vader
{
    echo "MPI goes on: $(./look stays)"
    ./look first.h5 second.h5
    echo "MPI ends:    $(./look ends)"
    ./look first.h5 second.h5
} | tee seen
cat >before <<'SEEN'
MPI goes on: the first handle is open, the second file has another; write: works
  first.h5 has: before after
  second.h5 has:
MPI ends:    the first handle is closed, the second file has the same; write: works
  first.h5 has: before
  second.h5 has: after
SEEN
diff before seen || { echo "this is not what was seen before"; exit 1; }
