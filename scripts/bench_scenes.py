"""The scenes of the benchmark: eight instants of one column on several meshes."""

from dataclasses import dataclass
from functools import cached_property

# The path of WTNV146: pressed, pulled beyond the strength, unloaded, broken, sheared, closed again.
AXIAL = """{
      x: {table: [[6, 0], [7, 1.0e-3], [8, 0]]},
      y: 0,
      z: {table: [[0, 0], [1, -1.0e-4], [2, 1.0e-4], [3, 1.0e-3], [4, 5.0e-4], [5, 1.2e-3], [6, 1.7e-3], [7, 1.7e-3],
                  [8, -1.0e-4]]}}"""
# Mixed mode: opens unevenly while it slides, then goes back.
TILTED = """{
      x: {formula: "1e-4*min(t, 8-t)"},
      y: 0,
      z: {formula: "3e-4*min(t, 8-t)*(1 + 0.4*(x-0.5) + 0.2*(y-0.5))"}}"""

CASE = """title: Benchmark {name}
mesh: {{column: {{size: [1.0, 1.0, 5.0], {mesh}}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: {nu}}}}}}}
interfaces:
  - {{name: joint, z: 2.5, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0, augmentation: 10.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - on: top
    displacement: {top}
time: {{instants: [1, 2, 3, 4, 5, 6, 7, 8]}}
output: {{fields: {fields}}}
"""

# The elastic instant: the interface a perfect bond, the load of the third instant alone, in one step.
ELASTIC = ["interfaces.0.law={tied: {}}", "time.instants=[3]"]
ELASTIC_AXIAL = ELASTIC + ["boundary.1.displacement.x=0", "boundary.1.displacement.z=1.0e-3"]


@dataclass(frozen=True)
class Scene:
    """One mesh with one load. `bodies` holds the cells of each body, or of the whole column."""

    name: str
    bodies: tuple
    nu: float = 0.3
    top: str = AXIAL
    # The mesh of the bare PETSc solve where it is not that of the column itself.
    instead: tuple = ()
    once: bool = False
    checked: bool = False
    ladder: bool = False

    @property
    def elastic(self):
        return ELASTIC_AXIAL if self.top == AXIAL else ELASTIC

    @property
    def raw_cells(self):
        return self.instead or self.bodies[0]

    @property
    def cells(self):
        return " + ".join("x".join(map(str, body)) for body in self.bodies)

    @cached_property
    def unknowns(self):
        """About: what limits and forecasts go by; the tables show what the program reports."""
        nodes = sum((x + 1) * (y + 1) * (z + 1) for x, y, z in self.bodies)
        if len(self.bodies) == 1:
            x, y, z = self.bodies[0]
            # The nodes of the interface are there twice; a layer of cells that holds it is split.
            nodes += (x + 1) * (y + 1) * (1 + z % 2)
        return 3 * nodes

    def case(self, fields):
        """The text of the case file."""
        if len(self.bodies) == 1:
            mesh = f"cells: {list(self.bodies[0])}"
        else:
            mesh = "bodies: [" + ", ".join(f"{{cells: {list(body)}}}" for body in self.bodies) + "]"
        return CASE.format(name=self.name, mesh=mesh, nu=self.nu, top=self.top, fields=fields)


def cube(n, **more):
    return Scene(f"cube-{n}", ((n, n, 5 * n),), ladder=True, **more)


def tilted(n, **more):
    return Scene(f"tilted-{n}", ((n, n, 5 * n),), top=TILTED, **more)


def nonmatching(k, instead):
    """Two cells of the lower body face three of the upper one."""
    return Scene("nonmatching", ((2 * k, 2 * k, 5 * k), (3 * k, 3 * k, 15 * k // 2)), instead=instead)


QUICK = [cube(8, checked=True), cube(12, checked=True), cube(16), tilted(12, checked=True)]

FULL = [
    cube(8, checked=True),
    tilted(12, checked=True),
    cube(16, checked=True),
    Scene("nu0-16", ((16, 16, 80),), nu=0.0, checked=True),
    Scene("slender", ((8, 8, 320),), checked=True),
    Scene("stretched", ((16, 16, 20),)),
    cube(24),
    Scene("odd-25", ((25, 25, 125),)),
    # The bare solve has one mesh, 26 x 26 x 130: its unknowns differ from the two bodies' by less than 1 %.
    nonmatching(10, instead=(26, 26, 130)),
    tilted(24),
    cube(32),
    cube(48, once=True),
]
