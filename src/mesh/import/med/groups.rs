//! Groups by dimension, from the families of elements and nodes.

use std::collections::{BTreeMap, BTreeSet};

use super::archive::Told;
use super::cells::Cells;
use super::families::Families;
use super::nodes::Nodes;
use crate::mesh::import::{Block, FileMesh, Group};

/// Names of groups of each dimension, with their indices.
type Index = BTreeMap<(usize, String), u32>;

/// Puts nodes, elements and families together.
///
/// One name on elements of two dimensions is two groups; on points and on nodes it is one.
pub fn assemble(
    nodes: Nodes,
    cells: Vec<Cells>,
    [of_cells, of_nodes]: [Families; 2],
    mut remarks: Vec<String>,
) -> Told<FileMesh> {
    let mut names = BTreeSet::new();
    for cells in &cells {
        let path = format!("{}/FAM", cells.path);
        let used = used(&cells.families, &of_cells, &path, "elements")?;
        names.extend(used.into_iter().map(|name| (cells.kind.dim(), name.to_owned())));
    }
    let used = used(&nodes.families, &of_nodes, &nodes.path, "nodes")?;
    names.extend(used.into_iter().map(|name| (0, name.to_owned())));
    let empty = |name: &&String| (0..=3).all(|dim| !names.contains(&(dim, (*name).clone())));
    let told = of_cells.values().chain(of_nodes.values()).flatten();
    let empty: BTreeSet<&String> = told.filter(empty).collect();
    if !empty.is_empty() {
        let list: Vec<&str> = empty.into_iter().map(String::as_str).collect();
        remarks
            .push(format!("groups without elements and nodes are left out: {}", list.join(", ")));
    }

    let index: Index = names.into_iter().zip(0..).collect();
    let node_groups = node_groups(&nodes.families, &of_nodes, &index);
    let mut sets = Sets::new();
    let block = |cells: Cells| {
        let groups = sets.of(&cells, &of_cells, &index);
        Block { kind: cells.kind, nodes: cells.nodes, numbers: cells.numbers, groups }
    };
    let blocks = cells.into_iter().map(block).collect();
    Ok(FileMesh {
        points: nodes.points,
        node_numbers: nodes.numbers,
        blocks,
        group_sets: sets.list,
        groups: index.into_keys().map(|(dim, name)| Group { name, dim }).collect(),
        node_groups,
        remarks,
    })
}

/// The names of the groups of all families of a list, each of which has to be told.
fn used<'f>(
    list: &[i64],
    families: &'f Families,
    path: &str,
    what: &str,
) -> Told<BTreeSet<&'f str>> {
    let mut names = BTreeSet::new();
    let mut seen = BTreeSet::from([0]);
    for (at, family) in list.iter().enumerate() {
        if !seen.insert(*family) {
            continue;
        }
        let groups = families.get(family).ok_or_else(|| {
            format!(
                "{path}: entry {} is the family {family}, which is not among those of the {what}",
                at + 1
            )
        })?;
        names.extend(groups.iter().map(String::as_str));
    }
    Ok(names)
}

fn node_groups(list: &[i64], families: &Families, index: &Index) -> Vec<(u32, Vec<u32>)> {
    let mut found = BTreeMap::<u32, Vec<u32>>::new();
    for (node, family) in (0..).zip(list) {
        for name in families.get(family).into_iter().flatten() {
            found.entry(index[&(0, name.clone())]).or_default().push(node);
        }
    }
    found.into_iter().collect()
}

/// Distinct sets of groups, in the order in which elements first have them.
struct Sets {
    list: Vec<Vec<u32>>,
    numbers: BTreeMap<Vec<u32>, u32>,
}

impl Sets {
    fn new() -> Self {
        Self { list: vec![Vec::new()], numbers: BTreeMap::from([(Vec::new(), 0)]) }
    }

    /// The number of the set of each element.
    fn of(&mut self, cells: &Cells, families: &Families, index: &Index) -> Vec<u32> {
        let dim = cells.kind.dim();
        let mut known = BTreeMap::from([(0, 0)]);
        let mut numbers = Vec::with_capacity(cells.families.len());
        for family in &cells.families {
            let number = *known.entry(*family).or_insert_with(|| {
                let names = families.get(family).into_iter().flatten();
                // Names are sorted, and so are their indices within one dimension.
                self.number(names.map(|name| index[&(dim, name.clone())]).collect())
            });
            numbers.push(number);
        }
        numbers
    }

    fn number(&mut self, set: Vec<u32>) -> u32 {
        let next = self.list.len() as u32;
        let number = *self.numbers.entry(set.clone()).or_insert(next);
        if number == next {
            self.list.push(set);
        }
        number
    }
}
