//! Joints of one facet between crossings: walls whose bricks are one cell each.

use crate::any_mesh::TURN;
use crate::cubes::{Blocks, Cut};
use crate::scene::{Run, Scene};

/// Displacement gradient of the patches: any, and one that presses all joints alike.
const ANY: [[f64; 3]; 3] =
    [[0.7e-4, 0.3e-4, 0.9e-4], [-0.2e-4, 0.4e-4, 0.6e-4], [0.5e-4, 0.1e-4, 1.1e-4]];
const PRESSED: [[f64; 3]; 3] = [[-1e-4, 0.0, 0.0], [0.0, -1e-4, 0.0], [0.0, 0.0, -1e-4]];
const TIED: &str = "{tied: {}}";
const COHESIVE: &str = "{linear_softening: {strength: 1.1e7, fracture_energy: 900}}";
const CONTACT: &str = "{contact: {}}";

/// A wall of bricks, each of them a cell or a cube cut into some.
struct Wall {
    bricks: [usize; 3],
    cut: Cut,
    /// Whether the heads of a course lie amid the bricks of the next one.
    is_bonded: bool,
    /// Where points of the straight wall lie.
    matrix: [[f64; 3]; 3],
}

const STRAIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// In the plane: turned, sheared, stretched.
const SKEW: [[f64; 3]; 3] = [[1.1, -0.5, 0.0], [0.7, 0.8, 0.0], [0.0, 0.0, 1.0]];

impl Wall {
    fn plane(bricks: [usize; 2], is_bonded: bool, matrix: [[f64; 3]; 3]) -> Self {
        Self { bricks: [bricks[0], bricks[1], 0], cut: Cut::Squares, is_bonded, matrix }
    }

    fn block(cut: Cut) -> Self {
        Self { bricks: [3, 3, 2], cut, is_bonded: false, matrix: TURN }
    }

    fn dim(&self) -> usize {
        if self.bricks[2] == 0 { 2 } else { 3 }
    }

    /// Writes the mesh, with the groups `outer`, `beds`, `heads` and `backs` across the axes,
    /// `foot` and `head`, and the points `corner` at the origin and `peg` above it.
    fn write(&self) -> String {
        let size = self.bricks.map(|count| count as f64);
        let is = |x: f64, at: usize| (x - at as f64).abs() < 1e-9;
        let mut blocks = Blocks::default().block([0.0; 3], size, self.bricks, self.cut);
        let between = |axis: usize| 1..self.bricks[axis].max(1);
        for plane in between(1) {
            blocks = blocks.group("beds", |x| is(x[1], plane));
        }
        for plane in between(0) {
            for row in (0..self.bricks[1]).filter(|row| !self.is_bonded || (plane + row) % 2 == 1) {
                let is_of_row = |y: f64| (y - row as f64 - 0.5).abs() < 0.5 + 1e-9;
                blocks = blocks.group("heads", |x| is(x[0], plane) && is_of_row(x[1]));
            }
        }
        for plane in between(2) {
            blocks = blocks.group("backs", |x| is(x[2], plane));
        }
        for axis in 0..self.dim() {
            for end in [0, self.bricks[axis]] {
                blocks = blocks.group("outer", |x| is(x[axis], end));
            }
        }
        blocks = blocks.group("foot", |x| is(x[1], 0)).group("head", |x| is(x[1], self.bricks[1]));
        blocks = blocks.point("corner", [0.0; 3]).point("peg", [0.0, size[1], 0.0]);
        blocks.mapped(|x| self.place(x)).write(false)
    }

    fn place(&self, x: [f64; 3]) -> [f64; 3] {
        self.matrix.map(|row| row.iter().zip(x).map(|(m, x)| m * x).sum())
    }

    /// The unit normal of the joints across an axis.
    fn normal(&self, axis: usize) -> [f64; 3] {
        let m = &self.matrix;
        let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
        let (a, b) = (column((axis + 1) % 3), column((axis + 2) % 3));
        let cross = |i: usize| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
        let cross = [cross(0), cross(1), cross(2)];
        let length = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
        cross.map(|x| x / length)
    }

