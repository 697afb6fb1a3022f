//! Files get to the disk and to their names while the solution goes on.
//!
//! Waiting for the disk is most of the cost of a field file. One thread does it, file after file in
//! their order, so that an index never names a file that is not there.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

use super::atomic;
use crate::error::{Error, Result};

/// A complete file under its temporary name; it is gone with this value unless it has got its name:
/// also where it never comes out of the queue.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        // There is none any more where it has got its name.
        atomic::discard(&self.0);
    }
}

/// What remains to be done for a file.
enum Job {
    /// A complete temporary file gets its name.
    Publish { temporary: Temporary, path: PathBuf },
    /// The same, and what bore the name gets another.
    Replace { temporary: Temporary, path: PathBuf, previous: PathBuf },
    /// A text is written.
    Text { path: PathBuf, text: String },
}

/// The queue of one rank; ranks that publish nothing have no thread.
#[derive(Default)]
pub struct Publisher {
    running: Option<(Sender<Job>, JoinHandle<Result<()>>)>,
}

impl Publisher {
    /// Brings a complete temporary file to the disk and gives it its name, some time before
    /// [`Publisher::finish`] returns.
    ///
    /// # Errors
    /// That of an earlier file; nothing is published after it.
    ///
    /// # Parallel
    /// Local; one rank does it, after every rank has closed the file.
    pub fn publish(&mut self, temporary: &Path, path: &Path) -> Result<()> {
        self.push(Job::Publish { temporary: Temporary(temporary.into()), path: path.into() })
    }

    /// As [`Publisher::publish`], and what bears the name until then becomes `previous`.
    ///
    /// # Errors
    /// As [`Publisher::publish`].
    ///
    /// # Parallel
    /// As [`Publisher::publish`].
    pub fn replace(&mut self, temporary: &Path, path: &Path, previous: &Path) -> Result<()> {
        let (temporary, path) = (Temporary(temporary.into()), path.into());
        self.push(Job::Replace { temporary, path, previous: previous.into() })
    }

    /// Writes a text file, as [`Publisher::publish`].
    ///
    /// # Errors
    /// As [`Publisher::publish`].
    ///
    /// # Parallel
    /// Local; call it on rank 0.
    pub fn write_text(&mut self, path: &Path, text: String) -> Result<()> {
        self.push(Job::Text { path: path.into(), text })
    }

    /// Waits until every file has its name.
    ///
    /// # Errors
    /// [`Error::System`] with the path and the reason, for the first file that failed.
    ///
    /// # Parallel
    /// Local.
    pub fn finish(&mut self) -> Result<()> {
        let Some((sender, thread)) = self.running.take() else { return Ok(()) };
        drop(sender);
        thread.join().unwrap_or_else(|_| Err(Error::Bug("the writer of files panicked".into())))
    }

    fn push(&mut self, job: Job) -> Result<()> {
        let (sender, _) = self.running.get_or_insert_with(|| {
            let (sender, jobs) = channel::<Job>();
            let work = move || {
                // An error ends the thread, and with it the queue: the next push tells.
                jobs.iter().try_for_each(|job| match &job {
                    Job::Publish { temporary, path } => atomic::publish(&temporary.0, path),
                    Job::Replace { temporary, path, previous } => {
                        atomic::replace(&temporary.0, path, previous)
                    }
                    Job::Text { path, text } => atomic::write_text(path, text),
                })
            };
            (sender, std::thread::spawn(work))
        });
        if sender.send(job).is_ok() {
            return Ok(());
        }
        self.finish()
    }
}

impl Drop for Publisher {
    fn drop(&mut self) {
        // After an error of something else, which is the one to report.
        let _ = self.finish();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    use rustix::fs::{CWD, FileType, Mode, mknodat};

    #[test]
    fn files_get_their_names_in_order_and_nothing_follows_an_error() {
        let name = format!("column-hpc-publisher-{}", std::process::id());
        let dir = std::env::temp_dir().join(name);
        fs::create_dir_all(&dir).expect("the temporary directory is writable");
        let mut publisher = Publisher::default();
        fs::write(dir.join("a.tmp.1"), "a").unwrap();
        publisher.publish(&dir.join("a.tmp.1"), &dir.join("a")).unwrap();
        publisher.write_text(&dir.join("index"), "a".into()).unwrap();
        publisher.finish().unwrap();
        assert_eq!(fs::read_to_string(dir.join("a")).unwrap(), "a");
        assert_eq!(fs::read_to_string(dir.join("index")).unwrap(), "a");

        publisher.publish(&dir.join("absent"), &dir.join("b")).unwrap();
        let told = (0..2000).find_map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(5));
            fs::write(dir.join("c.tmp.1"), "c").unwrap();
            publisher.publish(&dir.join("c.tmp.1"), &dir.join("c")).err()
        });
        let told = told.expect("the error is told").to_string();
        assert!(told.contains("cannot write") && told.contains("/b"), "{told}");
        assert!(!dir.join("c").exists() && !dir.join("c.tmp.1").exists());

        // What waits behind a file that fails is not left either: here the file is a pipe, which
        // cannot be brought to a disk, and holds the thread until there is a writer.
        let pipe = dir.join("p.tmp.1");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::RWXU, 0).unwrap();
        publisher.publish(&pipe, &dir.join("p")).unwrap();
        fs::write(dir.join("d.tmp.1"), "d").unwrap();
        publisher.publish(&dir.join("d.tmp.1"), &dir.join("d")).unwrap();
        drop(File::options().write(true).open(&pipe).unwrap());
        let told = publisher.finish().unwrap_err().to_string();
        assert!(told.contains("cannot write") && told.contains("/p"), "{told}");
        let left = fs::read_dir(&dir).unwrap().map(|e| e.unwrap().file_name());
        assert_eq!(left.filter(|n| n != "a" && n != "index").count(), 0);
        fs::remove_dir_all(dir).unwrap();
    }
}
