#!/usr/bin/env python3
"""Draws an interface's normal traction over the imposed displacement, as SVG.

    scripts/plot_history.py results/case [-o chart.svg] [--interface joint] [--on top]

Reads history.csv and report.json of an output directory: the line is what was computed at each
instant, the circles are the exact values that the case expects, numbered by their instant. Standard library only.

docs/wtnv146.svg is drawn from a run with more instants on the way, which shows the path between the eight:

    target/release/column-hpc cases/wtnv146/case.yaml --output results/path --set output.fields=none \
        --set "time.instants=[$(seq -s, 0.02 0.02 8)]"
    scripts/plot_history.py results/path -o docs/wtnv146.svg
"""

import argparse
import csv
import json
import math
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

WIDTH, HEIGHT = 640, 400
LEFT, RIGHT, TOP, BOTTOM = 76, 20, 44, 56
STYLE = """
text { font: 13px sans-serif; fill: #222 }
.title { font-size: 15px; font-weight: bold }
.axis { stroke: #222; stroke-width: 1 }
.grid { stroke: #ddd; stroke-width: 1 }
.path { stroke: #1f5fa8; stroke-width: 2; fill: none; stroke-linejoin: round }
.exact { stroke: #c23b22; stroke-width: 1.5; fill: none }
.instant { fill: #c23b22; font-weight: bold }
"""


class Wrong(Exception):
    """What the user can put right."""


def value_at(value, time):
    """A value of the case at a time: a number or a table, linear between, constant beyond."""
    if isinstance(value, (int, float)):
        return float(value)
    table = value.get("table") if isinstance(value, dict) else None
    if not table:
        raise Wrong("the imposed displacement is neither a number nor a table")
    if time <= table[0][0]:
        return float(table[0][1])
    for (t0, v0), (t1, v1) in zip(table, table[1:]):
        if time <= t1:
            return v0 + (v1 - v0) * (time - t0) / (t1 - t0)
    return float(table[-1][1])


