"""What the measurements of scripts/bench.py come to: CSV files and Markdown tables."""

import csv
import math
from statistics import median
from textwrap import fill

PHASES = ("mesh", "partition", "assembly", "solve", "output")
COLUMNS = ("scene", "cells", "ranks", "runs", "unknowns", "preset", "wall_s", "cores", *(f"{p}_s" for p in PHASES), "newton",
           "linear", "memory_mb", "kb_per_unknown", "unknowns_per_s", "raw_solver", "raw_wall_s", "ratio_raw",
           "elastic_wall_s", "ratio_elastic", "assembly_per_s", "raw_assembly_per_s")


def write_csv(path, columns, rows):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read_csv(path):
    """Rows with numbers where they are numbers; empty cells are None."""
    def value(text):
        try:
            return float(text)
        except ValueError:
            return text or None

    with open(path, newline="") as file:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(file)]


def text(value, form=".2f"):
    if value is None or value == "":
        return "-"
    return value if isinstance(value, str) else f"{value:{form}}"


def table(head, rows):
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


# As wide as a screen.
WIDEST = 100
# Columns that say of what a row is; the parts of a table that is too wide repeat them.
NAMES = ("scene", "ranks", "pressure", "n", "cubes")


def narrowed(page):
    """A page of Markdown, its tables split by columns and its prose broken where they are too wide."""
    blocks = []
    for block in page.split("\n\n"):
        lines = block.split("\n")
        wide = max(map(len, lines)) > WIDEST
        if wide and all(line.startswith("|") for line in lines):
            block = split(*([cell.strip() for cell in line.strip("|").split("|")] for line in lines if "---" not in line))
        elif wide and not block.startswith(("|", "![", "#", " ", "```")):
            block = fill(" ".join(lines), WIDEST)
        blocks.append(block)
    return "\n\n".join(blocks)


def split(head, *rows):
    """A table as several, each with the columns that say of what a row is."""
    names = [i for i, name in enumerate(head) if name in NAMES]
    wide = lambda columns: max(sum(len(row[i]) + 3 for i in columns) + 1 for row in (head, *rows))
    parts = [list(names)]
    for column in (i for i in range(len(head)) if i not in names):
        if len(parts[-1]) > len(names) and wide(parts[-1] + [column]) > WIDEST:
            parts.append(list(names))
        parts[-1].append(column)
    pick = lambda row, columns: [row[i] for i in columns]
    return "\n".join(table(pick(head, part), [pick(row, part) for row in rows]) for part in parts).rstrip("\n")


def middle(records, key):
    return median(r[key] for r in records) if records else None


def ratio(a, b):
    return a / b if a and b else None


def best_raw(records, scene, ranks):
    """The bare solver with the smallest median wall time on the scene's mesh, and that time."""
    walls = {}
    for r in records:
        if "solver" in r and r["ranks"] == ranks and r["scene"] == scene.name:
            walls.setdefault(r["solver"], []).append(r["wall"])
    if not walls:
        return None, None
    best = min(walls, key=lambda solver: median(walls[solver]))
    return best, median(walls[best])


def summary(records, scenes, ranks):
    """A row of COLUMNS for every scene and number of ranks that was run; medians over the runs."""
    rows = []
    for scene in scenes:
        for n in ranks:
            of = {kind: [r for r in records if r["kind"] == kind and r["ranks"] == n and r.get("scene") == scene.name]
                  for kind in ("eight", "elastic")}
            runs = of["eight"]
            if not runs:
                continue
            wall, memory, unknowns = middle(runs, "wall"), middle(runs, "memory"), runs[0]["unknowns"]
            solver, raw = best_raw(records, scene, n)
            elastic = middle(of["elastic"], "wall")
            assembly = middle(of["elastic"], "assembly")
            bare = [r for r in records if r.get("solver") == solver and r["ranks"] == n and r["scene"] == scene.name]
            bare_assembly = middle([r for r in bare if "assembly" in r], "assembly")
            rows.append({
                "scene": scene.name, "cells": scene.cells, "ranks": n, "runs": len(runs), "unknowns": unknowns,
                "preset": runs[0]["preset"], "wall_s": wall,
                "cores": median(r["cpu"] / r["wall"] for r in runs), **{f"{p}_s": middle(runs, p) for p in PHASES},
                "newton": runs[0]["newton"], "linear": middle(runs, "linear"), "memory_mb": memory / 1e6,
                "kb_per_unknown": memory / unknowns / 1e3, "unknowns_per_s": unknowns / wall, "raw_solver": solver,
                "raw_wall_s": raw, "ratio_raw": ratio(wall, raw), "elastic_wall_s": elastic,
                "ratio_elastic": ratio(wall, elastic), "assembly_per_s": ratio(unknowns, assembly),
                "raw_assembly_per_s": ratio(bare[0]["unknowns"], bare_assembly) if bare else None,
            })
    return rows


