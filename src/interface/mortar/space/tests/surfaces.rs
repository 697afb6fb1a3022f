//! Random meshes of a rectangle, laid anywhere into space, and sums of their rows.

use std::collections::BTreeMap;

use crate::element::{Shape, map_point};
use crate::interface::mortar::space::vector::{Vector, cross, unit};
use crate::interface::mortar::{
    Contribution, Partners, SpaceFacet, candidates_in_space, facet_rows_in_space,
};

pub const KINDS: [Kind; 6] = [
    Kind::Of(Shape::Tri3),
    Kind::Of(Shape::Tri6),
    Kind::Of(Shape::Quad4),
    Kind::Of(Shape::Quad9),
    Kind::Mixed(1),
    Kind::Mixed(2),
];

/// The facets of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    Of(Shape),
    /// Triangles and quadrilaterals of this order.
    Mixed(usize),
}

impl Kind {
    pub fn order(self) -> usize {
        match self {
            Kind::Of(shape) => shape.order(),
            Kind::Mixed(order) => order,
        }
    }

    /// Whether a side of this kind needs the transformed basis.
    pub fn transformed(self) -> bool {
        matches!(self, Kind::Of(Shape::Tri6) | Kind::Mixed(2))
    }
}

/// Random numbers between 0 and 1.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A facet in the plane z = 0.
#[derive(Debug, Clone)]
pub struct Flat {
    pub shape: Shape,
    pub nodes: Vec<u64>,
    pub points: Vec<[f64; 2]>,
}

/// The rectangle [0, 2] x [0, 1], or the part of it left of `right`, with `n` cells along its sides
/// and its inner points shaken; the facets look up or down, their nodes are named from `first` on.
pub fn rectangle(n: [usize; 2], kind: Kind, seed: u64, up: bool, right: f64) -> Vec<Flat> {
    let mut random = Random::new(seed);
    let mut corner = BTreeMap::new();
    for j in 0..=n[1] {
        for i in 0..=n[0] {
            let mut shake = |at: usize, most: usize| {
                let amount = 0.4 * (random.next() - 0.5);
                (at as f64 + if at == 0 || at == most { 0.0 } else { amount }) / most as f64
            };
            corner.insert((i, j), [right * shake(i, n[0]), shake(j, n[1])]);
        }
    }
    let mut names = Names { first: if up { 0 } else { 100_000 }, numbers: BTreeMap::new() };
    let mut out = Vec::new();
    for j in 0..n[1] {
        for i in 0..n[0] {
            let mut quad = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|c| corner[&c]);
            quad.rotate_left((4.0 * random.next()) as usize);
            let into_triangles = match kind {
                Kind::Of(shape) => shape.corners() == Shape::Tri3,
                Kind::Mixed(_) => random.next() < 0.5,
            };
            let [a, b, c, d] = quad;
            let cells: &[&[[f64; 2]]] =
                if into_triangles { &[&[a, b, c], &[c, d, a]] } else { &[&[a, b, c, d]] };
            out.extend(cells.iter().map(|corners| names.facet(corners, kind.order(), up)));
        }
    }
    out
}

/// The interval [0, 1] with `n` lines.
pub fn interval(n: usize, order: usize, seed: u64, up: bool, right: f64) -> Vec<Flat> {
    let mut random = Random::new(seed);
    let mut x = |i: usize| {
        let shake = 0.6 * (random.next() - 0.5);
        right * (i as f64 + if i == 0 || i == n { 0.0 } else { shake }) / n as f64
    };
    let x: Vec<f64> = (0..=n).map(&mut x).collect();
    let mut names = Names { first: if up { 0 } else { 100_000 }, numbers: BTreeMap::new() };
    x.windows(2).map(|x| names.facet(&[[x[0], 0.0], [x[1], 0.0]], order, up)).collect()
}

struct Names {
    first: u64,
    numbers: BTreeMap<[i64; 2], u64>,
}

impl Names {
    fn facet(&mut self, corners: &[[f64; 2]], order: usize, up: bool) -> Flat {
        let mut corners = corners.to_vec();
        // The corners of surfaces run counter-clockwise; lines to the left look up.
        if up == (corners.len() == 2) {
            corners.reverse();
        }
        let (first, shape) = match (corners.len(), order) {
            (2, _) => (Shape::Line2, Shape::of(1, order)),
            (3, 1) => (Shape::Tri3, Shape::Tri3),
            (3, _) => (Shape::Tri3, Shape::Tri6),
            _ => (Shape::Quad4, Shape::of(2, order)),
        };
        let points: Vec<[f64; 2]> =
            shape.node_points().iter().map(|xi| map_point(first, &corners, *xi)).collect();
        let mut name = |x: &[f64; 2]| {
            let next = self.first + self.numbers.len() as u64;
            *self.numbers.entry(x.map(|x| (x * 1e9).round() as i64)).or_insert(next)
        };
        let nodes = points.iter().map(&mut name).collect();
        Flat { shape, nodes, points }
    }
}

