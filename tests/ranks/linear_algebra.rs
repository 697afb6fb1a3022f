//! Vectors and matrices.

use column_hpc::comm::Comm;
use column_hpc::error::Error;
use column_hpc::petsc::{Matrix, Petsc, Vector};
use column_hpc::runtime::Runtime;

/// Rows of this rank out of `n`, as evenly as it goes: first, number.
pub fn share(comm: &Comm, n: usize) -> (usize, usize) {
    let (rank, size) = (comm.rank() as usize, comm.size() as usize);
    let first = |r: usize| n * r / size;
    (first(rank), first(rank + 1) - first(rank))
}

/// A preallocated matrix with three entries in each row of `n`.
pub fn tridiagonal(petsc: &Petsc, n: usize) -> Matrix {
    let (first, owned) = share(petsc.comm(), n);
    let (mut inner, mut outer) = (Vec::new(), Vec::new());
    for row in first..first + owned {
        let columns = [row.wrapping_sub(1), row, row + 1];
        let here = (first..first + owned, 0..n);
        let local = columns.iter().filter(|c| here.0.contains(c)).count();
        let valid = columns.iter().filter(|c| here.1.contains(c)).count();
        inner.push(local as i32);
        outer.push((valid - local) as i32);
    }
    Matrix::new(petsc, owned, 1, &inner, &outer).expect("a tridiagonal matrix")
}

/// Adds two-node elements that the rank of their left node computes.
fn add_elements(matrix: &mut Matrix, comm: &Comm, n: usize) {
    let (first, owned) = share(comm, n);
    for left in first..(first + owned).min(n - 1) {
        let nodes = [left as i32, left as i32 + 1];
        matrix.add_blocked(&nodes, &nodes, &[1.0, -1.0, -1.0, 1.0]).expect("within the pattern");
    }
    matrix.assemble().expect("assembly");
}

pub fn vectors(runtime: &Runtime) {
    let petsc = &runtime.petsc;
    let size = runtime.comm.size() as usize;
    let mut x = Vector::new(petsc, 6, 3).expect("a vector");
    assert!(x.read().expect("a view").iter().all(|&v| v == 0.0));
    x.write().expect("a view").fill(2.0);
    assert!((x.norm2().expect("a norm") - (24.0 * size as f64).sqrt()).abs() < 1e-12);
    let mut y = x.duplicate().expect("a copy");
    assert_eq!(y.norm2(), Ok(0.0));
    y.copy_from(&x).expect("same layout");
    assert_eq!(&y.read().expect("a view")[..], [2.0; 6]);
    y.zero().expect("zero");
    assert_eq!(y.norm2(), Ok(0.0));
    assert!(matches!(Vector::new(petsc, 7, 3), Err(Error::Bug(_))));
    let other = Vector::new(petsc, 3, 3).expect("a vector");
    assert!(matches!(y.copy_from(&other), Err(Error::Bug(_))));
    // A rank may own nothing.
    let owned = if runtime.comm.is_root() { 3 } else { 0 };
    let mut z = Vector::new(petsc, owned, 3).expect("a vector");
    z.write().expect("a view").fill(1.0);
    assert!((z.norm2().expect("a norm") - 3f64.sqrt()).abs() < 1e-12);
}

pub fn laplacian(runtime: &Runtime) {
    let (comm, n) = (&runtime.comm, 11);
    let (first, owned) = share(comm, n);
    let mut matrix = tridiagonal(&runtime.petsc, n);
    let mut x = Vector::new(&runtime.petsc, owned, 1).expect("a vector");
    let mut y = x.duplicate().expect("a vector");
    for (i, v) in x.write().expect("a view").iter_mut().enumerate() {
        *v = ((first + i) as f64).powi(2);
    }
    // A second assembly after zeroing gives the same.
    for _ in 0..2 {
        matrix.zero().expect("zero");
        add_elements(&mut matrix, comm, n);
        assert_eq!(matrix.nonzeros(), Ok(3 * n as u64 - 2));
        assert!(matrix.memory().expect("memory") > 8 * (3 * n as u64 - 2));
        matrix.multiply(&x, &mut y).expect("a product");
        for (i, &v) in y.read().expect("a view").iter().enumerate() {
            let expected = match first + i {
                0 => -1.0,
                row if row == n - 1 => (2 * n - 3) as f64,
                _ => -2.0,
            };
            assert_eq!(v, expected, "row {}", first + i);
        }
    }
    // Rows may be zeroed from any rank, and can be filled again.
    let rows = if comm.is_root() { vec![0, n as i32 - 1] } else { Vec::new() };
    matrix.zero_rows_keep_pattern(&rows).expect("rows");
    assert_eq!(matrix.nonzeros(), Ok(3 * n as u64 - 2));
    if comm.is_root() {
        matrix.set(&[n as i32 - 1], &[n as i32 - 2, n as i32 - 1], &[0.0, 5.0]).expect("a row");
    }
    matrix.assemble().expect("assembly");
    matrix.multiply(&x, &mut y).expect("a product");
    let y = y.read().expect("a view");
    if first == 0 {
        assert_eq!(y[0], 0.0);
    }
    if first + owned == n {
        assert_eq!(y[owned - 1], 5.0 * ((n - 1) as f64).powi(2));
    }
}

