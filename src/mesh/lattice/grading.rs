//! The planes of cells that grow away from places.

/// Halvings of the range in which the growth is sought that gives the wanted ratio of cells.
const HALVINGS: usize = 60;

/// Edges grow with the distance d from the nearest place, as 1 + (growth - 1) d / reach. Cells of
/// equal shares of the integral of one over the edge are then in geometric progression.
struct Growth<'p> {
    places: &'p [f64],
    reach: f64,
    growth: f64,
}

impl Growth<'_> {
    fn distance(&self, x: f64) -> f64 {
        self.places.iter().fold(f64::INFINITY, |least, place| least.min((x - place).abs()))
    }

    /// Where the nearest place changes, and the places, between `ends`.
    fn bends(places: &[f64], ends: [f64; 2]) -> Vec<f64> {
        let halfway = places.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let mut bends: Vec<f64> = places.iter().copied().chain(halfway).collect();
        bends.retain(|x| *x > ends[0] && *x < ends[1]);
        bends.extend(ends);
        bends.sort_by(f64::total_cmp);
        bends
    }

    /// The integral of one over the edge between two points with no bend between them.
    fn share(&self, [a, b]: [f64; 2]) -> f64 {
        let slope = (self.growth - 1.0) / self.reach;
        if slope * self.reach < 1e-9 {
            return b - a;
        }
        let [low, high] = [a, b].map(|x| (slope * self.distance(x)).ln_1p());
        (high - low).abs() / slope
    }

    /// `count` parts of equal shares between `ends`.
    fn divide(&self, ends: [f64; 2], count: usize) -> Vec<f64> {
        let bends = Self::bends(self.places, ends);
        let shares: Vec<f64> = bends.windows(2).map(|x| self.share([x[0], x[1]])).collect();
        let whole: f64 = shares.iter().sum();
        let slope = (self.growth - 1.0) / self.reach;
        let point = |k: usize| {
            let mut left = whole * (k as f64 / count as f64);
            let mut piece = 0;
            while piece + 1 < shares.len() && left > shares[piece] {
                left -= shares[piece];
                piece += 1;
            }
            let (a, b) = (bends[piece], bends[piece + 1]);
            if slope * self.reach < 1e-9 {
                return a + left;
            }
            let [near, far] = [a, b].map(|x| self.distance(x));
            // From the end that is nearer to its place, so that both sides of a place are alike.
            if near <= far {
                a + (1.0 + slope * near) * (slope * left).exp_m1() / slope
            } else {
                b - (1.0 + slope * far) * (slope * (shares[piece] - left)).exp_m1() / slope
            }
        };
        let inner = (1..count).map(point);
        std::iter::once(ends[0]).chain(inner).chain(std::iter::once(ends[1])).collect()
    }
}

/// The planes of `cells` cells between the ends of `stops` (m, rising), with planes at all of them,
/// which makes more cells where there are too few. Cells grow geometrically away from the `places`
/// (m, rising) up to `ratio` times the smallest, as near as the stops allow.
pub(super) fn graded(stops: &[f64], places: &[f64], ratio: f64, cells: usize) -> Vec<f64> {
    let ends = [stops[0], stops[stops.len() - 1]];
    let distance = Growth { places, reach: 1.0, growth: 1.0 };
    let at_bends = Growth::bends(places, ends).into_iter().map(|x| distance.distance(x));
    let [near, far] =
        at_bends.fold([f64::INFINITY, 0.0], |[low, high], d| [low.min(d), high.max(d)]);
    // What lies off all places grows from its own nearer end.
    let own = if near > 0.0 {
        let nearer = distance.distance(ends[0]) > distance.distance(ends[1]);
        vec![ends[usize::from(nearer)]]
    } else {
        places.to_vec()
    };
    let planes = |growth: f64, counts: &[usize]| -> Vec<f64> {
        let law = Growth { places: &own, reach: far - near, growth };
        let parts = stops.windows(2).zip(counts);
        let mut all = vec![ends[0]];
        parts.for_each(|(x, n)| all.extend(&law.divide([x[0], x[1]], *n)[1..]));
        all
    };
    let law = Growth { places: &own, reach: far - near, growth: ratio };
    let shares: Vec<f64> = stops
        .windows(2)
        .map(|x| {
            let bends = Growth::bends(&own, [x[0], x[1]]);
            bends.windows(2).map(|piece| law.share([piece[0], piece[1]])).sum()
        })
        .collect();
    let counts = counts(&shares, cells);
    // The ratio rises with the growth, and lies below it, as cells take the mean of their edge.
    let (mut low, mut high) = (1.0_f64, ratio * ratio * ratio.max(4.0));
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if largest_over_smallest(&planes(middle, &counts)) < ratio {
            low = middle;
        } else {
            high = middle;
        }
    }
    planes(low, &counts)
}

/// As many cells in each part as its share is of the whole, at least one; parts of one share get
/// as many.
fn counts(shares: &[f64], cells: usize) -> Vec<usize> {
    let whole: f64 = shares.iter().sum();
    let exact = |share: &f64| share / whole * cells as f64;
    shares.iter().map(|share| ((exact(share) - 1e-9).round() as usize).max(1)).collect()
}

fn largest_over_smallest(planes: &[f64]) -> f64 {
    let widths = planes.windows(2).map(|x| x[1] - x[0]);
    let [low, high] = widths.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], w| [a.min(w), b.max(w)]);
    high / low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn widths(planes: &[f64]) -> Vec<f64> {
        planes.windows(2).map(|x| x[1] - x[0]).collect()
    }

    #[test]
    fn cells_grow_geometrically_up_to_the_ratio() {
        let w = widths(&graded(&[0.0, 2.0], &[0.0], 8.0, 4));
        assert!(w.windows(2).all(|w| (w[1] / w[0] - 2.0).abs() < 1e-9), "{w:?}");
        assert!((w.iter().sum::<f64>() - 2.0).abs() < 1e-14);
        let w = widths(&graded(&[0.0, 1.0], &[0.0, 1.0], 16.0, 10));
        assert!((largest_over_smallest(&graded(&[0.0, 1.0], &[0.0, 1.0], 16.0, 10)) - 16.0) < 1e-9);
        for k in 0..5 {
            assert!((w[k] / w[9 - k] - 1.0).abs() < 1e-13, "{w:?}");
        }
        assert!((w[1] / w[0] - 2.0).abs() < 1e-9, "{w:?}");
    }

    #[test]
    fn interfaces_and_other_stops_are_planes_and_nothing_grows_with_a_ratio_of_one() {
        let planes = graded(&[0.0, 1.3, 5.0], &[1.3], 20.0, 24);
        assert_eq!((planes[0], planes[planes.len() - 1]), (0.0, 5.0));
        let joint = planes.iter().position(|z| *z == 1.3).expect("the interface is a plane");
        let w = widths(&planes);
        assert!((w[joint] / w[joint - 1] - 1.0).abs() < 0.3, "{w:?}");
        assert!((largest_over_smallest(&planes) - 20.0).abs() < 1e-6, "{w:?}");
        assert_eq!(graded(&[0.0, 4.0], &[4.0], 1.0, 4), [0.0, 1.0, 2.0, 3.0, 4.0]);
        // A body off all places grows from the end that is nearer to them.
        let w = widths(&graded(&[2.0, 4.0], &[0.0], 8.0, 4));
        assert!(w[0] < w[3] && (w[3] / w[0] - 8.0).abs() < 1e-6, "{w:?}");
        assert_eq!(graded(&[0.0, 1.0, 2.0, 3.0], &[0.0], 4.0, 1).len(), 4);
    }
}
