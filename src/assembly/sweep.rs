//! Forces of many like boxes at once: the sweep over the cells without a matrix.
//!
//! Cells that follow one another along x share nodes. Lines of them are laid side by side in
//! batches: one slot per node along x, two lines of nodes in 2D and four in 3D. Between two lines
//! of cells lies a slot whose cell does not exist. All arithmetic then runs over the slots of a
//! batch, as wide as the processor's vectors; the stiffness acts in modal form.

use crate::bulk::{MODES, Modal, partner};
use crate::simd::widest;

/// Slots of a batch: the arrays of the sweep stay in the innermost cache.
const SLOTS: usize = 64;
/// Lines of nodes of a batch in 3D.
const LINES: usize = 4;

/// The corners at the lower and upper end along x of each line, by number in the cell; a line's
/// index has bit 0 for the upper side along the second axis, bit 1 along the third.
const ENDS_2D: [[usize; 2]; 2] = [[0, 1], [3, 2]];
const ENDS_3D: [[usize; 2]; LINES] = [[0, 1], [3, 2], [4, 5], [7, 6]];

/// Like cells side by side.
struct Batch {
    prototype: u16,
    slots: u16,
    /// First entry in `nodes`.
    first: u32,
    /// Range in `gaps`.
    gaps: [u32; 2],
}

/// A set of cells in batches.
pub struct Sweep {
    dim: usize,
    batches: Vec<Batch>,
    /// Local nodes of the slots, line by line of each batch.
    nodes: Vec<u32>,
    /// Slots without a cell, but for the last of each batch.
    gaps: Vec<u16>,
}

/// Numbers of one batch: by component, line and slot; modes in the place of lines come in pairs.
struct Scratch {
    line: [[[f64; SLOTS]; LINES]; 3],
    mode: [[[f64; SLOTS]; MODES]; 3],
    force: [[[f64; SLOTS]; MODES]; 3],
    size: [[f64; SLOTS]; MODES],
}

impl Sweep {
    /// Puts cells into batches: each has `2^dim` local nodes and the index of its prototype.
    pub fn new<'a>(dim: usize, cells: impl Iterator<Item = (&'a [u32], u16)>) -> Self {
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

    fn close(&mut self, prototype: Option<u16>, lines: &mut [Vec<u32>], gaps: &mut Vec<u16>) {
        let slots = lines[0].len();
        let Some(prototype) = prototype.filter(|_| slots > 0) else { return };
        let (first, first_gap) = (self.nodes.len() as u32, self.gaps.len() as u32);
        lines.iter_mut().for_each(|line| self.nodes.append(line));
        self.gaps.append(gaps);
        let gaps = [first_gap, self.gaps.len() as u32];
        self.batches.push(Batch { prototype, slots: slots as u16, first, gaps });
    }

    /// Adds the forces K u of the cells to `force` (N), both `dim` numbers per local node;
    /// `stiffness` gives the modal form of a prototype. `magnitude` gets the sum of the lengths of
    /// the cells' nodal forces, one per local node. Local.
    pub fn add_forces<'a>(
        &self,
        stiffness: impl Fn(u16) -> &'a Modal,
        u: &[f64],
        force: &mut [f64],
        magnitude: Option<&mut [f64]>,
    ) {
        let none: &mut [f64] = &mut [];
        match (self.dim, magnitude) {
            (2, None) => widest(|| self.run::<2, 2, false>(&stiffness, u, force, none)),
            (2, Some(m)) => widest(|| self.run::<2, 2, true>(&stiffness, u, force, m)),
            (_, None) => widest(|| self.run::<3, 4, false>(&stiffness, u, force, none)),
            (_, Some(m)) => widest(|| self.run::<3, 4, true>(&stiffness, u, force, m)),
        }
    }

    #[inline(always)]
    fn run<'a, const DIM: usize, const L: usize, const SIZES: bool>(
        &self,
        stiffness: &impl Fn(u16) -> &'a Modal,
        u: &[f64],
        force: &mut [f64],
        magnitude: &mut [f64],
    ) {
        let zero = [[0.0; SLOTS]; MODES];
        let mut s = Scratch {
            line: [[[0.0; SLOTS]; LINES]; 3],
            mode: [zero; 3],
            force: [zero; 3],
            size: zero,
        };
        for batch in &self.batches {
            let slots = batch.slots as usize;
            let nodes = &self.nodes[batch.first as usize..][..slots * L];
            // Whole vectors: what lies behind the last slot is computed and not used.
            let width = slots.next_multiple_of(8);
            for (line, nodes) in nodes.chunks_exact(slots).enumerate() {
                for (slot, node) in nodes.iter().enumerate() {
                    let values = &u[*node as usize * DIM..][..DIM];
                    for (c, value) in values.iter().enumerate() {
                        s.line[c][line][slot] = *value;
                    }
                }
            }
            to_modes::<DIM, L>(&mut s, width);
            apply::<DIM>(stiffness(batch.prototype), &mut s, width);
            for gap in &self.gaps[batch.gaps[0] as usize..batch.gaps[1] as usize] {
                for mode in s.force.iter_mut().take(DIM).flatten() {
                    mode[*gap as usize] = 0.0;
                }
            }
            for mode in s.force.iter_mut().take(DIM).flatten() {
                mode[slots - 1] = 0.0;
            }
            to_ends::<DIM, L>(&mut s, width);
            for (line, nodes) in nodes.chunks_exact(slots).enumerate() {
                let mut left = [0.0; 3];
                for (slot, node) in nodes.iter().enumerate() {
                    let target = &mut force[*node as usize * DIM..][..DIM];
                    for (c, target) in target.iter_mut().enumerate() {
                        *target += s.force[c][2 * line][slot] + left[c];
                        left[c] = s.force[c][2 * line + 1][slot];
                    }
                }
            }
            if SIZES {
                lengths::<DIM, L>(&mut s, width);
                for (line, nodes) in nodes.chunks_exact(slots).enumerate() {
                    let mut left = 0.0;
                    for (slot, node) in nodes.iter().enumerate() {
                        magnitude[*node as usize] += s.size[2 * line][slot] + left;
                        left = s.size[2 * line + 1][slot];
                    }
                }
            }
        }
    }
}

