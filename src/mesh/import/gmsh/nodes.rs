//! The nodes of a file, and the way from their numbers, which have gaps, to their indices.

use super::cursor::{Cursor, REWRITE};
use super::format::Version;
use crate::error::Result;

/// The nodes in the order of the file.
pub(super) struct Nodes {
    pub points: Vec<[f64; 3]>,
    pub numbers: Vec<u64>,
    index: Index,
}

/// From the number of a node to its index.
enum Index {
    /// The index of each number from the first on; `u32::MAX` where there is none.
    Table { first: u64, places: Vec<u32> },
    /// Numbers and indices, rising.
    Sorted(Vec<(u64, u32)>),
}

impl Nodes {
    /// Reads `$Nodes`, or `$ParametricNodes` of MSH 2.2.
    pub fn read(cursor: &mut Cursor, version: Version, is_parametric: bool) -> Result<Self> {
        let mut nodes =
            Self { points: Vec::new(), numbers: Vec::new(), index: Index::Sorted(Vec::new()) };
        match version {
            Version::V2 => nodes.read_v2(cursor, is_parametric)?,
            Version::V4 => nodes.read_v4(cursor)?,
        }
        nodes.index = Index::new(&nodes.numbers, cursor)?;
        Ok(nodes)
    }

    fn read_v2(&mut self, cursor: &mut Cursor, is_parametric: bool) -> Result<()> {
        let count = cursor.text_count()?;
        let count = cursor.check_room(count, 8, 28, "nodes")?;
        self.reserve(count);
        for _ in 0..count {
            cursor.begin();
            self.numbers.push(cursor.size()?);
            self.points.push(cursor.point()?);
            if is_parametric {
                skip_parameters_v2(cursor)?;
            }
            cursor.end()?;
        }
        Ok(())
    }

    fn read_v4(&mut self, cursor: &mut Cursor) -> Result<()> {
        cursor.begin();
        let [blocks, total, ..] = [cursor.size()?, cursor.size()?, cursor.size()?, cursor.size()?];
        cursor.end()?;
        cursor.check_room(blocks, 8, 16, "blocks of nodes")?;
        let total = cursor.check_room(total, 8, 28, "nodes")?;
        self.reserve(total);
        for _ in 0..blocks {
            cursor.begin();
            let (dim, _entity, parametric) = (cursor.int()?, cursor.int()?, cursor.int()?);
            let count = cursor.size()?;
            let parameters = match (parametric, dim) {
                (0, _) | (_, 0) => 0,
                (_, 1..=3) => dim,
                _ => return Err(cursor.error(format!("an entity has dimension {dim}"), REWRITE)),
            };
            cursor.end()?;
            let count = cursor.check_room(count, 8, 28, "nodes")?;
            for _ in 0..count {
                cursor.begin();
                self.numbers.push(cursor.size()?);
            }
            for _ in 0..count {
                cursor.begin();
                self.points.push(cursor.point()?);
                for _ in 0..parameters {
                    cursor.real()?;
                }
                cursor.end()?;
            }
        }
        let found = self.points.len();
        if found != total {
            let what = format!("{total} nodes are promised, the blocks have {found}");
            return Err(cursor.error(what, REWRITE));
        }
        Ok(())
    }

    fn reserve(&mut self, count: usize) {
        self.points.reserve(count);
        self.numbers.reserve(count);
    }

    /// The index of a node.
    pub fn index_of(&self, number: u64) -> Option<u32> {
        match &self.index {
            Index::Table { first, places } => {
                let place = usize::try_from(number.checked_sub(*first)?).ok()?;
                places.get(place).copied().filter(|index| *index != u32::MAX)
            }
            Index::Sorted(list) => {
                let at = list.binary_search_by_key(&number, |(number, _)| *number).ok()?;
                Some(list[at].1)
            }
        }
    }
}

/// Entity and parameters of a node of MSH 2.2: one on curves, two on surfaces.
fn skip_parameters_v2(cursor: &mut Cursor) -> Result<()> {
    if cursor.is_ascii() {
        cursor.skip_line();
        return Ok(());
    }
    let (dim, _entity) = (cursor.int()?, cursor.int()?);
    let parameters = if dim == 1 || dim == 2 { dim } else { 0 };
    for _ in 0..parameters {
        cursor.real()?;
    }
    Ok(())
}

impl Index {
    fn new(numbers: &[u64], cursor: &Cursor) -> Result<Self> {
        if u32::try_from(numbers.len()).is_err() {
            let what = format!("{} nodes are more than 32 bits count", numbers.len());
            return Err(cursor.error(what, "make the mesh coarser"));
        }
        let twice =
            |number: u64| cursor.error(format!("two nodes have the number {number}"), REWRITE);
        let (first, last) = (
            numbers.iter().min().copied().unwrap_or(0),
            numbers.iter().max().copied().unwrap_or(0),
        );
        // As large as twice the nodes is cheap; sparser numbers are searched.
        if last - first < 2 * numbers.len() as u64 {
            let mut places = vec![u32::MAX; (last - first) as usize + 1];
            for (index, number) in numbers.iter().enumerate() {
                let place = &mut places[(number - first) as usize];
                if *place != u32::MAX {
                    return Err(twice(*number));
                }
                *place = index as u32;
            }
            return Ok(Self::Table { first, places });
        }
        let mut list: Vec<_> = numbers.iter().copied().zip(0..).collect();
        list.sort_unstable();
        match list.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(twice(pair[0].0)),
            None => Ok(Self::Sorted(list)),
        }
    }
}
