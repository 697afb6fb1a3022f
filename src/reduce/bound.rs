//! Bounds that turn a residual into an error, and a softening slope into stability.
//!
//! All follow from integrals of strains along straight lines ("fibres") that begin where a
//! displacement is prescribed; docs/theory.md, section 8, derives them.

use crate::bulk::Elastic;
use crate::case::{Case, Surface};
use crate::mesh::Column;

/// What the states say of the interfaces.
pub struct Joints {
    /// Whether there is no jump at any instant.
    pub is_tied: Vec<bool>,
    /// Whether the nodes of both sides are at the same places.
    pub is_matching: Vec<bool>,
}

/// Whether a surface prescribes a component of the displacement along an axis.
pub(super) fn holds(case: &Case, surface: &Surface, axis: usize) -> bool {
    let mut entries = case.boundary.iter().filter(|entry| entry.on == *surface);
    entries.any(|entry| entry.displacement[axis].is_some())
}

/// The constant C in $\int |v|^2 \le C \int |\varepsilon(v)|^2$ over the column, for displacements
/// v that vanish where the case prescribes them and are continuous over tied interfaces only (m2).
///
/// # Errors
/// What stands in the way, in words.
pub fn size_over_strain(case: &Case, column: &Column, joints: &Joints) -> Result<f64, String> {
    let apart = (0..joints.is_tied.len()).find(|i| joints.is_tied[*i] && !joints.is_matching[*i]);
    if let Some(index) = apart {
        let name = &case.interfaces[index].name;
        return Err(format!("no bound is known for {name}, which ties meshes that do not match"));
    }
    let height = column.size[2];
    let far = std::f64::consts::FRAC_2_PI;
    // Along a fibre of length l that begins where v vanishes: integral of v2 over that of its
    // slope2.
    let along = |length: f64| (far * length).powi(2);
    let mut sum = 0.0;
    let reach = |axes: &[usize]| reach(case, column, joints, axes);
    for (axis, near, beyond) in
        [(0, &Surface::Left, &Surface::Right), (1, &Surface::Front, &Surface::Back)]
    {
        if case.dim == 2 && axis == 1 {
            continue;
        }
        let width = column.size[axis];
        if holds(case, near, axis) || holds(case, beyond, axis) {
            sum += along(width);
            continue;
        }
        // Fibres that lean by s towards the middle: v.d from the strain along d = (s, 1), v_z
        // upright.
        let length = reach(&[axis, 2])?;
        let s = width / (2.0 * height);
        let leaning = 2.0 * along(length) * (1.0 + s * s).powi(2);
        sum += 2.0 / (s * s) * (along(length) + leaning);
    }
    Ok(sum + along(reach(&[2])?))
}

/// The greatest distance of a point from an end of the column that prescribes the displacements
/// along `axes`, over tied interfaces alone (m).
fn reach(case: &Case, column: &Column, joints: &Joints, axes: &[usize]) -> Result<f64, String> {
    let held = |surface: &Surface| axes.iter().all(|axis| holds(case, surface, *axis));
    let (from_below, from_above) = (held(&Surface::Bottom), held(&Surface::Top));
    let height = column.size[2];
    let first = joints.is_tied.iter().position(|tied| !tied);
    let last = joints.is_tied.iter().rposition(|tied| !tied);
    let z = |interface: usize| case.interfaces[interface].height().unwrap_or(height);
    match (first, last) {
        (Some(first), Some(last)) if first == last && from_below && from_above => {
            Ok(z(first).max(height - z(last)))
        }
        (None, None) if from_below || from_above => Ok(height),
        (Some(_), Some(_)) if first != last => Err(format!(
            "the body between {} and {} is held by neither end",
            case.interfaces[first.unwrap_or(0)].name,
            case.interfaces[last.unwrap_or(0)].name
        )),
        _ => Err("an end of the column is free, and no bound of its stiffness is known".into()),
    }
}

/// The constant c in $\varepsilon : D : \varepsilon \ge c |\varepsilon|^2$ in every material (Pa).
pub fn stiffness_over_strain(case: &Case) -> f64 {
    let least = |m: &crate::case::Material| {
        let Elastic { lambda, mu } = Elastic::new(m.young_modulus, m.poisson_ratio);
        (2.0 * mu).min(3.0 * lambda + 2.0 * mu)
    };
    case.materials.iter().map(least).fold(f64::INFINITY, f64::min)
}

