//! The meshes of a case before any rank has its part of them.

use std::path::Path;

use super::import::{FileMesh, gmsh, med};
use super::lattice::Column;
use super::whole::{InterfacePlace, InterfaceRequest, Keep, MaterialGroups, Request};
use super::whole::{WholeFacet, WholeMesh};
use super::{DualGraph, LocalMesh, Marks, MeshFacts, whole};
use crate::case::{Case, FileSpec, InterfaceSpec, Linear, Location, Material};
use crate::error::{Error, Result};

/// The meshes of a case.
#[derive(Debug, Clone)]
pub struct MeshFamily {
    source: Source,
    /// What is to be said of them, in words.
    pub remarks: Vec<String>,
}

#[derive(Debug, Clone)]
enum Source {
    /// Nested lattices, coarsest first, the same on every rank; the last one is that of the case.
    /// The cells of the first one are shared out, and every rank refines its own.
    Lattices(Vec<Column>),
    /// The mesh of a file: what is known of it, and on the rank that read it the mesh itself, after
    /// the coarser ones that multigrid asks for, coarsest first.
    Whole(Box<MeshFacts>, Vec<WholeMesh>),
    /// The mesh of a file that no rank has whole: the part of this rank, and on the root, where
    /// there are interfaces, the cells behind these and surfaces.
    Slabs(Box<LocalMesh>, Option<Box<WholeMesh>>),
}

impl MeshFamily {
    /// The mesh that the case describes, or that its file holds: a column also before its
    /// refinement. Local; every rank has columns, one of them reads a file.
    ///
    /// # Errors
    /// `Input` when a material's height range leaves a layer without a material; when a file cannot
    /// be read, or does not hold what the case asks for.
    pub fn new(case: &Case) -> Result<Self> {
        Self::divided(case, case.mesh.refine, &[])
    }

    /// As [`MeshFamily::new`], with the mesh of a file refined so often, after some `facets` of
    /// interfaces, of the mesh without refinement, have been divided.
    ///
    /// # Errors
    /// As [`MeshFamily::new`].
    pub fn divided(case: &Case, refine: u32, facets: &[WholeFacet]) -> Result<Self> {
        if let Some(file) = case.mesh.file() {
            let mut meshes = read(case, file, refine, facets)?;
            let coarser: Vec<u64> = meshes.iter().map(|mesh| mesh.cells() as u64).collect();
            let Some(mesh) = meshes.last_mut() else {
                return Err(Error::Bug("no mesh in the file".into()));
            };
            let remarks = std::mem::take(&mut mesh.remarks);
            let names = case.interfaces.iter().map(|interface| interface.name.clone()).collect();
            let mut facts = MeshFacts { names, coarser, ..mesh.facts() };
            facts.coarser.pop();
            let source = Source::Whole(Box::new(facts), meshes);
            return Ok(Self { source, remarks });
        }
        let column = Column::new(case)?;
        let source = Source::Lattices(vec![column.described(), column]);
        Ok(Self { source, remarks: Vec::new() })
    }

    /// The mesh of a file that another rank has read.
    pub fn known_by_its_facts(facts: MeshFacts) -> Self {
        Self { source: Source::Whole(Box::new(facts), Vec::new()), remarks: Vec::new() }
    }

    /// The mesh of a file of which this rank has a part; `behind` are the cells behind surfaces and
    /// interfaces, on the root, where there are interfaces.
    pub fn in_slabs(part: LocalMesh, behind: Option<WholeMesh>, remarks: Vec<String>) -> Self {
        Self { source: Source::Slabs(Box::new(part), behind.map(Box::new)), remarks }
    }

    /// The part of this rank, where that is all it has; else all of it comes back. Local.
    ///
    /// # Errors
    /// The meshes themselves.
    pub fn into_part(self) -> std::result::Result<LocalMesh, Box<Self>> {
        match self.source {
            Source::Slabs(part, _) => Ok(*part),
            source => Err(Box::new(Self { source, remarks: self.remarks })),
        }
    }

    /// What is known of the mesh of the case.
    pub fn facts(&self) -> MeshFacts {
        match &self.source {
            Source::Lattices(columns) => columns[columns.len() - 1].facts(),
            Source::Whole(facts, _) => (**facts).clone(),
            Source::Slabs(part, _) => part.facts.clone(),
        }
    }

    /// The lattice of the mesh of the case, where it is one.
    pub fn lattice(&self) -> Option<&Column> {
        match &self.source {
            Source::Lattices(columns) => columns.last(),
            Source::Whole(..) | Source::Slabs(..) => None,
        }
    }

