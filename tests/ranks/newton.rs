//! The nonlinear solver: u + u^3 summed with the second difference of a chain.

use crate::linear_algebra::{share, tridiagonal};
use column_hpc::comm::Comm;
use column_hpc::error::{Error, Result};
use column_hpc::petsc::{
    FurtherSolve, KspSetup, LinearReason, LinearTolerance, Matrix, NonlinearSystem, Petsc, Snes,
    SnesReason, SolveReport, TangentChange, Vector, Verdict,
};
use column_hpc::runtime::Runtime;

const N: usize = 40;

const MUMPS: &[(&str, &str)] =
    &[("ksp_type", "preonly"), ("pc_type", "cholesky"), ("pc_factor_mat_solver_type", "mumps")];
const GAMG: &[(&str, &str)] = &[("ksp_type", "cg"), ("pc_type", "gamg")];
const HYPRE: &[(&str, &str)] = &[("ksp_type", "cg"), ("pc_type", "hypre")];
const JACOBI: &[(&str, &str)] = &[("ksp_type", "cg"), ("pc_type", "jacobi")];

/// Which callback fails, as every rank knows.
#[derive(Clone, Copy, PartialEq)]
enum Fails {
    Nothing,
    Residual,
    Tangent,
    Direction,
    Verdict,
}

/// stiffness * (second difference) + shift * u + cubic * u^3 = load, with the chain's ends free.
struct Chain {
    comm: Comm,
    stiffness: f64,
    shift: f64,
    cubic: f64,
    fails: Fails,
    change: TangentChange,
    relative: f64,
    norms: Vec<f64>,
    tangents: usize,
    give_up: bool,
}

impl Chain {
    fn new(runtime: &Runtime) -> Self {
        Chain {
            comm: runtime.comm.clone(),
            stiffness: 1.0,
            shift: 1.0,
            cubic: 1.0,
            fails: Fails::Nothing,
            change: TangentChange::Changed,
            relative: 1e-12,
            norms: Vec::new(),
            tangents: 0,
            give_up: false,
        }
    }

    /// Without stiffness the first row is empty.
    fn shift(&self, i: usize) -> f64 {
        if self.stiffness == 0.0 && i == 0 { 0.0 } else { self.shift }
    }

    fn whole(&self, x: &[f64]) -> Vec<f64> {
        let send = vec![x.to_vec(); self.comm.size() as usize];
        self.comm.exchange(&send).concat()
    }

    fn fail(&self, place: Fails, words: &str) -> Result<()> {
        if self.fails != place {
            return Ok(());
        }
        let last = self.comm.rank() + 1 == self.comm.size();
        self.comm.agree(if last { Err(Error::Numerics(words.into())) } else { Ok(()) })
    }
}

impl NonlinearSystem for Chain {
    fn residual(&mut self, x: &[f64], f: &mut [f64]) -> Result<()> {
        self.fail(Fails::Residual, "residual")?;
        let (first, _) = share(&self.comm, N);
        let u = self.whole(x);
        for (i, f) in (first..).zip(f) {
            let left = if i > 0 { u[i] - u[i - 1] } else { 0.0 };
            let right = if i + 1 < N { u[i] - u[i + 1] } else { 0.0 };
            let load = 1.0 + i as f64 / N as f64;
            *f = self.stiffness * (left + right) + self.shift(i) * u[i] + self.cubic * u[i].powi(3)
                - load;
        }
        Ok(())
    }

    fn tangent(&mut self, x: &[f64], matrix: &mut Matrix) -> Result<TangentChange> {
        self.fail(Fails::Tangent, "tangent")?;
        self.tangents += 1;
        let (first, _) = share(&self.comm, N);
        matrix.zero()?;
        for (i, u) in (first..).zip(x) {
            let row = i as i32;
            let ends = f64::from(u8::from(i > 0) + u8::from(i + 1 < N));
            let diagonal = self.stiffness * ends + self.shift(i) + 3.0 * self.cubic * u * u;
            let right = if i + 1 < N { row + 1 } else { -1 };
            matrix.add(
                &[row],
                &[row - 1, row, right],
                &[-self.stiffness, diagonal, -self.stiffness],
            )?;
        }
        matrix.assemble()?;
        Ok(self.change)
    }

