//! Facets of a secondary side none of whose nodes carries a multiplier: those of other facets act
//! there as well.
//!
//! Interfaces meet or end at all nodes of such a facet, or supports lean against it. Each node
//! has an heir: the nearest node with a multiplier on a facet of the same lip that has the node
//! too. The function of the node on the facet is handed over to the heir's multiplier. So the
//! functions add up to one there as everywhere, and constant tractions pass.

use std::collections::BTreeMap;

use super::facet_terms::{Terms, space_facets};
use super::mortar::{Contribution, Partners, facet_rows_in_space};
use super::sides::Sides;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::{Facet, LocalMesh};
use crate::space::{AtNode, Directory};

/// What is known of nodes by their names.
pub struct Multipliers<'a> {
    /// Which components of a node have none.
    pub fixed: &'a dyn Fn(u64) -> [bool; 3],
    /// Whether that is for another reason than that all its components are prescribed.
    pub is_lost: &'a dyn Fn(u64) -> bool,
}

impl Multipliers<'_> {
    /// Bit c: component c has none.
    fn missing(&self, name: u64, components: usize) -> u64 {
        let fixed = (self.fixed)(name);
        (0..components).map(|c| u64::from(fixed[c]) << c).sum()
    }

    fn is_without(&self, name: u64, components: usize) -> bool {
        self.missing(name, components) == (1 << components) - 1
    }
}

/// A node that acts for another one. Better are those with more components, then the nearer one,
/// then that of the lower name.
#[derive(Debug, Clone, Copy)]
struct Heir {
    /// Bit c: component c has no multiplier.
    missing: u64,
    /// The squared distance (m2).
    square: f64,
    name: u64,
}

impl Heir {
    fn is_better(&self, other: &Self) -> bool {
        let fewer = self.missing.count_ones().cmp(&other.missing.count_ones());
        let nearer = self.square.total_cmp(&other.square);
        fewer.then(nearer).then(self.name.cmp(&other.name)).is_lt()
    }
}

/// A facet without multipliers.
#[derive(Debug, Clone, Copy)]
pub struct LostFacet {
    /// The side, by its place.
    pub side: usize,
    /// The facet of this rank's cells.
    pub facet: Facet,
}

/// A node without a multiplier on the lip of an interface.
type Key = (u64, u64);

/// Numbers of an heir on its journey: node, interface, components, distance, name.
const WIDTH: usize = 5;

/// The heirs of nodes.
#[derive(Debug, Default)]
pub struct Heirs {
    of: BTreeMap<Key, Heir>,
}

/// The facets of this rank without multipliers that something else than supports has taken. Local.
pub fn lost_facets(mesh: &LocalMesh, sides: &[Sides], nodes: &Multipliers<'_>) -> Vec<LostFacet> {
    let mut found = Vec::new();
    for (place, side) in sides.iter().enumerate() {
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let names = names(mesh, *facet);
            let is_empty = names.iter().all(|name| nodes.is_without(*name, mesh.dim()));
            if is_empty && names.iter().any(|n| (nodes.is_lost)(*n)) && !is_shut(mesh, side, *facet)
            {
                found.push(LostFacet { side: place, facet: *facet });
            }
        }
    }
    found
}

impl Heirs {
    /// Those that the facets of this rank give. Local.
    pub fn here(mesh: &LocalMesh, sides: &[Sides], nodes: &Multipliers<'_>) -> Self {
        let mut heirs = Self::default();
        for side in sides {
            for facet in mesh.on_lip(side.interface, side.secondary) {
                let (_, local) = mesh.facet_nodes(*facet);
                let name = |node: &u32| mesh.nodes.names[*node as usize];
                let point = |node: &u32| mesh.nodes.points[*node as usize];
                let (without, with): (Vec<u32>, Vec<u32>) =
                    local.into_iter().partition(|node| nodes.is_without(name(node), mesh.dim()));
                for one in &without {
                    for other in &with {
                        let (a, b) = (point(one), point(other));
                        let square = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum();
                        let missing = nodes.missing(name(other), mesh.dim());
                        let heir = Heir { missing, square, name: name(other) };
                        heirs.see((name(one), side.interface as u64), heir);
                    }
                }
            }
        }
        heirs
    }

    /// Takes the better one.
    fn see(&mut self, key: Key, heir: Heir) {
        let known = self.of.entry(key).or_insert(heir);
        if heir.is_better(known) {
            *known = heir;
        }
    }

    fn see_words(&mut self, lists: &[Vec<u64>]) {
        for [node, interface, missing, square, name] in
            lists.iter().flat_map(|list| list.as_chunks::<WIDTH>().0)
        {
            let square = f64::from_bits(*square);
            self.see((*node, *interface), Heir { missing: *missing, square, name: *name });
        }
    }

