//! What is special about nodes, known to every rank that has unknowns there.

use std::collections::BTreeMap;

use crate::assembly::{Framed, Frames};
use crate::comm::Comm;
use crate::mesh::LocalMesh;
use crate::space::{CARTESIAN, Directory, Nodes, Rotation, SpecialNode};

/// Numbers of an entry on its journey: the directions, the prescribed unknowns, the ends.
const WIDTH: usize = 12;
/// Stands for an end that there is not.
const NO_END: f64 = -1.0;

/// Directions, prescribed unknowns and ends of an edge.
#[derive(Debug, Clone, Copy)]
struct Entry {
    rotation: Rotation,
    fixed: [bool; 3],
    ends: Option<[u64; 2]>,
}

/// The special nodes by name.
pub struct SpecialByName {
    entries: BTreeMap<u64, Entry>,
}

impl SpecialByName {
    /// Of this rank's own cells, and of the further `needed` nodes from the ranks that own them.
    /// Adds the ends of edges in whose middles needed nodes lie. Collective.
    pub fn new(
        comm: &Comm,
        directory: &Directory<'_>,
        mesh: &LocalMesh,
        special: &[SpecialNode],
        needed: &mut Vec<u64>,
    ) -> Self {
        let name = |node: u32| mesh.nodes.names[node as usize];
        let entry = |special: &SpecialNode| Entry {
            rotation: special.rotation.unwrap_or(CARTESIAN),
            fixed: special.fixed,
            ends: special.ends.map(|ends| ends.map(name)),
        };
        let entries = special.iter().map(|special| (name(special.node), entry(special))).collect();
        let mut all = Self { entries };
        if !comm.any(!special.is_empty()) {
            return all;
        }
        // Ends have no ends, so that two rounds do.
        for _ in 0..2 {
            let mut far: Vec<u64> = needed.clone();
            far.retain(|name| mesh.nodes.number(*name).is_none());
            far.sort_unstable();
            far.dedup();
            all.fetch(comm, directory, &far);
            let ends = far.iter().filter_map(|name| all.entries.get(name)?.ends);
            needed.extend(ends.flatten().collect::<Vec<u64>>());
        }
        all
    }

    /// Gets the entries of nodes from their owners. Collective.
    fn fetch(&mut self, comm: &Comm, directory: &Directory<'_>, names: &[u64]) {
        let mut asked = vec![Vec::new(); comm.size() as usize];
        for (name, entry) in names.iter().zip(directory.look_up(names)) {
            asked[entry.owner as usize].push(*name);
        }
        let wanted = comm.exchange(&asked);
        let known = |name: &u64| {
            let entry = self.entries.get(name)?;
            Some((*name, entry.packed()))
        };
        let found: Vec<Vec<(u64, [f64; WIDTH])>> =
            wanted.iter().map(|list| list.iter().filter_map(known).collect()).collect();
        let names: Vec<Vec<u64>> =
            found.iter().map(|list| list.iter().map(|(name, _)| *name).collect()).collect();
        let values: Vec<Vec<f64>> = found
            .iter()
            .map(|list| list.iter().flat_map(|(_, values)| *values).collect())
            .collect();
        let (names, values) = (comm.exchange(&names), comm.exchange(&values));
        for (names, values) in names.iter().zip(&values) {
            for (name, values) in names.iter().zip(values.as_chunks::<WIDTH>().0) {
                self.entries.insert(*name, Entry::unpacked(values));
            }
        }
    }

    /// The prescribed unknowns of a special node.
    pub fn fixed(&self, name: u64) -> Option<[bool; 3]> {
        self.entries.get(&name).map(|entry| entry.fixed)
    }

    /// The frames of local nodes. Local.
    pub fn frames(&self, dim: usize, nodes: &Nodes) -> Frames {
        let local = |name: u64| nodes.local(name).expect("the ends of an edge are held");
        let framed = |(name, entry): (&u64, &Entry)| {
            let is_plain = entry.rotation == CARTESIAN && entry.ends.is_none();
            let node = nodes.local(*name).filter(|_| !is_plain)?;
            let ends = entry.ends.map(|ends| ends.map(local));
            Some(Framed { node, rotation: entry.rotation, ends })
        };
        Frames::new(dim, nodes.len(), self.entries.iter().filter_map(framed).collect())
    }
}

impl Entry {
    fn packed(&self) -> [f64; WIDTH] {
        let mut values = [0.0; WIDTH];
        values[..9].copy_from_slice(self.rotation.as_flattened());
        let bits = self.fixed.iter().enumerate().map(|(c, fixed)| u8::from(*fixed) << c);
        values[9] = f64::from(bits.sum::<u8>());
        // Names are whole numbers far below 2^53.
        let ends = self.ends.map_or([NO_END; 2], |ends| ends.map(|end| end as f64));
        values[10..].copy_from_slice(&ends);
        values
    }

    fn unpacked(values: &[f64; WIDTH]) -> Self {
        let bits = values[9] as u8;
        let ends = [values[10], values[11]];
        Self {
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| values[3 * i + j])),
            fixed: std::array::from_fn(|c| bits >> c & 1 == 1),
            ends: (ends[0] != NO_END).then(|| ends.map(|end| end as u64)),
        }
    }
}