    fn direction(
        &mut self,
        _x: &[f64],
        _correction: &mut [f64],
        _solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        self.fail(Fails::Direction, "direction")
    }

    fn verdict(&mut self, iteration: usize, _x: &[f64], f: &[f64], norm: f64) -> Result<Verdict> {
        self.fail(Fails::Verdict, "verdict")?;
        assert_eq!(iteration, self.norms.len());
        let mut square = [f.iter().map(|v| v * v).sum::<f64>()];
        self.comm.sum(&mut square);
        assert!((square[0].sqrt() - norm).abs() <= 1e-9 * norm, "the norm is that of f");
        self.norms.push(norm);
        Ok(match norm {
            _ if self.give_up && iteration == 1 => Verdict::Diverged,
            norm if norm < 1e-10 => Verdict::Converged,
            _ => Verdict::Continue,
        })
    }

    fn linear_tolerance(&mut self, iteration: usize, norm: f64) -> LinearTolerance {
        assert_eq!(Some(&norm), self.norms.get(iteration));
        LinearTolerance { relative: self.relative, absolute: 1e-13 }
    }
}

fn solver(petsc: &Petsc, prefix: &str, preset: &[(&str, &str)]) -> Snes {
    let matrix = tridiagonal(petsc, N);
    Snes::new(petsc, prefix, matrix, &KspSetup::new(preset)).expect("a solver")
}

fn start(runtime: &Runtime) -> Vector {
    let (_, owned) = share(&runtime.comm, N);
    Vector::new(&runtime.petsc, owned, 1).expect("a vector")
}

fn solve(snes: &mut Snes, chain: &mut Chain, x: &mut Vector) -> SolveReport {
    chain.norms.clear();
    snes.solve(chain, x).expect("no error of PETSc or of the chain")
}

pub fn presets_agree(runtime: &Runtime) {
    let mut reference: Option<Vec<f64>> = None;
    for (preset, ksp, pc) in
        [(MUMPS, "preonly", "cholesky"), (GAMG, "cg", "gamg"), (HYPRE, "cg", "hypre")]
    {
        let mut snes = solver(&runtime.petsc, "", preset);
        let (mut chain, mut x) = (Chain::new(runtime), start(runtime));
        let report = solve(&mut snes, &mut chain, &mut x);
        assert_eq!(report.reason, SnesReason::Converged, "{}", report.words());
        assert_eq!(report.words(), "converged");
        assert_eq!(report.iterations + 1, chain.norms.len());
        assert!(report.iterations <= 7 && report.linear_iterations >= report.iterations);
        assert_eq!((snes.ksp_type(), snes.pc_type()), (Ok(ksp.into()), Ok(pc.into())));
        assert_eq!(snes.mumps_infog(1), (pc == "cholesky").then_some(0));
        assert!(snes.last_linear_iterations().expect("a number") >= 1);
        let u = chain.whole(&x.read().expect("a view"));
        let reference = reference.get_or_insert_with(|| u.clone());
        let error = u.iter().zip(&*reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-10, "{pc} differs by {error}");
        // Again from the solution: nothing to do.
        assert_eq!(solve(&mut snes, &mut chain, &mut x).iterations, 0);
    }
}