def read(directory, interface, surface):
    """The interface's name, the path and the exact points, both [(time, displacement, traction)] in s, m, Pa."""
    with open(directory / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    case = json.loads((directory / "report.json").read_text())["case"]
    if not rows:
        raise Wrong(f"{directory / 'history.csv'} has no rows")
    names = [c.removesuffix(".normal_traction.mean") for c in rows[0] if c.endswith(".normal_traction.mean")]
    name = interface or (names[0] if names else None)
    if name not in names:
        raise Wrong(f"history.csv has no normal traction of {name}; interfaces: {', '.join(names) or 'none'}")
    imposed = None
    for entry in case.get("boundary", []):
        displacement = entry.get("displacement") or {}
        if entry.get("on") == surface and displacement.get("z") is not None:
            imposed = displacement["z"]
            break
    if imposed is None:
        raise Wrong(f"the case prescribes no displacement z on {surface}")
    quantities = {f"{name}.normal_traction{end}" for end in ("", ".min", ".max", ".mean")}
    times = [float(r["time"]) for r in rows]
    path = [(t, value_at(imposed, t), float(r[f"{name}.normal_traction.mean"])) for t, r in zip(times, rows)]
    exact = [
        (float(e["at"]), value_at(imposed, e["at"]), float(e["equals"]))
        for e in case.get("expect") or []
        if e["quantity"] in quantities
    ]
    return name, path, exact


def ticks(low, high):
    """About six round numbers that cover the range."""
    raw = (high - low or 1.0) / 6
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(m * power for m in (1, 2, 2.5, 5, 10) if m * power >= raw * (1 - 1e-12))
    return [i * step for i in range(math.floor(low / step), math.ceil(high / step - 1e-9) + 1)]


def labels(path, exact):
    """For every exact point its instants in words, and whether they stand above it: where the path falls."""
    found = {}
    before = (0.0, 0.0, 0.0)
    falls = {}
    for time, u, t in path:
        falls[time] = u > before[1] and t < before[2]
        before = (time, u, t)
    for time, u, t in exact:
        place = (round(u, 9), round(t, 3))
        texts, above = found.setdefault(place, ([], falls.get(time, False)))
        texts.append(f"{time:g}")
        found[place] = (texts, above)
    return [(place, ", ".join(texts), above) for place, (texts, above) in found.items()]


def draw(name, path, exact):
    """The chart as the text of an SVG file."""
    # From the undeformed state, which history.csv leaves out.
    points = [(0.0, 0.0)] + [(u * 1e3, t / 1e6) for _, u, t in path]
    circles = [(u * 1e3, t / 1e6) for _, u, t in exact]
    every = points + circles + [(0.0, 0.0)]
    across = ticks(min(p[0] for p in every), max(p[0] for p in every))
    up = ticks(min(p[1] for p in every), max(p[1] for p in every))

    def x(u):
        return LEFT + (u - across[0]) / (across[-1] - across[0]) * (WIDTH - LEFT - RIGHT)

    def y(t):
        return HEIGHT - BOTTOM - (t - up[0]) / (up[-1] - up[0]) * (HEIGHT - TOP - BOTTOM)

    svg = xml.Element("svg", xmlns="http://www.w3.org/2000/svg", viewBox=f"0 0 {WIDTH} {HEIGHT}",
                      width=str(WIDTH), height=str(HEIGHT))

    def add(tag, text=None, **attributes):
        attributes = {k.rstrip("_").replace("_", "-"): v if isinstance(v, str) else f"{v:.2f}"
                      for k, v in attributes.items()}
        xml.SubElement(svg, tag, attributes).text = text

    def line(kind, x1, y1, x2, y2):
        add("line", class_=kind, x1=x1, y1=y1, x2=x2, y2=y2)

    add("style", STYLE)
    add("rect", width="100%", height="100%", fill="#fff")
    add("text", f"{name}: normal traction over imposed displacement", x=LEFT, y=24, class_="title")
    for u in across:
        line("grid", x(u), y(up[0]), x(u), y(up[-1]))
        add("text", f"{u:.4g}", x=x(u), y=HEIGHT - BOTTOM + 18, text_anchor="middle")
    for t in up:
        line("grid", x(across[0]), y(t), x(across[-1]), y(t))
        add("text", f"{t:.4g}", x=LEFT - 8, y=y(t) + 4, text_anchor="end")
    line("axis", x(across[0]), y(0.0), x(across[-1]), y(0.0))
    line("axis", x(0.0), y(up[0]), x(0.0), y(up[-1]))
    add("text", "imposed displacement (mm)", x=(LEFT + WIDTH - RIGHT) / 2, y=HEIGHT - 12, text_anchor="middle")
    middle = (TOP + HEIGHT - BOTTOM) / 2
    add("text", "normal traction (MPa)", x=18, y=middle, text_anchor="middle",
        transform=f"rotate(-90 18 {middle:.2f})")
    add("polyline", class_="path", points=" ".join(f"{x(u):.2f},{y(t):.2f}" for u, t in points))
    for u, t in circles:
        add("circle", class_="exact", cx=x(u), cy=y(t), r="5")
    for (u, t), text, above in labels(path, exact):
        # Clear of the vertical axis on its left.
        side, anchor = (-9, "end") if u < 0 else (9, "start")
        add("text", text, x=x(u * 1e3) + side, y=y(t / 1e6) + (-5 if above else 16),
            text_anchor=anchor, class_="instant")
    key = WIDTH - RIGHT - 250
    line("path", key, TOP + 14, key + 24, TOP + 14)
    add("text", "computed", x=key + 32, y=TOP + 18)
    if circles:
        add("circle", class_="exact", cx=key + 112, cy=TOP + 14, r="5")
        add("text", "exact, at instant", x=key + 124, y=TOP + 18)
    xml.indent(svg)
    return xml.tostring(svg, encoding="unicode") + "\n"


class Test(unittest.TestCase):
    """A history of two instants, drawn."""

    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.directory = Path(self.scratch.name)
        (self.directory / "history.csv").write_text(
            "time,joint.normal_traction.mean\n1,-1.0e6\n2,1.0e6\n"
        )
        case = {
            "boundary": [
                {"on": "bottom", "displacement": {"z": 0}},
                {"on": "top", "displacement": {"z": {"table": [[0, 0], [1, -1e-3], [3, 3e-3]]}}},
            ],
            "expect": [
                {"quantity": "joint.normal_traction", "at": 2, "equals": 1.0e6},
                {"quantity": "joint.shear_traction_x", "at": 2, "equals": 0},
            ],
        }
        (self.directory / "report.json").write_text(json.dumps({"case": case}))

    def tearDown(self):
        self.scratch.cleanup()

    def test_reads_path_and_exact_points(self):
        name, path, exact = read(self.directory, None, "top")
        self.assertEqual(name, "joint")
        self.assertEqual(path, [(1, -1e-3, -1e6), (2, 1e-3, 1e6)])
        self.assertEqual(exact, [(2, 1e-3, 1e6)])

    def test_circle_lies_on_the_line(self):
        tree = xml.fromstring(draw(*read(self.directory, None, "top")))
        space = "{http://www.w3.org/2000/svg}"
        last = tree.find(f"{space}polyline").get("points").split()[-1]
        circle = tree.find(f"{space}circle")
        self.assertEqual(last, f"{circle.get('cx')},{circle.get('cy')}")

    def test_points_that_meet_share_a_label(self):
        path = [(1, 1e-3, 1e6), (2, 2e-3, 0.0), (3, 1e-3, 1e6)]
        found = labels(path, path)
        self.assertEqual(found, [((1e-3, 1e6), "1, 3", False), ((2e-3, 0.0), "2", True)])

    def test_names_what_is_missing(self):
        with self.assertRaisesRegex(Wrong, "interfaces: joint"):
            read(self.directory, "fault", "top")
        with self.assertRaisesRegex(Wrong, "no displacement z on left"):
            read(self.directory, None, "left")

    def test_ticks_cover_the_range(self):
        self.assertEqual(ticks(0.0, 6.0), [0, 1, 2, 3, 4, 5, 6])
        found = ticks(-0.116, 1.0173)
        self.assertTrue(found[0] <= -0.116 and found[-1] >= 1.0173 and 5 <= len(found) <= 9)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", type=Path, nargs="?", help="output directory of a run")
    parser.add_argument("-o", "--output", type=Path, help="SVG file (default: DIRECTORY/history.svg)")
    parser.add_argument("--interface", help="default: the first of history.csv")
    parser.add_argument("--on", default="top", help="surface whose displacement z is imposed")
    parser.add_argument("--self-test", action="store_true", help="run this script's own tests")
    options = parser.parse_args()
    if options.self_test:
        unittest.main(argv=[sys.argv[0]])
    if options.directory is None:
        parser.error("the output directory of a run is needed")
    output = options.output or options.directory / "history.svg"
    try:
        output.write_text(draw(*read(options.directory, options.interface, options.on)))
    except (OSError, KeyError, ValueError, Wrong) as error:
        sys.exit(f"plot_history: {error}")
    print(output)


if __name__ == "__main__":
    main()
