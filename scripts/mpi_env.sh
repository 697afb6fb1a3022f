# shellcheck shell=bash
# Sourced: the environment in which Open MPI runs the program. What the user has set stays.

if [ "$(id -u)" -eq 0 ]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

# One thread per rank: ranks are the parallelism, threaded BLAS would only fight them for cores.
export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}"
export OPENBLAS_NUM_THREADS="${OPENBLAS_NUM_THREADS:-1}"

mpi_nodes=${SLURM_JOB_NUM_NODES:-1}
if [ -n "${PBS_NODEFILE:-}" ] && [ -r "$PBS_NODEFILE" ]; then
    mpi_nodes=$(sort -u "$PBS_NODEFILE" | wc -l)
fi
if [ "$mpi_nodes" -eq 1 ]; then
    # Shared memory only, without a probe of every network library: starts twice as fast.
    export OMPI_MCA_pml="${OMPI_MCA_pml:-ob1}"
    export OMPI_MCA_btl="${OMPI_MCA_btl:-self,vader}"
    # Containers without ptrace refuse the copy between processes.
    export OMPI_MCA_btl_vader_single_copy_mechanism="${OMPI_MCA_btl_vader_single_copy_mechanism:-none}"
    # Bound, two runs side by side would share the first cores and leave the others idle.
    export OMPI_MCA_hwloc_base_binding_policy="${OMPI_MCA_hwloc_base_binding_policy:-none}"
    # More ranks than cores are allowed, and do not spin while they wait.
    export OMPI_MCA_rmaps_base_oversubscribe="${OMPI_MCA_rmaps_base_oversubscribe:-1}"
    export OMPI_MCA_mpi_yield_when_idle="${OMPI_MCA_mpi_yield_when_idle:-1}"
fi
unset mpi_nodes
