//! Groups by name: their elements, and what there is where one is missing.

use std::collections::HashSet;

use super::cells::{Cells, NONE, corner_count};
use super::facet::WholeFacet;
use super::facets::{FacetTable, runs_alike, slot};
use super::words::{are, count, place, wrong};
use crate::error::Result;
use crate::mesh::import::{Block, FileMesh};

/// The groups of a file, with the numbers of their elements.
pub struct Groups<'f> {
    file: &'f FileMesh,
    /// Dimension of the cells.
    dim: usize,
    /// Elements (or nodes) of each group.
    counts: Vec<usize>,
}

/// An element of a group of facets, and the cells on both sides of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FoundFacet {
    /// As facets of the cell out of which the element's own normal points, and of the other one.
    /// At the boundary of the mesh, there is one.
    pub sides: [Option<WholeFacet>; 2],
}

impl FoundFacet {
    /// The facets of the cells.
    pub fn facets(self) -> impl Iterator<Item = WholeFacet> {
        self.sides.into_iter().flatten()
    }
}

impl<'f> Groups<'f> {
    /// Of a file whose cells were taken out of it.
    pub fn new(file: &'f FileMesh, cells: &Cells) -> Self {
        let dim = cells.dim();
        let mut counts = vec![0; file.groups.len()];
        let mut of_sets = vec![0_usize; cells.group_sets.len()];
        let below = file.blocks.iter().filter(|block| block.kind.dim() < dim);
        for set in below.flat_map(|block| &block.groups).chain(&cells.sets) {
            of_sets[*set as usize] += 1;
        }
        for (set, number) in cells.group_sets.iter().zip(of_sets) {
            set.iter().for_each(|group| counts[*group as usize] += number);
        }
        for (group, nodes) in &file.node_groups {
            counts[*group as usize] += nodes.len();
        }
        Self { file, dim, counts }
    }

    /// Of a file that is only a part of one, in which the groups have so many elements.
    pub fn with_counts(file: &'f FileMesh, dim: usize, counts: Vec<usize>) -> Self {
        Self { file, dim, counts }
    }

    /// The group of this name and dimension.
    pub fn find(&self, name: &str, dim: usize) -> Option<u32> {
        let of = |group: &crate::mesh::import::Group| group.name == name && group.dim == dim;
        self.file.groups.iter().position(of).map(|group| group as u32)
    }

    /// The group of cells of this name.
    ///
    /// # Errors
    /// `Input` if there is none with elements; `whose` says who asks.
    pub fn of_cells(&self, name: &str, whose: &str) -> Result<u32> {
        self.filled(name, self.dim).ok_or_else(|| self.missing(name, "cells", whose))
    }

    /// The group of facets of this name.
    ///
    /// # Errors
    /// As [`Groups::of_cells`].
    pub fn of_facets(&self, name: &str, whose: &str) -> Result<u32> {
        self.filled(name, self.dim - 1).ok_or_else(|| self.missing(name, "facets", whose))
    }

    /// The group of this name of facets, else edges, else points and nodes; its dimension.
    ///
    /// # Errors
    /// As [`Groups::of_cells`].
    pub fn of_surface(&self, name: &str, whose: &str) -> Result<(u32, usize)> {
        let below = (0..self.dim).rev().find_map(|dim| Some((self.filled(name, dim)?, dim)));
        below.ok_or_else(|| self.missing(name, "facets, edges, points or nodes", whose))
    }

    /// The number of nodes of the group of this name where it is one of nodes, not of elements.
    pub fn lone_nodes(&self, name: &str) -> usize {
        let Ok((group, 0)) = self.of_surface(name, "") else { return 0 };
        let of_group = self.file.node_groups.iter().filter(|(of, _)| *of == group);
        of_group.map(|(_, nodes)| nodes.len()).sum()
    }

    /// A group that has elements.
    fn filled(&self, name: &str, dim: usize) -> Option<u32> {
        self.find(name, dim).filter(|group| self.counts[*group as usize] > 0)
    }

    fn missing(&self, name: &str, what: &str, whose: &str) -> crate::error::Error {
        let same = self.file.groups.iter().filter(|group| group.name == name);
        let dims: Vec<usize> = same.map(|group| group.dim).collect();
        let is_empty = dims.iter().any(|dim| self.filled(name, *dim).is_none());
        let why = if dims.is_empty() {
            format!("{whose}: there is no group `{name}`")
        } else if is_empty {
            format!("{whose}: the group `{name}` has no elements")
        } else {
            let dims: Vec<String> = dims.iter().map(|dim| kind_of(*dim, self.dim).into()).collect();
            format!("{whose}: the group `{name}` has {}, not {what}", dims.join(" and "))
        };
        wrong(format!("{why}; {}", self.list()))
    }

    /// The groups that there are, in words.
    fn list(&self) -> String {
        let mut parts = Vec::new();
        for dim in (0..=self.dim).rev() {
            let of_dim = self.file.groups.iter().zip(&self.counts).filter(|(g, _)| g.dim == dim);
            let names: Vec<String> =
                of_dim.map(|(group, count)| format!("{} ({count})", group.name)).collect();
            if !names.is_empty() {
                parts.push(format!("{} {}", kind_of(dim, self.dim), names.join(", ")));
            }
        }
        if parts.is_empty() {
            return "the file has no groups: name them (Physical groups in Gmsh, groups in SALOME) \
                    and write the file again"
                .into();
        }
        format!("groups with the numbers of their elements: {}", parts.join("; "))
    }

