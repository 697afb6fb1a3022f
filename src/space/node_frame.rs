//! In which directions the unknowns of a node point, and which of them are prescribed.

use nalgebra::{DMatrix, DVector};

/// A rotation: its rows are directions, by components of the displacement.
pub type Rotation = [[f64; 3]; 3];

/// The rotation of a node whose unknowns are its displacements along the axes.
pub const CARTESIAN: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Directions whose cosine differs from 0 or 1 by less are at right angles or parallel.
const ALIGNED: f64 = 1e-9;
/// Directions are independent where what one has beyond the others is at least this long.
const INDEPENDENT: f64 = 1e-6;

/// The directions of the unknowns of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeFrame {
    /// The directions, the normal of an interface last; none where they are the axes.
    pub rotation: Option<Rotation>,
    /// Which of the unknowns are prescribed.
    pub fixed: [bool; 3],
    /// Their values: the sum of what is prescribed along directions, by their index, times factors.
    pub values: [Vec<(usize, f64)>; 3],
    /// For each direction that follows from earlier ones: its index, and theirs with factors.
    pub dependent: Vec<(usize, Vec<(usize, f64)>)>,
    /// Whether the directions of the interface and of the supports are at odds: the node then
    /// carries no multipliers.
    pub is_at_odds: bool,
}

impl NodeFrame {
    /// The frame of a node of a mesh of `dim` dimensions on an interface with unit `normal`, if it
    /// is on one, whose displacement is prescribed along the unit `directions`.
    pub fn new(dim: usize, normal: Option<[f64; 3]>, directions: &[[f64; 3]]) -> Self {
        let span = Span::of(directions);
        let axes_will_do = span.basis.iter().all(|d| axis_of(dim, *d).is_some());
        let is_last_axis = |n: [f64; 3]| axis_of(dim, n) == Some(dim - 1) && n[dim - 1] > 0.0;
        let mut is_at_odds = false;
        let rotation = match normal {
            _ if span.basis.len() == dim => None,
            None if axes_will_do => None,
            None => Some(completed(dim, &span.orthonormal)),
            Some(n) if is_last_axis(n) && axes_will_do => None,
            Some(n) => {
                // Multipliers are left out component by component, which therefore mean the same at
                // neighbours with and without supports.
                let [first, second] = tangents(dim, n);
                let rows = if dim == 2 { [first, n, [0.0, 0.0, 1.0]] } else { [first, second, n] };
                let is_kept_or_fixed = |row: &[f64; 3]| {
                    let inside = length(span.projection(*row));
                    !(ALIGNED..=1.0 - ALIGNED).contains(&inside)
                };
                // Supports that hold both tangents together, none of them along either, hold their
                // neighbours at odds, beside which this node would keep its normal alone.
                let is_along = |d: &[f64; 3], row: &[f64; 3]| dot(*d, *row).abs() > 1.0 - ALIGNED;
                let is_beside = |d: &[f64; 3]| {
                    dot(*d, n).abs() < ALIGNED && !rows[..dim].iter().any(|row| is_along(d, row))
                };
                is_at_odds =
                    !rows[..dim].iter().all(is_kept_or_fixed) || directions.iter().any(is_beside);
                match (is_at_odds, axes_will_do) {
                    (false, _) => Some(rows),
                    (true, true) => None,
                    (true, false) => Some(completed(dim, &span.orthonormal)),
                }
            }
        };
        let rows = rotation.unwrap_or(CARTESIAN);
        let is_fixed = |row: [f64; 3]| length(span.projection(row)) > 0.5;
        let fixed = std::array::from_fn(|c| c < dim && is_fixed(rows[c]));
        let values = std::array::from_fn(|c| if fixed[c] { span.factors(rows[c]) } else { vec![] });
        let all = 0..directions.len();
        let others = all.filter(|index| !span.independent.contains(index));
        let dependent = others.map(|index| (index, span.factors(directions[index]))).collect();
        Self { rotation, fixed, values, dependent, is_at_odds }
    }
}

