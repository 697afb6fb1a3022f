//! Solutions that are made up, with the loads that belong to them.
//!
//! Two bodies meet at z = 1/2 along an interface that softens everywhere. All fields are sums of
//! powers of the height above the interface times c + s sin(theta) + k cos(theta), theta a linear
//! function of x (and y): they can be differentiated by hand and written as formulas.

/// c + s sin(theta) + k cos(theta).
#[derive(Debug, Clone, Copy, Default)]
pub struct Wave {
    pub c: f64,
    pub s: f64,
    pub k: f64,
}

impl Wave {
    fn scaled(self, factor: f64) -> Self {
        Self { c: factor * self.c, s: factor * self.s, k: factor * self.k }
    }

    fn plus(self, other: Self) -> Self {
        Self { c: self.c + other.c, s: self.s + other.s, k: self.k + other.k }
    }

    fn slope(self) -> Self {
        Self { c: 0.0, s: -self.k, k: self.s }
    }

    fn at(self, theta: f64) -> f64 {
        self.c + self.s * theta.sin() + self.k * theta.cos()
    }

    fn text(self, theta: &str) -> String {
        let (amplitude, phase) = (self.s.hypot(self.k), self.k.atan2(self.s));
        format!("({:e}+{amplitude:e}*sin({theta}+{phase:e}))", self.c)
    }
}

/// The height above the interface is z less this.
pub const HEIGHT: f64 = 0.5;

/// Sum of powers of the height above the interface, with waves as coefficients.
#[derive(Debug, Clone, Default)]
struct Field(Vec<Wave>);

impl Field {
    fn scaled(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|w| w.scaled(factor)).collect())
    }

    fn plus(&self, other: &Self) -> Self {
        let get = |f: &Self, i: usize| f.0.get(i).copied().unwrap_or_default();
        Self(
            (0..self.0.len().max(other.0.len()))
                .map(|i| get(self, i).plus(get(other, i)))
                .collect(),
        )
    }

    fn along_theta(&self) -> Self {
        Self(self.0.iter().map(|w| w.slope()).collect())
    }

    fn along_height(&self) -> Self {
        Self(self.0.iter().enumerate().skip(1).map(|(i, w)| w.scaled(i as f64)).collect())
    }

    fn at(&self, theta: f64, height: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, w| sum * height + w.at(theta))
    }

    fn text(&self, theta: &str) -> String {
        let term = |(i, w): (usize, &Wave)| w.text(theta) + &format!("*(z-{HEIGHT})").repeat(i);
        let terms: Vec<String> = self.0.iter().enumerate().map(term).collect();
        if terms.is_empty() { "0".into() } else { terms.join("+") }
    }
}

/// theta = across[0] x + across[1] y + phase.
const ACROSS: [f64; 2] = [2.0, 1.3];
const PHASE: f64 = 0.4;

pub const STRENGTH: f64 = 1.0;
pub const CRITICAL: f64 = 0.1;

/// One body: its material and its displacement.
struct Body {
    young_modulus: f64,
    poisson_ratio: f64,
    across: [f64; 2],
    displacement: [Field; 3],
}

impl Body {
    fn lame(&self) -> (f64, f64) {
        let (e, nu) = (self.young_modulus, self.poisson_ratio);
        (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
    }

    fn along(&self, field: &Field, axis: usize) -> Field {
        if axis == 2 { field.along_height() } else { field.along_theta().scaled(self.across[axis]) }
    }

    fn stress(&self, i: usize, j: usize) -> Field {
        let (lambda, mu) = self.lame();
        let u = &self.displacement;
        let shear = self.along(&u[i], j).plus(&self.along(&u[j], i)).scaled(mu);
        if i != j {
            return shear;
        }
        let trace = (0..3).fold(Field::default(), |sum, k| sum.plus(&self.along(&u[k], k)));
        shear.plus(&trace.scaled(lambda))
    }

    /// What keeps the stress in equilibrium.
    fn force(&self, i: usize) -> Field {
        let divergence =
            (0..3).fold(Field::default(), |sum, j| sum.plus(&self.along(&self.stress(i, j), j)));
        divergence.scaled(-1.0)
    }
}

/// Lower and upper body, and the traction between them.
pub struct Manufactured {
    pub dim: usize,
    /// Whether the left side is held by prescribed displacements, the edge of the interface
    /// included.
    holds_left: bool,
    bodies: [Body; 2],
    traction: [Wave; 3],
}

impl Manufactured {
    /// Opens everywhere; its edges are free.
    pub fn new(dim: usize) -> Self {
        // Between 0.18 and 0.42 of the critical jump.
        Self::with(dim, Wave { c: 0.3 * CRITICAL, s: 0.12 * CRITICAL, k: 0.0 }, false)
    }

    /// Held on the left, where it does not open: both lips have one place there, and a formula one
    /// value.
    pub fn held_on_the_left() -> Self {
        let part = 0.2 * CRITICAL;
        let size = Wave { c: part, s: -part * PHASE.sin(), k: -part * PHASE.cos() };
        Self::with(2, size, true)
    }

