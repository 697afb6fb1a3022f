//! The V-cycle.

use std::cell::RefCell;
use std::rc::Rc;

use super::coarsest::Coarsest;
use super::smoother::Smoother;
use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::Preconditioner;
use crate::simd::{self, Kernel};
use crate::sparse::{BlockRows, Gathered, Halo, times, with_sizes};

/// A level with its way to the next coarser one.
pub struct Level {
    smoother: Smoother,
    /// The basis of the coarser level; none where no coarser one helps.
    basis: Option<(BlockRows<f32>, Rc<Halo>)>,
    halo: Rc<Halo>,
    /// Rows of a block.
    height: usize,
    work: RefCell<Work>,
}

/// Vectors of a cycle.
#[derive(Default)]
struct Work {
    /// Correction with its ghosts.
    x: Vec<f32>,
    /// What is left, at owned entries.
    left: Vec<f32>,
    /// Right-hand side and correction of the coarser level, with ghosts.
    coarse: [Vec<f32>; 2],
}

impl Level {
    /// From its parts. Local.
    pub fn new(
        smoother: Smoother,
        basis: Option<(BlockRows<f32>, Rc<Halo>)>,
        halo: Rc<Halo>,
        height: usize,
    ) -> Self {
        let mut work = Work { x: vec![0.0; halo.len() * height], ..Work::default() };
        if let Some((basis, below)) = &basis {
            work.left = vec![0.0; halo.owned * height];
            let zero = vec![0.0; below.len() * basis.width];
            work.coarse = [zero.clone(), zero];
        }
        Self { smoother, basis, halo, height, work: RefCell::new(work) }
    }
}

/// Where every rank goes on with the entries of all.
pub struct Gathering {
    comm: Comm,
    first: usize,
    total: usize,
}

impl Gathering {
    /// For a level of this halo. Local.
    pub fn new(comm: &Comm, halo: &Halo) -> Self {
        let [first, total] = [halo.first(), halo.total()].map(|n| n as usize);
        Self { comm: comm.clone(), first, total }
    }

    /// Entries of all ranks. Collective.
    fn gather(&self, own: &[f32], width: usize) -> Vec<f32> {
        let mut all = vec![0.0; self.total * width];
        let mine = &mut all[self.first * width..][..own.len()];
        mine.iter_mut().zip(own).for_each(|(to, value)| *to = f64::from(*value));
        self.comm.sum(&mut all);
        all.into_iter().map(|value| value as f32).collect()
    }
}

/// What a cycle does on its way down.
pub enum Stage {
    /// Smooths.
    Level(Box<Level>),
    /// Gathers blocks of this many rows.
    Gathering(Gathering, usize),
}

/// A symmetric V-cycle as a preconditioner.
pub struct Aggregation {
    pub(super) comm: Comm,
    /// From the finest level on.
    pub(super) stages: Vec<Stage>,
    pub(super) coarsest: Coarsest,
}

impl Aggregation {
    /// Nodes of all ranks on each level, finest first. Local.
    pub fn sizes(&self) -> Vec<u64> {
        let size = |stage: &Stage| match stage {
            Stage::Level(level) => Some(level.halo.total()),
            Stage::Gathering(..) => None,
        };
        self.stages.iter().filter_map(size).collect()
    }

    /// The correction of a level for a right-hand side. Collective.
    fn cycle(&self, at: usize, b: &[f32], correction: &mut [f32]) {
        let level = match self.stages.get(at) {
            None => return self.coarsest.solve(b, correction),
            Some(Stage::Level(level)) => level,
            Some(Stage::Gathering(gathering, width)) => {
                let b = gathering.gather(b, *width);
                let mut all = vec![0.0; b.len()];
                self.cycle(at + 1, &b, &mut all);
                let own = &all[gathering.first * width..][..correction.len()];
                return correction.copy_from_slice(own);
            }
        };
        let Work { x, left, coarse: [rhs, below] } = &mut *level.work.borrow_mut();
        let owned = correction.len();
        level.smoother.forward(b, x);
        level.halo.update(x, level.height);
        if let Some((basis, halo)) = &level.basis {
            level.smoother.left(x, left);
            rhs.fill(0.0);
            simd::widest(Restriction { basis, from: left, to: rhs });
            halo.add_to_owners(rhs, basis.width);
            let coarse = halo.owned * basis.width;
            self.cycle(at + 1, &rhs[..coarse], &mut below[..coarse]);
            halo.update(below, basis.width);
            simd::widest(Interpolation { basis, from: below, to: &mut x[..owned] });
            level.halo.update(x, level.height);
        }
        level.smoother.backward(b, x);
        correction.copy_from_slice(&x[..owned]);
    }
}

impl Preconditioner for Aggregation {
    fn apply(&self, r: &[f64], z: &mut [f64]) -> Result<()> {
        let mut largest = [r.iter().fold(0.0_f64, |m, r| m.max(r.abs()))];
        self.comm.max(&mut largest);
        let scale = largest[0];
        if scale == 0.0 {
            z.fill(0.0);
            return Ok(());
        }
        let b: Vec<f32> = r.iter().map(|r| (r / scale) as f32).collect();
        let mut x = vec![0.0; b.len()];
        self.cycle(0, &b, &mut x);
        z.iter_mut().zip(x).for_each(|(z, x)| *z = scale * f64::from(x));
        Ok(())
    }
}

/// Transposed basis times a vector, added.
struct Restriction<'a> {
    basis: &'a BlockRows<f32>,
    from: &'a [f32],
    to: &'a mut [f32],
}

impl Kernel for Restriction<'_> {
    #[inline(always)]
    fn run(self) {
        with_sizes!(self.basis, restrict, self.basis, self.from, self.to)
    }
}

#[inline(always)]
fn restrict<const H: usize, const W: usize>(basis: &BlockRows<f32>, from: &[f32], to: &mut [f32]) {
    for (i, from) in from.chunks_exact(H).enumerate() {
        let row = basis.row(i);
        let length = row.columns.len() * W;
        for (place, column) in row.columns.iter().enumerate() {
            let to = &mut to[*column as usize * W..][..W];
            for (h, from) in from.iter().enumerate() {
                let part = &row.values[h * length + place * W..][..W];
                for w in 0..W {
                    to[w] += part[w] * from;
                }
            }
        }
    }
}

/// Basis times a vector, added.
struct Interpolation<'a> {
    basis: &'a BlockRows<f32>,
    from: &'a [f32],
    to: &'a mut [f32],
}

impl Kernel for Interpolation<'_> {
    #[inline(always)]
    fn run(self) {
        with_sizes!(self.basis, interpolate, self.basis, self.from, self.to)
    }
}

#[inline(always)]
fn interpolate<const H: usize, const W: usize>(
    basis: &BlockRows<f32>,
    from: &[f32],
    to: &mut [f32],
) {
    let mut room = Gathered::default();
    for (i, to) in to.chunks_exact_mut(H).enumerate() {
        let row = basis.row(i);
        let length = row.columns.len() * W;
        let sums = times::<f32, H, W>(row.columns, row.values, length, from, &mut room);
        for h in 0..H {
            to[h] += sums[h];
        }
    }
}
