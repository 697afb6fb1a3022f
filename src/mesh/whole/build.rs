//! From a file to a whole mesh.

use super::along_axes::lay_along_axes;
use super::bodies::bodies_of;
use super::cells::{Cells, collect};
use super::coarsen::{self, Coarser};
use super::cut::{Copies, cut};
use super::facet::WholeFacet;
use super::facets::FacetTable;
use super::groups::Groups;
use super::hinges::hinges;
use super::plan::{Known, Plan, plan};
use super::refine::{Parent, Refiner};
use super::request::Request;
use super::types::WholeMesh;
use super::words::{count, wrong};
use super::{divide, doubled, jacobian, lips, materials, raise, refine, surfaces, touching};
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::mesh::facts::Hinges;
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
/// place, interfaces that are not where they have to be, more refinements than can be numbered.
///
/// # Parallel
/// Local.
pub fn build(file: &FileMesh, request: &Request, name: &str) -> Result<WholeMesh> {
    let mut meshes = nested(file, request, name, Keep::Finest)?;
    meshes.pop().ok_or_else(|| Error::Bug("no mesh of the file".into()))
}

/// Which meshes are wanted where one is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// The finest one.
    Finest,
    /// All that can be made, coarsest first: an interface that cuts nothing in a coarse mesh leaves
    /// it and those below out.
    All,
}

/// As [`build`], with coarser meshes before the finest.
///
/// # Errors
/// As [`build`].
pub fn nested(
    file: &FileMesh,
    request: &Request,
    name: &str,
    keep: Keep,
) -> Result<Vec<WholeMesh>> {
    made(file, request, keep).map_err(|error| match error {
        Error::Input(text) => wrong(format!("{name}: {text}")),
        other => other,
    })
}

fn made(file: &FileMesh, request: &Request, keep: Keep) -> Result<Vec<WholeMesh>> {
    let mut remarks = file.remarks.clone();
    let divided = divided(file, request, &mut remarks)?;
    let file = divided.as_ref().unwrap_or(file);
    let mut cells = collect(file, request.scale, &mut remarks)?;
    raise::raise(&mut cells, request.raise_order, &mut remarks)?;
    lay_along_axes(&mut cells);
    refine::check(&cells, request.refine)?;
    // What is wrong is told of the elements that are in the file.
    let found = Found::new(file, &cells, request)?;
    let none = (Vec::new(), Vec::new());
    let (mut meshes, parents) =
        if keep == Keep::All { coarser(file, &cells, &found, request) } else { none };
    if request.refine == 0 {
        meshes.push(WholeMesh { parents, ..cut_up(cells, found, request, remarks)? });
        return Ok(meshes);
    }
    if keep == Keep::All {
        match cut_up(cells.clone(), found, request, Vec::new()) {
            Ok(mesh) => meshes.push(WholeMesh { parents, ..mesh }),
            Err(_) => meshes.clear(),
        }
    }
    let (before, scale) = (cells.shapes.len(), 1.0);
    let request = Request { scale, ..request.clone() };
    let mut refiner = Refiner::new(file, cells);
    for time in 1..=request.refine {
        let parents = refiner.refine();
        let is_last = time == request.refine;
        if !is_last && keep == Keep::Finest {
            continue;
        }
        let (file, cells) = refiner.mesh(is_last);
        let mut said = Vec::new();
        if is_last {
            said.append(&mut remarks);
            let times = if time == 1 { "once" } else { &format!("{time} times") };
            let number = count(before, "cell");
            said.push(format!("{number} refined {times} to {}", cells.shapes.len()));
        }
        let found = Found::new(&file, &cells, &request);
        match found.and_then(|found| cut_up(cells, found, &request, said)) {
            Ok(mesh) => meshes.push(WholeMesh { parents, ..mesh }),
            Err(error) if is_last => return Err(error),
            Err(_) => meshes.clear(),
        }
    }
    meshes[0].parents.clear();
    Ok(meshes)
}

/// The coarser meshes that the mesh of a file has of itself, coarsest first, and where the cells of
/// the mesh lie in the last one.
fn coarser(
    file: &FileMesh,
    cells: &Cells,
    found: &Found,
    request: &Request,
) -> (Vec<WholeMesh>, Vec<Parent>) {
    let is_second = cells.shapes.iter().any(|shape| shape.order() > 1);
    let next = if is_second {
        Some(coarsen::of_first_order(file, cells))
    } else {
        coarsen::coarser(file, cells, &found.table, &found.mates)
    };
    let made = next.and_then(|Coarser { file, cells, parents }| {
        let request = Request { scale: 1.0, ..request.clone() };
        let found = Found::new(&file, &cells, &request).ok()?;
        let (mut meshes, of_these) = coarser(&file, &cells, &found, &request);
        if is_second && meshes.is_empty() {
            return None;
        }
        let mesh = cut_up(cells, found, &request, Vec::new()).ok()?;
        meshes.push(WholeMesh { parents: of_these, ..mesh });
        Some((meshes, parents))
    });
    made.unwrap_or_default()
}

