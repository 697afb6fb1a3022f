//! The output directory: whose results it holds, and which files in it are ours to replace.

use std::fs;
use std::path::{Path, PathBuf};

use super::{atomic, checkpoint};
use crate::comm::Comm;
use crate::error::{Error, Result};
use serde_json::Value;

/// Name of the history table.
pub const HISTORY: &str = "history.csv";
/// Name of the report.
pub const REPORT: &str = "report.json";
/// Name of the page.
pub const PAGE: &str = "report.html";
/// Name of the resolved case, which marks whose results a directory holds.
pub const CASE: &str = "case.resolved.json";
/// Name of the directory of field files.
pub const FIELDS: &str = "fields";

/// An output directory that belongs to this run.
#[derive(Debug, Clone)]
pub struct OutputDirectory {
    path: PathBuf,
}

impl OutputDirectory {
    /// Creates the directory if there is none, and refuses one that [`OutputDirectory::open`]
    /// would refuse; removes nothing, so that a case which then proves wrong costs no results.
    ///
    /// # Errors
    /// As [`OutputDirectory::open`].
    ///
    /// # Parallel
    /// Collective; rank 0 does the work.
    pub fn examine(comm: &Comm, path: &Path, case: &str, overwrite: bool) -> Result<()> {
        comm.agree(if comm.is_root() { examine(path, case, overwrite).map(drop) } else { Ok(()) })
    }

    /// Creates the directory or takes over an existing one, and writes the resolved case into it.
    ///
    /// Earlier results of the same case are removed, so that what is there afterwards is from this
    /// run alone; so are those of another case with `overwrite`. Files that the program did not
    /// write are never touched.
    ///
    /// # Arguments
    /// * `case` the resolved case as JSON text; results whose case has another value are of another
    ///   case
    ///
    /// # Errors
    /// [`Error::Input`] if the directory holds results of another case and `overwrite` is false;
    /// [`Error::System`] with the path and the reason if it cannot be created or written.
    ///
    /// # Parallel
    /// Collective; rank 0 does the work.
    pub fn open(comm: &Comm, path: &Path, case: &str, overwrite: bool) -> Result<Self> {
        let taken = if comm.is_root() { take(path, case, overwrite) } else { Ok(()) };
        comm.agree(taken)?;
        Ok(Self { path: path.to_path_buf() })
    }

    /// Takes over a directory to go on with its results: those of the same physics up to the step
    /// `last` stay, later field files go.
    ///
    /// # Errors
    /// As [`OutputDirectory::open`].
    ///
    /// # Parallel
    /// As [`OutputDirectory::open`].
    pub fn resume(comm: &Comm, path: &Path, case: &str, last: usize) -> Result<Self> {
        let taken = if comm.is_root() { go_on(path, case, last) } else { Ok(()) };
        comm.agree(taken)?;
        Ok(Self { path: path.to_path_buf() })
    }

    /// The directory itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of the history table.
    pub fn history(&self) -> PathBuf {
        self.path.join(HISTORY)
    }

    /// Path of the report.
    pub fn report(&self) -> PathBuf {
        self.path.join(REPORT)
    }

    /// Path of the page.
    pub fn page(&self) -> PathBuf {
        self.path.join(PAGE)
    }

    /// Path of the directory of field files.
    pub fn fields(&self) -> PathBuf {
        self.path.join(FIELDS)
    }
}

/// The files of earlier runs in the directory, all of which may be replaced.
fn examine(path: &Path, case: &str, overwrite: bool) -> Result<Vec<PathBuf>> {
    fs::create_dir_all(path)
        .map_err(|cause| Error::file("cannot create the output directory", path, cause))?;
    let ours = our_files(path)?;
    if !overwrite
        && let Some(newest) = ours.iter().find(|f| f.ends_with(checkpoint::NEWEST))
        && !has_ended(path)
    {
        return Err(Error::Input(format!(
            "{} is of a run that was stopped: go on from it with --restart latest, or start anew \
             with --overwrite",
            newest.display()
        )));
    }
    if !overwrite && let Some(reason) = belongs_to_another(path, &ours, case) {
        return Err(Error::Input(format!(
            "the output directory {} {reason}; \
             choose another with --output DIR, or replace them with --overwrite",
            path.display()
        )));
    }
    Ok(ours)
}

