//! The product of a box of like cells with a vector, gathered node by node.
//!
//! Three planes of nodes pass through the caches, component by component. For each line of nodes
//! along x the sums over y and z come first, by the taps of its plane: what acts on the node itself
//! and what acts on those before and behind it along x. Then they are added up along x.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use super::stencil::{EndTaps, Stencil, Taps};
use crate::simd::Kernel;
use crate::sparse::Real;

/// Room before the first node of a line, where nothing is.
const FRONT: usize = 8;

/// The nodes of a box, line by line along x, then y, then z: ranges of local nodes that follow one
/// another.
pub struct Runs {
    /// First local node and length.
    pub runs: Vec<[u32; 2]>,
    /// First run of each line, and the end.
    pub start: Vec<u32>,
}

impl Runs {
    fn of_line(&self, line: usize) -> &[[u32; 2]] {
        &self.runs[self.start[line] as usize..self.start[line + 1] as usize]
    }
}

/// Room for the planes and for the sums of a line.
#[derive(Default)]
pub struct Room<T> {
    planes: Vec<T>,
    sums: Vec<T>,
}

/// One product with a box: adds to the forces at the first nodes, then at the others.
pub struct Product<'a, T> {
    pub stencil: &'a Stencil<T>,
    pub runs: &'a Runs,
    pub u: &'a [[T; 3]],
    pub force: [&'a mut [[T; 3]]; 2],
    pub room: &'a mut Room<T>,
}

/// A product with so many nodes at once, with or without instructions that multiply and add.
pub struct InLanes<'a, T, const L: usize, const FUSED: bool>(pub Product<'a, T>);

/// Numbers of nodes that follow one another along x.
type Lanes<T, const L: usize> = [T; L];

/// The lines of nodes of the planes that pass through.
struct Shape {
    /// Nodes along x, y, z.
    nodes: [usize; 3],
    /// Numbers of a line.
    pitch: usize,
    /// Numbers of a component of a plane: a line without nodes, those of the box, another one.
    part: usize,
}

impl Shape {
    fn new(cells: [usize; 3], lanes: usize) -> Self {
        let nodes = [cells[0] + 1, cells[1] + 1, cells[2] + 1];
        let pitch = nodes[0].div_ceil(lanes) * lanes;
        Self { nodes, pitch, part: pitch * (nodes[1] + 2) }
    }
}

impl<T: Real, const L: usize, const FUSED: bool> Kernel for InLanes<'_, T, L, FUSED> {
    #[inline(always)]
    fn run(self) {
        let Product { stencil, runs, u, force: [first, others], room } = self.0;
        let shape = Shape::new(stencil.cells, L);
        let [nx, ny, nz] = shape.nodes;
        let width = shape.pitch + 2 * FRONT;
        room.planes.resize((9 * shape.part).max(room.planes.len()), T::ZERO);
        room.sums.resize((9 * width).max(room.sums.len()), T::ZERO);
        let (planes, _) = room.planes.split_at_mut(9 * shape.part);
        let (plane_0, rest) = planes.split_at_mut(3 * shape.part);
        let (plane_1, plane_2) = rest.split_at_mut(3 * shape.part);
        let mut planes = [plane_0, plane_1, plane_2];
        for plane in &mut planes {
            for d in 0..3 {
                let part = &mut plane[d * shape.part..][..shape.part];
                part[..shape.pitch].fill(T::ZERO);
                part[shape.part - shape.pitch..].fill(T::ZERO);
            }
        }
        let sums = &mut room.sums[..9 * width];
        load(planes[1], &shape, runs, 0, u);
        for k in 0..nz {
            if k + 1 < nz {
                load(planes[2], &shape, runs, k + 1, u);
            }
            let taps = stencil.plane(k);
            let near = [&*planes[0], &*planes[1], &*planes[2]];
            for j in 0..ny {
                // A line on the lower or upper side along y has other taps.
                let side = usize::from(j > 0) + usize::from(j + 1 == ny);
                let lines = Lines::new(near, &shape, j);
                let of_side = &taps.lines[side];
                if side == 1 {
                    add_across::<T, L, FUSED>(&lines, of_side, false, sums, width);
                } else {
                    add_across::<T, L, FUSED>(&lines, of_side, true, sums, width);
                }
                let first_end = at_end(&lines, &taps.ends[side], 0);
                let last_end = at_end(&lines, &taps.ends[side], nx - 1);
                let ends = [first_end, last_end];
                finish(sums, width, nx, ends);
                let line = runs.of_line(k * ny + j);
                store(sums, width, line, [&mut *first, &mut *others]);
            }
            planes.rotate_left(1);
        }
    }
}