    /// Those that the facets of all ranks give to the nodes of some facets. Collective.
    pub fn everywhere(
        mut self,
        comm: &Comm,
        directory: &Directory<'_>,
        mesh: &LocalMesh,
        lost: &[LostFacet],
    ) -> Self {
        // Each owner of a node gathers what is known of it.
        let keys: Vec<Key> = self.of.keys().copied().collect();
        let names: Vec<u64> = keys.iter().map(|key| key.0).collect();
        let mut packed = vec![Vec::new(); comm.size() as usize];
        for (key, entry) in keys.iter().zip(directory.look_up(&names)) {
            packed[entry.owner as usize].extend(words(key, &self.of[key]));
        }
        self.of.clear();
        let mut gathered = Self::default();
        gathered.see_words(&comm.exchange(&packed));
        // And tells those who have a facet there.
        let mut wanted: Vec<u64> =
            lost.iter().flat_map(|lost| self::names(mesh, lost.facet)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let mut asked = vec![Vec::new(); comm.size() as usize];
        for (name, entry) in wanted.iter().zip(directory.look_up(&wanted)) {
            asked[entry.owner as usize].push(*name);
        }
        let answers: Vec<Vec<u64>> = comm
            .exchange(&asked)
            .iter()
            .map(|names| names.iter().flat_map(|name| gathered.words_of(*name)).collect())
            .collect();
        self.see_words(&comm.exchange(&answers));
        self
    }

    fn words_of(&self, name: u64) -> impl Iterator<Item = u64> {
        self.of.range((name, 0)..=(name, u64::MAX)).flat_map(|(key, heir)| words(key, heir))
    }

    /// The heir of each node of a facet, that of another node where one has none; none if no node
    /// has one. Local.
    fn of_facet(&self, mesh: &LocalMesh, sides: &[Sides], lost: LostFacet) -> Option<Vec<Heir>> {
        let interface = sides[lost.side].interface;
        let names = names(mesh, lost.facet);
        let heir = |name: &u64| self.of.get(&(*name, interface as u64)).copied();
        let first = names.iter().find_map(heir)?;
        Some(names.iter().map(|name| heir(name).unwrap_or(first)).collect())
    }

    /// The facets no node of which has an heir. Local.
    pub fn without(&self, mesh: &LocalMesh, sides: &[Sides], lost: &[LostFacet]) -> Vec<Facet> {
        let lost = lost.iter().filter(|lost| self.of_facet(mesh, sides, **lost).is_none());
        lost.map(|lost| lost.facet).collect()
    }

    /// Refuses facets no node of which has an heir. Local.
    ///
    /// # Errors
    /// `Input` that names interface and place.
    pub fn check(
        &self,
        mesh: &LocalMesh,
        sides: &[Sides],
        lost: &[LostFacet],
    ) -> std::result::Result<(), AtNode> {
        let refused = |lost: &LostFacet| {
            self.of_facet(mesh, sides, *lost).is_none().then(|| without_heirs(mesh, sides, *lost))
        };
        let first = lost.iter().filter_map(refused).min_by_key(|AtNode(name, _)| *name);
        first.map_or(Ok(()), Err)
    }

    /// Adds what lost facets contribute to the rows of their heirs. Local.
    ///
    /// # Errors
    /// Those of [`facet_rows_in_space`].
    pub fn add_terms(
        &self,
        mesh: &LocalMesh,
        sides: &[Sides],
        lost: &[LostFacet],
        terms: &mut Terms,
    ) -> Result<()> {
        let components = mesh.dim();
        for one in lost {
            let side = &sides[one.side];
            let Some(heirs) = self.of_facet(mesh, sides, *one) else { continue };
            let (secondary, primary) = space_facets(mesh, side, one.facet);
            let primary: Vec<_> = primary.iter().collect();
            let partners =
                if side.has_gap { Partners::Across(&primary) } else { Partners::Near(&primary) };
            let has_shares = side.secondary_facts(&mesh.facts).has_shares;
            let is_transformed = has_shares && secondary.shape().order() == 2;
            let rows =
                facet_rows_in_space(&secondary, partners, &vec![0; components], is_transformed)?;
            for row in rows.contributions {
                let place = secondary.nodes().iter().position(|node| *node == row.node);
                let Some(heir) = place.map(|place| heirs[place]) else { continue };
                let components = std::array::from_fn(|c| heir.missing >> c & 1 == 0);
                let row = Contribution { node: heir.name, components, ..row };
                terms.add(side, mesh.dim(), &row);
            }
        }
        Ok(())
    }
}

fn names(mesh: &LocalMesh, facet: Facet) -> Vec<u64> {
    let (_, nodes) = mesh.facet_nodes(facet);
    nodes.iter().map(|node| mesh.nodes.names[*node as usize]).collect()
}

fn words(key: &Key, heir: &Heir) -> [u64; WIDTH] {
    [key.0, key.1, heir.missing, heir.square.to_bits(), heir.name]
}

/// Whether both sides share all nodes of a facet, beyond the edge of the interface.
fn is_shut(mesh: &LocalMesh, side: &Sides, facet: Facet) -> bool {
    let own = names(mesh, facet);
    let across = mesh.across(side.interface, side.secondary, facet);
    across.iter().any(|far| far.nodes.iter().all(|name| own.contains(name)))
}

fn without_heirs(mesh: &LocalMesh, sides: &[Sides], lost: LostFacet) -> AtNode {
    let names = names(mesh, lost.facet);
    let name = names.iter().copied().min().unwrap_or_default();
    let [x, y, z] = mesh.nodes.number(name).map_or([f64::NAN; 3], |node| mesh.nodes.points[node]);
    let interface = sides[lost.side].interface;
    let interface = mesh.facts.names.get(interface).map_or("", String::as_str);
    AtNode(
        name,
        Error::Input(format!(
            "interface {interface}: no node of its facet at ({x:.6}, {y:.6}, {z:.6}) m can carry a \
             traction, and none of the facets beside it: interfaces meet or end at them, or \
             displacements are prescribed there that are neither along nor across the interface; \
             prescribe none on the interface itself, and have more facets there"
        )),
    )
}
