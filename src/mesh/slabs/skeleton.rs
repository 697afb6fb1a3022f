//! The cells behind surfaces and interfaces, on every rank: what is told of groups is found here
//! once, in the order of the file, by the code for whole meshes.

use super::head::Head;
use super::numbers::Numbers;
use crate::case::Case;
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::mesh::facts::Hinges;
use crate::mesh::family::{add_connected, check_surfaces};
use crate::mesh::import::Group;
use crate::mesh::whole::{
    Cells, Copies, FacetTable, FoundSurface, InterfacePlace, Known, NO_MATE, Plan, Request,
    WholeFacet, WholeMesh, check_copies, corner_count, facing_of_lips, find_surface,
    finish_surface, lay_along_axes, make_interfaces, plan, raise, slot,
};

/// Which cells are behind surfaces and interfaces.
pub struct Behind {
    /// Corners of elements that are facets, rising, and of edges.
    corners: Vec<[u32; 4]>,
    nodes: Numbers,
    is_raised: bool,
}

/// Whether a group is one that the case asks for.
pub fn is_wanted(request: &Request, dim: usize, group: &Group) -> bool {
    use InterfacePlace::{Between, On};
    let of_interface = request.interfaces.iter().any(|interface| match &interface.place {
        On { group: name, .. } => *name == group.name,
        Between { lower, upper, .. } => [lower, upper].contains(&&group.name),
    });
    group.dim < dim && (of_interface || request.surfaces.contains(&group.name))
}

impl Behind {
    /// Those behind the elements of the groups that a case asks for.
    pub fn new(head: &Head, request: &Request) -> Self {
        let is_raised = request.raise_order == Some(2);
        let wanted = |group: &Group| is_wanted(request, head.dim, group);
        let mut corners = Vec::new();
        for block in head.below.iter().filter(|block| block.kind.dim() > 0) {
            if block.kind.dim() + 1 < head.dim && !is_raised {
                continue;
            }
            for (nodes, set) in block.nodes.chunks(block.kind.nodes()).zip(&block.groups) {
                if head.is_wanted(*set, &wanted) {
                    corners.push(row(nodes[..corner_count(block.kind)].iter().copied()));
                }
            }
        }
        corners.sort_unstable();
        corners.dedup();
        let nodes = corners.iter().flatten().copied().filter(|node| *node != u32::MAX);
        let nodes = Numbers::of(0, u64::from(head.nodes), nodes);
        Self { corners, nodes, is_raised }
    }

    /// Whether a cell of this shape and with these corners is one of them.
    pub fn has(&self, shape: Shape, nodes: &[u32]) -> bool {
        let is_on = |local: usize| self.nodes.place(nodes[local]).is_some();
        let shape = shape.corners();
        if (0..shape.nodes()).filter(|local| is_on(*local)).count() < 2 {
            return false;
        }
        let is_there = |corners: [u32; 4]| self.corners.binary_search(&corners).is_ok();
        let of_facet = |facet: &&[usize]| {
            let all = facet.iter().all(|local| is_on(*local));
            all && is_there(row(facet.iter().map(|local| nodes[*local])))
        };
        let pairs = || {
            let of = |a: usize| (a + 1..shape.nodes()).map(move |b| [nodes[a], nodes[b]]);
            (0..shape.nodes()).flat_map(of)
        };
        shape.facets().iter().any(of_facet)
            || self.is_raised && pairs().any(|ends| is_there(row(ends.into_iter())))
    }
}

/// Up to four nodes, rising.
fn row(nodes: impl Iterator<Item = u32>) -> [u32; 4] {
    let mut row = [u32::MAX; 4];
    row.iter_mut().zip(nodes).for_each(|(place, node)| *place = node);
    row.sort_unstable();
    row
}

/// The cells behind surfaces and interfaces, before the mesh is cut.
pub struct Skeleton {
    cells: Cells,
    /// Names of its cells, rising.
    pub names: Vec<u32>,
    /// Names of its nodes of the file, rising.
    nodes: Vec<u32>,
    mates: Vec<u32>,
    plans: Vec<Plan>,
    surfaces: Vec<FoundSurface>,
    /// What is to be said, in words.
    pub remarks: Vec<String>,
}

/// The names of the nodes that a skeleton of these cells has, rising.
pub fn nodes_of(head: &Head, request: &Request, of_cells: &[u32]) -> Vec<u32> {
    let wanted = |group: &Group| is_wanted(request, head.dim, group);
    let mut nodes = of_cells.to_vec();
    for block in &head.below {
        for (of, set) in block.nodes.chunks(block.kind.nodes()).zip(&block.groups) {
            if head.is_wanted(*set, &wanted) {
                nodes.extend_from_slice(of);
            }
        }
    }
    let groups = head.node_groups.iter();
    let asked = groups.filter(|(group, _)| wanted(&head.groups[*group as usize]));
    asked.for_each(|(_, of)| nodes.extend_from_slice(of));
    nodes.sort_unstable();
    nodes.dedup();
    if nodes.last() == Some(&u32::MAX) {
        nodes.pop();
    }
    nodes.shrink_to_fit();
    nodes
}

