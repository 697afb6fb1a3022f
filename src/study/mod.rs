//! Studies: a family of cases, run one after the other, measured and charted.
//!
//! A study process is serial: it starts neither MPI nor PETSc, and launches every run as a process
//! of its own.

mod against;
mod charts;
mod check;
mod draw;
mod file;
mod launch;
mod measure;
mod page;
mod plan;
mod read;
mod record;
mod spec;
mod stats;
mod table;
mod words;

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result, number_text};
use crate::output::atomic;
use crate::report::versions;
use launch::{End, Interrupt, Scene, launch};
use plan::{Plan, Run};
use record::{Ended, Launch, Record, tidy};
use spec::Study;
use table::{EVERYTHING, TABLE};

/// Name of the directory of the runs' directories.
const RUNS: &str = "runs";
/// Says whose directory it is.
const MARKER: &str = "README.txt";
const MARKER_TEXT: &str = "The runs of a study of column-hpc, a directory for each, and in it record.json, \
     for which the run is not launched again. `column-hpc study STUDY.yaml --overwrite` removes them all.\n";
/// Name of the directory of charts.
const CHARTS: &str = "charts";
/// Name of the page.
const PAGE: &str = "study.html";

/// What is asked of a study.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Request {
    /// The study file.
    pub study: PathBuf,
    /// The output directory, instead of the study's.
    pub output: Option<PathBuf>,
    /// Go on in a directory that holds finished runs.
    pub resume: bool,
    /// Replace the study in the output directory.
    pub overwrite: bool,
    /// Only the K-th of N shares of the runs, and no charts; K from 1.
    pub part: Option<(usize, usize)>,
    /// List the runs; launch none.
    pub dry_run: bool,
    /// Draw what finished runs have left; launch none.
    pub charts_only: bool,
}

/// Carries out a study: runs what is not finished, and writes tables, charts and the page. Local;
/// needs no MPI. Progress goes to the log, one line for each run.
///
/// # Errors
/// `Input` when study or case are wrong, or the directory holds other things; `System` when
/// something cannot be written or launched; `Stopped` when it was interrupted. A run that fails is
/// a result.
pub fn run(request: &Request) -> Result<()> {
    let study = Study::read(&request.study)?;
    let version = version();
    let plan = Plan::new(&study, &version)?;
    if request.dry_run {
        list(&study, &plan);
        return Ok(());
    }
    let directory = request.output.clone().unwrap_or_else(|| study.directory.clone());
    take(&directory, request)?;
    let session = Session { study: &study, plan: &plan, version: &version, directory: &directory };
    if !request.charts_only {
        session.launch_all(request.part)?;
    }
    if request.part.is_none() {
        session.close()?;
    }
    Ok(())
}

/// The program and the library that most of its numbers come from: other ones may give others.
fn version() -> String {
    let versions = versions();
    let of = |name: &str| versions.get(name).cloned().unwrap_or_default();
    format!("{}, PETSc {}", of("column-hpc"), of("PETSc"))
}

fn list(study: &Study, plan: &Plan) {
    let es = if study.repeats == 1 { "" } else { "es" };
    tracing::info!("{}: {} runs, {} launch{es} each", study.title, plan.runs.len(), study.repeats);
    for (number, run) in plan.runs.iter().enumerate() {
        tracing::info!("{}", headline(plan, number, run));
        for text in &run.overrides {
            tracing::info!("      --set {text}");
        }
    }
}

fn headline(plan: &Plan, number: usize, run: &Run) -> String {
    let ranks = if run.ranks == 1 { "1 rank" } else { &format!("{} ranks", run.ranks) };
    let name = if run.name.is_empty() { "the base case" } else { &run.name };
    format!("{:>4}/{}  {name}, {ranks}", number + 1, plan.runs.len())
}

/// Makes the output directory ours, or refuses it.
fn take(path: &Path, request: &Request) -> Result<()> {
    fs::create_dir_all(path)
        .map_err(|cause| Error::file("cannot create the output directory", path, cause))?;
    let mut entries = fs::read_dir(path)
        .map_err(|cause| Error::file("cannot read the output directory", path, cause))?;
    if entries.next().is_some() {
        let goes_on = request.resume || request.part.is_some() || request.charts_only;
        let refuse = |what: &str| Err(Error::Input(format!("{} {what}", path.display())));
        if !path.join(RUNS).join(MARKER).exists() {
            return refuse(
                "is not empty, and holds no study: name another directory with --output",
            );
        }
        if request.overwrite {
            for name in [EVERYTHING, TABLE, PAGE] {
                remove(&path.join(name), |file| fs::remove_file(file))?;
            }
            for name in [CHARTS, RUNS] {
                remove(&path.join(name), |directory| fs::remove_dir_all(directory))?;
            }
        } else if !goes_on {
            return refuse("holds a study: go on with --resume, or start anew with --overwrite");
        }
    }
    let runs = path.join(RUNS);
    fs::create_dir_all(&runs).map_err(|cause| Error::file("cannot create", &runs, cause))?;
    let marker = runs.join(MARKER);
    if marker.exists() { Ok(()) } else { atomic::write_text(&marker, MARKER_TEXT) }
}

