//! E. Lorentz's field with a jump that is not constant (code_aster V6.03.128), turned so that the
//! interface is horizontal, in plane strain with nu = 0.
//!
//! Above the interface the stress is sigma_zz = a z + b x + g, sigma_xx = 0, sigma_xz = -(a x + e),
//! in equilibrium without a load; the law gives the jump. Below, the displacement is what the jump
//! leaves at the lip plus a part that is linear in z and carries the traction on, with the body
//! force that this takes.

use crate::manufactured::HEIGHT;

const A: f64 = 0.3;
const B: f64 = 0.2;
const G: f64 = 0.5;
const E: f64 = 0.1;
const YOUNG_MODULUS: f64 = 100.0;
const MU: f64 = 0.5 * YOUNG_MODULUS;
const STRENGTH: f64 = 1.0;
const CRITICAL: f64 = 0.1;
/// Traction turns by TURN/q^2 per length, q its size.
const TURN: f64 = E * B - A * G;

/// Numbers at a place x along the interface, names as in the comment of each line of [`below`].
struct Below {
    /// Displacement at the lip (x, z) and its derivatives.
    lip: [f64; 2],
    lip_slope: [f64; 2],
    /// What it gains per height (x, z), and the slope of that.
    gain: [f64; 2],
    gain_slope: [f64; 2],
}

fn shear(x: f64) -> f64 {
    -A * x - E
}

fn normal(x: f64) -> f64 {
    B * x + G
}

fn below(x: f64) -> Below {
    let (s, n) = (shear(x), normal(x));
    let q = s.hypot(n);
    let half = n * B - s * A; // half the derivative of q^2
    // Derivatives of s/q and n/q.
    let s_turn = TURN * n / q.powi(3);
    let n_turn = -TURN * s / q.powi(3);
    let n_turn_slope = -TURN * (-A / q.powi(3) - 3.0 * s * half / q.powi(5));
    let lip = [
        -CRITICAL * (s / q - s / STRENGTH),
        -A * x * x / YOUNG_MODULUS - CRITICAL * (n / q - n / STRENGTH),
    ];
    let lip_slope = [
        -CRITICAL * (s_turn + A / STRENGTH),
        -2.0 * A * x / YOUNG_MODULUS - CRITICAL * (n_turn - B / STRENGTH),
    ];
    let lip_bend = -2.0 * A / YOUNG_MODULUS - CRITICAL * n_turn_slope;
    Below {
        lip,
        lip_slope,
        gain: [s / MU - lip_slope[1], n / YOUNG_MODULUS],
        gain_slope: [-A / MU - lip_bend, B / YOUNG_MODULUS],
    }
}

/// Displacement, its gradient and Lame's constants.
pub fn at(upper: bool, [x, _, z]: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3], (f64, f64)) {
    let h = z - HEIGHT;
    let (u, gradient) = if upper {
        (
            [-(B * h * h / 2.0 + 2.0 * E * h), A * (h * h / 2.0 - x * x) + h * normal(x)],
            [[0.0, -B * h - 2.0 * E], [-2.0 * A * x + h * B, A * h + normal(x)]],
        )
    } else {
        let b = below(x);
        let scaled = |v: f64| v * YOUNG_MODULUS;
        (
            [0, 1].map(|i| scaled(b.lip[i] + h * b.gain[i])),
            [0, 1].map(|i| [scaled(b.lip_slope[i] + h * b.gain_slope[i]), scaled(b.gain[i])]),
        )
    };
    let mut out = ([0.0; 3], [[0.0; 3]; 3], (0.0, MU));
    for (i, axis) in [0, 2].into_iter().enumerate() {
        out.0[axis] = u[i] / YOUNG_MODULUS;
        out.1[axis][0] = gradient[i][0] / YOUNG_MODULUS;
        out.1[axis][2] = gradient[i][1] / YOUNG_MODULUS;
    }
    out
}

pub fn traction([x, _, _]: [f64; 3]) -> [f64; 3] {
    [shear(x), 0.0, normal(x)]
}

/// The case; `bodies` is that list of the mesh.
pub fn yaml(bodies: &str) -> String {
    let s = format!("(-{A}*x-{E})");
    let n = format!("({B}*x+{G})");
    let q2 = format!("({s}^2+{n}^2)");
    let half = format!("({n}*{B}-{s}*{A})");
    let h = format!("(z-{HEIGHT})");
    let (e, mu, critical) = (YOUNG_MODULUS, MU, CRITICAL);
    let s_turn = format!("{TURN}*{n}/{q2}^1.5");
    let s_turn_slope = format!("{TURN}*({B}/{q2}^1.5-3*{n}*{half}/{q2}^2.5)");
    let n_turn = format!("(-{TURN})*{s}/{q2}^1.5");
    let n_turn_slope = format!("(-{TURN})*(-{A}/{q2}^1.5-3*{s}*{half}/{q2}^2.5)");
    let square = A * A + B * B;
    let n_turn_bend =
        format!("(-{TURN})*((6*{A}*{half}-3*{s}*{square})/{q2}^2.5+15*{s}*{half}^2/{q2}^3.5)");
    let lip_x = format!("(-{critical})*({s}/{q2}^0.5-{s}/{STRENGTH})");
    let lip_z = format!("(-{A}*x^2/{e}-{critical}*({n}/{q2}^0.5-{n}/{STRENGTH}))");
    let lip_z_slope = format!("(-2*{A}*x/{e}-{critical}*({n_turn}-{B}/{STRENGTH}))");
    let bottom_x = format!("{lip_x}+{h}*({s}/{mu}-{lip_z_slope})");
    let bottom_z = format!("{lip_z}+{h}*{n}/{e}");
    let top_x = format!("-({B}*{h}^2/2+2*{E}*{h})/{e}");
    let top_z = format!("({A}*({h}^2/2-x^2)+{h}*{n})/{e}");
    // On the sides below: sigma_xx and what sigma_xz has beyond the traction of the interface.
    let stretch = format!(
        "{e}*((-{critical})*({s_turn}+{A}/{STRENGTH})+{h}*(-{A}/{mu}+2*{A}/{e}+{critical}*({n_turn_slope})))"
    );
    let lower = format!("(1-min(1,max(0,1e9*{h})))");
    let sheared = format!("{s}+{lower}*{mu}*{h}*{B}/{e}");
    let force_x =
        format!("{lower}*({e}*{critical}*({s_turn_slope}-{h}*({n_turn_bend}))-{})", mu * B / e);
    format!(
        "
mesh: {{column: {{size: [1.0, 1.0], bodies: {bodies}}}}}
materials: {{rock: {{elastic: {{young_modulus: {e}, poisson_ratio: 0}}}}}}
interfaces:
  - {{name: joint, z: {HEIGHT}, law: {{linear_softening: {{strength: {STRENGTH}, fracture_energy: {}}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: {{formula: \"{bottom_x}\"}}, z: {{formula: \"{bottom_z}\"}}}}}}
  - {{on: top, displacement: {{x: {{formula: \"{top_x}\"}}, z: {{formula: \"{top_z}\"}}}}}}
  - {{on: left, traction: {{x: {{formula: \"-{lower}*{stretch}\"}}, z: {{formula: \"-({sheared})\"}}}}}}
  - {{on: right, traction: {{x: {{formula: \"{lower}*{stretch}\"}}, z: {{formula: \"{sheared}\"}}}}}}
body_force: {{x: {{formula: \"{force_x}\"}}, z: {{formula: \"{lower}*{A}\"}}}}
time: {{instants: [1]}}
",
        0.5 * STRENGTH * CRITICAL,
    )
}
