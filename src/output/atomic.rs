//! Files that are complete or absent under their name.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rustix::fs::{FallocateFlags, fallocate, fstatvfs};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};

use crate::error::{Error, Result};

/// Where a file is written until it is complete: beside its place, `NAME.tmp.PID`.
///
/// `process` is the process id of rank 0, so that all ranks of a run share the name and a later
/// run can tell a leftover.
pub fn temporary(path: &Path, process: u32) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".tmp.{process}"));
    PathBuf::from(name)
}

/// Brings a complete temporary file to the disk and gives it its name, replacing what bore it.
///
/// # Errors
/// [`Error::System`] with the path and the reason of the operating system.
///
/// # Parallel
/// Local; one rank does it, after every rank has closed the file.
pub fn publish(temporary: &Path, path: &Path) -> Result<()> {
    let flushed = File::open(temporary).and_then(|file| file.sync_all());
    flushed
        .and_then(|()| fs::rename(temporary, path))
        .and_then(|()| flush_directory(path))
        .map_err(|cause| Error::file("cannot write", path, cause))
}

/// As [`publish`], but what bore the name becomes `previous`. There is a whole file under one of
/// the two names at every moment.
///
/// # Errors
/// As [`publish`].
///
/// # Parallel
/// As [`publish`].
pub fn replace(temporary: &Path, path: &Path, previous: &Path) -> Result<()> {
    let flushed = File::open(temporary).and_then(|file| file.sync_all());
    let kept = flushed.and_then(|()| match fs::rename(path, previous) {
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    });
    kept.and_then(|()| fs::rename(temporary, path))
        .and_then(|()| flush_directory(path))
        .map_err(|cause| Error::file("cannot write", path, cause))
}

/// Writes a text file at once.
///
/// # Errors
/// [`Error::System`] with the path and the reason of the operating system; nothing is left behind.
///
/// # Parallel
/// Local; call it on rank 0.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    write_bytes(path, text.as_bytes())
}

/// As [`write_text`], for any bytes.
///
/// # Errors
/// As [`write_text`].
///
/// # Parallel
/// As [`write_text`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let temporary = temporary(path, std::process::id());
    let written = File::create(&temporary)
        .and_then(|mut file| file.write_all(bytes))
        .map_err(|cause| Error::file("cannot write", path, cause));
    let outcome = written.and_then(|()| publish(&temporary, path));
    if outcome.is_err() {
        discard(&temporary);
    }
    outcome
}

/// Makes sure that a file can grow to a size, and keeps the room for it where the file system can.
///
/// MPI's collective writes do not end together when the disk fills up: the rank that writes fails,
/// and the others wait for ever. So room is made before.
///
/// # Errors
/// The operating system's, when there is not enough room.
///
/// # Parallel
/// Local; one rank does it.
pub fn reserve(path: &Path, bytes: u64) -> io::Result<()> {
    within_limit(bytes)?;
    let file = File::options().write(true).open(path)?;
    match fallocate(&file, FallocateFlags::KEEP_SIZE, 0, bytes) {
        Ok(()) => Ok(()),
        Err(Errno::OPNOTSUPP | Errno::NOSYS) => {
            let system = fstatvfs(&file)?;
            let room = system.f_bavail.saturating_mul(system.f_frsize);
            if room < bytes { Err(Errno::NOSPC.into()) } else { Ok(()) }
        }
        Err(cause) => Err(cause.into()),
    }
}

/// Makes sure that this process may write a file of a size (`ulimit -f`).
///
/// # Errors
/// The operating system's, when it may not.
///
/// # Parallel
/// Local; on every rank that writes.
pub fn within_limit(bytes: u64) -> io::Result<()> {
    match getrlimit(Resource::Fsize).current {
        Some(most) if bytes > most => Err(Errno::FBIG.into()),
        _ => Ok(()),
    }
}

/// Removes a temporary file that will not be completed.
pub fn discard(temporary: &Path) {
    // The error that led here is the one to report; the next run removes what stays.
    let _ = fs::remove_file(temporary);
}

