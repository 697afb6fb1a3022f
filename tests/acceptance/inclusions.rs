//! Closed forms with a round interface of radius 1 m: an inclusion in an infinite plate, a ball in
//! an infinite body.

/// The interface has the radius 1 m; so far inwards and outwards the bodies go (m).
pub const RADII: [f64; 2] = [0.5, 2.0];
/// Young's moduli (Pa) and Poisson's ratios of the inner and the outer body.
pub const ELASTIC: [(f64, f64); 2] = [(2e10, 0.2), (5e9, 0.3)];

/// Lame's constants of the inner (0) or outer (1) body (Pa).
pub fn lame(body: usize) -> (f64, f64) {
    let (e, nu) = ELASTIC[body];
    (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
}

/// What is exact.
pub trait Exact {
    /// Displacement of a body at a place (m).
    fn displacement(&self, body: usize, x: [f64; 3]) -> [f64; 3];
    /// Traction of the interface in the direction of a place, on the inner body (Pa).
    fn traction(&self, x: [f64; 3]) -> [f64; 3];
}

/// A round inclusion in plane strain under -1 MPa along x and -2 MPa along y, with complex
/// potentials (Muskhelishvili): phi = S z + A/z, psi = T z + B/z + C/z^3 outside, D z + E z^3 and
/// F z inside, 2 mu u = kappa phi - z conj(phi') - conj(psi), kappa = 3 - 4 nu.
///
/// On the circle, in powers of w = exp(2 i theta), the plate has
///
///     2 mu (u_r + i u_theta) = (kappa S - S - B) + (A - C) w + (kappa A - T)/w
///     s_rr - i s_rtheta      = (2 S + B) - (A + T) w + (3 C - 3 A)/w
///
/// and the inclusion (kappa D - D) + kappa E w - (3 E + F)/w and 2 D - (3 E + F) w + 3 E/w.
/// Bonded, all are equal: E = 0, C = A, F = A + T. Without friction the terms of w and 1/w of both
/// tractions are equal, and u_r: F = -6 E, 3 E = -A - T, 3 C = 2 A - T.
pub struct Inclusion {
    far: [f64; 2],
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    e: f64,
    f: f64,
}

impl Inclusion {
    pub fn new(bonded: bool) -> Self {
        let [s, t] = [(-1e6 - 2e6) / 4.0, (-2e6 + 1e6) / 2.0];
        let [inner, outer] = [0, 1].map(|body| (3.0 - 4.0 * ELASTIC[body].1, 1.0 / lame(body).1));
        let ((kappa_in, soft_in), (kappa, soft)) = (inner, outer);
        // Equal means: 2 S + B = 2 D and (kappa S - S - B)/mu = (kappa' - 1) D/mu'.
        let d = (kappa + 1.0) * s * soft / ((kappa_in - 1.0) * soft_in + 2.0 * soft);
        let b = 2.0 * (d - s);
        let a = if bonded {
            t * (soft - soft_in) / (kappa * soft + soft_in)
        } else {
            t * (2.0 * soft - (kappa_in + 3.0) * soft_in)
                / ((3.0 * kappa + 1.0) * soft + (kappa_in + 3.0) * soft_in)
        };
        let (c, e, f) = if bonded {
            (a, 0.0, a + t)
        } else {
            ((2.0 * a - t) / 3.0, -(a + t) / 3.0, 2.0 * (a + t))
        };
        Self { far: [s, t], a, b, c, d, e, f }
    }

    /// The displacement of a body along x and y as formulas.
    pub fn formulas(&self, body: usize) -> [String; 2] {
        let two_mu = 2.0 * lame(body).1;
        let kappa = 3.0 - 4.0 * ELASTIC[body].1;
        let square = "(x^2+y^2)";
        let cubes = ["(x^3-3*x*y^2)", "(3*x^2*y-y^3)"];
        let [s, t] = self.far;
        [0, 1].map(|i| {
            let (sign, axis, cube) = ([1.0, -1.0][i], ["x", "y"][i], cubes[i]);
            if body == 1 {
                format!(
                    "({:e})*{axis} + ({:e})*{axis}/{square} + ({:e}/{square}^2 + ({:e})/{square}^3)*{cube}",
                    ((kappa - 1.0) * s - sign * t) / two_mu,
                    (sign * kappa * self.a - self.b) / two_mu,
                    self.a / two_mu,
                    -self.c / two_mu,
                )
            } else {
                format!(
                    "({:e})*{axis} + ({:e})*{cube} + ({:e})*{square}*{axis}",
                    ((kappa - 1.0) * self.d - sign * self.f) / two_mu,
                    kappa * self.e / two_mu,
                    -sign * 3.0 * self.e / two_mu,
                )
            }
        })
    }
}

impl Exact for Inclusion {
    fn displacement(&self, body: usize, [x, y, _]: [f64; 3]) -> [f64; 3] {
        let two_mu = 2.0 * lame(body).1;
        let kappa = 3.0 - 4.0 * ELASTIC[body].1;
        let (square, [s, t]) = (x * x + y * y, self.far);
        let cubes = [x * x * x - 3.0 * x * y * y, 3.0 * x * x * y - y * y * y];
        let along = |i: usize| {
            let (sign, at) = ([1.0, -1.0][i], [x, y][i]);
            let value = if body == 1 {
                ((kappa - 1.0) * s - sign * t) * at
                    + (sign * kappa * self.a - self.b) * at / square
                    + (self.a / square.powi(2) - self.c / square.powi(3)) * cubes[i]
            } else {
                ((kappa - 1.0) * self.d - sign * self.f) * at + kappa * self.e * cubes[i]
                    - sign * 3.0 * self.e * square * at
            };
            value / two_mu
        };
        [along(0), along(1), 0.0]
    }

    fn traction(&self, [x, y, _]: [f64; 3]) -> [f64; 3] {
        let (r, two_theta) = (x.hypot(y), 2.0 * y.atan2(x));
        let (up, down) = (-3.0 * self.e - self.f, 3.0 * self.e);
        let normal = 2.0 * self.d + (up + down) * two_theta.cos();
        let shear = -(up - down) * two_theta.sin();
        [(normal * x - shear * y) / r, (normal * y + shear * x) / r, 0.0]
    }
}

/// A ball under -1 MPa from all sides (Lame): u = alpha r inside, alpha r + beta/r^2 outside, with
/// equal displacement and traction, 3 K alpha - 4 mu beta, at r = 1 m.
pub struct Ball {
    alpha: [f64; 2],
    beta: f64,
    pressure: f64,
}

impl Ball {
    pub fn new() -> Self {
        let bulk = |body: usize| 3.0 * lame(body).0 + 2.0 * lame(body).1; // 3 K
        let four_mu = 4.0 * lame(1).1;
        let outer = -1e6 / bulk(1);
        let inner = (bulk(1) + four_mu) * outer / (bulk(0) + four_mu);
        Self { alpha: [inner, outer], beta: inner - outer, pressure: -bulk(0) * inner }
    }

    pub fn formula(&self, body: usize, axis: &str) -> String {
        let beta = self.beta * body as f64;
        format!("({:e} + ({beta:e})/(x^2+y^2+z^2)^1.5)*{axis}", self.alpha[body])
    }
}

impl Exact for Ball {
    fn displacement(&self, body: usize, x: [f64; 3]) -> [f64; 3] {
        let r = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        x.map(|x| (self.alpha[body] + self.beta * body as f64 / r.powi(3)) * x)
    }

    fn traction(&self, x: [f64; 3]) -> [f64; 3] {
        let r = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        x.map(|x| -self.pressure * x / r)
    }
}
