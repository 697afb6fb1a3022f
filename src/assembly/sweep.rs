//! Forces of many like boxes at once: the sweep over the cells without a matrix.
//!
//! Cells that follow one another along x share nodes. Lines of them are laid side by side in
//! batches: one slot per node along x, two lines of nodes in 2D and four in 3D. Between two lines
//! of cells lies a slot whose cell does not exist. All arithmetic then runs over the slots of a
//! batch, as wide as the processor's vectors; the stiffness acts in modal form.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use crate::bulk::{MODES, Modal, couples, partner};
use crate::simd::{Kernel, widest};
use crate::sparse::Real;

/// Slots of a batch: the arrays of the sweep stay in the innermost cache.
const SLOTS: usize = 32;
/// Room behind the slots, so that loops over all of them may look at the next one.
const PADDED: usize = SLOTS + 8;
/// Place of the first slot where loops look at the one before.
const FIRST: usize = 8;
/// Lines of nodes of a batch in 3D.
const LINES: usize = 4;

/// The corners at the lower and upper end along x of each line, by number in the cell; a line's
/// index has bit 0 for the upper side along the second axis, bit 1 along the third.
const ENDS_2D: [[usize; 2]; 2] = [[0, 1], [3, 2]];
const ENDS_3D: [[usize; 2]; LINES] = [[0, 1], [3, 2], [4, 5], [7, 6]];

/// Like cells side by side.
struct Batch {
    prototype: u32,
    slots: u16,
    /// First entry in `nodes`.
    first: u32,
    /// Range in `gaps`.
    gaps: [u32; 2],
}

/// A set of cells in batches.
#[derive(Default)]
pub struct Sweep {
    dim: usize,
    batches: Vec<Batch>,
    /// Local nodes of the slots, line by line of each batch.
    nodes: Vec<u32>,
    /// Slots without a cell, but for the last of each batch.
    gaps: Vec<u16>,
}

/// Numbers of one batch. All loops run over all slots: what lies behind the last one is computed
/// and not used.
struct Scratch {
    /// Displacements by component, line and slot; then the forces there.
    line: [[[f64; PADDED]; LINES]; 3],
    /// Displacements by component and mode.
    mode: [[[f64; SLOTS]; MODES]; 3],
    /// Forces by component and mode, from [`FIRST`] on; before it stands the cell before the first,
    /// which has none.
    force: [[[f64; PADDED]; MODES]; 3],
}

impl Sweep {
    /// Puts cells into batches: each has `2^dim` local nodes and the index of its prototype.
    pub fn new<'a>(dim: usize, cells: impl Iterator<Item = (&'a [u32], u32)>) -> Self {
        let ends: &[[usize; 2]] = if dim == 2 { &ENDS_2D } else { &ENDS_3D };
        let mut sweep = Self { dim, batches: Vec::new(), nodes: Vec::new(), gaps: Vec::new() };
        let mut lines: Vec<Vec<u32>> = vec![Vec::new(); ends.len()];
        let mut gaps = Vec::new();
        let mut current = None;
        for (nodes, prototype) in cells {
            let slots = lines[0].len();
            let goes_on = current == Some(prototype)
                && slots > 0
                && lines.iter().zip(ends).all(|(line, end)| line[slots - 1] == nodes[end[0]]);
            let needed = if goes_on { 1 } else { 2 };
            let full = slots + needed > SLOTS;
            if full || current != Some(prototype) {
                sweep.close(current, &mut lines, &mut gaps);
                current = Some(prototype);
            }
            // A line of cells goes on in the next batch with its last node once more.
            if full || !goes_on {
                if !lines[0].is_empty() {
                    gaps.push(lines[0].len() as u16 - 1);
                }
                lines.iter_mut().zip(ends).for_each(|(line, end)| line.push(nodes[end[0]]));
            }
            lines.iter_mut().zip(ends).for_each(|(line, end)| line.push(nodes[end[1]]));
        }
        sweep.close(current, &mut lines, &mut gaps);
        sweep
    }

    fn close(&mut self, prototype: Option<u32>, lines: &mut [Vec<u32>], gaps: &mut Vec<u16>) {
        let slots = lines[0].len();
        let Some(prototype) = prototype.filter(|_| slots > 0) else { return };
        let (first, first_gap) = (self.nodes.len() as u32, self.gaps.len() as u32);
        lines.iter_mut().for_each(|line| self.nodes.append(line));
        self.gaps.append(gaps);
        let gaps = [first_gap, self.gaps.len() as u32];
        self.batches.push(Batch { prototype, slots: slots as u16, first, gaps });
    }

    /// Adds the forces K u of the cells to `force` (N), both `dim` numbers per local node, the
    /// forces in two parts: those of the first nodes, then those of the others. `stiffness` gives
    /// the modal form of a prototype. `magnitude` gets the sum of the lengths of the cells' nodal
    /// forces, one per local node. Local.
    pub fn add_forces<'a, T: Real>(
        &self,
        stiffness: impl Fn(u32) -> &'a Modal,
        u: &[T],
        force: [&mut [T]; 2],
        magnitude: Option<&mut [f64]>,
    ) {
        let sizes = magnitude.is_some();
        let magnitude = magnitude.unwrap_or_default();
        let pass = Pass { sweep: self, stiffness, u, force, magnitude };
        match (self.dim, sizes) {
            (2, false) => widest(Dim::<_, _, 2, 2, false>(pass)),
            (2, true) => widest(Dim::<_, _, 2, 2, true>(pass)),
            (_, false) => widest(Dim::<_, _, 3, 4, false>(pass)),
            (_, true) => widest(Dim::<_, _, 3, 4, true>(pass)),
        }
    }
}

