//! Wall-clock time by phase.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use crate::comm::Comm;
use serde::Serialize;

/// A part of a run whose time is reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Reading or making the mesh.
    Mesh,
    /// Sharing it out.
    Partition,
    /// Residuals and tangents.
    Assembly,
    /// Newton and linear solves, without assembly.
    Solve,
    /// Writing results.
    Output,
}

impl Phase {
    /// Its name, as in [`Timings`].
    pub fn name(self) -> &'static str {
        ["mesh", "partition", "assembly", "solve", "output"][self as usize]
    }
}

const PHASES: usize = 5;

/// Seconds by phase; what belongs to none is in the total alone.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Timings {
    /// [`Phase::Mesh`]
    pub mesh: f64,
    /// [`Phase::Partition`]
    pub partition: f64,
    /// [`Phase::Assembly`]
    pub assembly: f64,
    /// [`Phase::Solve`]
    pub solve: f64,
    /// [`Phase::Output`]
    pub output: f64,
    /// Since the timers were made.
    pub total: f64,
}

/// Told of every change of the phase.
type Watch = Box<dyn Fn(Option<Phase>)>;

/// Clocks of one rank. Time in a phase entered within another counts for the inner one alone.
pub struct Timers {
    start: Instant,
    since: Cell<Instant>,
    current: Cell<Option<Phase>>,
    spent: Cell<[Duration; PHASES]>,
    watch: RefCell<Option<Watch>>,
}

/// A phase that lasts until this value goes; phases end in the reverse order of their beginning.
#[must_use = "the phase ends when this value is dropped"]
pub struct Running<'a> {
    timers: &'a Timers,
    enclosing: Option<Phase>,
}

impl Default for Timers {
    fn default() -> Self {
        Self::new()
    }
}

impl Timers {
    /// Starts the total.
    pub fn new() -> Self {
        let now = Instant::now();
        Self {
            start: now,
            since: Cell::new(now),
            current: Cell::new(None),
            spent: Cell::new([Duration::ZERO; PHASES]),
            watch: RefCell::new(None),
        }
    }

    /// Has `watch` called with the current phase at every change, until [`Timers::unwatch`].
    pub fn watch(&self, watch: impl Fn(Option<Phase>) + 'static) {
        *self.watch.borrow_mut() = Some(Box::new(watch));
    }

    /// Drops what watches the phases.
    pub fn unwatch(&self) {
        self.watch.borrow_mut().take();
    }

    /// Begins a phase.
    pub fn enter(&self, phase: Phase) -> Running<'_> {
        Running { timers: self, enclosing: self.switch(Some(phase)) }
    }

    /// Charges the time since the last switch to the current phase and makes another current.
    fn switch(&self, next: Option<Phase>) -> Option<Phase> {
        let now = Instant::now();
        let elapsed = now - self.since.replace(now);
        let current = self.current.replace(next);
        if current != next
            && let Some(watch) = &*self.watch.borrow()
        {
            watch(next);
        }
        if let Some(phase) = current {
            let mut spent = self.spent.get();
            spent[phase as usize] += elapsed;
            self.spent.set(spent);
        }
        current
    }

    /// This rank's seconds up to now, the current phase included.
    ///
    /// # Parallel
    /// Local.
    pub fn timings(&self) -> Timings {
        self.switch(self.current.get());
        let [mesh, partition, assembly, solve, output] = self.spent.get().map(|d| d.as_secs_f64());
        Timings {
            mesh,
            partition,
            assembly,
            solve,
            output,
            total: self.start.elapsed().as_secs_f64(),
        }
    }

    /// Seconds of the slowest rank, for each phase and the total by itself.
    ///
    /// # Parallel
    /// Collective.
    pub fn slowest(&self, comm: &Comm) -> Timings {
        let t = self.timings();
        let mut slowest = [t.mesh, t.partition, t.assembly, t.solve, t.output, t.total];
        comm.max(&mut slowest);
        let [mesh, partition, assembly, solve, output, total] = slowest;
        Timings { mesh, partition, assembly, solve, output, total }
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.timers.switch(self.enclosing);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::sleep;

    #[test]
    fn an_inner_phase_is_not_counted_twice() {
        let timers = Timers::new();
        let pause = Duration::from_millis(20);
        {
            let _solve = timers.enter(Phase::Solve);
            for _ in 0..2 {
                let _assembly = timers.enter(Phase::Assembly);
                sleep(pause);
            }
            sleep(pause);
        }
        sleep(pause);
        let t = timers.timings();
        assert!(t.assembly >= 0.04 && t.solve >= 0.02, "{t:?}");
        assert_eq!((t.mesh, t.partition, t.output), (0.0, 0.0, 0.0));
        assert!(t.assembly + t.solve + 0.02 <= t.total, "{t:?}");
    }
}
