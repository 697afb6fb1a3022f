"""Runs programs against the clock, within a budget of time."""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "peers"))
import raw_best  # noqa: E402  (the bare PETSc program and the environment of Open MPI)


class Failed(Exception):
    """A run that gave no measurement; says why. `after`: the seconds after which it was stopped."""

    after = None


def stop(process):
    """Ends a run: politely, since mpirun then ends its ranks, which are in process groups of their own."""
    for number, patience in ((signal.SIGTERM, 15), (signal.SIGKILL, None)):
        try:
            os.killpg(process.pid, number)
            process.wait(patience)
            return
        except subprocess.TimeoutExpired:
            continue
        except ProcessLookupError:
            return


class Bench:
    """The programs, the directory of the results, what was measured and what was left out."""

    def __init__(self, directory, budget, limit):
        self.directory = Path(directory).resolve()
        self.runs = self.directory / "runs"
        self.runs.mkdir(parents=True, exist_ok=True)
        self.program = os.environ.get("COLUMN_HPC") or "target/release/column-hpc"
        self.raw_program = None
        self.environment = raw_best.mpi_environment()
        self.end = time.monotonic() + budget
        self.limit = limit
        self.records = []
        self.notes = []
        self.versions = {}
        # Before the first run, since the runs are load too.
        self.machine = machine()
        self.repeats_missing = 0

    def left(self):
        return self.end - time.monotonic()

    def note(self, text):
        """Remembers what the tables will not show, and says it once."""
        if text not in self.notes:
            self.notes.append(text)
            print(f"bench: {text}", file=sys.stderr)

    def forecast(self, kind, ranks, unknowns):
        """Seconds that a run should take: as the nearest measured one of its kind, scaled by its unknowns."""
        known = [r for r in self.records if r["kind"] == kind and r["ranks"] == ranks]
        if not known:
            return 0.0
        near = min(known, key=lambda r: abs(r["unknowns"] - unknowns))
        return near["wall"] * max(unknowns / near["unknowns"], 0.5) ** 1.15

    def timed(self, command, ranks, limit=None):
        """Runs a process to its end: mpirun on several ranks, on one the bare program.

        Returns its wall clock, the processor time of all ranks and what it printed."""
        limit = max(min(limit or self.limit, self.left()), 1.0)
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks), "--quiet", *command]
        before = children()
        start = time.perf_counter()
        process = subprocess.Popen(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, start_new_session=True)
        try:
            output, errors = process.communicate(timeout=limit)
        except BaseException as error:
            stop(process)
            if isinstance(error, subprocess.TimeoutExpired):
                stopped = Failed(f"stopped after {limit:.0f} s")
                stopped.after = limit
                raise stopped from None
            raise
        wall = time.perf_counter() - start
        if process.returncode != 0:
            last = (errors.strip().splitlines() or ["no message"])[-1]
            raise Failed(f"status {process.returncode}: {last[:120]}")
        return wall, children() - before, output

    def ours(self, scene, ranks, kind, number=1, settings=(), fields="all", limit=None):
        """A run of the column: its report with the wall time. Fields are deleted once they have been timed."""
        name = f"{scene.name}-{ranks}-{kind}-{number}"
        print(f"{name}", file=sys.stderr)
        case, output = self.runs / f"{scene.name}.yaml", self.runs / name
        case.write_text(scene.case(fields))
        shutil.rmtree(output, ignore_errors=True)
        command = [self.program, str(case), "--quiet", "--overwrite", "--output", str(output),
                   "--set", "reduce=never"]
        for setting in settings:
            command += ["--set", setting]
        try:
            wall, cpu, _ = self.timed(command, ranks, limit)
            report = json.loads((output / "report.json").read_text())
        finally:
            shutil.rmtree(output / "fields", ignore_errors=True)
        self.versions = report["versions"]
        return self.keep({
            "kind": kind, "scene": scene.name, "cells": scene.cells, "ranks": ranks, "number": number,
            "checked": scene.checked, "unknowns": report["unknowns"], "preset": report["linear_solver"]["choice"], "wall": wall,
            "newton": report["newton_iterations"], "linear": report["linear_iterations"],
            "memory": report["peak_memory_bytes"], "cpu": cpu, "directory": name, **report["timings"],
        })

    def choice(self, scene):
        """The preset that `auto` takes."""
        case = self.runs / f"{scene.name}.yaml"
        case.write_text(scene.case("none"))
        *_, output = self.timed([self.program, "check", str(case)], 1)
        return next(line.split()[1].rstrip(":") for line in output.splitlines() if line.startswith("linear"))

    def raw(self, scene, ranks, solver, number=1):
        """One bare PETSc solve under the load of the elastic instant: what it prints with the wall time."""
        print(f"{scene.name}-{ranks}-raw-{solver}-{number}", file=sys.stderr)
        self.raw_program = self.raw_program or raw_best.program()
        command = [self.raw_program, "-cells", ",".join(map(str, scene.raw_cells)), "-nu", str(scene.nu),
                   "-top", "0,0,1e-3", "-solver", solver]
        wall, cpu, output = self.timed(command, ranks)
        printed = json.loads(next(line for line in output.splitlines() if line.startswith("{")))
        return self.keep({
            "kind": f"raw-{solver}", "scene": scene.name, "ranks": ranks, "number": number, "solver": solver,
            "unknowns": printed["unknowns"], "wall": wall, "linear": printed["iterations"],
            "assembly": printed["assembly_s"],
            "memory": printed["peak_memory_bytes"], "cpu": cpu,
        })

    def heading(self, text):
        """The first paragraph of a page: where it was measured, and how."""
        petsc = f"PETSc {self.versions['PETSc']}" if self.versions else "PETSc"
        return f"{self.machine}; {petsc}; {text}\n"

    def triad(self, ranks, times):
        """Memory bandwidth of all ranks together, GB/s: the best of several runs."""
        self.raw_program = self.raw_program or raw_best.program()
        found = []
        for _ in range(times):
            *_, output = self.timed([self.raw_program, "-n", "2", "-triad"], ranks)
            line = next(line for line in output.splitlines() if line.startswith("{"))
            found.append(json.loads(line)["stream_triad_gbs"])
        return max(found)

    def keep(self, record):
        self.records.append(record)
        return record

    def attempt(self, what, kind, ranks, unknowns, number, measure):
        """Runs `measure` where the budget allows it; None, with a note, where it does not or the run fails.

        Repeats that were left out are only counted: the tables show how many there were."""
        needed = self.forecast(kind, ranks, unknowns)
        if needed > self.left():
            if number > 1:
                self.repeats_missing += 1
                return None
            self.note(f"{what} left out: {max(self.left(), 0):.0f} s of the budget left, about {needed:.0f} s needed")
            return None
        try:
            return measure()
        except Failed as error:
            self.note(f"{what}, run {number}: {error}")
            return None


def children():
    """Processor time of all processes that have ended, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def machine():
    """The processor and how busy it is, in words."""
    model = "unknown processor"
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            model = " ".join(line.split(":", 1)[1].split())
            break
    return f"{model}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the start"
