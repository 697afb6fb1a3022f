//! The pieces of a rank, made one after the other.

use super::runs::Runs;
use super::spread::Held;
use crate::error::Result;
use crate::mesh::slabs::{Given, Head, Key, Numbers, piece};

/// Set in what stands for a node that has no name yet.
const FRESH: u32 = 1 << 31;

/// What has become of the cells of a rank.
pub struct Work {
    /// Names of the files' nodes, of own cells and of those around.
    pub names: Numbers,
    /// Their positions (m).
    pub points: Vec<[f64; 3]>,
    /// The shortest edge (m) at each that own cells have, or a little more.
    pub shortest: Vec<f32>,
    /// The nodes of own cells: names, or places among the new nodes with a bit set; none where they
    /// are those of the file.
    pub nodes: Option<Vec<u32>>,
    /// New nodes, perhaps several times.
    pub fresh: Fresh,
    /// Facets on the boundary before cutting, by names of own cells.
    pub boundary: Vec<(u32, u8)>,
    /// How many new nodes each node of own cells has in edges and faces.
    pub counts: Vec<(u32, [u32; 2])>,
    /// Nodes that were split, and how many copies they got.
    pub splits: Vec<(Key, u32)>,
}

/// New nodes.
#[derive(Default)]
pub struct Fresh {
    /// What each is.
    pub keys: Vec<Key>,
    /// Their positions (m).
    pub points: Vec<[f64; 3]>,
    /// The shortest edge (m) at each, or a little more.
    pub shortest: Vec<f32>,
}

/// The place of a new node in what stands for it.
pub fn fresh_place(node: u32) -> Option<usize> {
    (node & FRESH != 0).then_some((node & !FRESH) as usize)
}

impl Work {
    /// Before any piece is made.
    pub fn new(names: Numbers, points: Vec<[f64; 3]>) -> Self {
        let shortest = vec![f32::INFINITY; points.len()];
        let (fresh, boundary, counts, splits) = Default::default();
        Self { names, points, shortest, nodes: None, fresh, boundary, counts, splits }
    }

    /// Makes all pieces.
    ///
    /// # Arguments
    /// * `runs`: where the nodes of own cells stand after raising
    /// * `cuts`: the facets along which the mesh is cut, rising
    ///
    /// # Errors
    /// As [`piece`].
    pub fn make(
        &mut self,
        head: &Head,
        held: &Held,
        runs: &Runs,
        is_raised: bool,
        cuts: &[(u32, u8)],
    ) -> Result<()> {
        let is_changed = runs.nodes() != held.nodes.len() || !cuts.is_empty();
        let mut out = if is_changed { vec![0; runs.nodes()] } else { Vec::new() };
        for (number, beside) in (0_u16..).zip(&held.beside) {
            let own = (0..held.cells.len()).filter(|cell| held.pieces[*cell] == number);
            let mut places: Vec<(u32, u32)> =
                own.map(|place| (held.cells[place], place as u32)).collect();
            places.extend(beside.iter().map(|place| (held.cell(*place as usize).0, *place)));
            places.sort_unstable();
            let is_own = |place: u32| held.pieces.get(place as usize) == Some(&number);
            let given: Vec<Given<'_>> = places
                .iter()
                .map(|(name, place)| {
                    let nodes = held.cell(*place as usize).1;
                    Given { name: *name, nodes, is_own: is_own(*place) }
                })
                .collect();
            let point = |name: u32| self.points[self.names.place(name).unwrap_or_default()];
            let made = piece(head, &given, &point, is_raised, cuts)?;
            drop(given);
            let mut words = vec![0; made.keys.len()];
            let mut is_told = vec![false; made.keys.len()];
            let mut at = 0;
            for (_, place) in places.iter().filter(|(_, place)| is_own(*place)) {
                let range = runs.of(*place as usize);
                for (offset, node) in made.nodes[at..at + range.len()].iter().enumerate() {
                    let node = *node as usize;
                    if !std::mem::replace(&mut is_told[node], true) {
                        let shortest = made.shortest.get(node).copied();
                        words[node] = self.word(made.keys[node], made.points[node], shortest);
                    }
                    if is_changed {
                        out[range.start + offset] = words[node];
                    }
                }
                at += range.len();
            }
            self.boundary.extend(made.boundary);
            self.counts.extend(made.counts);
            self.splits.extend(made.splits);
        }
        self.nodes = is_changed.then_some(out);
        Ok(())
    }

    /// What stands for a node of an own cell.
    fn word(&mut self, key: Key, point: [f64; 3], shortest: Option<f64>) -> u32 {
        let least = shortest.map_or(f32::INFINITY, from_above);
        if let Some(name) = key.name() {
            if let Some(place) = self.names.place(name) {
                self.shortest[place] = least;
            }
            return name;
        }
        self.fresh.keys.push(key);
        self.fresh.points.push(point);
        self.fresh.shortest.push(least);
        FRESH | (self.fresh.keys.len() - 1) as u32
    }
}

/// A length in half the memory, not below what it is.
fn from_above(length: f64) -> f32 {
    let near = length as f32;
    if f64::from(near) < length { near.next_up() } else { near }
}