/// Whether the report tells of a run that came to its end.
fn has_ended(path: &Path) -> bool {
    let report = fs::read_to_string(path.join(REPORT)).ok();
    let report: Option<Value> = report.and_then(|text| serde_json::from_str(&text).ok());
    let status = report.as_ref().and_then(|r| r.get("status")?.as_str());
    matches!(status, Some("done" | "expectation_missed" | "accuracy_missed"))
}

fn take(path: &Path, case: &str, overwrite: bool) -> Result<()> {
    let ours = examine(path, case, overwrite)?;
    // The marker stays until it is replaced, so that a run killed here leaves a directory of a
    // known case.
    for file in ours.iter().filter(|f| !f.ends_with(CASE)) {
        fs::remove_file(file).map_err(|cause| Error::file("cannot remove", file, cause))?;
    }
    atomic::write_text(&path.join(CASE), case)?;
    let fields = path.join(FIELDS);
    fs::create_dir_all(&fields)
        .map_err(|cause| Error::file("cannot create the directory", &fields, cause))
}

fn go_on(path: &Path, case: &str, last: usize) -> Result<()> {
    fs::create_dir_all(path)
        .map_err(|cause| Error::file("cannot create the output directory", path, cause))?;
    let later = |file: &&PathBuf| {
        let name = file.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let stem = name.strip_suffix(".vtkhdf");
        let step = stem.and_then(|s| s.rsplit_once("_mesh.").or(s.rsplit_once('_')));
        let leftover = atomic::parse_temporary(name).is_some();
        let step = step.and_then(|(_, number)| number.parse::<usize>().ok());
        let told = file.ends_with(REPORT) || file.ends_with(PAGE);
        leftover || told || step.is_some_and(|step| step > last)
    };
    for file in our_files(path)?.iter().filter(later) {
        fs::remove_file(file).map_err(|cause| Error::file("cannot remove", file, cause))?;
    }
    atomic::write_text(&path.join(CASE), case)?;
    let fields = path.join(FIELDS);
    fs::create_dir_all(&fields)
        .map_err(|cause| Error::file("cannot create the directory", &fields, cause))
}

/// Why the results in the directory are not of this case; none if they are, or if there are none.
fn belongs_to_another(path: &Path, ours: &[PathBuf], case: &str) -> Option<String> {
    let results = ours.iter().any(|f| {
        let name = f.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        atomic::parse_temporary(name).is_none()
    });
    if !results {
        return None;
    }
    let read = |name: &str| -> Option<Value> {
        serde_json::from_str(&fs::read_to_string(path.join(name)).ok()?).ok()
    };
    // Both sides are parsed from text by the same parser, so equal numbers stay equal.
    let case: Value = serde_json::from_str(case).ok()?;
    let before = read(CASE).or_else(|| Some(read(REPORT)?.get("case")?.clone()));
    match before {
        None => Some("holds results that do not say of which case they are".into()),
        Some(before) if before == case => None,
        Some(before) => {
            let title = before.get("title").and_then(Value::as_str).map(|t| format!(" ({t})"));
            let key = first_difference(&before, &case);
            Some(format!(
                "holds results of another case{}: `{key}` differs",
                title.unwrap_or_default()
            ))
        }
    }
}

/// The key at which two different values first differ, as it would be given to `--set`.
pub fn first_difference(a: &Value, b: &Value) -> String {
    fn walk(a: &Value, b: &Value, key: &str) -> Option<String> {
        let join = |k: &str| if key.is_empty() { k.to_string() } else { format!("{key}.{k}") };
        match (a, b) {
            (Value::Object(x), Value::Object(y)) => x.keys().chain(y.keys()).find_map(|k| {
                walk(x.get(k).unwrap_or(&Value::Null), y.get(k).unwrap_or(&Value::Null), &join(k))
            }),
            (Value::Array(x), Value::Array(y)) if x.len() == y.len() => x
                .iter()
                .zip(y)
                .enumerate()
                .find_map(|(i, (p, q))| walk(p, q, &join(&i.to_string()))),
            _ => (a != b).then(|| key.to_string()),
        }
    }
    walk(a, b, "").filter(|key| !key.is_empty()).unwrap_or_else(|| "case".into())
}

/// The files in the directory that a run wrote, and what dead runs left of them.
fn our_files(path: &Path) -> Result<Vec<PathBuf>> {
    let mut found = list(path, |name| {
        [HISTORY, REPORT, PAGE, CASE, checkpoint::NEWEST, checkpoint::PREVIOUS].contains(&name)
    })?;
    let fields = path.join(FIELDS);
    if fields.is_dir() {
        found.extend(list(&fields, is_field_file)?);
    }
    Ok(found)
}