    /// The elements of a group of one dimension: block, and index in it.
    fn elements(&self, group: u32, dim: usize) -> impl Iterator<Item = (&'f Block, usize)> {
        let has: Vec<bool> = self.file.group_sets.iter().map(|set| set.contains(&group)).collect();
        let blocks = self.file.blocks.iter().filter(move |block| block.kind.dim() == dim);
        blocks.flat_map(move |block| {
            let of_set: Vec<usize> =
                (0..block.groups.len()).filter(|e| has[block.groups[*e] as usize]).collect();
            of_set.into_iter().map(move |element| (block, element))
        })
    }

    /// The facets of a group, each once, in the order of the file.
    ///
    /// # Errors
    /// `Input` if some lie on no cell, or not on all its nodes.
    pub fn facets(
        &self,
        group: u32,
        cells: &Cells,
        table: &FacetTable,
        scale: f64,
    ) -> Result<Vec<FoundFacet>> {
        let mut found = Vec::new();
        let mut known = HashSet::new();
        let mut lost = Vec::new();
        for (block, element) in self.elements(group, self.dim - 1) {
            let nodes = self.nodes_of(block, element, cells);
            let corners = corner_count(block.kind);
            let mut sides = table.find(nodes[..corners].iter().copied());
            let Some(one) = sides.next().filter(|_| !nodes[..corners].contains(&NONE)) else {
                lost.push((block, element));
                continue;
            };
            check_nodes(&nodes, one, block, element, cells)?;
            let other = sides.next();
            let mut row = [NONE; 4];
            row[..corners].copy_from_slice(&nodes[..corners]);
            let is_out = runs_alike(&row, &cells.view().facet_corners(one), corners);
            let sides = if is_out { [Some(one), other] } else { [other, Some(one)] };
            if known.insert(slot(one)) {
                found.push(FoundFacet { sides });
            }
        }
        match lost[..] {
            [] => Ok(found),
            [first, ..] => Err(self.lost(group, "facet", lost.len(), first, scale)),
        }
    }

    /// The nodes of a group of edges, or of points and nodes, rising.
    ///
    /// # Errors
    /// `Input` if an edge or a point lies on no cell.
    pub fn nodes(&self, group: u32, dim: usize, cells: &Cells, scale: f64) -> Result<Vec<u32>> {
        let mut found = Vec::new();
        let mut lost = Vec::new();
        for (block, element) in self.elements(group, dim) {
            let nodes = self.nodes_of(block, element, cells);
            if nodes.contains(&NONE) {
                lost.push((block, element));
                continue;
            }
            found.extend_from_slice(&nodes);
            if let [a, b] = nodes[..] {
                let ends = [a.min(b), a.max(b)];
                let middle = cells.edges.binary_search_by_key(&ends, |(ends, _)| *ends);
                found.extend(middle.ok().map(|place| cells.edges[place].1));
            }
        }
        if let [first, ..] = lost[..] {
            let what = if dim == 0 { "point" } else { "edge" };
            return Err(self.lost(group, what, lost.len(), first, scale));
        }
        let of_group = self.file.node_groups.iter().filter(|(of, _)| dim == 0 && *of == group);
        for (_, nodes) in of_group {
            let nodes = nodes.iter().map(|node| cells.names[*node as usize]);
            found.extend(nodes.filter(|node| *node != NONE));
        }
        found.sort_unstable();
        found.dedup();
        Ok(found)
    }

    fn nodes_of(&self, block: &Block, element: usize, cells: &Cells) -> Vec<u32> {
        let count = block.kind.nodes();
        let of_file = &block.nodes[element * count..][..count];
        of_file.iter().map(|node| cells.names[*node as usize]).collect()
    }

    fn lost(
        &self,
        group: u32,
        what: &str,
        number: usize,
        (block, element): (&Block, usize),
        scale: f64,
    ) -> crate::error::Error {
        let nodes = &block.nodes[element * block.kind.nodes()..][..block.kind.nodes()];
        let points = || nodes.iter().map(|node| self.file.points[*node as usize]);
        let mean = |i: usize| points().map(|point| point[i]).sum::<f64>() / nodes.len() as f64;
        let at = [0, 1, 2].map(|i| scale * mean(i));
        wrong(format!(
            "{} of the group `{}` {} on no cell, the first being the {} number {} at {}; mesh the \
             group together with the bodies, so that it is made of their sides",
            count(number, what),
            self.file.groups[group as usize].name,
            if number == 1 { "lies" } else { "lie" },
            block.kind.name(),
            block.numbers[element],
            place(at)
        ))
    }
}

/// Checks that the nodes of an element are those of the facet.
fn check_nodes(
    nodes: &[u32],
    facet: WholeFacet,
    block: &Block,
    element: usize,
    cells: &Cells,
) -> Result<()> {
    let of_cell = |node: &u32| cells.view().facet_nodes(facet).any(|other| other == *node);
    let strangers = nodes.iter().filter(|node| !of_cell(node)).count();
    if strangers == 0 {
        return Ok(());
    }
    Err(wrong(format!(
        "the {} number {} has {} that {} not on the cell behind it: {}; give all elements one order",
        block.kind.name(),
        block.numbers[element],
        count(strangers, "node"),
        are(strangers),
        cells.describe_facet(facet)
    )))
}

/// What elements of a dimension are in a mesh.
fn kind_of(dim: usize, of_mesh: usize) -> &'static str {
    match of_mesh.saturating_sub(dim) {
        0 => "cells",
        1 => "facets",
        _ if dim == 1 => "edges",
        _ => "points or nodes",
    }
}