    /// Whether it is the mesh of a file.
    pub fn is_of_file(&self) -> bool {
        !matches!(self.source, Source::Lattices(_))
    }

    /// Takes levels for multigrid in the place of the meshes below the finest, the coarsest of at
    /// least `fewest` cells. False where there are none.
    pub fn coarsen(&mut self, fewest: u64) -> bool {
        let columns = match &mut self.source {
            Source::Lattices(columns) => columns,
            Source::Whole(facts, meshes) => {
                let few = facts.coarser.iter().take_while(|cells| **cells < fewest).count();
                facts.coarser.drain(..few);
                meshes.drain(..few.min(meshes.len()));
                return facts.has_coarser();
            }
            Source::Slabs(part, _) => return part.facts.has_coarser(),
        };
        let levels = columns[columns.len() - 1].hierarchy(fewest);
        let has_levels = levels.len() > 1;
        if has_levels {
            *columns = levels;
        }
        has_levels
    }

    /// Leaves out the coarser meshes of a file.
    pub fn leave_finest(&mut self) {
        if let Source::Whole(facts, meshes) = &mut self.source {
            facts.coarser.clear();
            meshes.drain(..meshes.len().saturating_sub(1));
            meshes.iter_mut().for_each(|mesh| mesh.parents = Vec::new());
        }
    }

    /// Number of cells of the mesh that is shared out.
    pub fn coarse_cells(&self) -> u64 {
        match &self.source {
            Source::Lattices(columns) => columns[0].cells(),
            Source::Whole(facts, _) => facts.coarser.first().copied().unwrap_or(facts.cells),
            Source::Slabs(part, _) => part.facts.cells,
        }
    }

    /// The dual graph of the mesh that is shared out; that of a file on the rank that read it.
    ///
    /// # Errors
    /// `Input` when it has too many cells.
    pub fn dual_graph(&self) -> Result<DualGraph> {
        match &self.source {
            Source::Lattices(columns) => columns[0].dual_graph(),
            _ => Ok(whole::dual_graph(&self.meshes_of_file()?[0])),
        }
    }

    /// The parts of a rank that gets these cells of the coarsest lattice, rising; coarsest first.
    /// `held` is the size of the largest mesh that any rank held before. None for the mesh of a
    /// file. Local.
    pub fn share(&self, cells: Vec<u64>, held: u64) -> Option<Vec<LocalMesh>> {
        let Source::Lattices(columns) = &self.source else { return None };
        let mut meshes = vec![LocalMesh::new(&columns[0], cells, held)];
        for column in &columns[1..] {
            meshes.push(meshes[meshes.len() - 1].refined(&columns[meshes.len() - 1], column));
        }
        Some(meshes)
    }

    /// The parts of all ranks of the meshes of a file, coarsest first, on the rank that read it, of
    /// which each gets the cells that `rank_of` gives it of the coarsest mesh, and their children.
    /// Local.
    ///
    /// # Errors
    /// `Bug` on another rank, or for a column.
    pub fn parts(&self, rank_of: &[i32], ranks: usize) -> Result<Vec<Vec<LocalMesh>>> {
        let meshes = self.meshes_of_file()?;
        let mut rank_of = rank_of.to_vec();
        let mut parts = vec![meshes[0].parts(&rank_of, ranks)];
        for pair in meshes.windows(2) {
            let fine = &pair[1];
            rank_of = fine.parents.iter().map(|parent| rank_of[parent.cell as usize]).collect();
            let mut of_ranks = fine.parts(&rank_of, ranks);
            of_ranks.iter_mut().for_each(|part| part.depend_on(fine, &pair[0]));
            parts.push(of_ranks);
        }
        Ok(parts)
    }

    /// The whole mesh of the case on one rank. Local.
    ///
    /// # Errors
    /// `Bug` for the mesh of a file on another rank than the one that read it.
    pub fn whole(&self) -> Result<LocalMesh> {
        if let Source::Lattices(columns) = &self.source {
            let column = &columns[columns.len() - 1];
            return Ok(LocalMesh::new(column, (0..column.cells()).collect(), column.cells()));
        }
        let meshes = self.meshes_of_file()?;
        let mesh = &meshes[meshes.len() - 1];
        let mut parts = mesh.parts(&vec![0; mesh.cells()], 1);
        let mut part = parts.pop().ok_or_else(|| Error::Bug("no part of the mesh".into()))?;
        part.facts.names = self.facts().names;
        Ok(part)
    }

