//! The largest memory that a run held.

use crate::comm::Comm;

/// Largest resident memory of every rank so far, summed in bytes; none if a rank's system does not
/// tell.
///
/// # Parallel
/// Collective.
pub fn peak(comm: &Comm) -> Option<u64> {
    let own = std::fs::read_to_string("/proc/self/status").ok().and_then(|s| high_water_mark(&s));
    let unknown = comm.any(own.is_none());
    let sum = comm.sum_u64(own.unwrap_or(0));
    (!unknown).then_some(sum)
}

/// `VmHWM` of the text of `/proc/PID/status` in bytes.
fn high_water_mark(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_is_read_in_bytes() {
        let text = "Name:\tcolumn-hpc\nVmPeak:\t  999 kB\nVmHWM:\t   10240 kB\nThreads:\t1\n";
        assert_eq!(high_water_mark(text), Some(10_485_760));
        assert_eq!(high_water_mark("Name:\tcolumn-hpc\n"), None);
    }

    #[test]
    fn this_process_holds_more_than_a_megabyte() {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        assert!(high_water_mark(&status).unwrap() > 1 << 20);
    }
}
