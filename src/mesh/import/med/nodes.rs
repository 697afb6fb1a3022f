//! The nodes of a step, and which of them elements use.

use super::archive::{Folder, Told};
use super::cells::{Cells, families, numbers, whole};

/// Nodes as the file has them.
pub struct Nodes {
    /// Their coordinates.
    pub points: Vec<[f64; 3]>,
    /// The file's numbers.
    pub numbers: Vec<u64>,
    /// The number of the family of each.
    pub families: Vec<i64>,
    /// Where the families are told.
    pub path: String,
}

/// Reads the nodes of a step in a space of two or three dimensions; z is 0 in two.
pub fn read(step: &Folder, space: usize) -> Told<Nodes> {
    let folder = step.folder("NOE")?;
    whole(&folder)?;
    let path = folder.inner("COO");
    let file = folder.reals("COO")?;
    let count = folder.rows("COO")?;
    if count.checked_mul(space) != Some(file.len()) {
        return Err(format!(
            "{path}: {} entries where NBR says {count} nodes of {space} coordinates",
            file.len()
        ));
    }
    if count >= u32::MAX as usize {
        return Err(format!("{path}: {count} nodes; at most {} can be read", u32::MAX - 1));
    }
    // All x come before all y.
    if let Some(at) = file.iter().position(|coordinate| !coordinate.is_finite()) {
        return Err(format!(
            "{path}: the coordinate {} of node {} is {}",
            ["x", "y", "z"][at / count],
            at % count + 1,
            file[at]
        ));
    }
    let coordinate = |axis: usize, node| if axis < space { file[axis * count + node] } else { 0.0 };
    let points = (0..count).map(|node| [0, 1, 2].map(|axis| coordinate(axis, node))).collect();
    let numbers = numbers(&folder, count)?;
    let families = families(&folder, count)?;
    Ok(Nodes { points, numbers, families, path: folder.inner("FAM") })
}

/// Drops the nodes that no element uses, with a remark, and numbers the others anew.
pub fn drop_orphans(nodes: &mut Nodes, cells: &mut [Cells], remarks: &mut Vec<String>) {
    let mut names = vec![u32::MAX; nodes.points.len()];
    for node in cells.iter().flat_map(|cells| &cells.nodes) {
        names[*node as usize] = 0;
    }
    let mut kept = 0;
    for (node, name) in names.iter_mut().enumerate() {
        if *name == 0 {
            *name = kept;
            nodes.points[kept as usize] = nodes.points[node];
            nodes.numbers[kept as usize] = nodes.numbers[node];
            nodes.families.swap(kept as usize, node);
            kept += 1;
        }
    }
    let (kept, total) = (kept as usize, nodes.points.len());
    if kept == total {
        return;
    }
    let grouped = nodes.families[kept..].iter().filter(|family| **family != 0).count();
    nodes.points.truncate(kept);
    nodes.numbers.truncate(kept);
    nodes.families.truncate(kept);
    for node in cells.iter_mut().flat_map(|cells| &mut cells.nodes) {
        *node = names[*node as usize];
    }
    let grouped =
        if grouped == 0 { String::new() } else { format!(", of which {grouped} in families") };
    remarks.push(format!(
        "nodes that no element uses are left out: {} of {total}{grouped}",
        total - kept
    ));
}
