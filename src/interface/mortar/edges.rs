//! The nodal basis of a facet of second order whose corners take a share of the edges.

use super::MOST_NODES;
use crate::element::Shape;
use crate::space::SHARE_OF_END as SHARE;

/// The nodal basis of a facet, or that with positive integrals made of it: the integrals of the
/// corner functions of six-node triangles vanish, and no dual basis can belong to them.
///
/// Each corner c takes the share $\alpha = 1/5$ of the functions N_m of the middles m of its edges:
/// $\tilde N_c = N_c + \alpha\sum_m N_m$, $\tilde N_m = (1 - 2\alpha) N_m$; they sum to one as
/// before. The values that belong to them are $\tilde u_c = u_c$ and
/// $\tilde u_m = (u_m - \alpha (u_{c1} + u_{c2})) / (1 - 2\alpha)$.
///
/// An edge is left as it is where its middle carries no multiplier: so the row of a corner never
/// holds another corner that has a row itself. Two facets see their common edge alike.
///
/// # Source
/// Wohlmuth, Popp, Gee, Wall (2012), Comput. Mech. 49, 735-747; Popp, Wohlmuth, Gee, Wall (2012),
/// SIAM J. Sci. Comput. 34, B421-B446.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeBasis {
    shape: Shape,
    transformed: bool,
    /// Bit m: the middle m has given its shares away.
    changed: u16,
}

impl EdgeBasis {
    /// The nodal basis itself.
    pub fn plain(shape: Shape) -> Self {
        Self { shape, transformed: false, changed: 0 }
    }

    /// That with positive integrals; of facets of first order the nodal basis. Bit b of `dropped`
    /// says that the local node b carries no multiplier.
    pub fn transformed(shape: Shape, dropped: u16) -> Self {
        let mut changed = 0;
        for_each_edge(shape, |middle, _| changed |= 1 << middle);
        Self { shape, transformed: true, changed: changed & !dropped }
    }

    /// Whether it is other than the nodal basis.
    pub fn is_transformed(self) -> bool {
        self.transformed && self.shape.order() > 1
    }

    /// The shape of the facet.
    pub fn shape(self) -> Shape {
        self.shape
    }

    /// Its functions at a reference point, in the order of the nodes.
    pub fn values(self, xi: [f64; 3]) -> [f64; MOST_NODES] {
        let mut values = [0.0; MOST_NODES];
        self.shape.values(xi, &mut values);
        self.for_each_changed(|middle, corners| {
            for corner in corners {
                values[corner] += SHARE * values[middle];
            }
            values[middle] *= 1.0 - 2.0 * SHARE;
        });
        values
    }

    /// Of a sum over values that belong to this basis the coefficients: in terms of nodal values.
    pub fn of_nodal_values(self, mut coefficients: [f64; MOST_NODES]) -> [f64; MOST_NODES] {
        self.for_each_changed(|middle, corners| {
            coefficients[middle] /= 1.0 - 2.0 * SHARE;
            for corner in corners {
                coefficients[corner] -= SHARE * coefficients[middle];
            }
        });
        coefficients
    }

    fn for_each_changed(self, mut visit: impl FnMut(usize, [usize; 2])) {
        for_each_edge(self.shape, |middle, corners| {
            if self.changed >> middle & 1 == 1 {
                visit(middle, corners);
            }
        });
    }
}

/// Calls `visit` with the middle of each edge and its two corners; never for first order.
fn for_each_edge(shape: Shape, mut visit: impl FnMut(usize, [usize; 2])) {
    let corners = shape.corners().nodes();
    match (shape.order(), shape.dim()) {
        (1, _) => {}
        (_, 1) => visit(2, [0, 1]),
        _ => (0..corners).for_each(|e| visit(corners + e, [e, (e + 1) % corners])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middles_lie_between_their_corners() {
        for shape in [Shape::Line3, Shape::Tri6, Shape::Quad9] {
            let points = shape.node_points();
            let mut count = 0;
            for_each_edge(shape, |middle, [a, b]| {
                count += 1;
                assert!((0..2).all(|d| points[middle][d] == 0.5 * (points[a][d] + points[b][d])));
            });
            assert_eq!(count, if shape.dim() == 1 { 1 } else { shape.corners().nodes() });
        }
        for_each_edge(Shape::Quad4, |_, _| panic!("no middles"));
    }

    /// A field is the same sum over either basis.
    #[test]
    fn the_transformed_values_belong_to_the_transformed_basis() {
        for shape in [Shape::Line3, Shape::Tri6, Shape::Quad9, Shape::Quad4] {
            for dropped in [0, 0b1, 0b1000, 0b1_1100] {
                let basis = EdgeBasis::transformed(shape, dropped);
                let u: [f64; MOST_NODES] = std::array::from_fn(|a| (a as f64 * 1.7).sin());
                let (xi, mut plain) = ([0.3, 0.2, 0.0], [0.0; MOST_NODES]);
                shape.values(xi, &mut plain);
                let changed = basis.of_nodal_values(basis.values(xi));
                for a in 0..shape.nodes() {
                    assert!((changed[a] - plain[a]).abs() < 1e-15, "{shape:?} {a}");
                }
                let sum: f64 = basis.values(xi).iter().sum();
                assert!((sum - 1.0).abs() < 1e-15);
                let values = |u: &[f64; MOST_NODES]| -> f64 {
                    plain.iter().zip(u).map(|(n, u)| n * u).sum()
                };
                let by_hand: f64 = changed.iter().zip(u).map(|(n, u)| n * u).sum();
                assert!((by_hand - values(&u)).abs() < 1e-14);
            }
        }
    }
}