def exponent(points):
    """Slope of the least-squares line through (log x, log y); None for less than two points."""
    logs = [(math.log(x), math.log(y)) for x, y in points if x and y]
    if len(logs) < 2:
        return None
    mean_x, mean_y = (sum(c) / len(logs) for c in zip(*logs))
    across = sum((x - mean_x) ** 2 for x, _ in logs)
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / across if across else None


def growth(rows, scenes, ranks):
    """Table of how the cost grows along the cubes, for all and for those solved as the largest one is."""
    names = {scene.name for scene in scenes if scene.ladder}
    lines = []
    for n in ranks:
        ladder = sorted((r for r in rows if r["ranks"] == n and r["scene"] in names), key=lambda r: r["unknowns"])
        if not ladder:
            continue
        # Elimination has one iteration per solve: only cubes with one and the same preset can be compared.
        alike = [r for r in ladder if r["preset"] == ladder[-1]["preset"]]
        for label, chosen in (("all", ladder), (f"with {alike[-1]['preset']}", alike)):
            if chosen is alike and len(alike) == len(ladder):
                continue
            first, last = chosen[0], chosen[-1]
            iterations = ratio(last["linear"] / last["newton"], first["linear"] / first["newton"])
            one = len(chosen) == 1
            lines.append([label, str(n), f"{first['scene']} to {last['scene']}",
                          text(exponent([(r["unknowns"], r["wall_s"]) for r in chosen])),
                          text(exponent([(r["unknowns"], r["memory_mb"]) for r in chosen])),
                          "-" if one else f"{first['newton']:.0f} to {last['newton']:.0f}",
                          "-" if one else f"{first['linear']:.0f} to {last['linear']:.0f}",
                          "-" if one else text(iterations)])
    head = ["cubes", "ranks", "from, to", "exponent of wall time", "exponent of memory", "Newton iterations",
            "linear iterations", "linear per Newton, last / first"]
    return table(head, lines) if lines else ""


def speed_up(rows, triads):
    """Table of 1 against 2 ranks beside what the memory of the machine allows."""
    by_place = {(r["scene"], r["ranks"]): r for r in rows}
    lines = []
    for row in rows:
        other = by_place.get((row["scene"], 2))
        if row["ranks"] != 1 or not other:
            continue
        gains = [ratio(row[key], other[key]) for key in ("wall_s", "elastic_wall_s", "raw_wall_s")]
        lines.append([row["scene"], *map(text, gains)])
    stream = ""
    if len(triads) == 2:
        one, two = triads[1], triads[2]
        stream = f"\nSTREAM triad: {one:.1f} GB/s on 1 rank, {two:.1f} GB/s on 2: ratio {two / one:.2f}.\n"
    if not lines:
        return stream
    return table(["2 against 1 rank", "eight instants", "elastic instant", "raw solve"], lines) + stream


