//! The film of fluid between the lips of an interface: how it flows along a facet.
//!
//! Lubrication theory with the cubic law: the mass that passes a line in the film per second and
//! metre is rho w^3/(12 mu) times the slope of the pressure (P. Witherspoon et al., Water Resour.
//! Res. 16, 1980). Pressures are those above the reference; masses are divided by the density of
//! the fluid there.

use crate::bulk::{CANCELLED, exp_m1_on_its_tangent};
use crate::element::{Shape, gauss, quadrature};

/// Corners of the largest facet.
pub const FACET_CORNERS: usize = 4;
/// Nodes of the largest facet.
const FACET_NODES: usize = 9;

/// The fluid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluid {
    /// Viscosity mu (Pa s).
    pub viscosity: f64,
    /// Density at the reference pressure (kg/m3).
    pub density: f64,
    /// Compressibility 1/K_w (1/Pa).
    pub compressibility: f64,
    /// Reference pressure (Pa).
    pub reference: f64,
}

impl Fluid {
    /// rho / rho_0 = exp(p/K_w).
    pub fn density_ratio(&self, pressure: f64) -> f64 {
        1.0 + exp_m1_on_its_tangent(self.compressibility * pressure)
    }

    /// w^3/(12 mu), 0 where the lips touch, and its derivative by the opening w.
    fn transmissivity(&self, opening: f64) -> [f64; 2] {
        let w = opening.max(0.0);
        [w * w * w / (12.0 * self.viscosity), w * w / (4.0 * self.viscosity)]
    }
}

/// A point of the Gauss rule of a facet.
#[derive(Debug, Clone)]
struct Point {
    /// Weight times area (m2; 2D: m).
    area: f64,
    /// Values of the shape functions of the opening.
    openings: [f64; FACET_NODES],
    /// Values of the linear ones of the pressure.
    pressures: [f64; FACET_CORNERS],
    /// Their gradients along the facet, by displacement component (1/m).
    slopes: [[f64; 3]; FACET_CORNERS],
}

/// A facet, or what facets of boxes of one size and order have in common.
#[derive(Debug, Clone)]
pub struct Film {
    shape: Shape,
    points: Vec<Point>,
}

/// State of the film in one facet.
#[derive(Debug, Clone, Copy)]
pub struct FilmState<'a> {
    /// Openings at the nodes (m).
    pub opening: &'a [f64],
    /// Pressures at the corners (Pa).
    pub pressure: &'a [f64],
    /// Acceleration of gravity by displacement component (m/s2); only what lies along the facet
    /// counts.
    pub gravity: [f64; 3],
}

impl Film {
    /// The film in a box-shaped facet with edges of `size` (m).
    pub fn new(shape: Shape, size: [f64; 2]) -> Self {
        let (dim, corners) = (shape.dim(), shape.corners());
        let area: f64 = size[..dim].iter().product();
        let points = gauss(shape, shape.order() + 1).into_iter().map(|q| {
            let mut openings = [0.0; FACET_NODES];
            shape.values(q.xi, &mut openings);
            let mut pressures = [0.0; FACET_CORNERS];
            corners.values(q.xi, &mut pressures);
            let mut reference = [[0.0; 3]; FACET_CORNERS];
            corners.gradients(q.xi, &mut reference);
            let slope = |c: usize, g: f64| if c < dim { 2.0 * g / size[c] } else { 0.0 };
            let slopes = reference.map(|g| std::array::from_fn(|c| slope(c, g[c])));
            Point { area: q.weight * area / f64::from(1 << dim), openings, pressures, slopes }
        });
        Self { shape, points: points.collect() }
    }