/// One pass over the cells of a sweep.
struct Pass<'s, F, T> {
    sweep: &'s Sweep,
    stiffness: F,
    u: &'s [T],
    force: [&'s mut [T]; 2],
    magnitude: &'s mut [f64],
}

/// A pass in `DIM` dimensions with `L` lines per batch, with or without the lengths of the forces.
struct Dim<'s, F, T, const DIM: usize, const L: usize, const SIZES: bool>(Pass<'s, F, T>);

impl<'a, F, T, const DIM: usize, const L: usize, const SIZES: bool> Kernel
    for Dim<'_, F, T, DIM, L, SIZES>
where
    F: Fn(u32) -> &'a Modal,
    T: Real,
{
    #[inline(always)]
    fn run(self) {
        let Pass { sweep, stiffness, u, force, magnitude } = self.0;
        let mut s = Scratch {
            line: [[[0.0; PADDED]; LINES]; 3],
            mode: [[[0.0; SLOTS]; MODES]; 3],
            force: [[[0.0; PADDED]; MODES]; 3],
        };
        let u = u.as_chunks::<DIM>().0;
        let [first, others] = force.map(|part| part.as_chunks_mut::<DIM>().0);
        for batch in &sweep.batches {
            let slots = batch.slots as usize;
            let nodes = &sweep.nodes[batch.first as usize..][..slots * L];
            gather::<T, DIM, L>(u, nodes, &mut s);
            to_modes::<DIM, L>(&mut s);
            apply::<DIM>(stiffness(batch.prototype), &mut s);
            let gaps = &sweep.gaps[batch.gaps[0] as usize..batch.gaps[1] as usize];
            for gap in gaps.iter().map(|gap| *gap as usize).chain([slots - 1]) {
                for mode in s.force.iter_mut().take(DIM).flatten() {
                    mode[FIRST + gap] = 0.0;
                }
            }
            to_lines_of_cells::<DIM, L>(&mut s);
            if SIZES {
                lengths::<DIM, L>(&mut s);
                add_lengths::<L>(&s, nodes, magnitude);
            }
            to_nodes::<DIM, L>(&mut s);
            scatter::<T, DIM, L>(&s, nodes, first, others);
        }
    }
}

/// Takes the displacements of the nodes of a batch, line by line.
#[inline(always)]
fn gather<T: Real, const DIM: usize, const L: usize>(
    u: &[[T; DIM]],
    nodes: &[u32],
    s: &mut Scratch,
) {
    for (line, nodes) in (0..L).zip(nodes.chunks_exact(nodes.len() / L)) {
        let [x, y, z] = s.line.each_mut().map(|of_component| &mut of_component[line]);
        for (((node, x), y), z) in nodes.iter().zip(x).zip(y).zip(z) {
            let values = &u[*node as usize];
            *x = values[0].to_double();
            *y = values[1].to_double();
            if DIM == 3 {
                *z = values[2].to_double();
            }
        }
    }
}

/// Adds the forces to the nodes of a batch, those of the `first` nodes and of the others.
#[inline(always)]
fn scatter<T: Real, const DIM: usize, const L: usize>(
    s: &Scratch,
    nodes: &[u32],
    first: &mut [[T; DIM]],
    others: &mut [[T; DIM]],
) {
    for (line, nodes) in (0..L).zip(nodes.chunks_exact(nodes.len() / L)) {
        let [x, y, z] = s.line.each_ref().map(|of_component| &of_component[line]);
        for (((node, x), y), z) in nodes.iter().zip(x).zip(y).zip(z) {
            let node = *node as usize;
            let target =
                if node < first.len() { &mut first[node] } else { &mut others[node - first.len()] };
            target[0] += T::from_double(*x);
            target[1] += T::from_double(*y);
            if DIM == 3 {
                target[2] += T::from_double(*z);
            }
        }
    }
}

/// Adds the lengths of the forces of the two cells at each node of a batch, which [`lengths`] left.
#[inline(always)]
fn add_lengths<const L: usize>(s: &Scratch, nodes: &[u32], magnitude: &mut [f64]) {
    for (line, nodes) in (0..L).zip(nodes.chunks_exact(nodes.len() / L)) {
        let mut left = 0.0;
        let ends = s.mode[0][2 * line].iter().zip(&s.mode[0][2 * line + 1]);
        for (node, (lower, upper)) in nodes.iter().zip(ends) {
            magnitude[*node as usize] += lower + left;
            left = *upper;
        }
    }
}