    /// Whether some node of an interface in the mesh of a file is doubtful. Local.
    ///
    /// # Errors
    /// `Bug` for the mesh of a file on another rank than the one that read it.
    pub fn touches_interfaces(&self, is_doubtful: &dyn Fn(&Marks) -> bool) -> Result<bool> {
        let meshes = self.meshes_of_file()?;
        Ok(meshes[meshes.len() - 1].touches_interfaces(is_doubtful))
    }

    /// At least one.
    fn meshes_of_file(&self) -> Result<&[WholeMesh]> {
        match &self.source {
            Source::Whole(_, meshes) if !meshes.is_empty() => Ok(meshes),
            Source::Slabs(_, Some(behind)) => Ok(std::slice::from_ref(&**behind)),
            _ => Err(Error::Bug("the mesh of a file is on another rank".into())),
        }
    }
}

/// Reads the mesh of a file and makes of it what the case asks for, after the coarser ones where
/// multigrid is to use them.
fn read(
    case: &Case,
    file: &FileSpec,
    refine: u32,
    divided: &[WholeFacet],
) -> Result<Vec<WholeMesh>> {
    let path = file.path.display().to_string();
    let content = content(file, &path)?;
    let request = Request { refine, divided: divided.to_vec(), ..request(case, file)? };
    let may_need_levels = matches!(case.solver.linear, Linear::Multigrid | Linear::Auto);
    let keep = if may_need_levels { Keep::All } else { Keep::Finest };
    let mut meshes = whole::nested(&content, &request, &path, keep)?;
    meshes.iter_mut().for_each(|mesh| add_connected(case, mesh));
    check_surfaces(meshes.first().map_or(0, |mesh| mesh.surfaces.len()))?;
    Ok(meshes)
}

/// Makes the lips of interfaces with a connected fluid surfaces too.
pub(super) fn add_connected(case: &Case, mesh: &mut WholeMesh) {
    for index in (0..case.interfaces.len()).filter(|index| case.interfaces[*index].connected) {
        let lips = mesh.surface_of_lips(index);
        mesh.surfaces.push(lips);
    }
}

/// Refuses more surfaces than marks tell of.
pub(super) fn check_surfaces(surfaces: usize) -> Result<()> {
    if surfaces > Marks::SURFACES {
        return Err(Error::Input(format!(
            "boundary: {surfaces} groups and interfaces with a connected fluid are more than the {} \
             that a node can be marked for; join groups that are treated alike",
            Marks::SURFACES
        )));
    }
    Ok(())
}

/// What a case asks of its file.
///
/// # Errors
/// `Bug` for an interface at a height.
pub fn request(case: &Case, file: &FileSpec) -> Result<Request> {
    let interface = |spec: &InterfaceSpec| {
        let place = match &spec.location {
            Location::Group { name, flip } => {
                InterfacePlace::On { group: name.clone(), flip: *flip }
            }
            Location::Between([lower, upper]) => {
                let [lower, upper] = [lower, upper].map(Clone::clone);
                InterfacePlace::Between { lower, upper, has_gap: spec.has_gap }
            }
            Location::Height(_) => return Err(Error::Bug("a height in the mesh of a file".into())),
        };
        Ok(InterfaceRequest { name: spec.name.clone(), place })
    };
    let material = |material: &Material| MaterialGroups {
        name: material.name.clone(),
        groups: material.groups.clone(),
    };
    Ok(Request {
        scale: file.scale,
        raise_order: file.raise_order.then_some(2),
        refine: case.mesh.refine,
        materials: case.materials.iter().map(material).collect(),
        surfaces: case.surfaces().iter().map(|surface| surface.name().to_owned()).collect(),
        interfaces: case.interfaces.iter().map(interface).collect::<Result<_>>()?,
        divided: Vec::new(),
    })
}

/// What the file holds.
fn content(file: &FileSpec, path: &str) -> Result<FileMesh> {
    if is_med(&file.path) {
        return med::read(&file.path);
    }
    let bytes = std::fs::read(&file.path).map_err(|error| {
        Error::Input(format!(
            "mesh.file: {path} cannot be read: {error}; the path counts from the folder of the \
             case file"
        ))
    })?;
    gmsh::read(&bytes).map_err(|error| match error {
        Error::Input(text) => Error::Input(format!("{path}: {text}")),
        other => other,
    })
}

/// Whether a file is one of MED: HDF5, by its ending.
pub fn is_med(path: &Path) -> bool {
    let is = |ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
    is("med") || is("mmed") || is("rmed")
}