    fn with(dim: usize, size: Wave, holds_left: bool) -> Self {
        let across = if dim == 2 { [ACROSS[0], 0.0] } else { ACROSS };
        // The jump has one direction.
        let (tilt, turn) = (0.5_f64, if dim == 2 { 0.0 } else { 0.7_f64 });
        let direction = [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()];
        let law = Wave { c: STRENGTH, ..Wave::default() }.plus(size.scaled(-STRENGTH / CRITICAL));
        let traction = direction.map(|e| law.scaled(e));
        let at_lip = |i: usize, upper: f64| {
            let base = Wave { c: 0.01 * i as f64, s: 0.02 - 0.004 * i as f64, k: 0.011 };
            base.plus(size.scaled(upper * direction[i]))
        };
        let body = |upper: f64, young_modulus: f64, poisson_ratio: f64| {
            let mut body =
                Body { young_modulus, poisson_ratio, across, displacement: Default::default() };
            let (lambda, mu) = body.lame();
            let lip: [Wave; 3] = std::array::from_fn(|i| at_lip(i, upper));
            let mut first = [Wave::default(); 3];
            let mut spread = Wave::default();
            for i in 0..dim - 1 {
                first[i] = traction[i].scaled(1.0 / mu);
                first[i] = first[i].plus(lip[2].slope().scaled(-across[i]));
                spread = spread.plus(lip[i].slope().scaled(across[i]));
            }
            let normal = traction[2].plus(spread.scaled(-lambda));
            first[2] = normal.scaled(1.0 / (lambda + 2.0 * mu));
            let second = Wave { c: 0.02 * upper - 0.01, s: 0.015, k: -0.02 };
            for i in (0..3).filter(|i| dim == 3 || *i != 1) {
                body.displacement[i] = Field(vec![lip[i], first[i], second]);
            }
            body
        };
        Self { dim, holds_left, bodies: [body(0.0, 100.0, 0.3), body(1.0, 140.0, 0.2)], traction }
    }

    fn theta(&self, [x, y, _]: [f64; 3]) -> f64 {
        let across = self.bodies[0].across;
        across[0] * x + across[1] * y + PHASE
    }

    /// Displacement, its gradient and Lame's constants at a point of a body.
    pub fn at(&self, upper: bool, point: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3], (f64, f64)) {
        let body = &self.bodies[usize::from(upper)];
        let (theta, height) = (self.theta(point), point[2] - HEIGHT);
        let u = &body.displacement;
        let gradient = |i: usize| std::array::from_fn(|j| body.along(&u[i], j).at(theta, height));
        (
            std::array::from_fn(|i| u[i].at(theta, height)),
            std::array::from_fn(gradient),
            body.lame(),
        )
    }

    pub fn traction(&self, point: [f64; 3]) -> [f64; 3] {
        self.traction.map(|t| t.at(self.theta(point)))
    }

    fn text(&self, of: impl Fn(&Body) -> Field) -> String {
        let theta = match self.dim {
            2 => format!("{}*x+{PHASE}", ACROSS[0]),
            _ => format!("{}*x+{}*y+{PHASE}", ACROSS[0], ACROSS[1]),
        };
        let [lower, upper] = [&self.bodies[0], &self.bodies[1]].map(of);
        let step = upper.plus(&lower.scaled(-1.0)).text(&theta);
        let lower = lower.text(&theta);
        format!("{lower}+min(1,max(0,1e9*(z-{HEIGHT})))*({step})")
    }

    /// The components of a vector as the case file has them.
    fn vector(&self, of: impl Fn(&Body, usize) -> Field) -> String {
        let axes: &[usize] = if self.dim == 2 { &[0, 2] } else { &[0, 1, 2] };
        let component = |i: &usize| {
            let name = ["x", "y", "z"][*i];
            format!("{name}: {{formula: \"{}\"}}", self.text(|body| of(body, *i)))
        };
        axes.iter().map(component).collect::<Vec<_>>().join(", ")
    }

    /// The case; `bodies` is that list of the mesh. Displacements are prescribed below and above,
    /// tractions on the sides that are not held.
    pub fn yaml(&self, bodies: &str) -> String {
        let size = if self.dim == 2 { "[1.0, 1.0]" } else { "[1.0, 1.0, 1.0]" };
        let mut boundary = String::new();
        let sides = [("left", 0, -1.0), ("right", 0, 1.0), ("front", 1, -1.0), ("back", 1, 1.0)];
        let sides = &sides[..2 * self.dim - 2];
        let held = self.holds_left.then_some("left");
        for surface in ["bottom", "top"].into_iter().chain(held) {
            let u = self.vector(|body, i| body.displacement[i].clone());
            boundary += &format!("  - {{on: {surface}, displacement: {{{u}}}}}\n");
        }
        for (surface, axis, sign) in sides.iter().filter(|side| held != Some(side.0)) {
            let t = self.vector(|body, i| body.stress(i, *axis).scaled(*sign));
            boundary += &format!("  - {{on: {surface}, traction: {{{t}}}}}\n");
        }
        let material = |body: &Body, z: [f64; 2]| {
            format!(
                "{{z: [{}, {}], elastic: {{young_modulus: {}, poisson_ratio: {}}}}}",
                z[0], z[1], body.young_modulus, body.poisson_ratio
            )
        };
        format!(
            "
mesh: {{column: {{size: {size}, bodies: {bodies}}}}}
materials:
  lower: {}
  upper: {}
interfaces:
  - {{name: joint, z: {HEIGHT}, law: {{linear_softening: {{strength: {STRENGTH}, fracture_energy: {}}}}}}}
boundary:
{boundary}body_force: {{{}}}
time: {{instants: [1]}}
",
            material(&self.bodies[0], [0.0, HEIGHT]),
            material(&self.bodies[1], [HEIGHT, 1.0]),
            0.5 * STRENGTH * CRITICAL,
            self.vector(Body::force),
        )
    }
}
