//! Facets of interfaces that are divided before anything is solved: those at which nothing would
//! hold, and those by which bodies hang that could turn without them.
//!
//! Where interfaces meet or end at all nodes of a facet, none of them carries a multiplier. If
//! facets beside it do, they act there too ([`Heirs`]); but what holds a body may be the multiplier
//! of a single node, about which it turns.

use nalgebra::{DMatrix, SymmetricEigen};

use super::special::{Carriers, special_at, special_of};
use crate::case::Case;
use crate::error::{Error, Result};
use crate::interface::{Heirs, Multipliers, Sides, lost_facets};
use crate::mesh::whole::WholeFacet;
use crate::mesh::{Facet, LocalMesh, Marks, MeshFamily};
use crate::space::{Prescribed, SpecialNode};

/// A motion is free where what resists it is less than this part of the most that any meets.
const FREE: f64 = 1e-9;

/// The meshes of a case, in that of a file with facets divided. Local; reads the file.
///
/// # Errors
/// As [`MeshFamily::new`]; `Input` for a body that could still turn.
pub fn family(case: &Case) -> Result<MeshFamily> {
    let family = MeshFamily::new(case)?;
    if !family.is_of_file() || case.interfaces.is_empty() {
        return Ok(family);
    }
    let of_dimension = case.clone().for_dimension(family.facts().dim)?;
    let mut found = Found::of(&of_dimension, &family)?;
    let refine = case.mesh.refine;
    if refine > 0 && !found.facets.is_empty() {
        let coarse = MeshFamily::divided(case, 0, &[])?;
        found = Found::of(&of_dimension, &coarse)?;
    }
    if found.facets.is_empty() {
        return Ok(family);
    }
    // Where that makes no mesh, it is refused at the facet.
    let divided = MeshFamily::divided(case, refine, &found.facets).unwrap_or(family);
    let left = Found::of(&of_dimension, &divided)?;
    match left.loose.filter(|_| !left.has_lost) {
        Some([x, y, z]) => Err(Error::Input(format!(
            "interfaces hold the body around ({x:.4}, {y:.4}, {z:.4}) m at too few nodes: it could \
             turn about them; have more facets on its interfaces, as with `mesh.refine: 1`"
        ))),
        None => Ok(divided),
    }
}

/// Why the mesh of a file has to be read whole that was read in slabs: where facets are to be
/// divided. Local, on the root.
///
/// # Errors
/// `Input` where the case does not fit the dimension of the mesh.
pub fn divides(case: &Case, family: &MeshFamily) -> Result<Option<String>> {
    if case.interfaces.is_empty() {
        return Ok(None);
    }
    let case = case.clone().for_dimension(family.facts().dim)?;
    let found = Found::of(&case, family)?;
    let why = "facets of interfaces are divided, at which nothing would hold otherwise";
    Ok((!found.facets.is_empty()).then(|| why.to_owned()))
}

/// What is found in a mesh.
#[derive(Debug, Default)]
struct Found {
    /// Facets to divide, on the lips with multipliers.
    facets: Vec<WholeFacet>,
    /// Whether nothing would hold at some facet, which is refused at its place.
    has_lost: bool,
    /// The middle (m) of a body that could move even where contacts are closed.
    loose: Option<[f64; 3]>,
}

impl Found {
    fn of(case: &Case, family: &MeshFamily) -> Result<Self> {
        let prescribed = Prescribed::new(case);
        let is_doubtful = |marks: &Marks| marks.is_junction || prescribed.acts_on(marks);
        if !family.touches_interfaces(&is_doubtful)? {
            return Ok(Self::default());
        }
        let mesh = &family.whole()?;
        let sides = &Sides::choose(case, &mesh.facts);
        let special = &special_of(case, mesh, sides, &prescribed);
        let prescribed = &prescribed;
        Ok(Scene { case, mesh, sides, special, prescribed }.search())
    }
}

