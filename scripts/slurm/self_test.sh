#!/usr/bin/env bash
# Runs the batch scripts here, with mpirun and signals in the place of the scheduler: srun, scancel and scontrol
# are stand-ins that do with processes what SLURM does with jobs. COLUMN_HPC names the program; without it the release
# build is taken.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
# shellcheck source=scripts/mpi_env.sh
. scripts/mpi_env.sh
export COLUMN_HPC=${COLUMN_HPC:-${CARGO_TARGET_DIR:-$root/target}/release/column-hpc}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir "$scratch/bin"
cat >"$scratch/bin/srun" <<'STUB'
#!/usr/bin/env bash
if [ "$1" = --mpi=list ]; then echo pmix; exit 0; fi
while [[ $1 == --* ]]; do shift; done
mpirun -n "$SLURM_NTASKS" --quiet "$@" &
echo $! >"$STATE/step"
wait $!
STUB
cat >"$scratch/bin/scancel" <<'STUB'
#!/usr/bin/env bash
kill "-${1#--signal=}" "$(cat "$STATE/step")"
STUB
cat >"$scratch/bin/scontrol" <<'STUB'
#!/usr/bin/env bash
echo "$@" >>"$STATE/requeued"
STUB
# Hydra passes TERM on and ends the job at USR2; a launcher that ends with a status of its own, whatever the ranks say.
cat >"$scratch/bin/hydra" <<'STUB'
#!/usr/bin/env bash
if [ "$1" = --version ]; then echo "HYDRA build details:"; exit 0; fi
mpirun "$@" &
trap 'kill -USR2 $!' TERM
trap 'kill -KILL $!' USR2
wait $!; status=$?
while kill -0 $! 2>/dev/null; do wait $!; status=$?; done
exit $status
STUB
cat >"$scratch/bin/abrupt" <<'STUB'
#!/usr/bin/env bash
hydra "$@" &
trap 'kill -TERM $!' TERM
wait $!; status=$?
while kill -0 $! 2>/dev/null; do wait $!; status=$?; done
[ $status -eq 75 ] && exit 1
exit $status
STUB
chmod +x "$scratch"/bin/*
export PATH="$scratch/bin:$PATH" STATE="$scratch" SLURM_SUBMIT_DIR="$root" SLURM_NTASKS=2 SLURM_JOB_ID=42
unset SLURM_JOB_NUM_NODES

fail() {
    printf 'slurm: FAILED: %s\n' "$1" >&2
    cat "$scratch"/log >&2 || true
    exit 1
}
# A run of some seconds, so that signals meet it on its way.
case_file=cases/wtnv146/case.yaml
long=(--set "mesh.column.cells=[8, 8, 40]" --set "time.instants=[$(seq -s, 0.02 0.02 8)]" --set "expect=[]" --set reduce=never)
column() { cut -d, -f1,5-9 "$1/history.csv"; }

# shellcheck disable=SC2086
bash scripts/slurm/run.sbatch $case_file "${long[@]}" --output "$scratch/whole" --quiet >"$scratch/log" 2>&1 ||
    fail "run.sbatch ended with status $?"

for LAUNCHER in "" "mpirun -n 2 --quiet" "hydra -n 2 --quiet" "abrupt -n 2 --quiet"; do
    export LAUNCHER
    out="$scratch/requeued_by_${LAUNCHER:0:6}"
    : >"$scratch/requeued"
    rounds=0
    while :; do
        rounds=$((rounds + 1))
        touch "$scratch/stamp"
        bash scripts/slurm/requeue.sbatch $case_file "$out" "${long[@]}" --quiet >"$scratch/log" 2>&1 &
        job=$!
        # The first two jobs run out of time on their way.
        if [ "$rounds" -le 2 ]; then
            for _ in {1..600}; do
                [ "$out/history.csv" -nt "$scratch/stamp" ] && break
                sleep 0.1
            done
            sleep 0.5
            # The second may be done by then.
            kill -USR2 "$job" 2>/dev/null || true
        fi
        status=0
        wait "$job" || status=$?
        [ "$(wc -l <"$scratch/requeued")" -eq "$rounds" ] || break
        [ "$rounds" -lt 20 ] || fail "the job never ended"
    done
    [ "$status" -eq 0 ] || fail "requeue.sbatch ended with status $status after $rounds jobs"
    [ "$rounds" -ge 2 ] || fail "no signal met the run"
    [ "$(wc -l <"$scratch/requeued")" -eq $((rounds - 1)) ] || fail "$rounds jobs, requeued $(wc -l <"$scratch/requeued") times"
    python3 - "$scratch/whole/history.csv" "$out/history.csv" <<'PYTHON' || fail "the histories differ"
import csv, sys
whole, parts = (list(csv.reader(open(name))) for name in sys.argv[1:])
assert whole[0] == parts[0] and len(whole) == len(parts), (len(whole), len(parts))
for index, name in enumerate(whole[0]):
    if name.endswith("_iterations"):
        continue
    a, b = ([float(row[index]) for row in table[1:]] for table in (whole, parts))
    kind = next(word for word in ("time", "traction", "jump", "sliding", "damage", "force", "area", "reaction", "energy", "factor", "displacement") if word in name)
    scale = max(abs(float(row[i])) for row in whole[1:] for i, other in enumerate(whole[0]) if kind in other)
    worst = max(abs(x - y) for x, y in zip(a, b))
    assert worst <= 1e-9 * scale, (name, worst, scale)
PYTHON
    printf 'slurm: %s: stopped %s times and went on to the end\n' "${LAUNCHER:-srun}" $((rounds - 1))
done

export LAUNCHER="mpirun -n 2 --quiet"
printf '%s --output %s/one --quiet\n%s --set mesh.column.cells=[1,1,5] --output %s/two --quiet\n' \
    $case_file "$scratch" $case_file "$scratch" >"$scratch/list"
for task in 1 2; do
    SLURM_ARRAY_TASK_ID=$task bash scripts/slurm/array.sbatch "$scratch/list" >"$scratch/log" 2>&1 ||
        fail "task $task of array.sbatch ended with status $?"
done
[ -s "$scratch/one/history.csv" ] && [ -s "$scratch/two/history.csv" ] || fail "a task wrote nothing"
SLURM_ARRAY_TASK_ID=3 bash scripts/slurm/array.sbatch "$scratch/list" >"$scratch/log" 2>&1 && fail "there is no third line"
printf 'slurm: an array of two cases\n'

# A study in two shares and its charts; the list of the scaling job.
unset LAUNCHER
cat >"$scratch/case.yaml" <<'CASE'
mesh: {column: {size: [1, 1, 5], cells: [1, 1, 6]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: 1.0e-4}}
time: {instants: [1]}
CASE
cat >"$scratch/study.yaml" <<'STUDY'
base: case.yaml
axes: [{name: order, key: mesh.order, values: [1, 2]}, {name: ranks, ranks: [1, 2]}]
charts: [{name: strong, kind: strong_scaling, series: [order]}]
STUDY
for task in 1 2; do
    SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_COUNT=2 bash scripts/slurm/study.sbatch "$scratch/study.yaml" "$scratch/study" \
        >"$scratch/log" 2>&1 || fail "task $task of study.sbatch ended with status $?"
done
[ ! -e "$scratch/study/study.html" ] || fail "a share drew"
bash scripts/slurm/study.sbatch "$scratch/study.yaml" "$scratch/study" --charts-only >"$scratch/log" 2>&1 ||
    fail "study.sbatch --charts-only ended with status $?"
[ "$(grep -c ',done,' "$scratch/study/study.csv")" -eq 4 ] || fail "the shares do not add up"
[ -s "$scratch/study/charts/strong.png" ] || fail "there is no chart"
bash scripts/slurm/scaling.sbatch "$scratch/scaling" "$scratch/study.yaml" >"$scratch/log" 2>&1 ||
    fail "scaling.sbatch ended with status $?"
[ -s "$scratch/scaling/study/study.html" ] || fail "scaling.sbatch drew nothing"
DRY_RUN=1 bash scripts/slurm/scaling.sbatch "$scratch/none" >"$scratch/log" 2>&1 || fail "the dry run failed"
grep -q 'study cases/studies/weak_scaling.yaml' "$scratch/log" || fail "the dry run does not name the study"
printf 'slurm: a study in two shares, and a scaling job\n'
