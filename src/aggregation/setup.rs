//! The levels, from the finest to the coarsest.

use std::rc::Rc;

use super::aggregates::Aggregates;
use super::coarsest::{Coarsest, rows_of_all};
use super::cycle::{Aggregation, Gathering, Level, Stage};
use super::galerkin::coarser;
use super::prolongation::{Motions, Prolongation, Tentative};
use super::smoother::Smoother;
use crate::comm::Comm;
use crate::error::Result;
use crate::sparse::{BlockMatrix, BlockRows, Halo};

/// Couplings below this part of the mean of the diagonals do not join nodes of the finest level;
/// half of it on the next one, and so on: aggregates couple to more others, and less to each.
const STRONG: f64 = 0.02;

/// Up to so many nodes a level is inverted.
const FEWEST: u64 = 50;

/// Up to so many nodes of all ranks every rank holds a level whole, and needs no messages from
/// there on.
const FEW: u64 = 2000;

/// A level that has more than this part of the nodes of the one above is no help.
const STALLED: f64 = 0.8;

/// A level that is being set up.
struct Setup {
    /// Its matrix; none of the finest one, which stays where it is.
    matrix: Option<BlockRows<f64>>,
    halo: Rc<Halo>,
    motions: Motions,
}

impl Aggregation {
    /// For a symmetric positive definite matrix; `motions` are those of its owned nodes that cost
    /// little energy. Collective.
    ///
    /// # Errors
    /// `Bug` when an exchange does not fit.
    pub fn new(comm: &Comm, matrix: &BlockMatrix, motions: Motions) -> Result<Self> {
        let (mut with, mut stages) = (comm.clone(), Vec::new());
        let mut level = Setup { matrix: None, halo: Rc::clone(&matrix.halo), motions };
        let mut stalls = false;
        let coarsest = loop {
            let rows = level.matrix.as_ref().unwrap_or(&matrix.rows);
            let height = rows.height;
            if with.size() > 1 && (level.halo.total() <= FEW || stalls) {
                stages.push(Stage::Gathering(Gathering::new(&with, &level.halo), height));
                level = gathered(&with, rows, &level)?;
                (with, stalls) = (with.alone(), false);
                continue;
            }
            if with.size() == 1 && level.halo.total() <= FEWEST {
                break Coarsest::new(rows);
            }
            let halo = Rc::clone(&level.halo);
            if stalls {
                let smoother = Smoother::new(rows, &halo);
                stages.push(Stage::Level(Box::new(Level::new(smoother, None, halo, height))));
                break Coarsest::none();
            }
            let least = STRONG * 0.5_f64.powi(stages.len() as i32);
            let (basis, below) = coarsened(&with, rows, &level, least)?;
            stalls = below.halo.total() as f64 > STALLED * halo.total() as f64;
            let basis = Some((basis, Rc::clone(&below.halo)));
            // The double precision of the basis is gone before this copy of the matrix is made.
            let smoother = Smoother::new(rows, &halo);
            stages.push(Stage::Level(Box::new(Level::new(smoother, basis, halo, height))));
            level = below;
        };
        Ok(Self { comm: comm.clone(), stages, coarsest })
    }
}

/// The next coarser level, and its basis. Collective.
fn coarsened(
    comm: &Comm,
    rows: &BlockRows<f64>,
    level: &Setup,
    least: f64,
) -> Result<(BlockRows<f32>, Setup)> {
    let Setup { halo, motions, .. } = level;
    let aggregates = Aggregates::new(rows, halo, &motions.free(), least);
    let offsets = Halo::new(comm, aggregates.count, Vec::new())?.offsets;
    let own = [offsets[comm.rank() as usize], aggregates.count as u64];
    let tentative = Tentative::new(motions, &aggregates, own[0], halo);
    let mut basis = Prolongation::new(comm, rows, halo, &tentative, own);
    let (mut matrix, below) = coarser(comm, rows, halo, &mut basis, &offsets)?;
    hold_what_is_missing(&mut matrix);
    let motions = tentative.coarse;
    let below = Setup { matrix: Some(matrix), halo: Rc::new(below), motions };
    Ok((basis.rows.to_single(), below))
}

/// A level with the rows of all ranks, on every rank. Collective.
fn gathered(comm: &Comm, rows: &BlockRows<f64>, level: &Setup) -> Result<Setup> {
    let (matrix, halo, motions) = rows_of_all(comm, rows, &level.halo, &level.motions)?;
    Ok(Setup { matrix: Some(matrix), halo: Rc::new(halo), motions })
}

/// Motions that an aggregate lacks have rows of zeros: they get a diagonal.
fn hold_what_is_missing(matrix: &mut BlockRows<f64>) {
    let n = matrix.height;
    let mut block = vec![0.0; n * n];
    for i in 0..matrix.len() {
        let place = matrix.place(i, i as u32);
        let place = place.expect("an aggregate touches itself");
        matrix.block(i, place, &mut block);
        let largest = block.iter().step_by(n + 1).fold(0.0_f64, |m, d| m.max(*d));
        let size = if largest > 0.0 { largest } else { 1.0 };
        let mut missing = vec![0.0; n * n];
        for (d, missing) in block.iter().step_by(n + 1).zip(missing.iter_mut().step_by(n + 1)) {
            if *d <= f64::EPSILON * largest {
                *missing = size;
            }
        }
        matrix.add(i, place, &missing, n);
    }
}
