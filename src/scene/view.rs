//! From where a scene is seen, and where its points lie in a drawing.

use super::drawing::Place;
use super::vector::{Vector, bounds, cross, dot, length, plus, unit};

/// A direction of view without perspective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct View {
    right: Vector,
    up: Vector,
    /// Towards the eye.
    pub toward: Vector,
}

/// Height of the eye above the ground and its way round from the x axis, in degrees: the front
/// (y = 0) is seen best, then the right side and the top.
const HEIGHT: f64 = 24.0;
const ROUND: f64 = -58.0;

impl View {
    /// For a body: z up.
    pub fn of_body() -> Self {
        let ((sin, cos), (lift, flat)) =
            (ROUND.to_radians().sin_cos(), HEIGHT.to_radians().sin_cos());
        Self {
            right: [-sin, cos, 0.0],
            up: [-lift * cos, -lift * sin, flat],
            toward: [flat * cos, flat * sin, lift],
        }
    }

    /// Head-on to a plane with this normal; what is highest in it, or y, is up.
    pub fn onto(normal: Vector) -> Self {
        let toward = unit(normal);
        let lies = toward[2].abs() > 0.999;
        let up = if lies { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let up = unit(plus(up, -dot(up, toward), toward));
        Self { right: cross(up, toward), up, toward }
    }

    /// Head-on to a plane mesh, along the axis in which it does not extend: x to the right, z or y
    /// up.
    pub fn of_plane(depth: usize) -> Self {
        match depth {
            0 => Self::onto([1.0, 0.0, 0.0]),
            1 => Self::onto([0.0, -1.0, 0.0]),
            _ => Self::onto([0.0, 0.0, 1.0]),
        }
    }

    /// How far a point is to the right and up (m).
    pub fn place(&self, point: Vector) -> Place {
        [dot(point, self.right), dot(point, self.up)]
    }

    /// How near a point is to the eye (m).
    pub fn nearness(&self, point: Vector) -> f64 {
        dot(point, self.toward)
    }

    /// How much of a surface with this normal is turned to the eye: from -1 to 1.
    pub fn turned(&self, normal: Vector) -> f64 {
        dot(unit(normal), self.toward)
    }
}

/// A rectangle of a drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

/// Where points lie in a drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Camera {
    pub view: View,
    /// Pixels per metre.
    pub scale: f64,
    offset: Place,
}

/// What points take up, seen from somewhere (m): left, right, low, high.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reach {
    low: Place,
    high: Place,
}

impl Reach {
    pub fn of(view: &View, points: impl Iterator<Item = Vector>) -> Self {
        let [low, high] = bounds(points.map(|point| {
            let [x, y] = view.place(point);
            [x, y, 0.0]
        }));
        Self { low: [low[0], low[1]], high: [high[0], high[1]] }
    }

    pub fn with(self, other: Self) -> Self {
        let pick = |of: fn(f64, f64) -> f64, a: Place, b: Place| [of(a[0], b[0]), of(a[1], b[1])];
        Self {
            low: pick(f64::min, self.low, other.low),
            high: pick(f64::max, self.high, other.high),
        }
    }

    /// Width and height (m), neither of them 0.
    pub fn size(&self) -> Place {
        let [wide, high] = [0, 1].map(|c| self.high[c] - self.low[c]);
        let least = 1e-3 * length([wide, high, 0.0]).max(1e-300);
        [wide.max(least), high.max(least)]
    }

    /// The scale at which it fits into a rectangle (pixels per metre).
    pub fn scale(&self, width: f64, height: f64) -> f64 {
        let [wide, high] = self.size();
        (width / wide).min(height / high)
    }
}

impl Camera {
    /// Puts what is seen into the middle of a frame, as large as it fits.
    pub fn new(view: View, reach: Reach, frame: Frame) -> Self {
        Self::at_scale(view, reach, frame, reach.scale(frame.width, frame.height))
    }

    /// As [`Camera::new`] with a scale of one's own.
    pub fn at_scale(view: View, reach: Reach, frame: Frame, scale: f64) -> Self {
        let middle = [0, 1].map(|c| 0.5 * (reach.low[c] + reach.high[c]));
        let offset = [
            frame.left + 0.5 * frame.width - scale * middle[0],
            frame.top + 0.5 * frame.height + scale * middle[1],
        ];
        Self { view, scale, offset }
    }

    /// The place of a point (pixels).
    pub fn place(&self, point: Vector) -> Place {
        let [x, y] = self.view.place(point);
        [self.offset[0] + self.scale * x, self.offset[1] - self.scale * y]
    }

    /// A direction in the drawing, of length 1 where it is seen from the side.
    pub fn way(&self, direction: Vector) -> Place {
        let [x, y] = self.view.place(direction);
        [x, -y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_right_handed() {
        let views =
            [View::of_body(), View::of_plane(1), View::of_plane(2), View::onto([1.0, 2.0, 3.0])];
        for view in views {
            let out = cross(view.right, view.up);
            let error = length(plus(out, -1.0, view.toward));
            assert!(error < 1e-12 && (length(out) - 1.0).abs() < 1e-12, "{view:?}");
        }
        assert_eq!(views[1].place([2.0, 0.0, 5.0]), [2.0, 5.0]);
        assert_eq!(views[2].place([2.0, 5.0, 0.0]), [2.0, 5.0]);
        // The front, the right side and the top are seen.
        for side in [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] {
            assert!(views[0].turned(side) > 0.3);
        }
    }

    #[test]
    fn what_is_seen_lies_in_its_frame() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 5.0], [0.0, 1.0, 0.0]];
        let frame = Frame { left: 10.0, top: 20.0, width: 100.0, height: 300.0 };
        let view = View::of_body();
        let camera = Camera::new(view, Reach::of(&view, points.into_iter()), frame);
        for point in points {
            let [x, y] = camera.place(point);
            assert!((9.99..=110.01).contains(&x) && (19.99..=320.01).contains(&y), "{x} {y}");
        }
        assert!(camera.place([0.0, 0.0, 5.0])[1] < camera.place([0.0; 3])[1]);
    }
}