/// The two tangents of a surface with a unit normal that results are given along: the direction of
/// the first axis projected on the surface, or of the last one where that vanishes, and n x t; in
/// 2D only the first.
pub fn tangents(dim: usize, n: [f64; 3]) -> [[f64; 3]; 2] {
    let projected = |axis: usize| -> [f64; 3] {
        std::array::from_fn(|i| f64::from(u8::from(i == axis)) - n[axis] * n[i])
    };
    let mut first = projected(0);
    if length(first) < 1e-6 {
        first = projected(dim - 1);
    }
    let size = length(first);
    let first = first.map(|x| x / size);
    [first, if dim == 3 { cross(n, first) } else { [0.0; 3] }]
}

/// What some directions span.
struct Span {
    /// Indices of directions that are independent of those before them.
    independent: Vec<usize>,
    /// Those directions.
    basis: Vec<[f64; 3]>,
    /// The same space at right angles.
    orthonormal: Vec<[f64; 3]>,
}

impl Span {
    fn of(directions: &[[f64; 3]]) -> Self {
        let mut span = Self { independent: vec![], basis: vec![], orthonormal: vec![] };
        for (index, direction) in directions.iter().enumerate() {
            let inside = span.projection(*direction);
            let beyond: [f64; 3] = std::array::from_fn(|i| direction[i] - inside[i]);
            let size = length(beyond);
            if size > INDEPENDENT {
                span.independent.push(index);
                span.basis.push(*direction);
                span.orthonormal.push(beyond.map(|x| x / size));
            }
        }
        span
    }

    fn projection(&self, v: [f64; 3]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for q in &self.orthonormal {
            let along = dot(*q, v);
            sum.iter_mut().zip(q).for_each(|(sum, q)| *sum += along * q);
        }
        sum
    }

    /// The factors of the independent directions in a vector of the space.
    fn factors(&self, v: [f64; 3]) -> Vec<(usize, f64)> {
        let n = self.basis.len();
        let gram = DMatrix::from_fn(n, n, |i, j| dot(self.basis[i], self.basis[j]));
        let right = DVector::from_fn(n, |i, _| dot(self.basis[i], v));
        let factors = gram.lu().solve(&right).unwrap_or(right);
        let all = self.independent.iter().copied().zip(factors.iter().copied());
        all.filter(|(_, factor)| factor.abs() > f64::EPSILON).collect()
    }
}

/// A rotation whose first rows are the `given` ones.
fn completed(dim: usize, given: &[[f64; 3]]) -> Rotation {
    let mut rows: Vec<[f64; 3]> = Vec::new();
    let add = |rows: &mut Vec<[f64; 3]>, v: [f64; 3]| {
        let mut beyond = v;
        for q in rows.iter() {
            let along = dot(*q, v);
            beyond.iter_mut().zip(q).for_each(|(b, q)| *b -= along * q);
        }
        let size = length(beyond);
        if size > 1e-3 {
            rows.push(beyond.map(|x| x / size));
        }
    };
    given.iter().for_each(|v| add(&mut rows, *v));
    for axis in 0..dim {
        if rows.len() < dim {
            add(&mut rows, std::array::from_fn(|i| f64::from(u8::from(i == axis))));
        }
    }
    rows.resize(3, [0.0; 3]);
    if dim == 2 {
        rows[2] = [0.0, 0.0, 1.0];
    }
    [rows[0], rows[1], rows[2]]
}