/// `NAME_000003.vtkhdf`, `NAME_mesh.vtkhdf`, `NAME_mesh.000003.vtkhdf` or `NAME.vtkhdf.series`.
fn is_field_file(name: &str) -> bool {
    let numbered = name.strip_suffix(".vtkhdf").and_then(|stem| stem.rsplit_once('_'));
    let numbered = numbered.map(|(_, n)| n.strip_prefix("mesh.").unwrap_or(n));
    let numbered = numbered
        .is_some_and(|n| n == "mesh" || n.len() >= 6 && n.bytes().all(|b| b.is_ascii_digit()));
    numbered || name.ends_with(".vtkhdf.series")
}

fn list(path: &Path, ours: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>> {
    let failed = |cause| Error::file("cannot read the output directory", path, cause);
    let mut found = Vec::new();
    for entry in fs::read_dir(path).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        let mine = match atomic::parse_temporary(name) {
            Some((base, process)) => ours(base) && atomic::is_leftover(process),
            None => ours(name),
        };
        if mine && !entry.path().is_dir() {
            found.push(entry.path());
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE_A: &str = r#"{"title":"a","materials":{"rock":{"young_modulus":5.8e9}}}"#;
    const CASE_B: &str = r#"{"title":"a","materials":{"rock":{"young_modulus":5.9e9}}}"#;

    fn scratch(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("column-hpc-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        path
    }

    fn fill(path: &Path) {
        for name in [
            HISTORY,
            PAGE,
            "fields/bulk_000001.vtkhdf",
            "fields/bulk_mesh.vtkhdf",
            "fields/bulk_mesh.000001.vtkhdf",
            "fields/bulk.vtkhdf.series",
        ] {
            fs::write(path.join(name), "x").unwrap();
        }
    }

    fn names(path: &Path) -> Vec<String> {
        let mut names: Vec<String> = [path.to_path_buf(), path.join(FIELDS)]
            .iter()
            .flat_map(|d| fs::read_dir(d).unwrap())
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_same_case_replaces_its_results_and_keeps_other_files() {
        let dir = scratch("same-case");
        take(&dir, CASE_A, false).unwrap();
        fill(&dir);
        fs::write(dir.join("notes.txt"), "mine").unwrap();
        fs::write(dir.join("fields/model.vtkhdf"), "mine").unwrap();
        fs::write(dir.join("history.csv.tmp.4194305"), "left by a dead run").unwrap();
        take(&dir, CASE_A, false).unwrap();
        assert_eq!(names(&dir), [CASE, FIELDS, "model.vtkhdf", "notes.txt"]);
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn another_case_is_refused_with_the_difference_unless_overwritten() {
        let dir = scratch("other-case");
        take(&dir, CASE_A, false).unwrap();
        fill(&dir);
        let error = take(&dir, CASE_B, false).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.to_string().contains("`materials.rock.young_modulus` differs"), "{error}");
        assert!(dir.join(HISTORY).exists());
        take(&dir, CASE_B, true).unwrap();
        assert_eq!(names(&dir), [CASE, FIELDS]);
        assert_eq!(fs::read_to_string(dir.join(CASE)).unwrap(), CASE_B);
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn a_report_without_a_marker_says_whose_results_they_are() {
        let dir = scratch("report-only");
        fs::create_dir_all(&dir).unwrap();
        fs::write(dir.join(REPORT), format!(r#"{{"status":"done","case":{CASE_A}}}"#)).unwrap();
        assert_eq!(take(&dir, CASE_B, false).unwrap_err().exit_status(), 2);
        take(&dir, CASE_A, false).unwrap();
        assert!(!dir.join(REPORT).exists());
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn results_of_an_unknown_case_are_refused() {
        let dir = scratch("unknown-case");
        fs::create_dir_all(&dir).unwrap();
        fs::write(dir.join(HISTORY), "time\n").unwrap();
        assert_eq!(take(&dir, CASE_A, false).unwrap_err().exit_status(), 2);
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn a_directory_that_cannot_be_made_is_the_machines_fault() {
        let dir = scratch("under-a-file");
        fs::write(&dir, "a file, not a directory").unwrap();
        let error = take(&dir.join("results"), CASE_A, true).unwrap_err();
        assert_eq!(error.exit_status(), 4);
        assert!(error.to_string().contains("Not a directory"), "{error}");
        fs::remove_file(dir).unwrap();
    }
}