/// A case on its whole mesh.
struct Scene<'a> {
    case: &'a Case,
    mesh: &'a LocalMesh,
    sides: &'a [Sides],
    special: &'a [SpecialNode],
    prescribed: &'a Prescribed,
}

impl Scene<'_> {
    fn search(&self) -> Found {
        let carriers =
            Carriers { mesh: self.mesh, special: self.special, prescribed: self.prescribed };
        let (fixed, is_lost) = (|name| carriers.fixed(name), |name| carriers.is_lost(name));
        let nodes = Multipliers { fixed: &fixed, is_lost: &is_lost };
        let lost = lost_facets(self.mesh, self.sides, &nodes);
        let mut facets =
            Heirs::here(self.mesh, self.sides, &nodes).without(self.mesh, self.sides, &lost);
        let weak = self.weak_facets(&fixed);
        let mut bodies: Vec<usize> = weak.iter().flat_map(|(_, bodies)| bodies.clone()).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let mut found = Found { has_lost: !facets.is_empty(), ..Found::default() };
        for hold in self.holds(&bodies, &fixed) {
            if is_free(&hold.firm) {
                let of_body = weak.iter().filter(|(_, bodies)| bodies.contains(&hold.body));
                facets.extend(of_body.map(|(facet, _)| *facet));
                if is_free(&hold.with_contacts) {
                    found.loose.get_or_insert(hold.middle());
                }
            }
        }
        facets.sort_unstable_by_key(|facet| (facet.cell, facet.facet));
        facets.dedup();
        let whole = |facet: &Facet| WholeFacet {
            cell: self.mesh.cells[facet.cell as usize] as u32,
            facet: facet.facet,
        };
        found.facets = facets.iter().map(whole).collect();
        found
    }

    fn body(&self, node: u32) -> usize {
        self.mesh.nodes.marks[node as usize].body as usize
    }

    /// The bodies on both sides of a facet of the side with multipliers.
    fn bodies_at(&self, side: &Sides, facet: Facet) -> Vec<usize> {
        let own = self.mesh.facet_nodes(facet).1[0];
        let across = self.mesh.across(side.interface, side.secondary, facet);
        let far = across.iter().filter_map(|far| self.mesh.nodes.number(far.nodes[0]));
        let mut bodies: Vec<usize> =
            far.map(|node| self.body(node as u32)).chain([self.body(own)]).collect();
        bodies.sort_unstable();
        bodies.dedup();
        bodies
    }

    fn holds_firmly(&self, side: &Sides) -> bool {
        self.case.interfaces[side.interface].joins_at_start().unwrap_or(true)
    }

    /// The facets of interfaces that hold, where some node carries no multiplier, with the bodies
    /// on both sides.
    fn weak_facets(&self, fixed: &dyn Fn(u64) -> [bool; 3]) -> Vec<(Facet, Vec<usize>)> {
        let is_without = |node: &u32| {
            let fixed = fixed(self.mesh.nodes.names[*node as usize]);
            fixed[..self.mesh.dim()].iter().all(|fixed| *fixed)
        };
        let mut found = Vec::new();
        for side in self.sides.iter().filter(|side| self.holds_firmly(side)) {
            for facet in self.mesh.on_lip(side.interface, side.secondary) {
                if self.mesh.facet_nodes(*facet).1.iter().any(is_without) {
                    found.push((*facet, self.bodies_at(side, *facet)));
                }
            }
        }
        found
    }

    /// What holds some bodies, which rise.
    fn holds(&self, bodies: &[usize], fixed: &dyn Fn(u64) -> [bool; 3]) -> Vec<Hold> {
        let (nodes, dim) = (&self.mesh.nodes, self.mesh.dim());
        let mut holds: Vec<Hold> = bodies.iter().map(|body| Hold::new(*body, dim)).collect();
        let place = |body: usize| bodies.binary_search(&body).ok();
        for node in 0..nodes.names.len() as u32 {
            if let Some(place) = place(self.body(node)) {
                holds[place].see(self.along_axes(node));
            }
        }
        for node in 0..nodes.names.len() as u32 {
            let Some(place) = place(self.body(node)) else { continue };
            let normals = |surface| self.mesh.directions.of_surface(node, surface).collect();
            for given in self.prescribed.given_at(&nodes.marks[node as usize], normals) {
                holds[place].add(self.along_axes(node), given.direction, true);
            }
        }
        for (side, facet) in self.sides.iter().flat_map(|side| {
            let facets = self.mesh.on_lip(side.interface, side.secondary);
            facets.iter().map(move |facet| (side, *facet))
        }) {
            let (is_firm, at) = (self.holds_firmly(side), self.bodies_at(side, facet));
            for node in self.mesh.facet_nodes(facet).1 {
                let fixed = fixed(nodes.names[node as usize]);
                let first = if is_firm { 0 } else { dim - 1 };
                for c in (first..dim).filter(|c| !fixed[*c]) {
                    let direction = self.direction(node, c);
                    for place in at.iter().filter_map(|body| place(*body)) {
                        holds[place].add(self.along_axes(node), direction, is_firm);
                    }
                }
            }
        }
        holds
    }

    /// The position of a node by components (m).
    fn along_axes(&self, node: u32) -> [f64; 3] {
        let (point, axes) = (self.mesh.nodes.points[node as usize], self.mesh.facts.axes);
        std::array::from_fn(|c| axes.get(c).map_or(0.0, |axis| point[*axis]))
    }

    /// The direction of an unknown of a node, by components.
    fn direction(&self, node: u32, unknown: usize) -> [f64; 3] {
        let rotation = special_at(self.special, node).and_then(|special| special.rotation);
        let axis = std::array::from_fn(|c| f64::from(u8::from(c == unknown)));
        rotation.map_or(axis, |rotation| rotation[unknown])
    }
}

