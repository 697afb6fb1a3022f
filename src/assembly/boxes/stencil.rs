//! The assembled stiffness of a box of like cells as a stencil of one-dimensional factors.
//!
//! In sums and differences of nodal values along the axes a cell's stiffness is a sum of products
//! of three matrices of an element with two nodes, one along each axis: of sums (S), of differences
//! (T), of sums on differences (D), and the transpose of D. Assembled along an axis of like cells
//! they are S = (1, 2, 1), T = (-1, 2, -1) and D = (1, 0, -1), with half of the middle at the ends;
//! there both D and its transpose have -1 first and 1 last besides.
//!
//! Along x and y the cells are alike. Along z they may differ: what acts between planes of nodes is
//! summed over the cells below and above.

use crate::bulk::Modal;
use crate::sparse::Real;

/// Factors of a plane of nodes near a line: the displacements on the line (here), the sum of those
/// on its neighbours along y (even), and lower less upper one (step). Sums of three kinds: for the
/// node (own), for both neighbours along x (beside), and for the next less the previous (odd).
#[derive(Debug, Clone, Copy, Default)]
pub struct Taps<T> {
    /// Of each component on itself: here and even to own, here and even to beside.
    pub same: [[T; 4]; 3],
    /// Of the steps of x on y and of y on x: to odd.
    pub xy: [T; 2],
    /// On the lower and upper line along y, of here.
    pub xy_here: [T; 2],
    /// Of x on z and of z on x, here and even: to odd.
    pub xz: [[T; 2]; 2],
    /// Of the steps of y on z and of z on y: to own and to beside.
    pub yz: [[T; 2]; 2],
    /// On the lower and upper line along y, of here.
    pub yz_here: [[T; 2]; 2],
}

/// Factors of a plane of nodes near an end of a line.
#[derive(Debug, Clone, Copy, Default)]
pub struct EndTaps<T> {
    /// Of x on y and of y on x: of the step and of here.
    pub xy: [[T; 2]; 2],
    /// Of x on z and of z on x: of here and of even.
    pub xz: [[T; 2]; 2],
}

/// Factors of the planes below, at and above a plane of nodes; for its lower line along y, those
/// inside and the upper one.
#[derive(Debug, Clone)]
pub struct PlaneTaps<T> {
    /// Inside the lines.
    pub lines: [[Taps<T>; 3]; 3],
    /// At their ends.
    pub ends: [[EndTaps<T>; 3]; 3],
}

/// The stencil of a box.
#[derive(Debug, Clone)]
pub struct Stencil<T> {
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// The taps of each plane of nodes, by number in `kinds`.
    planes: Vec<u32>,
    kinds: Vec<PlaneTaps<T>>,
}

impl<T: Real> Stencil<T> {
    /// Of so many cells along x and y, and along z those of `layers`; `modal` gives the stiffness
    /// of the cells of a layer by the number there.
    pub fn new<'m>(across: [usize; 2], layers: &[u32], modal: impl Fn(u32) -> &'m Modal) -> Self {
        let (mut known, mut kinds, mut planes) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..=layers.len() {
            let between = [k.checked_sub(1).map(|below| layers[below]), layers.get(k).copied()];
            let number = known.iter().position(|other| *other == between).unwrap_or_else(|| {
                known.push(between);
                kinds.push(PlaneTaps::new(between.map(|cell| cell.map(&modal))));
                kinds.len() - 1
            });
            planes.push(number as u32);
        }
        Self { cells: [across[0], across[1], layers.len()], planes, kinds }
    }

    /// The taps of a plane of nodes.
    #[inline(always)]
    pub fn plane(&self, k: usize) -> &PlaneTaps<T> {
        &self.kinds[self.planes[k] as usize]
    }
}

impl Stencil<f64> {
    /// The same in single precision.
    pub fn to_single(&self) -> Stencil<f32> {
        let single = |taps: &PlaneTaps<f64>| PlaneTaps {
            lines: taps.lines.map(|side| side.map(|taps| taps.to_single())),
            ends: taps.ends.map(|side| side.map(|taps| taps.to_single())),
        };
        Stencil {
            cells: self.cells,
            planes: self.planes.clone(),
            kinds: self.kinds.iter().map(single).collect(),
        }
    }
}

impl Taps<f64> {
    fn to_single(self) -> Taps<f32> {
        let pairs = |pairs: [[f64; 2]; 2]| pairs.map(|pair| pair.map(Real::to_single));
        Taps {
            same: self.same.map(|of| of.map(Real::to_single)),
            xy: self.xy.map(Real::to_single),
            xy_here: self.xy_here.map(Real::to_single),
            xz: pairs(self.xz),
            yz: pairs(self.yz),
            yz_here: pairs(self.yz_here),
        }
    }
}

impl EndTaps<f64> {
    fn to_single(self) -> EndTaps<f32> {
        let pairs = |pairs: [[f64; 2]; 2]| pairs.map(|pair| pair.map(Real::to_single));
        EndTaps { xy: pairs(self.xy), xz: pairs(self.xz) }
    }
}

/// How the force of a plane of nodes follows from the displacements of the planes below, at and
/// above it.
type AlongZ = [f64; 3];

/// The cells below and above a plane of nodes.
#[derive(Clone, Copy)]
struct Between<'m>([Option<&'m Modal>; 2]);

