//! The nodes of one rank and the exchange of their values.

use mpi::datatype::traits::Equivalence;

use super::Directory;
use crate::comm::{Comm, Neighbours};
use crate::error::Result;
use crate::mesh::{Marks, Places};
use crate::sparse::Real;

/// Local nodes, owned first (by rising name), then ghosts (by owner, then number).
pub struct Nodes {
    /// Name of each local node.
    pub names: Vec<u64>,
    /// Position of each local node (m).
    pub points: Vec<[f64; 3]>,
    /// Where each local node lies.
    pub marks: Vec<Marks>,
    /// Block number of each local node among all nodes.
    pub numbers: Vec<i32>,
    /// Owned nodes.
    pub owned: usize,
    /// Number of the first owned node.
    pub first: i32,
    /// Nodes of all ranks.
    pub total: u64,
    /// Rank that owns each ghost.
    pub ghost_owners: Vec<usize>,
    /// Local numbers by rising name.
    by_name: Vec<u32>,
    /// Owned nodes that neighbours hold as ghosts, by neighbour.
    shared: Vec<u32>,
    forward: Neighbours,
    backward: Neighbours,
}

impl Nodes {
    /// The owned nodes of the directory and the given further nodes, owned or not. `places` has the
    /// owned ones, by rising name. Collective.
    pub fn new(
        comm: &Comm,
        directory: &Directory<'_>,
        needed: &[u64],
        places: &Places,
    ) -> Result<Self> {
        let owned = directory.owned.len();
        let mut others: Vec<u64> =
            needed.iter().copied().filter(|n| directory.owned.binary_search(n).is_err()).collect();
        others.sort_unstable();
        others.dedup();
        let entries = directory.look_up(&others);
        let mut ghosts: Vec<_> = entries.iter().map(|e| (e.owner, e.number)).zip(others).collect();
        ghosts.sort_unstable();

        let mut wanted = vec![Vec::new(); comm.size() as usize];
        for ((owner, number), _) in &ghosts {
            wanted[*owner as usize].push(*number);
        }
        let asked = comm.exchange(&wanted);
        let counts = |lists: &[Vec<i32>]| -> Vec<(i32, usize)> {
            let counted = lists.iter().enumerate().map(|(rank, list)| (rank as i32, list.len()));
            counted.filter(|(_, n)| *n > 0).collect()
        };
        let (to_send, to_receive) = (counts(&asked), counts(&wanted));
        let first = directory.first_owned;
        let names: Vec<u64> =
            directory.owned.iter().copied().chain(ghosts.iter().map(|g| g.1)).collect();
        let mut by_name: Vec<u32> = (0..names.len() as u32).collect();
        by_name.sort_unstable_by_key(|i| names[*i as usize]);
        let mut nodes = Self {
            points: Vec::new(),
            marks: Vec::new(),
            numbers: (first..first + owned as i32).chain(ghosts.iter().map(|g| g.0.1)).collect(),
            names,
            owned,
            first,
            ghost_owners: ghosts.iter().map(|g| g.0.0 as usize).collect(),
            total: comm.sum_u64(owned as u64),
            by_name,
            shared: asked.iter().flatten().map(|n| (n - first) as u32).collect(),
            forward: Neighbours::new(comm, to_send.clone(), to_receive.clone())?,
            backward: Neighbours::new(comm, to_receive, to_send)?,
        };
        nodes.place(places);
        Ok(nodes)
    }

    /// Takes positions and marks of the owned nodes, and gets those of the ghosts. Collective.
    fn place(&mut self, places: &Places) {
        const WIDTH: usize = 3 + Marks::PACKED;
        let mut values = vec![0.0; self.len() * WIDTH];
        for (name, values) in self.names[..self.owned].iter().zip(values.chunks_exact_mut(WIDTH)) {
            let at = places.number(*name).expect("an owned node is one of the rank's cells");
            values[..3].copy_from_slice(&places.points[at]);
            values[3..].copy_from_slice(&places.marks[at].packed());
        }
        self.update_ghosts(&mut values, WIDTH);
        let (nodes, _) = values.as_chunks::<WIDTH>();
        self.points = nodes.iter().map(|v| [v[0], v[1], v[2]]).collect();
        let marks = |[_, _, _, marks @ ..]: &[f64; WIDTH]| Marks::unpacked(*marks);
        self.marks = nodes.iter().map(marks).collect();
    }

    /// Ranks whose nodes this rank holds, or that hold its nodes.
    pub fn neighbours(&self) -> usize {
        self.forward.ranks().len()
    }

    /// Local nodes, owned and ghosts.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether this rank holds no node.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Name, position and marks of every owned node.
    pub fn iter_owned(&self) -> impl Iterator<Item = (u64, [f64; 3], &Marks)> {
        let places = self.names[..self.owned].iter().zip(&self.points).zip(&self.marks);
        places.map(|((name, point), marks)| (*name, *point, marks))
    }

    /// The place of a node of any rank, in words. Collective.
    pub fn place_in_words(&self, comm: &Comm, name: u64) -> String {
        let mut point = [f64::NEG_INFINITY; 3];
        if let Some(node) = self.local(name) {
            point = self.points[node as usize];
        }
        comm.max(&mut point);
        let [x, y, z] = point;
        format!("at ({x}, {y}, {z}) m")
    }

    /// Local number of a node that this rank holds.
    pub fn local(&self, name: u64) -> Option<u32> {
        let at = self.by_name.binary_search_by_key(&name, |i| self.names[*i as usize]).ok()?;
        Some(self.by_name[at])
    }

    /// Copies the owners' values to the ghosts; `values` holds `width` numbers per local node.
    /// Collective.
    pub fn update_ghosts<T: Equivalence + Copy>(&self, values: &mut [T], width: usize) {
        let (owned, ghosts) = values.split_at_mut(self.owned * width);
        let mut outgoing = Vec::with_capacity(self.shared.len() * width);
        for node in &self.shared {
            outgoing.extend_from_slice(&owned[*node as usize * width..][..width]);
        }
        self.forward.exchange_wide(width, &outgoing, ghosts);
    }

    /// Adds the ghosts' values to the owners' and clears the ghosts. Collective.
    pub fn add_to_owners<T: Equivalence + Real>(&self, values: &mut [T], width: usize) {
        let (owned, ghosts) = values.split_at_mut(self.owned * width);
        self.add_ghosts_to_owners(owned, ghosts, width);
    }

    /// As [`Nodes::add_to_owners`], with the two kinds of values apart. Collective.
    pub fn add_ghosts_to_owners<T: Equivalence + Real>(
        &self,
        owned: &mut [T],
        ghosts: &mut [T],
        width: usize,
    ) {
        let mut incoming = vec![T::ZERO; self.shared.len() * width];
        self.backward.exchange_wide(width, ghosts, &mut incoming);
        for (node, value) in self.shared.iter().zip(incoming.chunks_exact(width)) {
            let target = &mut owned[*node as usize * width..][..width];
            target.iter_mut().zip(value).for_each(|(t, v)| *t += *v);
        }
        ghosts.fill(T::ZERO);
    }
}