/// Takes the values of a plane of nodes, component by component.
#[inline(always)]
fn load<T: Real>(plane: &mut [T], shape: &Shape, runs: &Runs, k: usize, u: &[[T; 3]]) {
    let (x, rest) = plane.split_at_mut(shape.part);
    let (y, z) = rest.split_at_mut(shape.part);
    for j in 0..shape.nodes[1] {
        let mut at = (j + 1) * shape.pitch;
        for [node, length] in runs.of_line(k * shape.nodes[1] + j) {
            let (node, length) = (*node as usize, *length as usize);
            let from = &u[node..node + length];
            let x = &mut x[at..at + length];
            let y = &mut y[at..at + length];
            let z = &mut z[at..at + length];
            for i in 0..length {
                x[i] = from[i][0];
                y[i] = from[i][1];
                z[i] = from[i][2];
            }
            at += length;
        }
    }
}

/// A line of nodes in the planes below, at and above its own, with the lines beside it along y.
struct Lines<'p, T> {
    /// Component by component of each plane: the line before, the line and the line behind.
    at: [[[&'p [T]; 3]; 3]; 3],
}

impl<'p, T: Real> Lines<'p, T> {
    #[inline(always)]
    fn new(near: [&'p [T]; 3], shape: &Shape, j: usize) -> Self {
        let mut at: [[[&[T]; 3]; 3]; 3] = [[[&[]; 3]; 3]; 3];
        for plane in 0..3 {
            for d in 0..3 {
                for line in 0..3 {
                    let first = d * shape.part + (j + line) * shape.pitch;
                    at[plane][d][line] = &near[plane][first..first + shape.pitch];
                }
            }
        }
        Self { at }
    }
}

/// sum + factor value
#[inline(always)]
fn add<T: Real, const L: usize, const FUSED: bool>(
    sum: &mut Lanes<T, L>,
    factor: T,
    value: &Lanes<T, L>,
) {
    for l in 0..L {
        sum[l] = if FUSED { factor.mul_add(value[l], sum[l]) } else { sum[l] + factor * value[l] };
    }
}

/// The sums over y and z on a line: what stays in place, and what goes to the next and to the
/// previous node along x.
#[inline(always)]
fn add_across<T: Real, const L: usize, const FUSED: bool>(
    lines: &Lines<'_, T>,
    taps: &[Taps<T>; 3],
    is_side: bool,
    sums: &mut [T],
    width: usize,
) {
    let chunks = lines.at[0][0][0].len() / L;
    for i in 0..chunks {
        let zero = [T::ZERO; L];
        let (mut own, mut beside, mut odd) = ([zero; 3], [zero; 3], [zero; 3]);
        for plane in 0..3 {
            let near = &lines.at[plane];
            let to = [&mut own, &mut beside, &mut odd];
            add_plane::<T, L, FUSED>(&taps[plane], is_side, near, i, to);
        }
        for c in 0..3 {
            let (mut forward, mut backward) = (zero, zero);
            for l in 0..L {
                forward[l] = beside[c][l] + odd[c][l];
                backward[l] = beside[c][l] - odd[c][l];
            }
            let at = c * width + FRONT + i * L;
            sums[at..at + L].copy_from_slice(&own[c]);
            sums[3 * width + at..][..L].copy_from_slice(&forward);
            sums[6 * width + at..][..L].copy_from_slice(&backward);
        }
    }
}

/// Adds what a plane of nodes contributes to the sums of some nodes of a line.
#[inline(always)]
fn add_plane<T: Real, const L: usize, const FUSED: bool>(
    taps: &Taps<T>,
    is_side: bool,
    near: &[[&[T]; 3]; 3],
    i: usize,
    [own, beside, odd]: [&mut [Lanes<T, L>; 3]; 3],
) {
    for d in 0..3 {
        let low = &near[d][0].as_chunks::<L>().0[i];
        let here = &near[d][1].as_chunks::<L>().0[i];
        let high = &near[d][2].as_chunks::<L>().0[i];
        let (mut even, mut step) = ([T::ZERO; L], [T::ZERO; L]);
        for l in 0..L {
            even[l] = low[l] + high[l];
            step[l] = low[l] - high[l];
        }
        let [own_here, own_even, beside_here, beside_even] = taps.same[d];
        add::<T, L, FUSED>(&mut own[d], own_here, here);
        add::<T, L, FUSED>(&mut own[d], own_even, &even);
        add::<T, L, FUSED>(&mut beside[d], beside_here, here);
        add::<T, L, FUSED>(&mut beside[d], beside_even, &even);
        // Of x and y on each other, of x and z, of y and z.
        if d < 2 {
            add::<T, L, FUSED>(&mut odd[1 - d], taps.xy[d], &step);
            if is_side {
                add::<T, L, FUSED>(&mut odd[1 - d], taps.xy_here[d], here);
            }
        }
        if d != 1 {
            let [on_here, on_even] = taps.xz[d / 2];
            add::<T, L, FUSED>(&mut odd[2 - d], on_here, here);
            add::<T, L, FUSED>(&mut odd[2 - d], on_even, &even);
        }
        if d > 0 {
            let [of_own, of_beside] = taps.yz[d - 1];
            add::<T, L, FUSED>(&mut own[3 - d], of_own, &step);
            add::<T, L, FUSED>(&mut beside[3 - d], of_beside, &step);
            if is_side {
                let [of_own, of_beside] = taps.yz_here[d - 1];
                add::<T, L, FUSED>(&mut own[3 - d], of_own, here);
                add::<T, L, FUSED>(&mut beside[3 - d], of_beside, here);
            }
        }
    }
}

/// What the first or last node of a line gets beside the half of its own sums, but for the sign.
#[inline(always)]
fn at_end<T: Real>(lines: &Lines<'_, T>, taps: &[EndTaps<T>; 3], i: usize) -> [T; 3] {
    let mut sum = [T::ZERO; 3];
    for (t, near) in taps.iter().zip(&lines.at) {
        let [u, v, w] = near;
        let (u, v, w) =
            ([u[0][i], u[1][i], u[2][i]], [v[0][i], v[1][i], v[2][i]], [w[0][i], w[1][i], w[2][i]]);
        sum[0] += t.xy[1][0] * (v[0] - v[2]) + t.xy[1][1] * v[1];
        sum[0] += t.xz[1][0] * w[1] + t.xz[1][1] * (w[0] + w[2]);
        sum[1] += t.xy[0][0] * (u[0] - u[2]) + t.xy[0][1] * u[1];
        sum[2] += t.xz[0][0] * u[1] + t.xz[0][1] * (u[0] + u[2]);
    }
    sum
}

/// Adds up along x, in the place of the first three sums.
#[inline(always)]
fn finish<T: Real>(sums: &mut [T], width: usize, nodes: usize, [first, last]: [[T; 3]; 2]) {
    let half = T::from_double(0.5);
    let (own, others) = sums.split_at_mut(3 * width);
    let (forward, backward) = others.split_at_mut(3 * width);
    for c in 0..3 {
        let own = &mut own[c * width..][..width];
        let forward = &mut forward[c * width..][..width];
        let backward = &mut backward[c * width..][..width];
        own[FRONT] = half * own[FRONT] - first[c];
        own[FRONT + nodes - 1] = half * own[FRONT + nodes - 1] + last[c];
        forward[FRONT - 1] = T::ZERO;
        backward[FRONT + nodes] = T::ZERO;
        let own = &mut own[FRONT..][..nodes];
        let forward = &forward[FRONT - 1..][..nodes];
        let backward = &backward[FRONT + 1..][..nodes];
        for i in 0..nodes {
            own[i] += forward[i] + backward[i];
        }
    }
}

/// Adds the sums of a line to the forces.
#[inline(always)]
fn store<T: Real>(
    sums: &[T],
    width: usize,
    line: &[[u32; 2]],
    [first, others]: [&mut [[T; 3]]; 2],
) {
    let mut at = FRONT;
    for [node, length] in line {
        let (mut node, mut left) = (*node as usize, *length as usize);
        while left > 0 {
            let to = if node < first.len() {
                let end = (node + left).min(first.len());
                &mut first[node..end]
            } else {
                let begin = node - first.len();
                &mut others[begin..begin + left]
            };
            let length = to.len();
            let x = &sums[at..][..length];
            let y = &sums[width + at..][..length];
            let z = &sums[2 * width + at..][..length];
            for i in 0..length {
                to[i][0] += x[i];
                to[i][1] += y[i];
                to[i][2] += z[i];
            }
            (node, left, at) = (node + length, left - length, at + length);
        }
    }
}
