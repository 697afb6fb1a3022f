//! The communicator.

use column_hpc::comm::Neighbours;
use column_hpc::error::Error;
use column_hpc::runtime::Runtime;

pub fn reductions(runtime: &Runtime) {
    let comm = &runtime.comm;
    let (rank, size) = (comm.rank() as u64, comm.size() as u64);
    let mut values = [rank as f64, 1.0];
    comm.sum(&mut values);
    assert_eq!(values, [(size * (size - 1) / 2) as f64, size as f64]);
    let mut values = [rank as f64, -(rank as f64)];
    comm.max(&mut values);
    assert_eq!(values, [(size - 1) as f64, 0.0]);
    let mut values = [rank as f64, -(rank as f64)];
    comm.min(&mut values);
    assert_eq!(values, [0.0, -((size - 1) as f64)]);
    // More than 32 bits.
    assert_eq!(comm.sum_u64(1 << 40), size << 40);
    assert_eq!(comm.max_u64(rank), size - 1);
    assert_eq!(comm.exscan_u64(10), 10 * rank);
    assert!(comm.any(rank == size - 1));
    assert!(!comm.any(false));
}

pub fn broadcast_and_root(runtime: &Runtime) {
    let comm = &runtime.comm.duplicate();
    let mine = if comm.is_root() { vec![1, 2, 3] } else { vec![9; 7] };
    assert_eq!(comm.broadcast_bytes(mine), [1, 2, 3]);
    let text = comm.on_root(|| {
        assert!(comm.is_root());
        Ok(b"case".to_vec())
    });
    assert_eq!(text, Ok(b"case".to_vec()));
    let error = Error::Input("case.yaml:3: unknown key".into());
    assert_eq!(comm.on_root(|| Err(error.clone())), Err(error));
}

pub fn exchange_and_gather(runtime: &Runtime) {
    let comm = &runtime.comm;
    let (rank, size) = (comm.rank(), comm.size());
    // Rank r sends r + s values 100 r + s to rank s.
    let send: Vec<Vec<i32>> =
        (0..size).map(|s| vec![100 * rank + s; (rank + s) as usize]).collect();
    for (source, values) in (0..).zip(comm.exchange(&send)) {
        assert_eq!(values, vec![100 * source + rank; (source + rank) as usize]);
    }
    // A list of bytes without any has no address.
    let to_self: Vec<Vec<u8>> = (0..size).map(|s| vec![7; usize::from(s == 0)]).collect();
    for values in comm.exchange(&to_self) {
        assert_eq!(values, vec![7; usize::from(rank == 0)]);
    }
    let mine = vec![f64::from(rank); rank as usize];
    let gathered = comm.gather(&mine);
    assert_eq!(gathered.is_some(), comm.is_root());
    for (source, values) in gathered.into_iter().flatten().enumerate() {
        assert_eq!(values, vec![source as f64; source]);
    }
    // Rows 2 r + 1 and 2 r, in this order, of two values each.
    let numbers = [2 * rank as u64 + 1, 2 * rank as u64];
    let values = numbers.map(|n| [n as f64, -(n as f64)]).concat();
    if let Some((numbers, values)) = comm.to_root_rows(&numbers, 2, &values) {
        assert_eq!(numbers, (0..2 * size as u64).collect::<Vec<_>>());
        let expected: Vec<f64> = (0..2 * size).flat_map(|n| [n.into(), -f64::from(n)]).collect();
        assert_eq!(values, expected);
    }
}

pub fn agree_on_an_error(runtime: &Runtime) {
    let comm = &runtime.comm;
    let (rank, size) = (comm.rank(), comm.size());
    assert_eq!(comm.agree(Ok(rank)), Ok(rank));
    let prefix = |failing: i32| if size > 1 { format!("rank {failing}: ") } else { String::new() };
    // The lowest of the ranks that fail speaks for all; here all but the first (if there are more).
    let first = i32::from(size > 1);
    let local = if rank >= first {
        Err(Error::Numerics(format!("negative volume in cell {rank}")))
    } else {
        Ok(())
    };
    let expected = format!("{}negative volume in cell {first}", prefix(first));
    assert_eq!(comm.agree(local), Err(Error::Numerics(expected)));
    // Input errors are about the case, not about a rank.
    let last = size - 1;
    let local = if rank == last { Err(Error::Input("E must be positive".into())) } else { Ok(()) };
    assert_eq!(comm.agree(local), Err(Error::Input("E must be positive".into())));
    // A long text is cut, and not in the middle of a character.
    let local = if rank == last { Err(Error::System("é".repeat(5000))) } else { Ok(()) };
    match comm.agree(local) {
        Err(Error::System(text)) => {
            assert!(text.len() <= 4100 && text.ends_with("é…"), "{} bytes", text.len());
        }
        other => panic!("{other:?}"),
    }
}

pub fn neighbours(runtime: &Runtime) {
    let comm = &runtime.comm;
    let (rank, size) = (comm.rank(), comm.size());
    // A chain: r values to the left, 2 to the right.
    let mut send = Vec::new();
    let mut receive = Vec::new();
    if rank > 0 {
        send.push((rank - 1, rank as usize));
        receive.push((rank - 1, 2));
    }
    if rank + 1 < size {
        send.push((rank + 1, 2));
        receive.push((rank + 1, rank as usize + 1));
    }
    let plan = Neighbours::new(comm, send.clone(), receive).expect("a chain");
    for width in [1, 3] {
        let outgoing = vec![f64::from(rank); width * plan.send_len()];
        let mut incoming = vec![f64::NAN; width * plan.receive_len()];
        plan.exchange_wide(width, &outgoing, &mut incoming);
        let mut expected = Vec::new();
        if rank > 0 {
            expected.extend(vec![f64::from(rank - 1); 2 * width]);
        }
        if rank + 1 < size {
            expected.extend(vec![f64::from(rank + 1); (rank as usize + 1) * width]);
        }
        assert_eq!(incoming, expected);
    }
    let outgoing = vec![rank as u64; plan.send_len()];
    let mut incoming = vec![u64::MAX; plan.receive_len()];
    plan.exchange(&outgoing, &mut incoming);
    assert!(incoming.iter().all(|&source| source.abs_diff(rank as u64) == 1));
    // Two sides that disagree are found before they wait for each other.
    if size > 1 {
        assert!(matches!(Neighbours::new(comm, send, Vec::new()), Err(Error::Bug(_))));
    }
}