/// Least eigenvalue of the mass matrix of a cell of unit size, by its order and along one axis.
const LEAST_MASS: [f64; 2] = [1.0 / 6.0, 0.080_375_885];

/// The constant m in $\int |v|^2 \ge m \sum_j |v_j|^2$ over the nodes (m3; 2D: m2), for the cells
/// of given sizes and orders.
pub fn size_over_values(dim: usize, cells: impl Iterator<Item = ([f64; 3], usize)>) -> f64 {
    let of = |(size, order): ([f64; 3], usize)| {
        size.iter().product::<f64>() * LEAST_MASS[order - 1].powi(dim as i32)
    };
    cells.map(of).fold(f64::INFINITY, f64::min)
}

/// Stiffness of the column against the opening of an interface, over the area, when both ends are
/// held: 1 / integral of dz/E (Pa/m). The strain energy is at least that of fibres of Young's
/// modulus.
pub fn stiffness_of_fibres(case: &Case, column: &Column) -> f64 {
    let mut compliance = 0.0;
    for body in 0..column.bodies() {
        for k in 0..column.extent(body)[2] {
            let place = crate::mesh::CellPlace { body, at: [0, 0, k] };
            let (size, material) = column.cell_size(place);
            compliance += size[2] / case.materials[material].young_modulus;
        }
    }
    1.0 / compliance
}

/// Modes across the section that are as short as the cells need so many times the slope of the
/// softening.
const SHORT_MODES: f64 = 36.0;