fn remove(path: &Path, how: impl Fn(&Path) -> std::io::Result<()>) -> Result<()> {
    match how(path) {
        Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::file("cannot remove", path, cause))
        }
        _ => Ok(()),
    }
}

struct Session<'a> {
    study: &'a Study,
    plan: &'a Plan,
    version: &'a str,
    directory: &'a Path,
}

impl Session<'_> {
    fn place(&self, run: &Run) -> PathBuf {
        self.directory.join(RUNS).join(&run.directory)
    }

    fn record(&self, run: &Run) -> Record {
        Record::load(&self.place(run), run, self.version)
    }

    /// Launches what is not finished of a share of the runs.
    fn launch_all(&self, part: Option<(usize, usize)>) -> Result<()> {
        let interrupt = Interrupt::listen()?;
        let (share, shares) = part.unwrap_or((1, 1));
        for (number, run) in self.plan.runs.iter().enumerate() {
            if number % shares != share - 1 {
                continue;
            }
            let mut record = self.record(run);
            let mut kept = true;
            while !record.is_finished(self.study.repeats, self.study.limit) {
                kept = false;
                let launch = self.launch(run, &interrupt)?.ok_or_else(|| {
                    let text =
                        "the study was interrupted; finished runs are kept, go on with --resume";
                    Error::Stopped(format!("{text} ({} of {} runs)", number, self.plan.runs.len()))
                })?;
                record.push(launch);
                record.store(&self.place(run))?;
            }
            if !self.study.keep_all {
                tidy(&self.place(run));
            }
            tracing::info!("{}: {}", headline(self.plan, number, run), told(&record, kept));
        }
        Ok(())
    }

    /// One launch; none if it was interrupted.
    fn launch(&self, run: &Run, interrupt: &Interrupt) -> Result<Option<Launch>> {
        if interrupt.is_set() {
            return Ok(None);
        }
        let output = self.place(run);
        fs::create_dir_all(&output)
            .map_err(|cause| Error::file("cannot create", &output, cause))?;
        let scene = Scene {
            launcher: &self.study.launcher,
            ranks: run.ranks,
            case: &self.study.base,
            overrides: &run.overrides,
            output: &output,
            limit: self.study.limit,
        };
        let (end, seconds) = launch(&scene, interrupt)?;
        // A run that ended by itself counts, also when the study is asked to stop meanwhile.
        Ok((end != End::Interrupted).then(|| Launch::of(&end, seconds, self.study.limit, &output)))
    }

    /// Tables, charts and the page from what is recorded.
    fn close(&self) -> Result<()> {
        let records: Vec<Record> = self.plan.runs.iter().map(|run| self.record(run)).collect();
        let runs = self.directory.join(RUNS);
        let rows = measure::rows(self.study, self.plan, &records, &runs);
        table::write_table(self.study, self.plan, &rows, &self.directory.join(TABLE))?;
        let everything = self.directory.join(EVERYTHING);
        table::write_everything(self.study, self.plan, &rows, &records, &everything)?;
        let charts = self.directory.join(CHARTS);
        fs::create_dir_all(&charts)
            .map_err(|cause| Error::file("cannot create", &charts, cause))?;
        let draw = |chart| draw::draw(self.study, self.plan, &rows, chart, &charts);
        let drawn: Vec<draw::Drawn> = self.study.charts.iter().map(draw).collect::<Result<_>>()?;
        let page = page::page(self.study, self.plan, &rows, &drawn);
        atomic::write_text(&self.directory.join(PAGE), &page)?;
        let count = |wanted: &dyn Fn(Option<Ended>) -> bool| {
            rows.iter().filter(|row| wanted(row.status)).count()
        };
        let done = count(&|status| status.is_some_and(Ended::has_results));
        let missing = count(&|status| status.is_none());
        tracing::info!(
            "{done} of {} runs came to their end, {} failed, {missing} not run; results in {}",
            rows.len(),
            rows.len() - done - missing,
            self.directory.display()
        );
        Ok(())
    }
}

/// How a run ended, for its line.
fn told(record: &Record, kept: bool) -> String {
    let Some(last) = record.launches.last() else { return "not run".to_owned() };
    let word = if kept { "kept, " } else { "" };
    let seconds = number_text((last.wall_seconds * 100.0).round() / 100.0);
    let what = match last.message.lines().next() {
        Some(line) => format!(": {line}"),
        None => String::new(),
    };
    format!("{word}{} in {seconds} s{what}", last.status.words())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_study_is_right() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/studies");
        let files = fs::read_dir(folder).expect("the studies").flatten().map(|file| file.path());
        let mut count = 0;
        for file in files.filter(|path| path.extension().is_some_and(|e| e == "yaml")) {
            let study = Study::read(&file).unwrap_or_else(|error| panic!("{error}"));
            let plan = Plan::new(&study, "v").unwrap_or_else(|error| panic!("{error}"));
            assert!(study.text.starts_with('#') && !study.charts.is_empty(), "{}", file.display());
            let names: std::collections::BTreeSet<_> =
                plan.runs.iter().map(|r| &r.directory).collect();
            assert_eq!(names.len(), plan.runs.len(), "{}", file.display());
            count += 1;
        }
        assert_eq!(count, 10);
    }
}
