//! Reference elements: shape functions, quadrature, mapping.
//!
//! In: a [`Shape`] and points of its reference cell. Out: values and gradients of the nodal basis,
//! rules of integration, Jacobians. Nodes are numbered as VTK does.
//! One file per family of cells: lines to hexahedra, simplices, prisms, pyramids.
//! Everything here is local: no communication.

mod cube;
mod simplex;
mod prism;
mod pyramid;
mod shape;
mod mapping;
mod quadrature;
#[cfg(test)]
mod shape_tests;

pub use mapping::{Mapping, map_point, mapping};
pub use quadrature::{
    MAX_DEGREE, QuadraturePoint, TrianglePoint, gauss, quadrature, quadrature_on_triangle,
    stiffness_rule, triangle,
};
pub use shape::{Family, MAX_NODES, Shape};
