//! The fence of METIS.
#![allow(unsafe_code)]

use crate::error::{Error, Result};
use crate::petsc::ffi;

/// Cuts a weighted graph into `parts`; returns the part of each vertex. Local.
///
/// `start` and `neighbours` are the compressed adjacency (every edge stands twice), `weights` one
/// weight per entry of `neighbours`, `work` that of each vertex.
///
/// # Errors
/// `System` when METIS refuses the graph or runs out of memory.
pub fn cut(
    start: &[i32],
    neighbours: &[i32],
    weights: &[i32],
    work: &[i32],
    parts: usize,
) -> Result<Vec<i32>> {
    let vertices = start.len() - 1;
    assert_eq!(neighbours.len(), weights.len());
    assert_eq!(work.len(), vertices);
    assert_eq!(start[vertices] as usize, neighbours.len());
    assert!(neighbours.iter().all(|n| (0..vertices as i32).contains(n)));
    // METIS takes mutable pointers to everything.
    let (mut start, mut neighbours) = (start.to_vec(), neighbours.to_vec());
    let (mut weights, mut work) = (weights.to_vec(), work.to_vec());
    let mut part = vec![0; vertices];
    let (mut vertices, mut constraints) = (vertices as i32, 1);
    let (mut parts_wanted, mut edge_cut) = (parts as i32, 0);
    let mut options = [0; ffi::METIS_NOPTIONS as usize];
    // SAFETY: `options` has METIS_NOPTIONS entries.
    unsafe { ffi::METIS_SetDefaultOptions(options.as_mut_ptr()) };
    options[ffi::METIS_OPTION_SEED as usize] = 1;
    // Recursive bisection balances better for a few parts, k-way is faster for many.
    let method = if parts <= 8 { ffi::METIS_PartGraphRecursive } else { ffi::METIS_PartGraphKway };
    // SAFETY: the graph is consistent (asserted above), the arrays outlive the call, `part` has
    // one entry per vertex, and METIS takes null for sizes and targets that are not given.
    let status = unsafe {
        method(
            &mut vertices,
            &mut constraints,
            start.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            work.as_mut_ptr(),
            std::ptr::null_mut(),
            weights.as_mut_ptr(),
            &mut parts_wanted,
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            options.as_mut_ptr(),
            &mut edge_cut,
            part.as_mut_ptr(),
        )
    };
    if status == ffi::METIS_OK {
        Ok(part)
    } else {
        Err(Error::System(format!(
            "METIS could not cut {vertices} cells into {parts} parts (status {status})"
        )))
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_path_is_cut_at_its_light_edge() {
        // 0 - 1 = 2 - 3: the middle edge is heavy, so 4 vertices in 2 equal parts would cut it;
        // a path of 6 with one light edge in the middle is cut there.
        let start = [0, 1, 3, 5, 7, 9, 10];
        let neighbours = [1, 0, 2, 1, 3, 2, 4, 3, 5, 4];
        let weights = [8, 8, 8, 8, 1, 1, 8, 8, 8, 8];
        let part = super::cut(&start, &neighbours, &weights, &[1; 6], 2).expect("a valid graph");
        assert_eq!(part[0], part[2]);
        assert_eq!(part[3], part[5]);
        assert_ne!(part[0], part[5]);
    }
}
