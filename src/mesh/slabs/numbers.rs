//! Whole numbers of a range, each with its place among those that are there.

/// A set of numbers of a range that is dense enough for a bit for each.
#[derive(Debug, Clone, Default)]
pub struct Numbers {
    first: u32,
    words: Vec<u64>,
    /// How many are there before each word.
    before: Vec<u32>,
}

impl Numbers {
    /// Those of a list, all of which lie from `first` on and before `end`.
    pub fn of(first: u32, end: u64, list: impl Iterator<Item = u32>) -> Self {
        let range = end.saturating_sub(u64::from(first)) as usize;
        let mut words = vec![0_u64; range.div_ceil(64)];
        for number in list {
            let at = (number - first) as usize;
            words[at / 64] |= 1 << (at % 64);
        }
        let mut sum = 0;
        let before = words.iter().map(|word| {
            sum += word.count_ones();
            sum - word.count_ones()
        });
        Self { first, before: before.collect(), words }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        let last = self.before.last().zip(self.words.last());
        last.map_or(0, |(before, word)| (before + word.count_ones()) as usize)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The place of a number, if it is there.
    pub fn place(&self, number: u32) -> Option<usize> {
        let at = number.checked_sub(self.first)? as usize;
        let word = *self.words.get(at / 64)?;
        let bit = 1_u64 << (at % 64);
        (word & bit != 0).then(|| (self.before[at / 64] + (word & (bit - 1)).count_ones()) as usize)
    }

    /// All of them, rising.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.words.iter().enumerate().flat_map(move |(index, word)| {
            let mut left = *word;
            std::iter::from_fn(move || {
                let bit = (left != 0).then(|| left.trailing_zeros())?;
                left &= left - 1;
                Some(self.first + 64 * index as u32 + bit)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Numbers;

    #[test]
    fn numbers_are_found_at_their_places() {
        let list = [7, 70, 71, 134, 135, 199, 200];
        let numbers = Numbers::of(7, 201, list.iter().rev().copied());
        assert_eq!(numbers.iter().collect::<Vec<_>>(), list);
        assert_eq!(numbers.len(), list.len());
        for number in 0..300 {
            assert_eq!(numbers.place(number), list.iter().position(|other| *other == number));
        }
        assert!(Numbers::of(3, 3, std::iter::empty()).is_empty());
    }
}
