#!/usr/bin/env python3
"""Measures the estimates of `accuracy` on scenes whose results are known from much finer meshes.

    scripts/accuracy.py PROGRAM SCRATCH [--scenes NAME,...] [--relative 1e-2,1e-3]

For each scene: a reference, from a search for a fifth of the smallest error that is asked for, less
its own estimated error; then each search, and the true error over the estimated one of every quantity
at every instant. Writes a table in Markdown to standard output, and every figure to
SCRATCH/accuracy.json. Not part of continuous integration: it takes minutes to an hour.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import time

ROCK = {"elastic": {"young_modulus": 5.8e9, "poisson_ratio": 0.3}}
STIFF = {"elastic": {"young_modulus": 2.0e10, "poisson_ratio": 0.2}}
SOFTENING = {"linear_softening": {"strength": 1.1e6, "fracture_energy": 900.0}}
MEAN, LARGEST = "joint.normal_traction.mean", "joint.normal_traction.max"


def formula(text):
    return {"formula": text}


def column(size, height, materials, law, top, of, instants=(1,), **more):
    """A column with one interface, held below and moved above."""
    flat = len(size) == 2
    held = {"x": 0, "z": 0} if flat else {"x": 0, "y": 0, "z": 0}
    joint = {"name": "joint", "z": height, "law": law}
    joint.update(more.pop("joint", {}))
    case = {
        "mesh": {"column": {"size": size}},
        "materials": materials,
        "interfaces": [joint],
        "boundary": [{"on": "bottom", "displacement": held}] + top,
        "time": {"instants": list(instants)},
        "output": {"fields": "none"},
        "accuracy": {"of": of},
    }
    case["mesh"].update(more.pop("mesh", {}))
    case.update(more)
    return case


def moved(**components):
    return [{"on": "top", "displacement": components}]


def scenes():
    """By name."""
    tilt2 = formula("3e-4*t*(1 + 0.4*(x-0.5))")
    tilt3 = formula("3e-4*t*(1 + 0.4*(x-0.5) + 0.2*(y-0.5))")
    layers = {"low": {"z": [0, 2], **ROCK}, "high": {"z": [2, 4], **STIFF}}
    of = [MEAN, LARGEST, "top.reaction_z"]
    return {
        "tilted 2D": column([1, 4], 2, {"rock": ROCK}, SOFTENING, moved(x=0, z=tilt2), of),
        "tilted 3D": column(
            [1, 1, 4], 2, {"rock": ROCK}, SOFTENING, moved(x=formula("1e-4*t"), y=0, z=tilt3), of
        ),
        "sheared 2D": column(
            [1, 2], 1, {"rock": ROCK}, {"tied": {}}, moved(x=formula("1e-3*t"), z=0),
            ["top.reaction_x", "joint.shear_traction_x.mean", "joint.shear_traction_x.max"],
        ),
        "two materials": column(
            [1, 4], 2, layers, SOFTENING, moved(x=formula("1e-4*t"), z=tilt2), of, (1, 2)
        ),
        "first order": column(
            [1, 4], 2, {"rock": ROCK}, SOFTENING, moved(x=0, z=tilt2), of, mesh={"order": 1}
        ),
        "non-matching": column(
            [1, 4], 2, layers, SOFTENING, moved(x=0, z=tilt2), of,
            mesh={"column": {"size": [1, 4], "bodies": [{"cells": [8, 16]}, {"cells": [16, 16]}]}},
        ),
        "softening": column(
            [0.2, 0.4], 0.2, {"rock": ROCK}, SOFTENING,
            moved(x=0, z=formula("6e-4*t*(1 + 1.5*(x-0.1))")),
            [MEAN, "joint.damage.mean", "top.reaction_z"], (0.25, 0.5, 0.75, 1.0),
        ),
        "contact": column(
            [1, 2], 1, {"rock": ROCK}, {"contact": {}},
            moved(x=0, z=formula("-1e-3*t*(1 + 2.5*(x-0.5))")), [MEAN, "top.reaction_z"],
        ),
        "uniform": column(
            [1, 1, 5], 2.5, {"rock": {"elastic": {"young_modulus": 5.8e9, "poisson_ratio": 0}}},
            SOFTENING, moved(x=0, y=0, z=formula("1e-4*t")), [MEAN, "top.reaction_z"], (1, 2, 3),
        ),
        "flow": {
            "mesh": {"column": {"size": [1, 4]}},
            "materials": {
                "soil": {
                    "elastic": {"young_modulus": 1e8, "poisson_ratio": 0.2},
                    "porous": {
                        "biot": 1.0, "porosity": 0.3, "permeability": 1e-12, "viscosity": 1e-3,
                        "fluid_compressibility": 4e-10, "fluid_density": 1000.0, "density": 2000.0,
                    },
                }
            },
            "boundary": [
                {"on": "bottom", "displacement": {"x": 0, "z": 0}},
                {"on": "left", "displacement": {"x": 0}},
                {"on": "right", "displacement": {"x": 0}},
                {"on": "top", "traction": {"z": -1e4}, "pressure": 0},
            ],
            "time": {"instants": [10, 40]},
            "probes": [{"name": "mid", "at": [0.5, 1.0]}],
            "output": {"fields": "none"},
            "accuracy": {"of": ["mid.pressure", "mid.displacement_z"]},
        },
    }


def run(program, folder, name, case, ranks=1):
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(json.dumps(case))
    command = [program, "run", str(path), "--output", str(folder / name), "--overwrite", "--quiet"]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks)] + command
    started = time.time()
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    if ended.returncode not in (0, 1):
        raise RuntimeError(f"{name}: {ended.stderr.strip()}")
    report = json.loads((folder / name / "report.json").read_text())
    return report["accuracy"], time.time() - started


def asked(case, relative, unknowns):
    case = json.loads(json.dumps(case))
    case["accuracy"].update({"relative": relative, "budget": {"unknowns": unknowns}})
    return case


# Where something else than more unknowns makes a reference finer.
REFERENCES = {"first order": {"mesh": {"column": {"size": [1, 4]}, "order": 2}}}


def measure(program, scratch, name, case, relatives, unknowns):
    """Of one scene: a row for each search."""
    folder = scratch / name.replace(" ", "_")
    finer = dict(case, **REFERENCES.get(name, {}))
    reference, _ = run(program, folder, "reference", asked(finer, min(relatives) / 5, unknowns))
    most = reference["meshes"][reference["chosen"]]["unknowns"]
    rows = []
    for relative in relatives:
        found, seconds = run(program, folder, f"at_{relative:g}", asked(case, relative, unknowns))
        pairs = []
        for own, exact in zip(found["quantities"], reference["quantities"]):
            true = own["value"] - exact["value"] + exact["error"]
            own = dict(own, true=true, beyond=abs(exact["error"]))
            # Neither is more than rounding and the tolerance of the solver leave.
            own["exact"] = max(abs(true), abs(own["error"])) < 1e-7 * abs(own["value"])
            pairs.append(own)
        chosen = found["meshes"][found["chosen"]]
        is_finer = name in REFERENCES or most > chosen["unknowns"] or most < 100
        rows.append(
            {
                "scene": name, "asked": relative, "met": found["met"], "why": found["why"],
                "unknowns": chosen["unknowns"], "meshes": len(found["meshes"]),
                "core_seconds": found["core_seconds"], "seconds": seconds, "quantities": pairs,
                "reference_met": reference["met"], "reference_is_finer": is_finer,
                "reference_unknowns": most,
            }
        )
    return rows


def table(rows):
    head = "| scene | asked | met | unknowns | meshes | core-s | largest true error | " \
        "true over estimated | of those that count | not trusted |"
    lines = [head, "|" + "---|" * 10]
    for row in rows:
        quantities = [q for q in row["quantities"] if not q["exact"] and q["error"] != 0]
        # Errors far below what was asked need not be known.
        least = row["asked"] / 10
        count = [
            q for q in quantities
            if max(abs(q["true"]), abs(q["error"])) > least * abs(q["value"])
        ]

        def spread(chosen):
            ratios = [abs(q["true"]) / abs(q["error"]) for q in chosen]
            return f"{min(ratios):.2f} to {max(ratios):.2f}" if ratios else "none"

        worst = max(abs(q["true"]) / max(abs(q["value"]), 1e-300) for q in row["quantities"])
        untrusted = sum(not q["trusted"] for q in row["quantities"])
        known = row["reference_is_finer"]
        lines.append(
            f"| {row['scene']} | {row['asked']:g} | {'yes' if row['met'] else 'no'} "
            f"| {row['unknowns']} | {row['meshes']} | {row['core_seconds']:.1f} "
            f"| {f'{worst:.1e}' if known else 'no finer reference'} "
            f"| {spread(quantities) if known else ''} | {spread(count) if known else ''} "
            f"| {untrusted} of {len(row['quantities'])} |"
        )
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program")
    parser.add_argument("scratch", type=pathlib.Path)
    parser.add_argument("--scenes", default="")
    parser.add_argument("--relative", default="1e-2,1e-3")
    parser.add_argument("--unknowns", type=int, default=100_000)
    given = parser.parse_args()
    relatives = [float(text) for text in given.relative.split(",")]
    rows = []
    for name, case in scenes().items():
        if given.scenes and name not in given.scenes.split(","):
            continue
        try:
            rows += measure(given.program, given.scratch, name, case, relatives, given.unknowns)
        except RuntimeError as error:
            print(f"{name}: {error}", file=sys.stderr)
        given.scratch.mkdir(parents=True, exist_ok=True)
        (given.scratch / "accuracy.json").write_text(json.dumps(rows, indent=1))
        print(f"{name}: done", file=sys.stderr)
    print(table(rows))


if __name__ == "__main__":
    main()
