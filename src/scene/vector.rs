//! Vectors of three components.

pub(super) type Vector = [f64; 3];

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + factor b
pub(super) fn plus(a: Vector, factor: f64, b: Vector) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Of length 1; zero where there is no direction.
pub(super) fn unit(a: Vector) -> Vector {
    let size = length(a);
    if size > 0.0 { a.map(|c| c / size) } else { [0.0; 3] }
}

/// The least and the largest coordinates; zeros where there are no points.
pub(super) fn bounds(points: impl Iterator<Item = Vector>) -> [Vector; 2] {
    let mut found: Option<[Vector; 2]> = None;
    for point in points {
        let [low, high] = found.get_or_insert([point, point]);
        for c in 0..3 {
            low[c] = low[c].min(point[c]);
            high[c] = high[c].max(point[c]);
        }
    }
    found.unwrap_or_default()
}

/// The length of the diagonal of what holds all points.
pub(super) fn extent(points: impl Iterator<Item = Vector>) -> f64 {
    let [low, high] = bounds(points);
    length(minus(high, low))
}