pub fn preconditioner_is_kept(runtime: &Runtime) {
    // Factors that are kept while the tangent changes cost conjugate gradients some iterations; a
    // direct solver has to build them again all the same.
    const FACTORS: &[(&str, &str)] =
        &[("ksp_type", "cg"), ("pc_type", "cholesky"), ("pc_factor_mat_solver_type", "mumps")];
    let solved = |options: &[(&str, &str)], change: TangentChange| {
        let mut snes = solver(&runtime.petsc, "", options);
        let (mut chain, mut x) = (Chain::new(runtime), start(runtime));
        chain.change = change;
        x.write().expect("a view").fill(0.9);
        let report = solve(&mut snes, &mut chain, &mut x);
        assert_eq!(report.reason, SnesReason::Converged);
        assert_eq!(chain.tangents, report.iterations);
        report
    };
    let fresh = solved(FACTORS, TangentChange::Changed);
    let kept = solved(FACTORS, TangentChange::ChangedKeepPreconditioner);
    assert!(kept.linear_iterations > fresh.linear_iterations + 3, "{kept:?} {fresh:?}");
    let direct = solved(MUMPS, TangentChange::ChangedKeepPreconditioner);
    assert_eq!(direct.iterations, solved(MUMPS, TangentChange::Changed).iterations);
}

pub fn callback_errors_come_back(runtime: &Runtime) {
    let mut snes = solver(&runtime.petsc, "", MUMPS);
    let size = runtime.comm.size();
    for (place, words) in [
        (Fails::Residual, "residual"),
        (Fails::Tangent, "tangent"),
        (Fails::Direction, "direction"),
        (Fails::Verdict, "verdict"),
    ] {
        let (mut chain, mut x) = (Chain::new(runtime), start(runtime));
        chain.fails = place;
        let prefix = if size > 1 { format!("rank {}: ", size - 1) } else { String::new() };
        let expected = Error::Numerics(format!("{prefix}{words}"));
        assert_eq!(snes.solve(&mut chain, &mut x), Err(expected));
        // The solver is as good as new.
        chain.fails = Fails::Nothing;
        let report = solve(&mut snes, &mut chain, &mut x);
        assert_eq!(report.reason, SnesReason::Converged, "after {words}");
    }
    let mut wrong = Vector::new(&runtime.petsc, 2 * N, 1).expect("a vector");
    let result = snes.solve(&mut Chain::new(runtime), &mut wrong);
    assert!(matches!(result, Err(Error::Bug(_))), "{result:?}");
}

pub fn verdict_stops(runtime: &Runtime) {
    let mut snes = solver(&runtime.petsc, "", MUMPS);
    let (mut chain, mut x) = (Chain::new(runtime), start(runtime));
    chain.give_up = true;
    let report = solve(&mut snes, &mut chain, &mut x);
    assert_eq!((report.reason, report.iterations), (SnesReason::Stopped, 1));
    assert!(!report.reason.is_converged());
}

/// The failure of a linear problem with the given coefficients.
fn failure(runtime: &Runtime, preset: &[(&str, &str)], stiffness: f64, shift: f64) -> SolveReport {
    let mut snes = solver(&runtime.petsc, "", preset);
    let (mut chain, mut x) = (Chain::new(runtime), start(runtime));
    (chain.stiffness, chain.shift, chain.cubic) = (stiffness, shift, 0.0);
    let report = solve(&mut snes, &mut chain, &mut x);
    // The same solver recovers when the next tangent is sound.
    (chain.stiffness, chain.shift, chain.cubic) = (1.0, 1.0, 1.0);
    x.zero().expect("zero");
    if !preset.iter().any(|(name, _)| *name == "ksp_max_it") {
        assert_eq!(solve(&mut snes, &mut chain, &mut x).reason, SnesReason::Converged);
    }
    assert_eq!(report.reason, SnesReason::LinearSolve);
    report
}

pub fn indefinite_in_words(runtime: &Runtime) {
    let none = &[("ksp_type", "cg"), ("pc_type", "none")];
    let report = failure(runtime, none, 1.0, -1.0);
    let linear = report.failing_linear.clone().expect("a linear failure");
    assert_eq!(linear.reason, LinearReason::IndefiniteMatrix);
    assert!(report.words().starts_with("the linear solve failed: the tangent is indefinite"));
}