/// The mesh of the file with facets divided where a case asks for that.
fn divided(
    file: &FileMesh,
    request: &Request,
    remarks: &mut Vec<String>,
) -> Result<Option<FileMesh>> {
    if request.divided.is_empty() {
        return Ok(None);
    }
    let mut cells = collect(file, request.scale, &mut Vec::new())?;
    raise::raise(&mut cells, None, &mut Vec::new())?;
    let is_raised = request.raise_order == Some(2);
    let (file, number) = divide::divide(file, &cells, &request.divided, is_raised);
    if number > 0 {
        remarks.push(format!(
            "{} of interfaces without a node that could carry a traction got nodes inside, and the \
             cells beside them one in the middle",
            count(number, "facet")
        ));
    }
    Ok(Some(file))
}

/// What a case asks for, found in the cells of a mesh that is not cut yet.
struct Found {
    materials: Vec<u32>,
    table: FacetTable,
    mates: Vec<u32>,
    plans: Vec<Plan>,
    surfaces: Vec<surfaces::Found>,
    remarks: Vec<String>,
}

impl Found {
    /// Checks the cells too.
    fn new(file: &FileMesh, cells: &Cells, request: &Request) -> Result<Self> {
        let mut remarks = Vec::new();
        remark_on_locking(cells, &mut remarks);
        jacobian::check(cells)?;
        let groups = Groups::new(file, cells);
        let materials = materials::assign(cells, &groups, &request.materials)?;
        let table = FacetTable::new(cells.view());
        let mates = table.mates(cells)?;
        let known = Known { cells, table: &table, groups: &groups, scale: request.scale };
        let plans = plan(&known, &request.interfaces, &mut remarks)?;
        let find = |name: &String| surfaces::find(&known, name);
        let surfaces = request.surfaces.iter().map(find).collect::<Result<Vec<_>>>()?;
        if request.refine > 0 {
            remark_on_lone_nodes(&groups, request, &mut remarks);
        }
        doubled::check(cells, &mates, &plans, file)?;
        touching::check(cells, &mates, &plans)?;
        Ok(Self { materials, table, mates, plans, surfaces, remarks })
    }
}

/// Cuts the mesh along its interfaces.
fn cut_up(
    mut cells: Cells,
    found: Found,
    request: &Request,
    mut remarks: Vec<String>,
) -> Result<WholeMesh> {
    let Found { materials, mut mates, plans, surfaces: of_request, remarks: more, .. } = found;
    remarks.extend(more);
    let cuts = plans.iter().filter(|plan| plan.is_cut).flat_map(|plan| plan.lips.iter().flatten());
    let cuts: Vec<WholeFacet> = cuts.copied().collect();
    let copies =
        if cuts.is_empty() { Copies::none(&cells) } else { cut(&mut cells, &mut mates, &cuts) };
    let interfaces = lips::make(&cells, &copies, plans, &request.interfaces, &mut remarks)?;
    let mut surfaces = Vec::new();
    for (name, found) in request.surfaces.iter().zip(of_request) {
        surfaces.push(surfaces::finish(&cells, &mates, &copies, name, found, &mut remarks));
    }
    let (bodies, body_count) = bodies_of(cells.view());
    let axes: &[usize] = if cells.dim() == 2 { &[0, 1] } else { &[0, 1, 2] };
    let Cells { points, shapes, start, nodes, numbers, .. } = cells;
    let mesh = WholeMesh {
        axes,
        points,
        shapes,
        start,
        nodes,
        numbers,
        materials,
        bodies,
        body_count,
        hinges: Hinges::default(),
        surfaces,
        interfaces,
        parents: Vec::new(),
        remarks,
    };
    Ok(WholeMesh { hinges: hinges(&mesh, &mates), ..mesh })
}

/// Says which surfaces are of nodes, between which refinement puts nodes that are not in them.
fn remark_on_lone_nodes(groups: &Groups, request: &Request, remarks: &mut Vec<String>) {
    for name in &request.surfaces {
        let number = groups.lone_nodes(name);
        if number > 1 {
            remarks.push(format!(
                "surface `{name}`: a group of nodes keeps its {number} nodes of the file, and gets \
                 none of those that `mesh.refine` puts between them; a group of facets or edges \
                 gets them"
            ));
        }
    }
}

/// Says that simplices of first order lock.
fn remark_on_locking(cells: &Cells, remarks: &mut Vec<String>) {
    let number = cells.shapes.iter().filter(|shape| is_stiff(**shape)).count();
    remarks.extend(locking(cells.dim(), number));
}

/// Whether cells of a shape lock.
pub fn is_stiff(shape: Shape) -> bool {
    matches!(shape, Shape::Tri3 | Shape::Tet4)
}

/// What is to be said of so many simplices of first order.
pub fn locking(dim: usize, number: usize) -> Option<String> {
    (number > 0).then(|| {
        let kind = match (dim, number) {
            (2, _) => count(number, "triangle"),
            (_, 1) => "1 tetrahedron".into(),
            _ => format!("{number} tetrahedra"),
        };
        format!(
            "{kind} of first order: they lock, so that the answer is too stiff; \
             `mesh.raise_order: 2` gives them middle nodes"
        )
    })
}
