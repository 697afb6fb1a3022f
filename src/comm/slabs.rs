//! Rows by name, in slabs: each rank keeps those of one range of names, in their order.
//!
//! What is kept so lies in one order on any number of ranks.

use super::Comm;

/// The last rank whose first name is not above `name`: floor(r total / ranks) <= name.
pub fn keeper_of(name: u64, total: u64, ranks: u64) -> u64 {
    (((u128::from(name) + 1) * u128::from(ranks) - 1) / u128::from(total)) as u64
}

/// First name whose entry rank `rank` keeps.
pub fn first_of(rank: u64, total: u64, ranks: u64) -> u64 {
    (u128::from(rank) * u128::from(total) / u128::from(ranks)) as u64
}

/// Rows of numbers with their names, names rising.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// Numbers in a row.
    pub width: usize,
    /// Names, rising; each once.
    pub names: Vec<u64>,
    /// Row after row.
    pub values: Vec<f64>,
}

impl Comm {
    /// Gathers the rows of all ranks in slabs; all names are below `total`, and each occurs once.
    /// Collective.
    pub fn to_slabs(&self, total: u64, rows: &Rows) -> Rows {
        let (width, ranks) = (rows.width, self.size() as u64);
        let mut names = vec![Vec::new(); ranks as usize];
        let mut values = vec![Vec::new(); ranks as usize];
        for (name, row) in rows.names.iter().zip(rows.values.chunks_exact(width)) {
            let keeper = keeper_of(*name, total, ranks) as usize;
            names[keeper].push(*name);
            values[keeper].extend_from_slice(row);
        }
        let names = self.exchange(&names).concat();
        let values = self.exchange(&values).concat();
        let mut order: Vec<usize> = (0..names.len()).collect();
        order.sort_unstable_by_key(|row| names[*row]);
        Rows {
            width,
            names: order.iter().map(|row| names[*row]).collect(),
            values: order.iter().flat_map(|row| &values[row * width..][..width]).copied().collect(),
        }
    }

    /// The rows of the wanted names, in their order, from slabs; none where a name has no row.
    /// Collective.
    pub fn from_slabs(&self, total: u64, slab: &Rows, wanted: &[u64]) -> Vec<Option<Vec<f64>>> {
        let (width, ranks) = (slab.width, self.size() as u64);
        let mut asked = vec![Vec::new(); ranks as usize];
        for name in wanted {
            asked[keeper_of(*name, total, ranks) as usize].push(*name);
        }
        // A row and whether it is there.
        let answer = |names: &Vec<u64>| -> Vec<f64> {
            let mut words = Vec::with_capacity(names.len() * (width + 1));
            for name in names {
                match slab.names.binary_search(name) {
                    Ok(at) => {
                        words.push(1.0);
                        words.extend_from_slice(&slab.values[at * width..][..width]);
                    }
                    Err(_) => words.extend(std::iter::repeat_n(0.0, width + 1)),
                }
            }
            words
        };
        let answers: Vec<Vec<f64>> = self.exchange(&asked).iter().map(answer).collect();
        let answers = self.exchange(&answers);
        let mut next = vec![0; ranks as usize];
        let take = |name: &u64| {
            let keeper = keeper_of(*name, total, ranks) as usize;
            let words = &answers[keeper][next[keeper]..][..width + 1];
            next[keeper] += width + 1;
            (words[0] == 1.0).then(|| words[1..].to_vec())
        };
        wanted.iter().map(take).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_its_keeper() {
        for (total, ranks) in [(8, 20), (8, 3), (8, 8), (1000, 7), (12, 13), (u64::MAX / 2, 4096)] {
            for name in (0..total.min(1000)).chain(total - total.min(5)..total) {
                let keeper = keeper_of(name, total, ranks);
                let range = first_of(keeper, total, ranks)..first_of(keeper + 1, total, ranks);
                assert!(keeper < ranks && range.contains(&name), "{name} of {total} on {ranks}");
            }
        }
    }
}