/// What holds a body.
struct Hold {
    body: usize,
    dim: usize,
    low: [f64; 3],
    high: [f64; 3],
    /// What resists its rigid motions: of supports and of interfaces that hold, and of contacts
    /// besides.
    firm: DMatrix<f64>,
    with_contacts: DMatrix<f64>,
}

impl Hold {
    fn new(body: usize, dim: usize) -> Self {
        let motions = if dim == 2 { 3 } else { 6 };
        let none = DMatrix::zeros(motions, motions);
        let (low, high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        Self { body, dim, low, high, firm: none.clone(), with_contacts: none }
    }

    /// A point of the body, by components (m).
    fn see(&mut self, at: [f64; 3]) {
        for (i, x) in at.into_iter().enumerate() {
            self.low[i] = self.low[i].min(x);
            self.high[i] = self.high[i].max(x);
        }
    }

    fn middle(&self) -> [f64; 3] {
        std::array::from_fn(|i| 0.5 * (self.low[i] + self.high[i]))
    }

    /// The body is held at a point along a direction, by components.
    fn add(&mut self, at: [f64; 3], direction: [f64; 3], is_firm: bool) {
        let rotations: &[[usize; 2]] =
            if self.dim == 2 { &[[0, 1]] } else { &[[0, 1], [1, 2], [2, 0]] };
        let size = (0..self.dim).map(|i| self.high[i] - self.low[i]).fold(0.0, f64::max);
        let middle = self.middle();
        let lever = |i: usize| (at[i] - middle[i]) / size;
        let turned =
            rotations.iter().map(|[a, b]| lever(*a) * direction[*b] - lever(*b) * direction[*a]);
        let all: Vec<f64> = direction[..self.dim].iter().copied().chain(turned).collect();
        let of = DMatrix::from_fn(all.len(), all.len(), |i, j| all[i] * all[j]);
        if is_firm {
            self.firm += &of;
        }
        self.with_contacts += of;
    }
}

/// Whether some rigid motion meets no resistance.
fn is_free(resistance: &DMatrix<f64>) -> bool {
    let values = SymmetricEigen::new(resistance.clone()).eigenvalues;
    values.min() <= FREE * values.max().max(f64::MIN_POSITIVE)
}