    /// The film in a facet with these nodes by displacement component (m), of any geometry.
    pub fn of_points(shape: Shape, points: &[[f64; 3]]) -> Self {
        let (dim, corners) = (shape.dim(), shape.corners());
        let rule = quadrature(shape, 2 * shape.order() + 1);
        let points = rule.into_iter().map(|q| {
            let mut openings = [0.0; FACET_NODES];
            shape.values(q.xi, &mut openings);
            let mut pressures = [0.0; FACET_CORNERS];
            corners.values(q.xi, &mut pressures);
            let (mut nodal, mut reference) = ([[0.0; 3]; FACET_NODES], [[0.0; 3]; FACET_CORNERS]);
            shape.gradients(q.xi, &mut nodal);
            corners.gradients(q.xi, &mut reference);
            let tangent = |d: usize| -> [f64; 3] {
                std::array::from_fn(|i| points.iter().zip(&nodal).map(|(x, g)| x[i] * g[d]).sum())
            };
            let (t, dual) = (tangent(0), dual_tangents([tangent(0), tangent(1)], dim));
            let normal = if dim == 1 { t } else { cross(t, tangent(1)) };
            let area = q.weight * dot(normal, normal).sqrt();
            let slopes = reference
                .map(|g| std::array::from_fn(|i| (0..dim).map(|d| g[d] * dual[d][i]).sum()));
            Point { area, openings, pressures, slopes }
        });
        Self { shape, points: points.collect() }
    }

    /// Nodes at which openings stand.
    pub fn nodes(&self) -> usize {
        self.shape.nodes()
    }

    /// Corners, at which pressures stand.
    pub fn corners(&self) -> usize {
        self.shape.corners().nodes()
    }

    /// Calls `act` with each point, the opening there, the density ratio, and slope of the pressure
    /// less the weight of the fluid (Pa/m).
    fn each(
        &self,
        fluid: &Fluid,
        state: FilmState<'_>,
        mut act: impl FnMut(&Point, f64, f64, [f64; 3]),
    ) {
        for q in &self.points {
            let opening: f64 = q.openings.iter().zip(state.opening).map(|(n, w)| n * w).sum();
            let at: f64 = q.pressures.iter().zip(state.pressure).map(|(n, p)| n * p).sum();
            let ratio = fluid.density_ratio(at);
            let drive = std::array::from_fn(|c| {
                let slope: f64 = q.slopes.iter().zip(state.pressure).map(|(g, p)| g[c] * p).sum();
                slope - fluid.density * ratio * state.gravity[c]
            });
            act(q, opening, ratio, drive);
        }
    }

    /// Adds to `rows` what flows off each corner in the time `length`, and the magnitudes to
    /// `sizes`, with [`CANCELLED`] (m3; 2D: m2).
    pub fn add_flow(
        &self,
        fluid: &Fluid,
        state: FilmState<'_>,
        length: f64,
        rows: &mut [f64],
        sizes: &mut [f64],
    ) {
        self.each(fluid, state, |q, opening, ratio, drive| {
            let factor = length * q.area * ratio * fluid.transmissivity(opening)[0];
            let steepness = |g: &[f64; 3]| g[0].abs() + g[1].abs() + g[2].abs();
            let alone = q.slopes.iter().zip(state.pressure).map(|(g, p)| steepness(g) * p.abs());
            let cancelled = CANCELLED * factor * alone.sum::<f64>();
            for ((row, size), g) in rows.iter_mut().zip(sizes.iter_mut()).zip(&q.slopes) {
                let off = factor * dot(*g, drive);
                *row += off;
                *size += off.abs() + cancelled * steepness(g);
            }
        });
    }

