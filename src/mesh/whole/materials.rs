//! Materials of cells by their groups.

use super::cells::{Cells, first_of};
use super::groups::Groups;
use super::request::MaterialGroups;
use super::words::wrong;
use crate::error::Result;

/// The index of the material of each cell.
///
/// # Errors
/// `Input` for groups that are not there, and for cells in no or in two materials.
pub fn assign(cells: &Cells, groups: &Groups, materials: &[MaterialGroups]) -> Result<Vec<u32>> {
    let of_sets = of_sets(groups, &cells.group_sets, materials)?;
    let of_cell = |cell: usize| &of_sets[cells.sets[cell] as usize];
    let with = |is: fn(usize) -> bool| -> Vec<usize> {
        (0..cells.sets.len()).filter(|cell| is(of_cell(*cell).len())).collect()
    };
    let bare = with(|count| count == 0);
    if !bare.is_empty() {
        return Err(wrong(format!(
            "in no material: {}; name its group in a material's `on`, or leave it out of the mesh",
            first_of(cells, &bare)
        )));
    }
    let double = with(|count| count > 1);
    if let Some(first) = double.first() {
        let names: Vec<String> = of_cell(*first)
            .iter()
            .map(|material| format!("`{}`", materials[*material as usize].name))
            .collect();
        return Err(wrong(format!(
            "in the materials {} at once: {}; give each cell one of them",
            names.join(" and "),
            first_of(cells, &double)
        )));
    }
    Ok((0..cells.sets.len()).map(|cell| of_cell(cell)[0]).collect())
}

/// The materials of each set of groups, rising: of a set that cells can have there is one.
///
/// # Errors
/// `Input` for groups that are not there.
pub fn of_sets(
    groups: &Groups,
    sets: &[Vec<u32>],
    materials: &[MaterialGroups],
) -> Result<Vec<Vec<u32>>> {
    if let [only] = materials
        && only.groups.is_empty()
    {
        return Ok(vec![vec![0]; sets.len()]);
    }
    if let Some(idle) = materials.iter().find(|material| material.groups.is_empty()) {
        return Err(wrong(format!(
            "the material `{}` names no group of cells; give them with `on`",
            idle.name
        )));
    }
    let mut of_groups = Vec::new();
    for (index, material) in materials.iter().enumerate() {
        for name in &material.groups {
            let whose = format!("material `{}`", material.name);
            of_groups.push((groups.of_cells(name, &whose)?, index as u32));
        }
    }
    let of_set = |set: &Vec<u32>| {
        let of_group = of_groups.iter().filter(|(group, _)| set.contains(group));
        let mut found: Vec<u32> = of_group.map(|(_, material)| *material).collect();
        found.sort_unstable();
        found.dedup();
        found
    };
    Ok(sets.iter().map(of_set).collect())
}