/// The name under which a temporary file would have been published, and its writer.
///
/// None for every other file name.
pub fn parse_temporary(name: &str) -> Option<(&str, u32)> {
    let (base, process) = name.rsplit_once(".tmp.")?;
    let digits = !process.is_empty() && process.bytes().all(|b| b.is_ascii_digit());
    (digits && !base.is_empty()).then(|| process.parse().ok().map(|p| (base, p)))?
}

/// Whether the writer of a temporary file cannot complete it any more.
///
/// A process of the same id as this one is an earlier one: in containers ids repeat, and this run
/// asks before it writes anything.
pub fn is_leftover(process: u32) -> bool {
    process == std::process::id() || !is_running(process)
}

/// Whether a process exists and has not ended: one that was killed stays listed, as a zombie,
/// until its parent asks for it, which in containers may be never.
fn is_running(process: u32) -> bool {
    let stat = fs::read_to_string(Path::new("/proc").join(process.to_string()).join("stat"));
    // The state is the first word after the name, which is in brackets and may hold any character.
    let state = stat.ok().and_then(|text| Some(text.rsplit_once(") ")?.1.chars().next()));
    !matches!(state, None | Some(Some('Z' | 'X')))
}

fn flush_directory(path: &Path) -> io::Result<()> {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match File::open(parent)?.sync_all() {
        // Some network file systems cannot flush a directory; the rename is then as safe as it
        // gets.
        Err(e) if matches!(e.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            Ok(())
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratch(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("column-hpc-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("the temporary directory is writable");
        path
    }

    #[test]
    fn a_text_replaces_the_one_before_and_leaves_no_other_file() {
        let dir = scratch("atomic");
        let path = dir.join("report.json");
        write_text(&path, "a longer first text").unwrap();
        write_text(&path, "second").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "second");
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn a_text_that_cannot_be_written_names_the_path_and_the_reason() {
        let dir = scratch("atomic-missing");
        let path = dir.join("absent/report.json");
        let error = write_text(&path, "x").unwrap_err();
        assert_eq!(error.exit_status(), 4);
        assert!(error.to_string().contains("absent/report.json"), "{error}");
        assert!(error.to_string().contains("No such file"), "{error}");
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn a_failed_rename_leaves_no_temporary_file() {
        let dir = scratch("atomic-rename");
        fs::create_dir(dir.join("history.csv")).unwrap();
        assert!(write_text(&dir.join("history.csv"), "x").is_err());
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn room_is_refused_when_there_is_too_little() {
        let dir = scratch("atomic-room");
        let path = dir.join("bulk.vtkhdf");
        fs::write(&path, "x").unwrap();
        reserve(&path, 4096).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().len(), 1);
        // More than any file system holds, whichever way it says so.
        assert!(reserve(&path, 1 << 61).is_err());
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn a_process_that_has_ended_cannot_complete_a_file() {
        let mut child = std::process::Command::new("sleep").arg("30").spawn().unwrap();
        let process = child.id();
        assert!(!is_leftover(process));
        child.kill().unwrap();
        // Ended, but nobody has asked for its status.
        while is_running(process) {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        assert!(Path::new("/proc").join(process.to_string()).exists());
        assert!(is_leftover(process));
        child.wait().unwrap();
        assert!(is_leftover(process) && is_leftover(std::process::id()));
    }

    #[test]
    fn temporary_names_are_told_from_others() {
        let name = temporary(Path::new("fields/bulk_000001.vtkhdf"), 42);
        assert_eq!(name, Path::new("fields/bulk_000001.vtkhdf.tmp.42"));
        assert_eq!(parse_temporary("history.csv.tmp.42"), Some(("history.csv", 42)));
        for other in ["history.csv", "history.csv.tmp.", "history.csv.tmp.4x", ".tmp.42"] {
            assert_eq!(parse_temporary(other), None, "{other}");
        }
    }
}