/// Sums and differences, across the lines and then along x: mode 2 q + b has the differences that
/// the bits of q mark along the second and third axis, and b along the first.
#[inline(always)]
fn to_modes<const DIM: usize, const L: usize>(s: &mut Scratch, width: usize) {
    for c in 0..DIM {
        let line = &mut s.line[c];
        across::<L>(line, width);
        for q in 0..L {
            let v = &line[q];
            let (sum, difference) = s.mode[c].split_at_mut(2 * q + 1);
            let (sum, difference) = (&mut sum[2 * q], &mut difference[0]);
            for i in 0..width - 1 {
                sum[i] = v[i + 1] + v[i];
                difference[i] = v[i + 1] - v[i];
            }
        }
    }
}

/// Replaces the values of the lines by their sums and differences along the second and third axis.
#[inline(always)]
fn across<const L: usize>(line: &mut [[f64; SLOTS]], width: usize) {
    if L == 2 {
        for i in 0..width {
            let (a, b) = (line[0][i], line[1][i]);
            (line[0][i], line[1][i]) = (a + b, b - a);
        }
    } else {
        for i in 0..width {
            let (a, b, c, d) = (line[0][i], line[1][i], line[2][i], line[3][i]);
            let (low, high, low_step, high_step) = (a + b, c + d, b - a, d - c);
            line[0][i] = low + high;
            line[1][i] = low_step + high_step;
            line[2][i] = high - low;
            line[3][i] = high_step - low_step;
        }
    }
}

#[inline(always)]
fn apply<const DIM: usize>(k: &Modal, s: &mut Scratch, width: usize) {
    for c in 0..DIM {
        for m in 0..1 << DIM {
            let force = &mut s.force[c][m];
            if DIM == 2 {
                let d = 1 - c;
                let (own, other) = (&s.mode[c][m], &s.mode[d][partner(c, d, m)]);
                let (k0, k1) = (k.entry[c][c][m], k.entry[c][d][m]);
                for i in 0..width {
                    force[i] = k0 * own[i] + k1 * other[i];
                }
            } else {
                let (d, e) = ((c + 1) % 3, (c + 2) % 3);
                let (own, one) = (&s.mode[c][m], &s.mode[d][partner(c, d, m)]);
                let two = &s.mode[e][partner(c, e, m)];
                let (k0, k1, k2) = (k.entry[c][c][m], k.entry[c][d][m], k.entry[c][e][m]);
                for i in 0..width {
                    force[i] = k0 * own[i] + k1 * one[i] + k2 * two[i];
                }
            }
        }
    }
}

/// Modal forces to those at the ends of each cell along each line: the lower ends at `2 line`, the
/// upper ones behind it.
#[inline(always)]
fn to_ends<const DIM: usize, const L: usize>(s: &mut Scratch, width: usize) {
    for force in s.force.iter_mut().take(DIM) {
        for b in 0..2 {
            for i in 0..width {
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
        for line in 0..L {
            for i in 0..width {
                let (sum, step) = (force[2 * line][i], force[2 * line + 1][i]);
                (force[2 * line][i], force[2 * line + 1][i]) = (sum - step, sum + step);
            }
        }
    }
}

/// Lengths of the nodal forces of each cell.
#[inline(always)]
fn lengths<const DIM: usize, const L: usize>(s: &mut Scratch, width: usize) {
    for end in 0..2 * L {
        for i in 0..width {
            let square: f64 = (0..DIM).map(|c| s.force[c][end][i] * s.force[c][end][i]).sum();
            s.size[end][i] = square.sqrt();
        }
    }
}