/// Sums and differences, across the lines and then along x: mode 2 q + b has the differences that
/// the bits of q mark along the second and third axis, and b along the first.
#[inline(always)]
fn to_modes<const DIM: usize, const L: usize>(s: &mut Scratch) {
    for c in 0..DIM {
        let line = &mut s.line[c];
        across::<L>(line);
        for q in 0..L {
            let v = &line[q];
            for i in 0..SLOTS {
                s.mode[c][2 * q][i] = v[i + 1] + v[i];
            }
            for i in 0..SLOTS {
                s.mode[c][2 * q + 1][i] = v[i + 1] - v[i];
            }
        }
    }
}

/// Replaces the values of the lines by their sums and differences along the second and third axis.
#[inline(always)]
fn across<const L: usize>(line: &mut [[f64; PADDED]; LINES]) {
    if L == 2 {
        for i in 0..SLOTS {
            let (a, b) = (line[0][i], line[1][i]);
            (line[0][i], line[1][i]) = (a + b, b - a);
        }
    } else {
        for i in 0..SLOTS {
            let (a, b, c, d) = (line[0][i], line[1][i], line[2][i], line[3][i]);
            let (low, high, low_step, high_step) = (a + b, c + d, b - a, d - c);
            line[0][i] = low + high;
            line[1][i] = low_step + high_step;
            line[2][i] = high - low;
            line[3][i] = high_step - low_step;
        }
    }
}

/// The stiffness, mode by mode.
#[inline(always)]
fn apply<const DIM: usize>(k: &Modal, s: &mut Scratch) {
    for c in 0..DIM {
        for m in 0..1 << DIM {
            let force: &mut [f64; SLOTS] =
                (&mut s.force[c][m][FIRST..]).try_into().expect("as long as the slots");
            let own = &s.mode[c][m];
            let other = |d: usize| (k.entry[c][d][m], &s.mode[d][partner(c, d, m)]);
            let coupled = |d: usize| d < DIM && couples(c, d, m);
            let (d, e) = ((c + 1) % DIM, (c + 2) % 3);
            let k0 = k.entry[c][c][m];
            match (coupled(d), e != c && e != d && coupled(e)) {
                (false, false) => {
                    for i in 0..SLOTS {
                        force[i] = k0 * own[i];
                    }
                }
                (true, true) => {
                    let ((k1, one), (k2, two)) = (other(d), other(e));
                    for i in 0..SLOTS {
                        force[i] = k0 * own[i] + k1 * one[i] + k2 * two[i];
                    }
                }
                (first, _) => {
                    let (k1, one) = other(if first { d } else { e });
                    for i in 0..SLOTS {
                        force[i] = k0 * own[i] + k1 * one[i];
                    }
                }
            }
        }
    }
}

/// Modal forces to sums and differences along x on each line, at `2 line` and behind it.
#[inline(always)]
fn to_lines_of_cells<const DIM: usize, const L: usize>(s: &mut Scratch) {
    for force in s.force.iter_mut().take(DIM) {
        for b in 0..2 {
            for i in FIRST..PADDED {
                if L == 2 {
                    let (sum, step) = (force[b][i], force[2 + b][i]);
                    (force[b][i], force[2 + b][i]) = (sum - step, sum + step);
                } else {
                    let (f0, f1) = (force[b][i], force[2 + b][i]);
                    let (f2, f3) = (force[4 + b][i], force[6 + b][i]);
                    let (low, high) = (f0 - f2, f0 + f2);
                    let (low_step, high_step) = (f1 - f3, f1 + f3);
                    force[b][i] = low - low_step;
                    force[2 + b][i] = low + low_step;
                    force[4 + b][i] = high - high_step;
                    force[6 + b][i] = high + high_step;
                }
            }
        }
    }
}

/// To the nodes: the lower end of the cell behind each, the upper end of the one before.
#[inline(always)]
fn to_nodes<const DIM: usize, const L: usize>(s: &mut Scratch) {
    for c in 0..DIM {
        for line in 0..L {
            let (sum, step) = (&s.force[c][2 * line], &s.force[c][2 * line + 1]);
            for i in 0..SLOTS {
                let (behind, before) = (FIRST + i, FIRST + i - 1);
                s.line[c][line][i] = (sum[behind] - step[behind]) + (sum[before] + step[before]);
            }
        }
    }
}

/// Lengths of the nodal forces at the lower and upper ends of the cells on each line, in the place
/// of the modes of the first component.
#[inline(always)]
fn lengths<const DIM: usize, const L: usize>(s: &mut Scratch) {
    for line in 0..L {
        for i in 0..SLOTS {
            let (mut lower, mut upper) = (0.0, 0.0);
            for force in s.force.iter().take(DIM) {
                let (sum, step) = (force[2 * line][FIRST + i], force[2 * line + 1][FIRST + i]);
                lower += (sum - step) * (sum - step);
                upper += (sum + step) * (sum + step);
            }
            s.mode[0][2 * line][i] = lower.sqrt();
            s.mode[0][2 * line + 1][i] = upper.sqrt();
        }
    }
}