pub fn blocks(runtime: &Runtime) {
    // One block row of 2 per rank; each rank adds the coupling with the next, whose rows it does
    // not own, and a negative number is skipped.
    let petsc = &runtime.petsc;
    let (rank, size) = (runtime.comm.rank(), runtime.comm.size());
    let off = i32::from(rank > 0) + i32::from(rank + 1 < size);
    let mut matrix = Matrix::new(petsc, 2, 2, &[1], &[off]).expect("a matrix");
    assert_eq!((matrix.owned_rows(), matrix.block_size()), (2, 2));
    let next = if rank + 1 < size { rank + 1 } else { -1 };
    #[rustfmt::skip]
    let values = [
        2.0, 0.5, -1.0, 0.0,
        0.5, 2.0, 0.0, -1.0,
        -1.0, 0.0, 1.0, 0.0,
        0.0, -1.0, 0.0, 1.0,
    ];
    matrix.add_blocked(&[rank, next], &[rank, next], &values).expect("within the pattern");
    matrix.add(&[2 * rank], &[2 * rank, -1], &[10.0, 99.0]).expect("within the pattern");
    matrix.assemble().expect("assembly");
    let mut x = Vector::new(petsc, 2, 2).expect("a vector");
    x.write().expect("a view").copy_from_slice(&[1.0, 2.0]);
    let mut y = x.duplicate().expect("a vector");
    matrix.multiply(&x, &mut y).expect("a product");
    // From the left neighbour a row gets 1 - 1 = 0 in all.
    let right = if rank + 1 < size { -1.0 } else { 0.0 };
    let expected = [13.0 + right, 4.5 + 2.0 * right];
    assert_eq!(&y.read().expect("a view")[..], expected);
    matrix.set_rigid_body_near_null_space(&x).expect("motions of the plane");
}

pub fn wrong_entries_are_errors(runtime: &Runtime) {
    let petsc = &runtime.petsc;
    assert!(matches!(Matrix::new(petsc, 5, 2, &[1, 1], &[0, 0]), Err(Error::Bug(_))));
    assert!(matches!(Matrix::new(petsc, 4, 2, &[1], &[0, 0]), Err(Error::Bug(_))));
    let mut matrix = tridiagonal(petsc, 8);
    assert!(matches!(matrix.add(&[0], &[8], &[1.0]), Err(Error::Bug(_))));
    assert!(matches!(matrix.add(&[0], &[0], &[1.0, 2.0]), Err(Error::Bug(_))));
    add_elements(&mut matrix, &runtime.comm, 8);
    let (first, _) = share(&runtime.comm, 8);
    let far = (first as i32 + 5) % 8;
    match matrix.add(&[first as i32], &[far], &[1.0]).and_then(|()| matrix.assemble()) {
        Err(Error::System(text)) => {
            assert!(text.contains("PETSc error 63"), "{text}");
            assert!(text.contains("ew nonzero") && text.contains("\n    at "), "{text}");
        }
        other => panic!("an entry outside the pattern gave {other:?}"),
    }
    let x = Vector::new(petsc, 3, 1).expect("a vector");
    let mut y = x.duplicate().expect("a vector");
    let small = tridiagonal(petsc, 4 * runtime.comm.size() as usize);
    assert!(matches!(small.multiply(&x, &mut y), Err(Error::Bug(_))));
}

pub fn log_stages(runtime: &Runtime) {
    for _ in 0..2 {
        let _outer = runtime.petsc.stage("assembly").expect("a stage");
        let _inner = runtime.petsc.stage("solve").expect("a stage");
    }
}