pub fn singular_in_words(runtime: &Runtime) {
    // Uncoupled rows, one of them empty: with rounding, MUMPS takes a singular matrix for regular.
    let words = failure(runtime, MUMPS, 0.0, 1.0).words();
    assert!(words.contains("the tangent is singular"), "{words}");
    assert!(words.contains("INFOG(1) = -10") && words.contains("numerically singular"), "{words}");
}

pub fn iteration_limit_in_words(runtime: &Runtime) {
    let two = [JACOBI, &[("ksp_max_it", "2")]].concat();
    let words = failure(runtime, &two, 1.0, 0.01).words();
    assert!(words.contains("limit of iterations was reached (2, residual"), "{words}");
}

pub fn not_a_number_in_words(runtime: &Runtime) {
    let mut snes = solver(&runtime.petsc, "", MUMPS);
    let (mut chain, mut x) = (Chain::new(runtime), start(runtime));
    chain.shift = f64::NAN;
    let report = solve(&mut snes, &mut chain, &mut x);
    assert_eq!(report.reason, SnesReason::NotANumber);
    assert_eq!(report.words(), "the residual is not a number");
}

pub fn user_options_win(runtime: &Runtime) {
    let petsc = &runtime.petsc;
    assert_eq!(
        (petsc.has_option("user_pc_type"), petsc.has_option("pc_type")),
        (Ok(true), Ok(false))
    );
    // Those of a case come after the presets and before the command line.
    petsc.insert_options("-user_pc_type gamg -user_snes_linesearch_type bt").expect("options");
    assert!(matches!(petsc.insert_options("pc_type gamg"), Err(Error::Input(_))));
    let mut snes = solver(petsc, "user_", MUMPS);
    // jacobi from the command line with preonly from the preset; the user adds cg.
    assert_eq!((snes.ksp_type(), snes.pc_type()), (Ok("preonly".into()), Ok("jacobi".into())));
    drop(snes);
    snes = solver(petsc, "user_", HYPRE);
    assert_eq!((snes.ksp_type(), snes.pc_type()), (Ok("cg".into()), Ok("jacobi".into())));
    // The user's relative tolerance of 1e-3 holds, not the 1e-12 that the system asks for.
    let (mut chain, mut x) = (Chain::new(runtime), start(runtime));
    let loose = solve(&mut snes, &mut chain, &mut x);
    assert_eq!(loose.reason, SnesReason::Converged);
    let mut snes = solver(petsc, "", JACOBI);
    let tight = solve(&mut snes, &mut chain, &mut start(runtime));
    assert!(loose.iterations > tight.iterations, "{loose:?} {tight:?}");
}

pub fn unused_options_are_found(runtime: &Runtime) {
    let petsc = &runtime.petsc;
    let unused = || petsc.unused_options().expect("a list");
    // Misspelt on the command line; asking whether it is there does not use it.
    assert_eq!(petsc.has_option("KPS_TYPE"), Ok(true));
    assert!(unused().contains(&"-kps_type cg".to_string()), "{:?}", unused());
    // An option of a preset that nothing uses is not the user's affair.
    let preset = [MUMPS, &[("pc_hypre_type", "boomeramg")]].concat();
    let snes = solver(petsc, "", &preset);
    assert!(!unused().iter().any(|option| option.contains("hypre")), "{:?}", unused());
    assert_eq!(petsc.has_option("pc_hypre_type"), Ok(true));
    drop(snes);
    assert_eq!(petsc.has_option("pc_hypre_type"), Ok(false));
    petsc.set_option("gamg_typo", "").expect("an option");
    assert!(unused().contains(&"-gamg_typo".to_string()), "{:?}", unused());
    // A wrong value is an error with its text.
    petsc.set_option("wrong_ksp_max_it", "many").expect("an option");
    let matrix = tridiagonal(petsc, N);
    match Snes::new(petsc, "wrong_", matrix, &KspSetup::new(JACOBI)) {
        Err(Error::System(text)) => assert!(text.contains("many"), "{text}"),
        Ok(_) => panic!("`many` was taken for a number"),
        Err(other) => panic!("{other:?}"),
    }
}