    fn joints(&self) -> &'static [(&'static str, usize)] {
        &[("heads", 0), ("beds", 1), ("backs", 2)][..self.dim()]
    }

    /// Constant strain, prescribed on the whole outer boundary.
    fn patch(&self, gradient: [[f64; 3]; 3], heads: &str, others: &str) -> Scene {
        let (dim, axes) = (self.dim(), ["x", "y", "z"]);
        let component = |i: usize| {
            let term = |j: usize| format!("({:e})*{}", gradient[i][j], axes[j]);
            let terms: Vec<String> = (0..dim).map(term).collect();
            format!("{}: {{formula: \"t*({})\"}}", axes[i], terms.join("+"))
        };
        let law = |name: &str| if name == "heads" { heads } else { others };
        let joints = self.joints().iter();
        let interfaces: Vec<String> = joints
            .map(|(name, _)| format!("{{name: {name}, on: {name}, law: {}}}", law(name)))
            .collect();
        let yaml = format!(
            "
mesh: {{file: \"{}\"}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces: [{}]
boundary: [{{on: outer, displacement: {{{}}}}}]
time: {{instants: [1, 2]}}
",
            self.write(),
            interfaces.join(", "),
            (0..dim).map(component).collect::<Vec<_>>().join(", ")
        );
        Scene::new("wall", &yaml)
    }

    fn check(&self, run: &Run, gradient: [[f64; 3]; 3]) {
        let trace: f64 = (0..self.dim()).map(|i| gradient[i][i]).sum();
        let (shear, bulk) = (5.8e9 / 2.6, 5.8e9 * 0.3 / (1.3 * 0.4));
        for (name, axis) in self.joints() {
            let n = self.normal(*axis);
            let traction: [f64; 3] = std::array::from_fn(|i| {
                let of = |j: usize| shear * (gradient[i][j] + gradient[j][i]) * n[j];
                (0..self.dim()).map(of).sum::<f64>() + bulk * trace * n[i]
            });
            let exact: f64 = traction.iter().zip(n).map(|(t, n)| t * n).sum();
            let scale = traction.iter().map(|t| t * t).sum::<f64>().sqrt();
            for statistic in ["min", "max"] {
                let found = run.column(&format!("{name}.normal_traction.{statistic}"));
                for (t, found) in found.iter().enumerate() {
                    let error = (found - (t + 1) as f64 * exact).abs();
                    assert!(error < 1e-10 * scale, "{}: {name} {found} {exact}", run.label);
                }
                let jumps = run.column(&format!("{name}.normal_jump.{statistic}"));
                assert!(jumps.iter().all(|jump| jump.abs() < 1e-15), "{}: {jumps:?}", run.label);
            }
        }
    }
}

#[test]
fn they_carry_constant_tractions_in_the_plane() {
    for (is_bonded, matrix) in [(false, STRAIGHT), (true, SKEW), (true, STRAIGHT), (false, SKEW)] {
        let wall = Wall::plane([4, 3], is_bonded, matrix);
        let tied = wall.patch(ANY, TIED, TIED);
        wall.check(&tied.on(1), ANY);
        wall.check(&tied.set("solver.form=saddle_point").on(1), ANY);
        for ranks in [2, 3, 4] {
            wall.check(&wall.patch(ANY, COHESIVE, COHESIVE).scattered().on(ranks), ANY);
        }
        wall.check(&wall.patch(PRESSED, CONTACT, TIED).on(2), PRESSED);
    }
}

#[test]
fn they_carry_constant_tractions_between_cells_of_all_kinds() {
    for (cut, ranks) in
        [(Cut::Hexahedra, 1), (Cut::Prisms, 2), (Cut::Tetrahedra, 3), (Cut::Pyramids, 4)]
    {
        let wall = Wall::block(cut);
        wall.check(&wall.patch(ANY, TIED, TIED).on(ranks), ANY);
        let cohesive = wall.patch(ANY, COHESIVE, COHESIVE).set("solver.linear=gamg");
        let cohesive = cohesive.set("solver.tolerance=1e-12");
        wall.check(&cohesive.scattered().on(ranks), ANY);
        wall.check(&wall.patch(PRESSED, CONTACT, TIED).on(ranks), PRESSED);
    }
}

/// A wall that is held at its foot and moved at its head, whose joints have these strengths (Pa).
fn pulled(wall: &Wall, [heads, beds]: [f64; 2], moved: &str, instants: &str) -> Scene {
    let joint = |name: &str, strength: f64| {
        format!(
            "{{name: {name}, on: {name}, law: {{linear_softening: {{strength: {strength:e}, \
             fracture_energy: 3000}}}}}}"
        )
    };
    let yaml = format!(
        "
mesh: {{file: \"{}\"}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.2}}}}}}
interfaces: [{}, {}]
boundary: [{moved}]
time: {{instants: {instants}}}
solver: {{tolerance: 1e-11}}
",
        wall.write(),
        joint("heads", heads),
        joint("beds", beds)
    );
    Scene::new("pulled", &yaml)
}

/// Two courses, of which the bed between opens evenly: pressed, pulled, softened, unloaded, broken.
#[test]
fn a_wall_breaks_along_its_bed() {
    const STRENGTH: f64 = 1.1e6;
    const CRITICAL: f64 = 2.0 * 3000.0 / STRENGTH;
    let strain = |stress: f64| stress * (1.0 - 0.2 * 0.2) / 5.8e9;
    // Normal traction and opening at the instants from 1 on.
    let softened = 0.6 * STRENGTH;
    let states = [
        [-2e6, 0.0],
        [0.0, 0.0],
        [STRENGTH, 0.0],
        [softened, 0.4 * CRITICAL],
        [0.5 * softened, 0.2 * CRITICAL],
        [softened, 0.4 * CRITICAL],
        [0.0, CRITICAL],
        [0.0, 1.5 * CRITICAL],
        [0.0, 0.0],
        [-2e6, 0.0],
    ];
    let head = |[stress, jump]: [f64; 2]| 2.0 * strain(stress) + jump;
    let rows = states.iter().enumerate().map(|(t, s)| format!("[{}, {:e}]", t + 1, head(*s)));
    let table: Vec<String> = rows.collect();
    let moved = format!(
        "{{on: foot, displacement: {{y: 0}}}}, {{on: corner, displacement: {{x: 0}}}},
  {{on: peg, displacement: {{x: 0}}}}, {{on: head, displacement: {{y: {{table: [[0, 0], {}]}}}}}}",
        table.join(", ")
    );
    let wall = Wall::plane([4, 2], false, STRAIGHT);
    let scene = pulled(&wall, [2.0 * STRENGTH, STRENGTH], &moved, "[1,2,3,4,5,6,7,8,9,10]");
    let one = scene.on(1);
    for (t, [stress, jump]) in states.iter().enumerate() {
        for statistic in ["min", "max"] {
            let found = one.column(&format!("beds.normal_traction.{statistic}"))[t];
            assert!((found - stress).abs() < 1e-9 * STRENGTH, "{t}: {found} {stress}");
            let found = one.column(&format!("beds.normal_jump.{statistic}"))[t];
            assert!((found - jump).abs() < 1e-10 * CRITICAL, "{t}: {found} {jump}");
        }
    }
    one.assert_energy_balance(1e-9);
    let dissipated = one.column("energy.dissipated");
    assert!((dissipated[9] - 4.0 * 3000.0).abs() < 1e-9 * 3000.0, "{dissipated:?}");
    for ranks in [2, 3, 4] {
        one.assert_same(&scene.scattered().on(ranks), 1e-9);
    }
    one.assert_same(&scene.set("solver.form=saddle_point").on(2), 1e-9);
}

/// A wall in running bond, sheared and pulled until its joints are broken: nothing is even.
#[test]
fn a_bonded_wall_breaks_by_and_by() {
    let moved = "{on: foot, displacement: {x: 0, y: 0}},
  {on: head, displacement: {x: {formula: \"2e-3*t\"}, y: {formula: \"5e-3*t*(1+0.1*x)\"}}}";
    let wall = Wall::plane([3, 3], true, STRAIGHT);
    let instants: Vec<String> = (1..=80).map(|i| format!("{}", f64::from(i) / 80.0)).collect();
    let instants = format!("[{}]", instants.join(", "));
    let scene = pulled(&wall, [0.7e6, 1.1e6], moved, &instants).in_any_steps();
    let one = scene.on(1);
    one.assert_energy_balance(5e-3);
    let dissipated = one.column("energy.dissipated");
    assert!(dissipated.is_sorted() && dissipated[79] > 6000.0, "{dissipated:?}");
    for ranks in [2, 3, 4] {
        one.assert_same(&scene.scattered().on(ranks), 1e-8);
    }
    one.assert_same(&scene.set("solver.form=saddle_point").on(1), 1e-8);
}

/// A brick that hangs by a bed between two clefts, at most of whose nodes other joints meet it: it
/// would turn about the only node left.
#[test]
fn a_brick_that_a_single_node_would_hold() {
    let is = |x: f64, at: f64| (x - at).abs() < 1e-9;
    let blocks = Blocks::default()
        .block([0.0; 3], [5.0, 2.0, 0.0], [5, 2, 0], Cut::Squares)
        .group("bed", |x| is(x[1], 1.0))
        .group("head", |x| is(x[0], 2.0) && x[1] < 1.0 + 1e-9)
        .group("clefts", |x| (is(x[0], 1.0) || is(x[0], 4.0)) && x[1] > 1.0 - 1e-9)
        .group("foot", |x| is(x[1], 0.0))
        .group("top", |x| is(x[1], 2.0) && (x[0] - 2.5).abs() < 1.5 + 1e-9);
    let yaml = format!(
        "
mesh: {{file: \"{}\"}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.2}}}}}}
interfaces:
  - {{name: bed, on: bed, law: {TIED}}}
  - {{name: head, on: head, law: {TIED}}}
  - {{name: clefts, on: clefts, law: {CONTACT}}}
boundary:
  - {{on: foot, displacement: {{x: 0, y: 0}}}}
  - {{on: top, traction: {{normal: {{formula: \"t*(3e5 + 1e5*(x-2.5))\"}}}}}}
time: {{instants: [1]}}
probes: [{{name: left, at: [1.2, 1.9]}}, {{name: right, at: [3.8, 1.9]}}]
",
        blocks.write(false)
    );
    let scene = Scene::new("brick", &yaml);
    let risen =
        |run: &Run| ["left", "right"].map(|p| run.column(&format!("{p}.displacement_y"))[0]);
    let exact = risen(&scene.set("mesh.refine=4").on(1));
    let one = scene.on(1);
    for (found, exact) in risen(&one).into_iter().zip(exact) {
        assert!((found / exact - 1.0).abs() < 0.1, "{found} {exact}");
    }
    for ranks in [2, 3, 4] {
        one.assert_same(&scene.scattered().on(ranks), 1e-9);
    }
}
