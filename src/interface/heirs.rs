//! Facets of a secondary side none of whose nodes carries a multiplier: those of other facets act
//! there as well.
//!
//! Interfaces meet or end at all nodes of such a facet, or supports lean against it. Each node
//! has an heir: the nearest node with a multiplier on a facet that goes straight on, on both lips,
//! from the node. The function of the node on the facet is handed over to the heir's multiplier. So
//! the functions add up to one there as everywhere, and constant tractions pass: those of a branch
//! at an angle are others.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::facet_terms::{Terms, space_facets};
use super::mortar::{Contribution, Partners, SpaceFacet, facet_rows_in_space};
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

/// Facets go straight on where their normals turn by less than 30 degrees: the cosine.
const STRAIGHT: f64 = 0.866_025_403_784_438_6;

/// Sides match at points that are apart by less than this part of their facet.
const SAME: f64 = 1e-9;

/// No node of the other side.
const NONE: u64 = u64::MAX;

/// Where a node is on a facet.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// The normal of the facet.
    normal: [f64; 3],
    /// The node that faces it, where the sides match.
    mate: u64,
}

impl Place {
    /// Whether the interface goes straight on from one facet at the node to the other, on both
    /// lips: where a branch begins at one lip, that of the other is not asked either. So it does
    /// not matter which of them carries the multipliers.
    fn goes_on_at(&self, other: &Self) -> bool {
        let turn: f64 = (0..3).map(|i| self.normal[i] * other.normal[i]).sum();
        let [one, two] = [self.mate, other.mate];
        turn > STRAIGHT && (one == two || one == NONE || two == NONE)
    }
}

/// A node that acts for another one.
#[derive(Debug, Clone, Copy)]
struct Heir {
    /// Bit c: component c has no multiplier.
    missing: u64,
    /// The squared distance (m2).
    square: f64,
    /// Its position (m).
    point: [f64; 3],
    name: u64,
    /// The other node, on the facet of both.
    place: Place,
}

