//! Which things hang together.

/// The group of each of `count` things that `edges` join, numbered in the order of the lowest
/// member.
pub fn groups(count: usize, edges: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    // The lowest member that each is known to hang together with.
    let mut root: Vec<usize> = (0..count).collect();
    for ends in edges {
        let [a, b] = ends.map(|end| lowest(&root, end));
        root[a.max(b)] = a.min(b);
    }
    let mut numbers = vec![0; count];
    let mut next = 0;
    for thing in 0..count {
        let first = lowest(&root, thing);
        if first == thing {
            numbers[thing] = next;
            next += 1;
        } else {
            numbers[thing] = numbers[first];
        }
    }
    numbers
}

fn lowest(root: &[usize], mut thing: usize) -> usize {
    while root[thing] != thing {
        thing = root[thing];
    }
    thing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_numbered_by_their_lowest_members() {
        assert_eq!(groups(0, std::iter::empty()), [0; 0]);
        assert_eq!(groups(3, std::iter::empty()), [0, 1, 2]);
        assert_eq!(groups(5, [[0, 1], [2, 3], [3, 4]].into_iter()), [0, 0, 1, 1, 1]);
        assert_eq!(groups(6, [[5, 1], [4, 2], [1, 4]].into_iter()), [0, 1, 1, 2, 1, 1]);
    }
}
