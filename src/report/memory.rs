//! The largest memory that a run held.

use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::CommunicatorCollectives;

/// Largest resident memory of every rank so far, summed in bytes; none if a rank's system does not
/// tell.
///
/// # Parallel
/// Collective.
pub fn peak(comm: &SimpleCommunicator) -> Option<u64> {
    let own = std::fs::read_to_string("/proc/self/status").ok().and_then(|s| high_water_mark(&s));
    let own = [own.unwrap_or(0), u64::from(own.is_none())];
    let mut sum = [0u64; 2];
    comm.all_reduce_into(&own[..], &mut sum[..], SystemOperation::sum());
    (sum[1] == 0).then_some(sum[0])
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