impl Heir {
    /// Better are those with more components, then the nearer one; then the place decides, which no
    /// numbers change.
    fn order(&self, other: &Self) -> Ordering {
        let fewer = self.missing.count_ones().cmp(&other.missing.count_ones());
        let nearer = self.square.total_cmp(&other.square);
        let along = |i: usize| self.point[i].total_cmp(&other.point[i]);
        let first = (0..3).map(along).fold(Ordering::Equal, Ordering::then);
        fewer.then(nearer).then(first).then(self.name.cmp(&other.name))
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

/// Numbers of an heir on its journey: node, interface, components, distance, name, the node that
/// faces, position, normal.
const WIDTH: usize = 12;

/// Who may be heirs of nodes.
#[derive(Debug, Default)]
pub struct Heirs {
    of: BTreeMap<Key, Vec<Heir>>,
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

/// The facets of this rank without multipliers that supports have taken, if the nodes across from
/// them are others, which need not be held: those of meshes that do not match. Local.
pub fn held_facets(mesh: &LocalMesh, sides: &[Sides], nodes: &Multipliers<'_>) -> Vec<LostFacet> {
    let mut found = Vec::new();
    for (place, side) in sides.iter().enumerate() {
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let is_held =
                |name: &u64| nodes.is_without(*name, mesh.dim()) && !(nodes.is_lost)(*name);
            let is_matched = || places(mesh, side, *facet).iter().all(|p| p.mate != NONE);
            if names(mesh, *facet).iter().all(is_held) && !is_matched() {
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
                let name = |place: usize| mesh.nodes.names[local[place] as usize];
                let point = |place: usize| mesh.nodes.points[local[place] as usize];
                let (without, with): (Vec<usize>, Vec<usize>) =
                    (0..local.len()).partition(|place| nodes.is_without(name(*place), mesh.dim()));
                if without.is_empty() || with.is_empty() {
                    continue;
                }
                let places = places(mesh, side, *facet);
                for one in without {
                    for other in &with {
                        let (a, b) = (point(one), point(*other));
                        let heir = Heir {
                            missing: nodes.missing(name(*other), mesh.dim()),
                            square: (0..3).map(|i| (a[i] - b[i]).powi(2)).sum(),
                            point: b,
                            name: name(*other),
                            place: places[one],
                        };
                        heirs.see((name(one), side.interface as u64), heir);
                    }
                }
            }
        }
        heirs
    }

    fn see(&mut self, key: Key, heir: Heir) {
        self.of.entry(key).or_default().push(heir);
    }

    fn see_words(&mut self, lists: &[Vec<u64>]) {
        for row in lists.iter().flat_map(|list| list.as_chunks::<WIDTH>().0) {
            let [node, interface, missing, square, name, mate, vectors @ ..] = *row;
            let [x, y, z, u, v, w] = vectors.map(f64::from_bits);
            let (place, square) = (Place { normal: [u, v, w], mate }, f64::from_bits(square));
            let heir = Heir { missing, square, point: [x, y, z], name, place };
            self.see((node, interface), heir);
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
            let heirs = self.of[key].iter();
            packed[entry.owner as usize].extend(heirs.flat_map(|heir| words(key, heir)));
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
        let of_name = self.of.range((name, 0)..=(name, u64::MAX));
        of_name.flat_map(|(key, heirs)| heirs.iter().flat_map(|heir| words(key, heir)))
    }

    /// The heir of each node of a facet, the best one of the others where one has none; none if no
    /// node has one. Local.
    fn of_facet(&self, mesh: &LocalMesh, sides: &[Sides], lost: LostFacet) -> Option<Vec<Heir>> {
        let side = &sides[lost.side];
        let heir = |(name, place): (u64, Place)| {
            let all = self.of.get(&(name, side.interface as u64))?.iter();
            all.filter(|heir| place.goes_on_at(&heir.place)).min_by(|a, b| a.order(b)).copied()
        };
        let places = places(mesh, side, lost.facet);
        let heirs: Vec<Option<Heir>> =
            names(mesh, lost.facet).into_iter().zip(places).map(heir).collect();
        let first = *heirs.iter().flatten().min_by(|a, b| a.order(b))?;
        Some(heirs.into_iter().map(|heir| heir.unwrap_or(first)).collect())
    }

    /// The facets no node of which has an heir. Local.
    pub fn without(&self, mesh: &LocalMesh, sides: &[Sides], lost: &[LostFacet]) -> Vec<Facet> {
        let lost = lost.iter().filter(|lost| self.of_facet(mesh, sides, **lost).is_none());
        lost.map(|lost| lost.facet).collect()
    }

    /// The area of those held facets of each side that no multiplier acts on (m2; 2D: m). Local.
    pub fn silent(&self, mesh: &LocalMesh, sides: &[Sides], held: &[LostFacet]) -> Vec<f64> {
        let mut areas = vec![0.0; sides.len()];
        for one in held.iter().filter(|one| self.of_facet(mesh, sides, **one).is_none()) {
            let (facet, _) = space_facets(mesh, &sides[one.side], one.facet);
            areas[one.side] += facet.rule().iter().map(|p| p.weight).sum::<f64>();
        }
        areas
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
    let [x, y, z] = heir.point.map(f64::to_bits);
    let [u, v, w] = heir.place.normal.map(f64::to_bits);
    let Place { mate, .. } = heir.place;
    [key.0, key.1, heir.missing, heir.square.to_bits(), heir.name, mate, x, y, z, u, v, w]
}

/// Each node of a facet on it.
fn places(mesh: &LocalMesh, side: &Sides, facet: Facet) -> Vec<Place> {
    let (own, far) = space_facets(mesh, side, facet);
    let normal = own.middle_normal().unwrap_or_default();
    let is_near = |a: &[f64; 3], b: &[f64; 3]| {
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt() <= SAME * own.size()
    };
    let faced = |far: &SpaceFacet, point: &[f64; 3]| -> Option<u64> {
        let place = far.points().iter().position(|other| is_near(point, other))?;
        Some(far.nodes()[place])
    };
    let all = |far: &SpaceFacet| -> Option<Vec<u64>> {
        own.points().iter().map(|point| faced(far, point)).collect()
    };
    let mates = far.iter().find_map(all).unwrap_or_else(|| vec![NONE; own.nodes().len()]);
    mates.into_iter().map(|mate| Place { normal, mate }).collect()
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