/// A place in space for the plane z = 0.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    pub axes: [Vector; 3],
    pub shift: Vector,
    pub scale: f64,
}

impl Motion {
    pub const NONE: Motion = Motion {
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        shift: [0.0; 3],
        scale: 1.0,
    };

    /// A random turn and a shift.
    pub fn random(seed: u64) -> Self {
        let mut random = Random::new(seed + 77);
        let mut vector = || [0; 3].map(|_| 2.0 * random.next() - 1.0);
        let (first, second, shift) = (unit(vector()).unwrap(), vector(), vector());
        let third = unit(cross(first, second)).unwrap();
        Motion { axes: [first, cross(third, first), third], shift, scale: 1.0 }
    }

    pub fn of(&self, x: [f64; 3]) -> Vector {
        let turned = |d: usize| (0..3).map(|a| x[a] * self.axes[a][d]).sum::<f64>();
        std::array::from_fn(|d| self.scale * (self.shift[d] + turned(d)))
    }
}

/// The facets at their place; lines in the plane of the first two axes.
pub fn lay(flat: &[Flat], to: &Motion) -> Vec<SpaceFacet> {
    let facet = |f: &Flat| {
        let points: Vec<Vector> = f.points.iter().map(|x| to.of([x[0], x[1], 0.0])).collect();
        SpaceFacet::new(f.shape, &f.nodes, &points, &[0, 1, 2])
    };
    flat.iter().map(facet).collect()
}

/// The sums of all contributions of one node.
#[derive(Debug, Clone, Default)]
pub struct Row {
    pub weight: f64,
    pub here: BTreeMap<u64, f64>,
    pub there: BTreeMap<u64, f64>,
}

/// Rows by node, and covered and whole area.
#[derive(Debug, Clone, Default)]
pub struct Sums {
    pub rows: BTreeMap<u64, Row>,
    pub covered: f64,
    pub area: f64,
}

/// All rows of one side, of which `dropped` says what nodes carry no multiplier.
pub fn rows(
    secondary: &[SpaceFacet],
    primary: &[SpaceFacet],
    transformed: bool,
    dropped: impl Fn(u64) -> bool,
) -> Sums {
    let pairs = candidates_in_space(secondary, primary, 0.0);
    let mut sums = Sums::default();
    for (s, facet) in secondary.iter().enumerate() {
        let near: Vec<&SpaceFacet> =
            pairs.iter().filter(|pair| pair.0 == s).map(|pair| &primary[pair.1]).collect();
        let mut mask = 0;
        for (bit, node) in facet.nodes().iter().enumerate() {
            mask |= u16::from(dropped(*node)) << bit;
        }
        let found =
            facet_rows_in_space(facet, Partners::Near(&near), &[mask, mask], transformed).unwrap();
        sums.covered += found.covered;
        sums.area += found.area;
        found.contributions.iter().for_each(|c| sums.add(c));
    }
    sums
}

impl Sums {
    fn add(&mut self, c: &Contribution) {
        assert_eq!(c.components, [true, true, false]);
        assert_eq!(c.secondary[0].0, c.node);
        let row = self.rows.entry(c.node).or_default();
        row.weight += c.weight;
        c.secondary.iter().for_each(|(k, v)| *row.here.entry(*k).or_default() += v);
        c.primary.iter().for_each(|(l, v)| *row.there.entry(*l).or_default() += v);
    }

    /// The largest jump of a field over all nodes, by its values at the nodes.
    pub fn largest_jump(&self, field: &BTreeMap<u64, f64>) -> f64 {
        let sum = |side: &BTreeMap<u64, f64>| side.iter().map(|(k, c)| c * field[k]).sum::<f64>();
        let jump = |row: &Row| ((sum(&row.here) - sum(&row.there)) / row.weight).abs();
        self.rows.values().map(jump).fold(0.0, f64::max)
    }
}

/// The values of a field at the nodes of both sides.
pub fn values(sides: [&[Flat]; 2], field: impl Fn([f64; 2]) -> f64) -> BTreeMap<u64, f64> {
    let facets = sides.into_iter().flatten();
    facets.flat_map(|f| f.nodes.iter().copied().zip(f.points.iter().map(|x| field(*x)))).collect()
}
