//! The largest memory that a run held.

use crate::comm::Comm;

/// Largest resident memory of every rank so far, summed in bytes; none if a rank's system does not
/// tell.
///
/// # Parallel
/// Collective.
pub fn peak(comm: &Comm) -> Option<u64> {
    let own = entry("/proc/self/status", HIGH_WATER_MARK);
    let unknown = comm.any(own.is_none());
    let sum = comm.sum_u64(own.unwrap_or(0));
    (!unknown).then_some(sum)
}

/// Largest resident memory in `/proc/PID/status`.
const HIGH_WATER_MARK: &str = "VmHWM:";

/// An entry of a file of `/proc` in which sizes stand line by line, in bytes; none where there is
/// none. Local.
pub fn entry(file: &str, name: &str) -> Option<u64> {
    read(&std::fs::read_to_string(file).ok()?, name)
}

fn read(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_is_read_in_bytes() {
        let text = "Name:\tcolumn-hpc\nVmPeak:\t  999 kB\nVmHWM:\t   10240 kB\nThreads:\t1\n";
        assert_eq!(read(text, HIGH_WATER_MARK), Some(10_485_760));
        assert_eq!(read("Name:\tcolumn-hpc\n", HIGH_WATER_MARK), None);
    }

    #[test]
    fn this_process_holds_more_than_a_megabyte() {
        assert!(entry("/proc/self/status", HIGH_WATER_MARK).expect("Linux tells") > 1 << 20);
    }
}
