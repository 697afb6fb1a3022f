//! Reference elements: shape functions, quadrature, mapping.
//!
//! In: a [`Shape`] and points of its reference cell [-1, 1]^dim. Out: values and gradients of the
//! nodal basis, Gauss rules, Jacobians. Nodes are numbered as VTK does.
//! Everything here is local: no communication.

mod lagrange;
mod mapping;
mod quadrature;

pub use lagrange::{MAX_NODES, Shape};
pub use mapping::{Mapping, map_point, mapping};
pub use quadrature::{QuadraturePoint, TrianglePoint, gauss, triangle};