def bench(rows, scenes, ranks, triads, notes, heading):
    """The whole page of the ladder."""
    cost = [[r["scene"], r["cells"], str(r["ranks"]), f"{r['unknowns']:.0f}", r["preset"], text(r["wall_s"]), text(r["cores"]),
             *(text(r[f"{p}_s"]) for p in PHASES), f"{r['newton']:.0f}", f"{r['linear']:.0f}",
             text(r["memory_mb"], ".0f"), text(r["kb_per_unknown"]), text(r["unknowns_per_s"], ".0f")] for r in rows]
    ratios = [[r["scene"], str(r["ranks"]), text(r["wall_s"]), text(r["elastic_wall_s"]), text(r["ratio_elastic"]),
               text(r["raw_wall_s"]), text(r["raw_solver"]), text(r["ratio_raw"])] for r in rows]
    head = ["scene", "cells", "ranks", "unknowns", "preset", "wall s", "cores", *PHASES, "Newton", "linear", "MB", "kB/unknown",
            "unknowns/s"]
    parts = [
        heading,
        "Eight instants:\n", table(head, cost),
        "Against one elastic instant of this program, and against one bare PETSc solve of the same mesh:\n",
        table(["scene", "ranks", "eight s", "elastic s", "eight / elastic", "raw s", "raw solver", "eight / raw"],
              ratios),
        "Growth over the cubes:\n", growth(rows, scenes, ranks),
        "Speed-up:\n", speed_up(rows, triads),
        "Assembly, in 1000 unknowns per second: all that the elastic instant counts under it (cells, mortar operators, levels "
        "of multigrid, residuals), and the loop of MatSetValues into AIJ of the bare solve:\n",
        table(["scene", "ranks", "this program", "bare loop", "ratio"],
              [[r["scene"], str(r["ranks"]), text(r["assembly_per_s"] and r["assembly_per_s"] / 1e3, ".0f"),
                text(r["raw_assembly_per_s"] and r["raw_assembly_per_s"] / 1e3, ".0f"),
                text(ratio(r["assembly_per_s"], r["raw_assembly_per_s"]))] for r in rows]),
    ]
    if any(scene.instead and scene.name in {r["scene"] for r in rows} for scene in scenes):
        instead = ", ".join(f"{s.name}: {'x'.join(map(str, s.instead))}" for s in scenes if s.instead)
        parts.append(f"The raw solve knows one mesh only; in its place one of about as many unknowns ({instead}).\n")
    if notes:
        parts.append("Left out or failed:\n\n" + "".join(f"- {note}\n" for note in notes))
    return "\n".join(parts)


PRESET_COLUMNS = ("scene", "ladder", "cells", "ranks", "unknowns", "preset", "auto", "wall_s", "newton", "linear",
                  "memory_mb", "ratio_best", "at_least_s", "why_not")


def presets(rows, heading, most=1.3):
    """The page of the presets: a line per scene and ranks, and what `auto` loses on it."""
    places, names = {}, []
    for row in rows:
        places.setdefault((row["scene"], row["ranks"]), {})[row["preset"]] = row
        if row["preset"] not in names:
            names.append(row["preset"])
    lines, losses = [], []
    for (scene, ranks), found in places.items():
        chosen = next((r for r in found.values() if r["auto"]), None)
        cells = []
        for name in names:
            row = found.get(name, {})
            cells.append(f"{row['wall_s']:.2f}" if row.get("wall_s") else row.get("why_not") or "-")
        loss = chosen["ratio_best"] if chosen else None
        losses.append((loss, scene, ranks))
        least = "> " if chosen and not chosen.get("wall_s") and loss else ""
        lines.append([scene, f"{ranks:.0f}", *cells, chosen["preset"] if chosen else "-", least + text(loss),
                      "-" if not loss else "yes" if loss <= most else "**no**"])
    known = [entry for entry in losses if entry[0]]
    verdict = ""
    if known:
        loss, scene, ranks = max(known)
        unknown = len(losses) - len(known)
        verdict = f"\n`auto` takes up to {loss:.2f} times as long as the best preset ({scene}, {ranks:.0f} rank(s))"
        verdict += f"; unknown in {unknown} place(s).\n" if unknown else ".\n"
    return heading + "\n" + table(["scene", "ranks", *(f"{n} s" for n in names), "auto takes", "auto / best",
                                   f"within {most}"], lines) + verdict
