# shellcheck shell=bash
# Sourced by the batch scripts: sets `command`, the launcher and the program, for this job.

# SITE: the modules the program was built with, e.g. MODULES="gcc openmpi/4.1 petsc/3.18 hdf5/1.12-mpi metis".
if [ -n "${MODULES:-}" ]; then
    # shellcheck disable=SC2086  # a list of words
    module load $MODULES
fi
# SITE: where no module sets them, e.g.
#   export PETSC_DIR=$HOME/petsc-3.18 PETSC_ARCH=arch-linux-c-opt
# They are needed to build; a run only needs the libraries to be found:
if [ -n "${PETSC_DIR:-}" ]; then
    export LD_LIBRARY_PATH="$PETSC_DIR/${PETSC_ARCH:-}/lib:${LD_LIBRARY_PATH:-}"
fi

# SLURM runs a copy of the script: the program is looked for from where sbatch was called.
program=${COLUMN_HPC:-${SLURM_SUBMIT_DIR:-$PWD}/target/release/column-hpc}
if [ ! -x "$program" ]; then
    printf '%s is no program: build with cargo build --release, or set COLUMN_HPC\n' "$program" >&2
    exit 4
fi

# One thread per rank, one rank per core.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

# SITE: LAUNCHER="mpirun" where Open MPI was built without SLURM's PMIx (`srun --mpi=list` shows it).
launcher=${LAUNCHER:-}
if [ -z "$launcher" ]; then
    if srun --mpi=list 2>&1 | grep -q pmix; then
        launcher="srun --mpi=pmix --cpu-bind=cores --kill-on-bad-exit=1"
    else
        launcher="mpirun --bind-to core"
    fi
fi
read -r -a command <<<"$launcher"
command+=("$program")

# Which signal asks for a checkpoint and the end: Open MPI's mpirun passes USR2 on and waits, while its TERM leaves the
# ranks two seconds; Hydra (MPICH, Intel MPI) passes TERM on and waits, while its USR2 ends the job. A study, which
# launches its runs itself, knows TERM only.
case ${command[0]} in
*srun) stop_signal=USR2 ;;
*)
    if [[ $("${command[0]}" --version 2>/dev/null || true) == *"Open MPI"* ]]; then
        stop_signal=USR2
    else
        stop_signal=TERM
    fi
    ;;
esac

# Sends the running program a signal: srun's tasks get it from the controller, mpirun passes it on.
signal_program() { # SIGNAL, PID of the launcher
    case ${command[0]} in
    *srun) scancel --signal="$1" "$SLURM_JOB_ID" ;;
    *) kill "-$1" "$2" ;;
    esac
}

# Whether somebody has asked for the end.
stop_asked=

# Whether a run that began at the file STAMP and ended with STATUS left work and a checkpoint to go on from: it says so
# (75), or it was asked to stop or killed, with another status of its launcher, and its checkpoint is younger than STAMP.
is_stopped() { # DIRECTORY, STAMP, STATUS
    if [ "$3" -eq 75 ]; then
        return 0
    fi
    if [ -z "$stop_asked" ] && [ "$3" -le 128 ]; then
        return 1
    fi
    # It came to its end all the same, or failed by itself.
    if [ "$1/report.json" -nt "$2" ] && ! grep -q '"status": *"stopped"' "$1/report.json"; then
        return 1
    fi
    [ "$1/checkpoint.h5" -nt "$2" ]
}

# Runs the program with the given words and waits for it, also across signals; its status is the result.
run_program() {
    printf '%s: %s rank(s) on %s node(s): %s\n' "${SLURM_JOB_ID:-no job}" "${SLURM_NTASKS:-1}" \
        "${SLURM_JOB_NUM_NODES:-1}" "${command[*]} $*"
    if [ -n "${DRY_RUN:-}" ]; then
        return 0
    fi
    local status=0 process
    "${command[@]}" "$@" &
    process=$!
    # The time is nearly over, or the job is preempted: a checkpoint and the end, status 75.
    # shellcheck disable=SC2064  # the process of now
    trap "stop_asked=yes; signal_program $stop_signal $process" USR2 TERM
    # shellcheck disable=SC2064
    trap "signal_program USR1 $process" USR1
    while :; do
        status=0
        wait "$process" || status=$?
        # Above 128 while the process lives: a trap interrupted the wait.
        if [ "$status" -le 128 ] || ! kill -0 "$process" 2>/dev/null; then
            break
        fi
    done
    trap - USR1 USR2 TERM
    return "$status"
}
