//! Vectors of three components.

/// A point or a direction in space.
pub type Vector = [f64; 3];

/// a - b.
pub fn difference(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|d| a[d] - b[d])
}

/// The inner product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The right-handed product.
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The length; the squares of the components must neither vanish nor overflow.
pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of length one; none of a vector without direction.
pub fn unit(a: Vector) -> Option<Vector> {
    let length = norm(a);
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}
