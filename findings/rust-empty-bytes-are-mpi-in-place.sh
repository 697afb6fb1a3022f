#!/usr/bin/env bash
# An empty slice of bytes that Rust hands to MPI is taken for MPI_IN_PLACE.
#
# Versions: Open MPI 4.1.4 (Debian 12), rsmpi (crate mpi) 0.8.2, Rust 1.88 or newer.
#
# Input: two ranks; rank 0 sends four bytes to each rank with MPI_Alltoallv, rank 1 sends none. The
# counts fit each other, and every buffer is a slice that lives through the call. The same program
# runs twice: with bytes, and with 64-bit numbers.
#
# Expected: both ranks receive what rank 0 has sent, whatever the type.
#
# What happens instead: an empty Vec<u8> has no memory, and its pointer is the alignment of its
# type: 1 for bytes, 8 for 64-bit numbers. Open MPI defines MPI_IN_PLACE as the address 1. Rank 1
# seems to say that its data lie in the receive buffer, sends the four bytes that it expects to
# receive, and rank 0, which expects none, ends with MPI_ERR_TRUNCATE. With 64-bit numbers all is
# well. An empty slice of a vector that has memory of its own (Vec::with_capacity(1)) is well too.
#
# Output seen:
#   u64 as it is: received
#   u8 as it is: MPI_ERR_TRUNCATE: message truncated
#   u8 with memory: received
#
# Why it matters: the error names the rank that did nothing wrong, and shows only where a rank has
# nothing to send: with bytes, and not with the types that are tried first. Whoever sends bytes
# (serialised data) with a collective of varying counts has to give empty buffers an address.
set -euo pipefail

for tool in cargo mpicc mpirun; do
    command -v "$tool" >/dev/null || { echo "$tool is missing"; exit 2; }
done
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
cd "$tmp"
mkdir src
cat >Cargo.toml <<'TOML'
[package]
name = "empty"
version = "0.0.0"
edition = "2021"
[dependencies]
mpi = "=0.8.2"
TOML
cat >src/main.rs <<'RUST'
use mpi::datatype::{Partition, PartitionMut};
use mpi::traits::*;

fn exchange<T: Equivalence + Copy + Default>(world: &impl Communicator, reserved: usize) {
    let (rank, ranks) = (world.rank(), world.size() as usize);
    let each = if rank == 0 { 4 } else { 0 };
    let mut send: Vec<T> = Vec::with_capacity(reserved);
    send.extend(vec![T::default(); each * ranks]);
    let (send_counts, send_starts) = (vec![each as i32; ranks], starts(each as i32, ranks));
    let receive_counts: Vec<i32> = (0..ranks).map(|from| if from == 0 { 4 } else { 0 }).collect();
    let receive_starts: Vec<i32> = (0..ranks).map(|from| if from == 0 { 0 } else { 4 }).collect();
    let mut received = vec![T::default(); 4];
    {
        let outgoing = Partition::new(&send[..], &send_counts[..], &send_starts[..]);
        let mut incoming =
            PartitionMut::new(&mut received[..], &receive_counts[..], &receive_starts[..]);
        world.all_to_all_varcount_into(&outgoing, &mut incoming);
    }
    println!("received");
}

fn starts(each: i32, ranks: usize) -> Vec<i32> {
    (0..ranks as i32).map(|rank| rank * each).collect()
}

fn main() {
    let universe = mpi::initialize().expect("one start");
    let world = universe.world();
    match std::env::args().nth(1).as_deref() {
        Some("u64") => exchange::<u64>(&world, 0),
        Some("u8") => exchange::<u8>(&world, 0),
        _ => exchange::<u8>(&world, 1),
    }
}
RUST
cargo build --quiet 2>build.log || { echo "the program cannot be built:"; tail -n 5 build.log; exit 2; }
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1
look() {
    timeout 60 mpirun -n 2 target/debug/empty "$1" >out.log 2>&1 || true
    if grep -q MPI_ERR_TRUNCATE out.log; then
        echo "MPI_ERR_TRUNCATE: message truncated"
    elif [ "$(grep -c '^received$' out.log)" -eq 2 ]; then
        echo "received"
    else
        echo "something else: $(head -n 1 out.log)"
    fi
}
{
    echo "u64 as it is: $(look u64)"
    echo "u8 as it is: $(look u8)"
    echo "u8 with memory: $(look reserved)"
} | tee seen.log
sed -n '/^# Output seen:/,/^#$/s/^#   //p' "$OLDPWD/$0" >expected.log 2>/dev/null ||
    printf '%s\n' "u64 as it is: received" "u8 as it is: MPI_ERR_TRUNCATE: message truncated" \
        "u8 with memory: received" >expected.log
diff expected.log seen.log && echo "as described"