    /// Derivatives of what [`Film::add_flow`] adds: by the pressures at constant density, corner by
    /// corner (m3/Pa), and by the openings, corner by node (m2).
    pub fn derivatives(&self, fluid: &Fluid, state: FilmState<'_>, length: f64) -> [Vec<f64>; 2] {
        let (corners, nodes) = (self.corners(), self.nodes());
        let (mut by_pressure, mut by_opening) =
            (vec![0.0; corners * corners], vec![0.0; corners * nodes]);
        self.each(fluid, state, |q, opening, ratio, drive| {
            let factor = length * q.area * ratio;
            let [flow, slope] = fluid.transmissivity(opening).map(|t| factor * t);
            for (a, g) in q.slopes[..corners].iter().enumerate() {
                for (b, h) in q.slopes[..corners].iter().enumerate() {
                    by_pressure[a * corners + b] += flow * dot(*g, *h);
                }
                let off = slope * dot(*g, drive);
                for (i, n) in q.openings[..nodes].iter().enumerate() {
                    by_opening[a * nodes + i] += off * n;
                }
            }
        });
        [by_pressure, by_opening]
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// The vectors along a facet whose products with its `dim` tangents are 1 and 0: a gradient is
/// their sum with the derivatives by the reference coordinates.
fn dual_tangents([s, t]: [[f64; 3]; 2], dim: usize) -> [[f64; 3]; 2] {
    if dim == 1 {
        let square = dot(s, s);
        return [s.map(|x| x / square), [0.0; 3]];
    }
    let (ss, st, tt) = (dot(s, s), dot(s, t), dot(t, t));
    let determinant = ss * tt - st * st;
    let of = |a: f64, b: f64| std::array::from_fn(|i| (a * s[i] + b * t[i]) / determinant);
    [of(tt, -st), of(-st, ss)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const WATER: Fluid =
        Fluid { viscosity: 1e-3, density: 1000.0, compressibility: 5e-10, reference: 0.0 };

    fn flow(film: &Film, state: FilmState<'_>) -> Vec<f64> {
        let (mut rows, mut sizes) = (vec![0.0; film.corners()], vec![0.0; film.corners()]);
        film.add_flow(&WATER, state, 2.0, &mut rows, &mut sizes);
        rows
    }

    #[test]
    fn between_parallel_plates_it_is_the_cubic_law() {
        let film = Film::new(Shape::Quad4, [0.5, 2.0]);
        let fluid = Fluid { compressibility: 0.0, ..WATER };
        let (mut rows, mut sizes) = ([0.0; 4], [0.0; 4]);
        // 100 Pa over 0.5 m along x.
        let state = FilmState {
            opening: &[1e-3; 4],
            pressure: &[0.0, 100.0, 100.0, 0.0],
            gravity: [0.0; 3],
        };
        film.add_flow(&fluid, state, 2.0, &mut rows, &mut sizes);
        let through = 2.0 * 1e-9 / (12.0 * 1e-3) * 200.0 * 2.0;
        assert!((rows[1] + rows[2] - through).abs() < 1e-15 * 1e3, "{rows:?} {through}");
        assert!(rows.iter().sum::<f64>().abs() < 1e-18);
        // Lips that overlap let nothing through, and water at rest does not flow.
        let shut = FilmState { opening: &[-1e-3; 4], ..state };
        assert_eq!(flow(&film, shut), [0.0; 4]);
        let rest =
            FilmState { pressure: &[0.0, 500.0, 500.0, 0.0], gravity: [1.0, 0.0, 9.0], ..state };
        let (mut rows, mut sizes) = ([0.0; 4], [0.0; 4]);
        film.add_flow(&fluid, rest, 2.0, &mut rows, &mut sizes);
        assert!(rows.iter().all(|row| row.abs() < 1e-18), "{rows:?}");
    }

    #[test]
    fn derivatives_are_those_of_the_flow() {
        for shape in [Shape::Line2, Shape::Line3, Shape::Quad4, Shape::Quad9] {
            let film = Film::new(shape, [0.5, 0.25]);
            let opening: Vec<f64> =
                (0..film.nodes()).map(|i| 1e-4 * (1.0 + 0.1 * i as f64)).collect();
            let pressure: Vec<f64> = (0..film.corners()).map(|i| 1e3 * (i * i) as f64).collect();
            let state =
                FilmState { opening: &opening, pressure: &pressure, gravity: [0.3, -0.2, 5.0] };
            let [by_pressure, by_opening] = film.derivatives(&WATER, state, 2.0);
            let corners = film.corners();
            let largest = by_opening.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for i in 0..film.nodes() {
                let at = |sign: f64| {
                    let mut opening = opening.clone();
                    opening[i] += sign * 1e-8;
                    flow(&film, FilmState { opening: &opening, ..state })
                };
                let (low, high) = (at(-1.0), at(1.0));
                for a in 0..corners {
                    let slope = (high[a] - low[a]) / 2e-8;
                    let given = by_opening[a * film.nodes() + i];
                    assert!((slope - given).abs() < 1e-6 * largest, "{shape:?} {slope} {given}");
                }
            }
            let largest = by_pressure.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for b in 0..corners {
                let at = |sign: f64| {
                    let mut pressure = pressure.clone();
                    pressure[b] += sign;
                    flow(&film, FilmState { pressure: &pressure, ..state })
                };
                let (low, high) = (at(-1.0), at(1.0));
                for a in 0..corners {
                    let slope = (high[a] - low[a]) / 2.0;
                    let given = by_pressure[a * corners + b];
                    // What the density changes is left out: p/K_w and the weight of the fluid.
                    assert!((slope - given).abs() < 1e-4 * largest, "{shape:?} {slope} {given}");
                }
            }
        }
    }

    /// A facet of a box that is turned gives the same flow under gravity that turns with it.
    #[test]
    fn a_facet_by_its_points_is_that_of_a_box() {
        for shape in [Shape::Line2, Shape::Line3, Shape::Quad4, Shape::Quad9] {
            let size = [0.5, 0.25];
            let of_box = Film::new(shape, size);
            let turn = |v: [f64; 3]| {
                let (cos, sin) = (0.8, 0.6);
                let [x, y, z] = [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
                if shape.dim() == 1 { [x, y, z] } else { [x, cos * y - sin * z, sin * y + cos * z] }
            };
            let place =
                |xi: &[f64; 3]| turn([0.5 * size[0] * xi[0] + 3.0, 0.5 * size[1] * xi[1], 1.0]);
            let points: Vec<[f64; 3]> = shape.node_points().iter().map(place).collect();
            let turned = Film::of_points(shape, &points);
            let opening: Vec<f64> = (0..shape.nodes()).map(|i| 1e-4 * (1.0 + i as f64)).collect();
            let pressure: Vec<f64> = (0..of_box.corners()).map(|i| 1e3 * (i * i) as f64).collect();
            let gravity = [3.0, if shape.dim() == 1 { 0.0 } else { -2.0 }, 5.0];
            let state = FilmState { opening: &opening, pressure: &pressure, gravity };
            let exact = flow(&of_box, state);
            let found = flow(&turned, FilmState { gravity: turn(gravity), ..state });
            let largest = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for (found, exact) in found.iter().zip(&exact) {
                assert!((found - exact).abs() < 1e-12 * largest, "{shape:?} {found} {exact}");
            }
        }
    }

    /// A linear pressure drives the same power through a plane facet however it is cut.
    #[test]
    fn triangles_carry_the_flow_of_the_square_that_they_make() {
        let place = |[x, y, _]: [f64; 3]| [x + 0.1 * y, y - 0.2 * x, 0.3 * x + 0.5 * y];
        let power = |shape: Shape, corners: &[[f64; 3]]| {
            let mut values = vec![0.0; corners.len()];
            let inside = |xi: &[f64; 3]| {
                shape.corners().values(*xi, &mut values);
                let along = |i: usize| corners.iter().zip(&values).map(|(x, n)| n * x[i]).sum();
                place([along(0), along(1), 0.0])
            };
            let points: Vec<[f64; 3]> = shape.node_points().iter().map(inside).collect();
            let film = Film::of_points(shape, &points);
            let pressure: Vec<f64> = points[..corners.len()].iter().map(|x| 10.0 * x[0]).collect();
            let (opening, gravity) = (vec![1e-3; points.len()], [0.0; 3]);
            let fluid = Fluid { compressibility: 0.0, ..WATER };
            let (mut rows, mut sizes) = (vec![0.0; corners.len()], vec![0.0; corners.len()]);
            let state = FilmState { opening: &opening, pressure: &pressure, gravity };
            film.add_flow(&fluid, state, 1.0, &mut rows, &mut sizes);
            rows.iter().zip(&pressure).map(|(row, p)| row * p).sum::<f64>()
        };
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let square = power(Shape::Quad4, &[a, b, c, d]);
        for shape in [Shape::Tri3, Shape::Tri6] {
            let both = power(shape, &[a, b, c]) + power(shape, &[a, c, d]);
            assert!((both / square - 1.0).abs() < 1e-12, "{shape:?} {both} {square}");
        }
    }
}
