"""Reads what the tests of the stability suite print."""

import json
import re
from pathlib import Path


class Wrong(Exception):
    """What keeps the page from being written."""


def read(directory):
    """The measured values by their names, with `inf_sup`, `null` and `orders`."""
    directory = Path(directory)
    try:
        suite = (directory / "suite.log").read_text()
        lib = (directory / "inf_sup.log").read_text()
    except OSError as error:
        raise Wrong(f"{error}; scripts/stability.sh runs the tests first") from None
    found = {}
    for line in suite.splitlines():
        # A test that ends may have begun the line.
        if "measured {" in line:
            record = json.loads(line[line.index("measured {") + len("measured "):])
            found[record["key"]] = record["value"]
    found["orders"] = dict(filter(None, map(order, suite.splitlines())))
    found["inf_sup"] = {m[1]: json.loads(m[2]) for m in re.finditer(r"inf-sup (.*?): (\[[^\]]*\])$", lib, re.M)}
    null = re.finditer(r"null (\dD), \[\((\d+), 1\), \((\d+), 1\)\]: (\d+) kept, (\d+) dropped", lib)
    found["null"] = [(f"{m[1]}, {m[2]} : {m[3]}", int(m[4]), int(m[5])) for m in null]
    for key in ("orders", "inf_sup", "null"):
        if not found[key]:
            raise Wrong(f"the logs hold no {key}")
    return found


def order(line):
    """A line of the tests of orders: (order, cells) and the errors of each level; None for other lines."""
    match = re.search(r"(\d)D, order (\d), (\[\d+, \d+\]): Errors \{.*?\} from (.*)", line)
    if not match:
        return None
    names = ("displacement", "energy", "traction")
    levels = {name: [float(v) for v in re.findall(rf"{name}: ([0-9.]+)", match[4])] for name in names}
    return (int(match[2]), tuple(json.loads(match[3]))), levels
