//! The V-cycle in single precision.
//!
//! The steps are those of PETSc's PCMG with Chebyshev's iteration over the diagonal, two before and
//! two after the correction of the coarser level: it is the check of this one. What rounds is the
//! preconditioner alone; residual and solution stay in double precision.

use std::cell::RefCell;
use std::rc::Rc;

use super::transfer::Transfer;
use crate::assembly::TangentOperator;
use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::{LinearSolver, Preconditioner};

/// Chebyshev's iteration of two steps.
#[derive(Default)]
struct Smoothing {
    /// Of a step over the diagonal.
    scale: f32,
    /// Of the second step: what goes on from the first, less the rest from before.
    omega: f32,
    /// Inverse of the diagonal (m/N).
    inverse: Vec<f32>,
}

/// Vectors of a level.
struct Work {
    product: Vec<f32>,
    before: Vec<f32>,
    /// Right-hand side and correction of the coarser level.
    coarse: [Vec<f32>; 2],
    /// Of all local coarse nodes.
    room: [Vec<f32>; 2],
}

/// A level above the coarsest.
struct Level {
    operator: Rc<TangentOperator>,
    transfer: Rc<Transfer>,
    smoothing: RefCell<Smoothing>,
    work: RefCell<Work>,
}

/// What corrects the coarsest level.
pub enum CoarsestSolver {
    /// A direct solver.
    Elimination(LinearSolver),
    /// Cycles of another multigrid.
    Cycles(Cycles),
}

/// Cycles in the place of elimination: more of them save few iterations of the finest level.
const TIMES: usize = 4;

/// Cycles of a preconditioner of a level, one after the other: together they are symmetric.
pub struct Cycles {
    preconditioner: Rc<dyn Preconditioner>,
    operator: Rc<TangentOperator>,
    /// Right-hand side or rest, and correction.
    work: RefCell<[Vec<f64>; 2]>,
    product: RefCell<Vec<f32>>,
}

impl CoarsestSolver {
    /// Those of a preconditioner for an operator. Local.
    pub fn cycles(preconditioner: Rc<dyn Preconditioner>, operator: &Rc<TangentOperator>) -> Self {
        let (operator, work) = (Rc::clone(operator), RefCell::default());
        Self::Cycles(Cycles { preconditioner, operator, work, product: RefCell::default() })
    }

    /// The correction for a right-hand side. Collective.
    fn solve(&self, b: &[f32], x: &mut [f32]) -> Result<()> {
        match self {
            Self::Elimination(solver) => solver.solve(b, x),
            Self::Cycles(cycles) => cycles.correct(b, x),
        }
    }
}

impl Cycles {
    fn correct(&self, b: &[f32], x: &mut [f32]) -> Result<()> {
        let ([rest, step], product) =
            (&mut *self.work.borrow_mut(), &mut *self.product.borrow_mut());
        step.resize(b.len(), 0.0);
        product.resize(b.len(), 0.0);
        rest.clear();
        rest.extend(b.iter().map(|b| f64::from(*b)));
        self.preconditioner.apply(rest, step)?;
        x.iter_mut().zip(&*step).for_each(|(x, step)| *x = *step as f32);
        for _ in 1..TIMES {
            self.operator.multiply_in(x, product);
            let left = rest.iter_mut().zip(b).zip(&*product);
            left.for_each(|((rest, b), product)| *rest = f64::from(b - product));
            self.preconditioner.apply(rest, step)?;
            x.iter_mut().zip(&*step).for_each(|(x, step)| *x += *step as f32);
        }
        Ok(())
    }
}

/// A symmetric V-cycle as a preconditioner.
pub struct Cycle {
    comm: Comm,
    /// From the one above the coarsest to the finest.
    levels: Vec<Level>,
    coarsest: CoarsestSolver,
    /// Of a cell against one displacement, at most (N/m).
    stiffness: f64,
    /// Right-hand side and correction of the finest level.
    finest: RefCell<[Vec<f32>; 2]>,
}

impl Level {
    fn new(operator: Rc<TangentOperator>, transfer: Rc<Transfer>) -> Self {
        let [fine, coarse] = transfer.unknowns();
        let held = transfer.coarse_unknowns_held();
        let zero = |length: usize| vec![0.0; length];
        let work = Work {
            product: zero(fine),
            before: zero(fine),
            coarse: [zero(coarse), zero(coarse)],
            room: [zero(held), zero(held)],
        };
        Self { operator, transfer, smoothing: RefCell::default(), work: RefCell::new(work) }
    }