impl Between<'_> {
    /// What component `d` does to mode `m` of component `c`, assembled along z.
    fn along_z(&self, c: usize, d: usize, m: usize) -> AlongZ {
        let of_force = m >> 2 & 1 == 1;
        let of_displacement = if c != d && (c == 2 || d == 2) { !of_force } else { of_force };
        let sign = |is_step: bool, upper: bool| if is_step && !upper { -1.0 } else { 1.0 };
        let mut column = [0.0; 3];
        // The node is the upper one of the cell below, the lower one of the cell above.
        for (cell, upper) in self.0.into_iter().zip([true, false]) {
            let Some(modal) = cell else { continue };
            for other in [false, true] {
                let place = usize::from(!upper) + usize::from(other);
                let factor = sign(of_force, upper) * sign(of_displacement, other);
                column[place] += factor * modal.entry[c][d][m];
            }
        }
        column
    }

    /// Those of modes that are sums and differences along z.
    fn both(&self, c: usize, d: usize, m: usize) -> AlongZ {
        plus(self.along_z(c, d, m), self.along_z(c, d, m | 4))
    }
}

fn plus(a: AlongZ, b: AlongZ) -> AlongZ {
    std::array::from_fn(|i| a[i] + b[i])
}

fn times(factor: f64, a: AlongZ) -> AlongZ {
    a.map(|a| factor * a)
}

fn minus(a: AlongZ, b: AlongZ) -> AlongZ {
    plus(a, times(-1.0, b))
}

/// What sums and differences of the two nodes of an element along an axis amount to: at the node,
/// and at each neighbour.
fn even(sums: AlongZ, differences: AlongZ) -> [AlongZ; 2] {
    [times(2.0, plus(sums, differences)), minus(sums, differences)]
}

impl<T: Real> PlaneTaps<T> {
    fn new(between: [Option<&Modal>; 2]) -> Self {
        let between = &Between(between);
        let sides = [-1.0, 0.0, 1.0];
        Self {
            lines: sides.map(|side| line_taps(between, side)),
            ends: sides.map(|side| end_taps(between, side)),
        }
    }
}

/// The taps of lines on the lower side along y (-1), inside (0), on the upper side (1).
fn line_taps<T: Real>(of: &Between<'_>, side: f64) -> [Taps<T>; 3] {
    let mut taps = [Taps::default(); 3];
    // At a side the middle along y has half its weight.
    let middle = if side == 0.0 { 1.0 } else { 0.5 };
    for c in 0..3 {
        // Along y of what is a sum and a difference along x, then along x.
        let along_y = |x: usize| even(of.both(c, c, x), of.both(c, c, x | 2));
        let ([sum_here, sum_even], [step_here, step_even]) = (along_y(0), along_y(1));
        let [own_here, beside_here] = even(sum_here, step_here);
        let [own_even, beside_even] = even(sum_even, step_even);
        for (p, taps) in taps.iter_mut().enumerate() {
            taps.same[c] =
                [middle * own_here[p], own_even[p], middle * beside_here[p], beside_even[p]]
                    .map(T::from_double);
        }
    }
    // Families of modes: differences along the axis of the force, or of the displacement.
    for (d, c, sign) in [(0, 1, -1.0), (1, 0, 1.0)] {
        let (first, second) = (of.both(c, d, 1 << c), of.both(c, d, 1 << d));
        let (step, here) = (times(-1.0, plus(first, second)), times(sign, minus(first, second)));
        for (p, taps) in taps.iter_mut().enumerate() {
            taps.xy[d] = T::from_double(step[p]);
            taps.xy_here[d] = T::from_double(side * here[p]);
        }
    }
    for (d, c, sign) in [(0, 2, -1.0), (2, 0, 1.0)] {
        let part = |y: usize| {
            let (first, second) = (of.along_z(c, d, 1 << c | y), of.along_z(c, d, 1 << d | y));
            times(sign, minus(first, second))
        };
        let [here, even] = even(part(0), part(2));
        for (p, taps) in taps.iter_mut().enumerate() {
            taps.xz[d / 2] = [middle * here[p], even[p]].map(T::from_double);
        }
    }
    for (d, c, sign) in [(1, 2, -1.0), (2, 1, 1.0)] {
        let parts = |x: usize| [of.along_z(c, d, 1 << c | x), of.along_z(c, d, 1 << d | x)];
        let ([first, second], [first_x, second_x]) = (parts(0), parts(1));
        let step = even(times(sign, minus(first, second)), times(sign, minus(first_x, second_x)));
        let here = even(plus(first, second), plus(first_x, second_x));
        for (p, taps) in taps.iter_mut().enumerate() {
            taps.yz[d - 1] = step.map(|s| T::from_double(s[p]));
            taps.yz_here[d - 1] = here.map(|h| T::from_double(side * h[p]));
        }
    }
    taps
}

/// The taps at the ends of lines on the lower side along y (-1), inside (0), on the upper side (1).
fn end_taps<T: Real>(of: &Between<'_>, side: f64) -> [EndTaps<T>; 3] {
    let mut taps = [EndTaps::default(); 3];
    let middle = if side == 0.0 { 1.0 } else { 0.5 };
    for (d, c, sign) in [(0, 1, 1.0), (1, 0, -1.0)] {
        let (first, second) = (of.both(c, d, 1 << c), of.both(c, d, 1 << d));
        let (step, here) = (times(sign, minus(first, second)), plus(first, second));
        for (p, taps) in taps.iter_mut().enumerate() {
            taps.xy[d] = [step[p], side * here[p]].map(T::from_double);
        }
    }
    for (d, c) in [(0, 2), (2, 0)] {
        let part = |y: usize| plus(of.along_z(c, d, 1 << c | y), of.along_z(c, d, 1 << d | y));
        let [here, even] = even(part(0), part(2));
        for (p, taps) in taps.iter_mut().enumerate() {
            taps.xz[d / 2] = [middle * here[p], even[p]].map(T::from_double);
        }
    }
    taps
}
