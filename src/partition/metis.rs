//! The fence of METIS.
#![allow(unsafe_code)]

use crate::error::{Error, Result};
use crate::petsc::ffi;

/// Below so many cells per part k-way cuts badly.
const SMALL: usize = 64;

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
    // Recursive bisection balances better for a few parts, k-way is faster for many; where they are
    // small it leaves parts torn, or without a cell.
    let recursive = parts <= 8 || work.len() < SMALL * parts;
    let method = if recursive { ffi::METIS_PartGraphRecursive } else { ffi::METIS_PartGraphKway };
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
        fill_empty(&mut part, &work, parts);
        Ok(part)
    } else {
        Err(Error::System(format!(
            "METIS could not cut {vertices} cells into {parts} parts (status {status})"
        )))
    }
}

/// Gives each part without a cell one of the heaviest part, as long as there are two. METIS may
/// leave parts empty where weights differ much.
fn fill_empty(part: &mut [i32], work: &[i32], parts: usize) {
    let (mut cells, mut load) = (vec![0; parts], vec![0_i64; parts]);
    for (part, work) in part.iter().zip(work) {
        cells[*part as usize] += 1;
        load[*part as usize] += i64::from(*work);
    }
    for empty in 0..parts {
        if cells[empty] > 0 {
            continue;
        }
        let heaviest = (0..parts).filter(|p| cells[*p] > 1).max_by_key(|p| load[*p]);
        let Some(heaviest) = heaviest else { return };
        // Its last cell: those before stay together.
        let Some(cell) = part.iter().rposition(|p| *p as usize == heaviest) else { return };
        part[cell] = empty as i32;
        (cells[empty], load[empty]) = (1, i64::from(work[cell]));
        cells[heaviest] -= 1;
        load[heaviest] -= i64::from(work[cell]);
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_part_without_a_cell_gets_one_of_the_heaviest() {
        let mut part = [0, 0, 2, 2, 2, 4];
        super::fill_empty(&mut part, &[9, 9, 1, 1, 1, 50], 5);
        assert_eq!(part, [0, 1, 2, 2, 3, 4]);
        // More parts than cells.
        let mut part = [0, 0];
        super::fill_empty(&mut part, &[1, 1], 4);
        assert_eq!(part, [0, 1]);
    }

    /// A column of 4 x 4 x 56 cells in 64 parts of 14: k-way left many of them in two pieces.
    #[test]
    fn small_parts_are_in_one_piece_and_have_cells() {
        let [nx, ny, nz] = [4, 4, 56];
        let cells = nx * ny * nz;
        let (mut start, mut neighbours) = (vec![0], Vec::new());
        for cell in 0..cells {
            let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            for (axis, (extent, stride)) in [(nx, 1), (ny, nx), (nz, nx * ny)].iter().enumerate() {
                neighbours.extend((at[axis] > 0).then(|| (cell - stride) as i32));
                neighbours.extend((at[axis] + 1 < *extent).then(|| (cell + stride) as i32));
            }
            start.push(neighbours.len() as i32);
        }
        let (weights, work) = (vec![1; neighbours.len()], vec![1; cells]);
        let part = super::cut(&start, &neighbours, &weights, &work, 64).expect("a valid graph");
        let mut pieces = [0; 64];
        let mut seen = vec![false; cells];
        for first in 0..cells {
            if seen[first] {
                continue;
            }
            pieces[part[first] as usize] += 1;
            let mut stack = vec![first];
            while let Some(cell) = stack.pop() {
                if std::mem::replace(&mut seen[cell], true) {
                    continue;
                }
                let own = &neighbours[start[cell] as usize..start[cell + 1] as usize];
                let same = own.iter().map(|n| *n as usize).filter(|n| part[*n] == part[cell]);
                stack.extend(same);
            }
        }
        assert!(pieces.iter().all(|pieces| *pieces > 0), "{pieces:?}");
        let torn = pieces.iter().filter(|pieces| **pieces > 1).count();
        assert_eq!(torn, 0, "{pieces:?}");
    }

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
