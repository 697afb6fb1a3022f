//! Convex polygons of a plane.

/// Sutherland-Hodgman: `polygon` cut by the lines of the edges of the convex polygon `window` in
/// turn; empty, or without area, where they have nothing in common.
///
/// # Arguments
/// * `turn` 1 if the window runs counter-clockwise, -1 if clockwise
/// * `near` what lies this close to a line (m) lies on it
pub fn clip(polygon: &[[f64; 2]], window: &[[f64; 2]], turn: f64, near: f64) -> Vec<[f64; 2]> {
    let mut polygon = polygon.to_vec();
    let mut cut = Vec::with_capacity(8);
    for (i, &a) in window.iter().enumerate() {
        let b = window[(i + 1) % window.len()];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        // Distance from the line of the edge, positive inside; what is on the line is zero.
        let distance = |x: [f64; 2]| {
            let d = turn * cross(a, b, x) / length;
            if d.abs() <= near { 0.0 } else { d }
        };
        cut.clear();
        for (j, &x) in polygon.iter().enumerate() {
            let y = polygon[(j + 1) % polygon.len()];
            let (dx, dy) = (distance(x), distance(y));
            if dx >= 0.0 {
                cut.push(x);
            }
            if dx * dy < 0.0 {
                let t = dx / (dx - dy);
                cut.push([x[0] + t * (y[0] - x[0]), x[1] + t * (y[1] - x[1])]);
            }
        }
        std::mem::swap(&mut polygon, &mut cut);
    }
    polygon
}

/// Twice the signed area of a triangle.
pub fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The area of a polygon, positive if it runs counter-clockwise, m2.
pub fn signed_area(polygon: &[[f64; 2]]) -> f64 {
    (2..polygon.len()).map(|i| 0.5 * cross(polygon[0], polygon[i - 1], polygon[i])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_cut_by_a_triangle_that_runs_either_way() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut triangle = [[-1.0, 0.5], [0.5, 0.5], [0.5, 2.0]];
        for turn in [1.0, -1.0] {
            let common = clip(&square, &triangle, turn, 1e-10);
            // The triangle above the line y = 0.5 and left of x = 0.5 is cut by y = x + 1.5 only.
            assert!((signed_area(&common) - 0.25).abs() < 1e-15, "{common:?}");
            triangle.reverse();
        }
        let away = [[2.0, 0.0], [3.0, 0.0], [2.0, 1.0]];
        assert!(signed_area(&clip(&square, &away, 1.0, 1e-10)) == 0.0);
    }
}