/// What the softening of the interface `name` with the slope `slope` (Pa/m) takes of the stiffness
/// against its opening; below 1 the state is stable, whatever varies across the section. `cells`
/// are those of the body of its secondary side.
///
/// # Errors
/// What stands in the way, in words.
pub fn softening(
    case: &Case,
    column: &Column,
    name: &str,
    slope: f64,
    cells: [usize; 3],
) -> Result<f64, String> {
    if slope == 0.0 {
        return Ok(0.0);
    }
    if !(holds(case, &Surface::Bottom, 2) && holds(case, &Surface::Top, 2)) {
        return Err(format!("{name} softens and an end of the column is free along z"));
    }
    // Nodes share the jump out to areas: of a jump that varies linearly over n cells its square is
    // larger by 2/n2 than the integral, and of one that alternates nine times, where the bulk
    // resists with its modulus over the size of the cells.
    let mut share = slope / stiffness_of_fibres(case, column);
    let least = case.materials.iter().map(|m| m.young_modulus).fold(f64::INFINITY, f64::min);
    for (axis, n) in cells.iter().enumerate().take(case.dim - 1) {
        let n = *n as f64;
        share *= 1.0 + 2.0 / (n * n);
        if n > 1.0 && SHORT_MODES * slope * column.size[axis] / n > least {
            return Err(format!(
                "{name} softens too steeply for the size of the cells; finer ones would do"
            ));
        }
    }
    Ok(share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Shape, gauss};
    use std::path::Path;

    fn case(boundary: &str) -> (Case, Column) {
        let yaml = format!(
            "mesh: {{column: {{size: [1, 2, 5], cells: [4, 4, 10]}}}}\n\
             materials:\n  a: {{z: [0, 2], elastic: {{young_modulus: 1.0, poisson_ratio: 0.2}}}}\n  \
             b: {{z: [2, 5], elastic: {{young_modulus: 3.0, poisson_ratio: -0.5}}}}\n\
             interfaces: [{{name: joint, z: 2, law: {{linear_softening: {{strength: 1.0, \
             fracture_energy: 2}}}}}}]\n\
             boundary:\n{boundary}time: {{instants: [1]}}\n"
        );
        let case = Case::read(&yaml, Path::new("t.yaml"), &[]).expect("a case");
        let column = Column::new(&case).expect("a column");
        (case, column)
    }

    const CLAMPED: &str = "  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}\n  \
                           - {on: top, displacement: {x: 0, y: 0, z: 1}}\n";

    /// The integrals of v2 and of the strain's square for v = f(z) along x, by the midpoint rule.
    fn bends(f: impl Fn(f64) -> [f64; 2], ends: [f64; 2]) -> f64 {
        let n = 1000;
        let h = (ends[1] - ends[0]) / n as f64;
        let at = |k: usize| f(ends[0] + h * (k as f64 + 0.5));
        let sum = |g: &dyn Fn([f64; 2]) -> f64| (0..n).map(|k| g(at(k))).sum::<f64>();
        // Bernoulli's beam of width 1: v_z = -(x - 1/2) f', the strain is -(x - 1/2) f''.
        sum(&|[f, _]| f * f) / (sum(&|[_, second]| second * second) / 12.0)
    }

    #[test]
    fn no_bent_column_is_larger_for_its_strain_than_the_bound() {
        let (case, column) = case(CLAMPED);
        let joints = Joints { is_tied: vec![false], is_matching: vec![true] };
        let bound = size_over_strain(&case, &column, &joints).unwrap();
        // A cantilever of 3 m, from the joint's side of the upper body: f = z2 and z3 - 9 z2.
        for f in [|z: f64| [z * z, 2.0], |z: f64| [z.powi(3) - 9.0 * z * z, 6.0 * z - 18.0]] {
            assert!(bends(f, [0.0, 3.0]) < bound, "{} {bound}", bends(f, [0.0, 3.0]));
        }
        assert!(bound < 3000.0, "{bound}");
    }

    #[test]
    fn supports_that_hold_too_little_are_told() {
        let tied = |tied| Joints { is_tied: vec![tied], is_matching: vec![true] };
        let (free, column) = case("  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}\n");
        assert!(size_over_strain(&free, &column, &tied(true)).is_ok());
        assert!(size_over_strain(&free, &column, &tied(false)).unwrap_err().contains("free"));
        let apart = Joints { is_tied: vec![true], is_matching: vec![false] };
        assert!(size_over_strain(&free, &column, &apart).unwrap_err().contains("do not match"));
        let rollers = "  - {on: bottom, displacement: {z: 0}}\n  - {on: top, displacement: {z: 1}}\n  \
                       - {on: left, displacement: {x: 0}}\n  - {on: back, displacement: {y: 0}}\n";
        let (rollers, column) = case(rollers);
        let bound = size_over_strain(&rollers, &column, &tied(false)).unwrap();
        let exact = 4.0 / std::f64::consts::PI.powi(2) * (1.0 + 4.0 + 9.0);
        assert!((bound / exact - 1.0).abs() < 1e-12, "{bound} {exact}");
    }

    #[test]
    fn the_fibres_are_in_series_and_softening_takes_its_share() {
        let (case, column) = case(CLAMPED);
        assert!((stiffness_of_fibres(&case, &column) - 1.0 / 3.0).abs() < 1e-14);
        let share = |slope, n| softening(&case, &column, "joint", slope, [n, n, 1]);
        assert_eq!(share(0.0, 4), Ok(0.0));
        assert!((share(0.02, 4).unwrap() - 0.06 * 1.125_f64.powi(2)).abs() < 1e-14);
        assert!(share(0.2, 4).unwrap_err().contains("too steeply"));
        assert!((share(0.2, 1).unwrap() - 0.6 * 9.0).abs() < 1e-14);
        // 2 mu is 1/1.2 and 6, 3 kappa is 1/0.6 and 1.5.
        assert!((stiffness_over_strain(&case) - 1.0 / 1.2).abs() < 1e-14);
    }

    #[test]
    fn the_least_mass_is_an_eigenvalue() {
        for order in [1, 2] {
            let shape = Shape::of(1, order);
            // The symmetric part of the end values decouples: a 2 x 2 problem of second order.
            let mut mass = [[0.0; 3]; 3];
            for point in gauss(shape, order + 1) {
                let mut n = [0.0; crate::element::MAX_NODES];
                shape.values(point.xi, &mut n);
                for (i, row) in mass.iter_mut().enumerate() {
                    (0..3).for_each(|j| row[j] += 0.5 * point.weight * n[i] * n[j]);
                }
            }
            let least = match order {
                1 => mass[0][0] - mass[0][1],
                _ => {
                    let (a, b) = (mass[0][0] + mass[0][1], mass[2][2]);
                    let c = 2.0 * mass[0][2] * mass[2][0];
                    0.5 * (a + b) - (0.25 * (a - b).powi(2) + c).sqrt()
                }
            };
            assert!((least / LEAST_MASS[order - 1] - 1.0).abs() < 1e-6, "{least}");
            assert!(LEAST_MASS[order - 1] <= least * (1.0 + 1e-12));
        }
    }
}