/// The axis along which a unit vector points, either way, if it does to the last bits.
fn axis_of(dim: usize, v: [f64; 3]) -> Option<usize> {
    let beside = |axis: usize| (0..dim).filter(|i| *i != axis).map(|i| v[i] * v[i]).sum::<f64>();
    (0..dim).find(|axis| beside(*axis) < 1e-28)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    fn unit(v: [f64; 3]) -> [f64; 3] {
        let size = length(v);
        v.map(|x| x / size)
    }

    #[test]
    fn axes_are_kept_where_they_serve() {
        let frame = NodeFrame::new(3, Some(Z), &[Y, X]);
        assert_eq!((frame.rotation, frame.fixed), (None, [true, true, false]));
        assert_eq!(frame.values[0], [(1, 1.0)]);
        assert_eq!(NodeFrame::new(3, None, &[]).rotation, None);
        let frame = NodeFrame::new(2, None, &[[0.0, -1.0, 0.0]]);
        assert_eq!((frame.rotation, frame.fixed), (None, [false, true, false]));
        assert_eq!(frame.values[1], [(0, -1.0)]);
        // An interface that looks down has a frame.
        assert!(NodeFrame::new(3, Some([0.0, 0.0, -1.0]), &[]).rotation.is_some());
    }

    #[test]
    fn a_support_across_the_interface_fits_its_frame() {
        let n = unit([0.3, 0.0, 0.9]);
        let frame = NodeFrame::new(3, Some(n), &[Y]);
        assert!(!frame.is_at_odds);
        let rotation = frame.rotation.expect("a leaning interface");
        // The second tangent, as at nodes without a support.
        assert_eq!(frame.fixed, [false, true, false]);
        assert_eq!(rotation[1].map(f64::abs), Y);
        assert_eq!(rotation[2], n);
        assert_eq!(NodeFrame::new(3, Some(n), &[]).rotation, Some(rotation));
    }

    #[test]
    fn a_support_that_fits_no_direction_is_at_odds() {
        let frame = NodeFrame::new(2, Some(unit([-0.5, 0.8, 0.0])), &[X]);
        assert!(frame.is_at_odds);
        assert_eq!((frame.rotation, frame.fixed), (None, [true, false, false]));
    }

    #[test]
    fn supports_beside_the_tangents_are_at_odds_together_too() {
        let (a, b) = (unit([0.8, 0.6, 0.0]), unit([-0.6, 0.8, 0.0]));
        let frame = NodeFrame::new(3, Some(Z), &[a]);
        assert!(frame.is_at_odds);
        let frame = NodeFrame::new(3, Some(Z), &[a, b]);
        assert!(frame.is_at_odds);
        assert_eq!(frame.fixed, [true, true, false]);
        assert!(!NodeFrame::new(3, Some(Z), &[X, Y]).is_at_odds);
        // A node that is held altogether has no multiplier anyway.
        assert!(!NodeFrame::new(3, Some(Z), &[a, b, Z]).is_at_odds);
    }

    #[test]
    fn two_leaning_planes_hold_two_directions() {
        let (a, b) = (unit([1.0, 0.2, 0.0]), unit([0.5, 1.0, 0.1]));
        let frame = NodeFrame::new(3, None, &[a, b, a]);
        assert_eq!(frame.fixed, [true, true, false]);
        assert_eq!(frame.dependent.len(), 1);
        // A displacement with given parts along both is found again.
        let u = [0.3, -0.7, 2.0];
        let given = [dot(a, u), dot(b, u), dot(a, u)];
        let rotation = frame.rotation.expect("planes that lean");
        for (values, row) in frame.values.iter().zip(rotation).take(2) {
            let value: f64 = values.iter().map(|(i, f)| f * given[*i]).sum();
            assert!((value - dot(row, u)).abs() < 1e-14);
        }
    }

    proptest! {
        #[test]
        fn frames_are_rotations_and_hold_what_is_prescribed(
            n in prop::array::uniform3(-1.0..1.0_f64),
            d in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            prop_assume!(length(n) > 0.1 && length(d) > 0.1);
            let (n, d) = (unit(n), unit(d));
            let frame = NodeFrame::new(3, Some(n), &[d]);
            let Some(rows) = frame.rotation else { return Ok(()) };
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let exact = f64::from(u8::from(i == j));
                prop_assert!((dot(rows[i], rows[j]) - exact).abs() < 1e-12);
            }
            // Neither along the normal nor, but by chance, along one of the two tangents.
            prop_assert!(frame.is_at_odds);
            let fixed: Vec<usize> = (0..3).filter(|c| frame.fixed[*c]).collect();
            prop_assert_eq!(fixed.len(), 1);
            prop_assert!((dot(rows[fixed[0]], d).abs() - 1.0).abs() < 1e-9);
        }
    }
}