    /// Two steps from zero.
    fn smooth_from_zero(&self, b: &[f32], x: &mut [f32], product: &mut [f32]) {
        let Smoothing { scale, omega, inverse } = &*self.smoothing.borrow();
        for ((x, b), d) in x.iter_mut().zip(b).zip(inverse) {
            *x = scale * d * b;
        }
        self.operator.multiply_in(x, product);
        for (((x, b), d), product) in x.iter_mut().zip(b).zip(inverse).zip(&*product) {
            *x = omega * (*x + scale * d * (b - product));
        }
    }

    /// Two steps.
    fn smooth(&self, b: &[f32], x: &mut [f32], product: &mut [f32], before: &mut [f32]) {
        let Smoothing { scale, omega, inverse } = &*self.smoothing.borrow();
        self.operator.multiply_in(x, product);
        before.copy_from_slice(x);
        for (((x, b), d), product) in x.iter_mut().zip(b).zip(inverse).zip(&*product) {
            *x += scale * d * (b - product);
        }
        self.operator.multiply_in(x, product);
        let vectors = x.iter_mut().zip(b).zip(inverse).zip(&*product).zip(&*before);
        for ((((x, b), d), product), before) in vectors {
            *x = omega * (*x + scale * d * (b - product)) + (1.0 - omega) * before;
        }
    }
}

impl Cycle {
    /// Over operators, coarsest first, and the transfers between them. Local.
    pub fn new(
        comm: &Comm,
        operators: &[Rc<TangentOperator>],
        transfers: impl Iterator<Item = Rc<Transfer>>,
        coarsest: CoarsestSolver,
    ) -> Self {
        let levels = operators[1..].iter().zip(transfers);
        let levels = levels.map(|(operator, transfer)| Level::new(Rc::clone(operator), transfer));
        let stiffness = operators[operators.len() - 1].identity_entry();
        let (comm, finest) = (comm.clone(), RefCell::default());
        Self { comm, levels: levels.collect(), coarsest, stiffness, finest }
    }

    /// Takes the diagonal of a level above the coarsest, of number 1 on, and the interval of
    /// eigenvalues over it that is damped. Local.
    pub fn damp(&self, level: usize, [low, high]: [f64; 2], diagonal: &[f64]) {
        let smoothing = &mut *self.levels[level - 1].smoothing.borrow_mut();
        let scale = 2.0 / (low + high);
        let alpha = 1.0 - scale * low;
        smoothing.scale = scale as f32;
        smoothing.omega = (2.0 / (2.0 - alpha * alpha)) as f32;
        smoothing.inverse.clear();
        smoothing.inverse.extend(diagonal.iter().map(|d| d.recip() as f32));
    }

    /// The correction of a level for a right-hand side. Collective.
    fn correct(&self, level: usize, b: &[f32], x: &mut [f32]) -> Result<()> {
        let Some(below) = level.checked_sub(1) else { return self.coarsest.solve(b, x) };
        let of = &self.levels[below];
        let Work { product, before, coarse: [rhs, correction], room } = &mut *of.work.borrow_mut();
        of.smooth_from_zero(b, x, product);
        of.operator.multiply_in(x, product);
        product.iter_mut().zip(b).for_each(|(product, b)| *product = b - *product);
        of.transfer.restrict(product, rhs, room);
        self.correct(below, rhs, correction)?;
        of.transfer.prolong(correction, product, &mut room[0]);
        x.iter_mut().zip(&*product).for_each(|(x, correction)| *x += correction);
        of.smooth(b, x, product, before);
        Ok(())
    }
}

impl Preconditioner for Cycle {
    fn apply(&self, r: &[f64], z: &mut [f64]) -> Result<()> {
        let mut largest = [r.iter().fold(0.0_f64, |m, r| m.max(r.abs()))];
        self.comm.max(&mut largest);
        let scale = largest[0];
        if scale == 0.0 {
            z.fill(0.0);
            return Ok(());
        }
        // Corrections of about 1: single precision has room above and below.
        let factor = self.stiffness / scale;
        let [b, x] = &mut *self.finest.borrow_mut();
        b.clear();
        b.extend(r.iter().map(|r| (r * factor) as f32));
        x.resize(b.len(), 0.0);
        self.correct(self.levels.len(), b, x)?;
        let back = factor.recip();
        z.iter_mut().zip(x).for_each(|(z, x)| *z = back * f64::from(*x));
        Ok(())
    }
}