impl Skeleton {
    /// That of cells, which rise.
    ///
    /// # Arguments
    /// * `sets` of groups of the cells
    /// * `of_cells`: the nodes of one cell after the other
    /// * `nodes`: as [`nodes_of`] tells, with their `points` (m)
    ///
    /// # Errors
    /// `Input` as of the whole mesh.
    pub fn new(
        head: &Head,
        request: &Request,
        [names, sets, of_cells]: [Vec<u32>; 3],
        (nodes, points): (Vec<u32>, Vec<[f64; 3]>),
    ) -> Result<Self> {
        let place = |name: u32| nodes.binary_search(&name).ok();
        let file = head.file(points.clone(), &place, &|group| is_wanted(request, head.dim, group));
        let mut cells = Cells { start: vec![0], points, sets, ..Cells::default() };
        for name in &names {
            cells.kinds.push(head.kind(*name));
            cells.numbers.push(u64::from(*name));
            let end = cells.start[cells.start.len() - 1]
                + cells.kinds[cells.kinds.len() - 1].nodes() as u32;
            cells.start.push(end);
        }
        let missing = || Error::Bug("a node of a cell behind a surface".into());
        let placed = |name: &u32| place(*name).map(|place| place as u32).ok_or_else(missing);
        cells.nodes = of_cells.iter().map(placed).collect::<Result<_>>()?;
        cells.group_sets.clone_from(&head.sets);
        cells.names = (0..nodes.len() as u32).chain([NO_MATE]).collect();
        check_copies(&mut cells)?;
        raise(&mut cells, request.raise_order, &mut Vec::new())?;
        lay_along_axes(&mut cells);
        let groups = head.groups(&file);
        let table = FacetTable::new(cells.view());
        let mates = table.mates(&cells)?;
        let known = Known { cells: &cells, table: &table, groups: &groups, scale: request.scale };
        let mut remarks = Vec::new();
        let plans = plan(&known, &request.interfaces, &mut remarks)?;
        let find = |name: &String| find_surface(&known, name);
        let surfaces = request.surfaces.iter().map(find).collect::<Result<Vec<_>>>()?;
        drop(table);
        Ok(Self { cells, names, nodes, mates, plans, surfaces, remarks })
    }

    /// The facets along which the mesh is cut, of both sides, rising by cell.
    pub fn cuts(&self) -> Vec<(u32, u8)> {
        let cut = self.plans.iter().filter(|plan| plan.is_cut);
        let facets = cut.flat_map(|plan| plan.lips.iter().flatten());
        let mut cuts: Vec<(u32, u8)> =
            facets.map(|facet| (self.names[facet.cell as usize], facet.facet)).collect();
        cuts.sort_unstable();
        cuts
    }

