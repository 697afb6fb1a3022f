//! From a file to a whole mesh.

use super::bodies::bodies;
use super::cells::{Cells, collect};
use super::cut::{Copies, cut};
use super::facet::WholeFacet;
use super::facets::FacetTable;
use super::groups::Groups;
use super::plan::{Known, plan};
use super::request::Request;
use super::types::WholeMesh;
use super::words::{count, wrong};
use super::{doubled, jacobian, lips, materials, raise, surfaces, touching};
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::mesh::import::FileMesh;

/// Makes a whole mesh of what a file holds, as a case asks for it.
///
/// # Arguments
/// * `name` of the file, with which every message begins
///
/// # Errors
/// `Input`, with the number of elements concerned, the first of them, its place (m) and a remedy:
/// no cells, cells that are turned over or degenerate, copies of cells, cells of two orders that
/// meet, cells in no or two materials, groups that are not there or lie on no cell, nodes at one
/// place, interfaces that are not where they have to be.
///
/// # Parallel
/// Local.
pub fn build(file: &FileMesh, request: &Request, name: &str) -> Result<WholeMesh> {
    made(file, request).map_err(|error| match error {
        Error::Input(text) => wrong(format!("{name}: {text}")),
        other => other,
    })
}

fn made(file: &FileMesh, request: &Request) -> Result<WholeMesh> {
    let mut remarks = file.remarks.clone();
    let mut cells = collect(file, request.scale, &mut remarks)?;
    raise::raise(&mut cells, request.raise_order, &mut remarks)?;
    remark_on_locking(&cells, &mut remarks);
    jacobian::check(&cells)?;
    let groups = Groups::new(file, cells.dim());
    let materials = materials::assign(&cells, &groups, &request.materials)?;
    let table = FacetTable::new(cells.view());
    let mut mates = table.mates(&cells)?;
    let known = Known { cells: &cells, table: &table, groups: &groups, scale: request.scale };
    let plans = plan(&known, &request.interfaces, &mut remarks)?;
    let find = |name: &String| surfaces::find(&known, name);
    let found = request.surfaces.iter().map(find).collect::<Result<Vec<_>>>()?;
    doubled::check(&cells, &mates, &plans, file)?;
    touching::check(&cells, &mates, &plans)?;
    drop(table);

    let cuts = plans.iter().filter(|plan| plan.is_cut).flat_map(|plan| plan.lips.iter().flatten());
    let cuts: Vec<WholeFacet> = cuts.copied().collect();
    let copies =
        if cuts.is_empty() { Copies::none(&cells) } else { cut(&mut cells, &mut mates, &cuts) };
    let interfaces = lips::make(&cells, &copies, plans, &request.interfaces, &mut remarks)?;
    let mut surfaces = Vec::new();
    for (name, found) in request.surfaces.iter().zip(found) {
        surfaces.push(surfaces::finish(&cells, &mates, &copies, name, found, &mut remarks));
    }
    let (bodies, body_count) = bodies(cells.view());
    let axes: &[usize] = if cells.dim() == 2 { &[0, 1] } else { &[0, 1, 2] };
    let Cells { points, shapes, start, nodes, numbers, .. } = cells;
    Ok(WholeMesh {
        axes,
        points,
        shapes,
        start,
        nodes,
        numbers,
        materials,
        bodies,
        body_count,
        surfaces,
        interfaces,
        remarks,
    })
}

/// Says that simplices of first order lock.
fn remark_on_locking(cells: &Cells, remarks: &mut Vec<String>) {
    let is_stiff = |shape: &&Shape| matches!(shape, Shape::Tri3 | Shape::Tet4);
    let number = cells.shapes.iter().filter(is_stiff).count();
    if number > 0 {
        let kind = match (cells.dim(), number) {
            (2, _) => count(number, "triangle"),
            (_, 1) => "1 tetrahedron".into(),
            _ => format!("{number} tetrahedra"),
        };
        remarks.push(format!(
            "{kind} of first order: they lock, so that the answer is too stiff; \
             `mesh.raise_order: 2` gives them middle nodes"
        ));
    }
}