    /// Pairs of cells, by name, that face each other across an interface.
    pub fn facing(&self, request: &Request) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        for (plan, request) in self.plans.iter().zip(&request.interfaces) {
            let has_gap = matches!(request.place, InterfacePlace::Between { has_gap: true, .. });
            if plan.is_cut {
                let [lower, upper] = &plan.lips;
                pairs.extend(lower.iter().zip(upper).map(|(one, other)| [*one, *other]));
            } else {
                pairs.extend(facing_of_lips(self.cells.view(), &plan.lips, has_gap));
            }
        }
        let name = |facet: WholeFacet| self.names[facet.cell as usize];
        pairs.into_iter().map(|pair| pair.map(name)).collect()
    }

    /// The mesh of these cells after cutting.
    pub fn finish(mut self, request: &Request, cut: &Cut) -> Result<Star> {
        for plan in self.plans.iter().filter(|plan| plan.is_cut) {
            for facet in plan.lips.iter().flatten() {
                self.mates[slot(*facet)] = NO_MATE;
            }
        }
        let names = self.names_after(cut);
        let place = |name: u32| names.binary_search(&name).unwrap_or_default() as u32;
        let base = names.partition_point(|name| *name < cut.first) as u32;
        let origins = cut.origins.iter().map(|origin| place(*origin)).collect();
        let copies = Copies::of_origins(base, origins);
        let found = self.placed_surfaces(cut, &place);
        let mut points = vec![[0.0; 3]; names.len()];
        for (name, point) in self.nodes.iter().zip(&self.cells.points) {
            points[place(*name) as usize] = *point;
        }
        for (name, point) in &cut.points {
            points[place(*name) as usize] = *point;
        }
        for copy in base..names.len() as u32 {
            points[copy as usize] = points[copies.origin(copy) as usize];
        }
        self.cells.points = points;
        self.cells.nodes = cut.nodes.iter().map(|name| place(*name)).collect();
        let mut remarks = Vec::new();
        let cells = &self.cells;
        let interfaces =
            make_interfaces(cells, &copies, self.plans, &request.interfaces, &mut remarks)?;
        let mut surfaces = Vec::new();
        let is_all = found.iter().map(|found| matches!(found, FoundSurface::All)).collect();
        for (name, found) in request.surfaces.iter().zip(found) {
            surfaces.push(finish_surface(cells, &self.mates, &copies, name, found, &mut remarks));
        }
        let Cells { points, shapes, start, nodes, numbers, .. } = self.cells;
        let mesh = WholeMesh {
            axes: if cut.dim == 2 { &[0, 1] } else { &[0, 1, 2] },
            points,
            shapes,
            start,
            nodes,
            numbers,
            materials: cut.materials.clone(),
            bodies: Vec::new(),
            body_count: 0,
            hinges: Hinges::default(),
            surfaces,
            interfaces,
            parents: Vec::new(),
            remarks,
        };
        Ok(Star { mesh, nodes: names, cells: self.names, is_all })
    }

    /// The names of all nodes after cutting, rising.
    fn names_after(&self, cut: &Cut) -> Vec<u32> {
        let copies = (0..cut.origins.len() as u32).map(|copy| cut.first + copy);
        let mut names: Vec<u32> = self.nodes.iter().chain(&cut.nodes).copied().collect();
        names.extend(cut.origins.iter().copied().chain(copies));
        names.sort_unstable();
        names.dedup();
        names.shrink_to_fit();
        names
    }

    /// The surfaces with their nodes, which were there before cutting, by place after it.
    fn placed_surfaces(&mut self, cut: &Cut, place: &dyn Fn(u32) -> u32) -> Vec<FoundSurface> {
        let mut names = self.nodes.clone();
        names.resize(self.cells.points.len(), 0);
        for (node, name) in self.cells.nodes.iter().zip(&cut.nodes) {
            names[*node as usize] = cut.origin(*name);
        }
        let of = |found: FoundSurface| match found {
            FoundSurface::Nodes(nodes) => {
                let mut nodes: Vec<u32> =
                    nodes.into_iter().map(|node| place(names[node as usize])).collect();
                nodes.sort_unstable();
                FoundSurface::Nodes(nodes)
            }
            other => other,
        };
        std::mem::take(&mut self.surfaces).into_iter().map(of).collect()
    }

    /// The facets of lips between which the mesh is not cut, by name of cell, rising.
    pub fn between(&self) -> Vec<(u32, u8)> {
        let between = self.plans.iter().filter(|plan| !plan.is_cut);
        let facets = between.flat_map(|plan| plan.lips.iter().flatten());
        let mut all: Vec<(u32, u8)> =
            facets.map(|facet| (self.names[facet.cell as usize], facet.facet)).collect();
        all.sort_unstable();
        all
    }
}

/// What cutting has made of the cells of a skeleton, and what is known of them.
pub struct Cut {
    /// 2 or 3.
    pub dim: usize,
    /// Names of the nodes of one cell after the other.
    pub nodes: Vec<u32>,
    /// The positions (m) of those that are not of the file.
    pub points: Vec<(u32, [f64; 3])>,
    /// The name of the first copy of all.
    pub first: u32,
    /// The node that each copy is one of, rising.
    pub origins: Vec<u32>,
    /// The materials of the cells.
    pub materials: Vec<u32>,
}

impl Cut {
    /// The node before cutting.
    pub fn origin(&self, name: u32) -> u32 {
        name.checked_sub(self.first).map_or(name, |copy| self.origins[copy as usize])
    }
}

/// The cells behind surfaces and interfaces, as a mesh that is cut.
#[derive(Debug, Clone)]
pub struct Star {
    /// The mesh; what it tells of surfaces and interfaces is whole.
    pub mesh: WholeMesh,
    /// Names of its nodes, rising.
    pub nodes: Vec<u32>,
    /// Names of its cells, rising.
    pub cells: Vec<u32>,
    /// Which surfaces are every node.
    pub is_all: Vec<bool>,
}

impl Star {
    /// Makes the lips of interfaces with a connected fluid surfaces too.
    ///
    /// # Errors
    /// `Input` for more surfaces than marks tell of.
    pub fn add_connected(&mut self, case: &Case) -> Result<()> {
        add_connected(case, &mut self.mesh);
        self.is_all.resize(self.mesh.surfaces.len(), false);
        check_surfaces(self.mesh.surfaces.len())
    }

    /// The names of the nodes of lips between which the mesh is not cut, before cutting, rising.
    pub fn between(&self, cut: &Cut) -> Vec<u32> {
        let between = self.mesh.interfaces.iter().filter(|interface| interface.faces.is_empty());
        let facets = between.flat_map(|interface| interface.lips.iter().flatten());
        let nodes = facets.flat_map(|facet| self.mesh.facet_nodes(*facet));
        let mut names: Vec<u32> = nodes.map(|node| cut.origin(self.nodes[node as usize])).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}
