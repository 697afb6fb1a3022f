//! Cells raised to full kinds of second order.

use super::buckets::{Buckets, Entry, split};
use super::cells::{Cells, NONE, check_size};
use super::words::{count, wrong};
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::import::Kind;

/// Where the nodes of a shape of second order lie that are no corners: local node and corners.
pub struct Middles {
    pub edges: Vec<(usize, [usize; 2])>,
    pub faces: Vec<(usize, [usize; 4])>,
    pub centre: Option<usize>,
}

/// The position (m) of a new node: of the cells, a cell, and the corners in whose middle it lies.
type Place<'p> = &'p dyn Fn(&Cells, usize, &[usize]) -> [f64; 3];

/// Gives every cell its shape: serendipity kinds get the nodes that they lack on faces and inside,
/// and cells of first order become of second order if `order` is 2. New nodes are shared.
///
/// # Errors
/// `Input` for pyramids that cannot be raised and for other orders.
pub fn raise(cells: &mut Cells, order: Option<u32>, remarks: &mut Vec<String>) -> Result<()> {
    if let Some(order) = order.filter(|order| !(1..=2).contains(order)) {
        return Err(wrong(format!(
            "`raise_order` is {order}; cells can be raised to order 2, or left as they are"
        )));
    }
    let is_raised = order == Some(2);
    cells.shapes = Vec::with_capacity(cells.kinds.len());
    let mut length = 0;
    for (cell, kind) in cells.kinds.iter().enumerate() {
        let shape = shape_of(*kind, is_raised).map_err(|why| {
            let number = cells.numbers[cell];
            wrong(format!("the {} number {number} {why}", kind.name()))
        })?;
        length += shape.nodes();
        cells.shapes.push(shape);
    }
    remark(cells, remarks);
    if length == cells.nodes.len() {
        return Ok(());
    }
    check_size(length)?;
    make_room(cells, Shape::nodes);
    let middles: Vec<Middles> = Shape::ALL.iter().map(|shape| middles(*shape)).collect();
    let has_edges = |kind: &Kind| kind.nodes() == corner_nodes(*kind);
    if is_raised && cells.kinds.iter().any(has_edges) {
        cells.edges = fill_edges(cells, &middles, &mean);
    }
    let inside = |cells: &Cells, cell: usize, corners: &[usize]| {
        serendipity(cells, cell, &middles[cells.shapes[cell] as usize], corners)
    };
    fill_faces(cells, &middles, &inside);
    fill_centres(cells, &middles, &inside);
    Ok(())
}

/// The shape that cells of a kind get, or why there is none.
pub fn shape_of(kind: Kind, is_raised: bool) -> std::result::Result<Shape, &'static str> {
    let (first, second) = match kind {
        Kind::Tri3 => (Shape::Tri3, Shape::Tri6),
        Kind::Quad4 => (Shape::Quad4, Shape::Quad9),
        Kind::Tet4 => (Shape::Tet4, Shape::Tet10),
        Kind::Prism6 => (Shape::Prism6, Shape::Prism18),
        Kind::Hex8 => (Shape::Hex8, Shape::Hex27),
        Kind::Tri6 => (Shape::Tri6, Shape::Tri6),
        Kind::Quad8 | Kind::Quad9 => (Shape::Quad9, Shape::Quad9),
        Kind::Tet10 => (Shape::Tet10, Shape::Tet10),
        Kind::Prism15 | Kind::Prism18 => (Shape::Prism18, Shape::Prism18),
        Kind::Hex20 | Kind::Hex27 => (Shape::Hex27, Shape::Hex27),
        Kind::Pyramid5 if is_raised => {
            return Err("cannot be raised: there are no pyramids of second order; leave \
                        `mesh.raise_order` out, or mesh without pyramids");
        }
        Kind::Pyramid5 => (Shape::Pyramid5, Shape::Pyramid5),
        Kind::Pyramid13 | Kind::Pyramid14 => {
            return Err("is of second order; only pyramids of 5 nodes can be computed: mesh with \
                        first order (Mesh.ElementOrder = 1), or without pyramids");
        }
        Kind::Point1 | Kind::Line2 | Kind::Line3 => return Err("is no cell"),
    };
    Ok(if is_raised { second } else { first })
}

fn corner_nodes(kind: Kind) -> usize {
    super::cells::corner_count(kind)
}

/// Says what becomes of which kinds.
fn remark(cells: &Cells, remarks: &mut Vec<String>) {
    let mut changed: Vec<(Kind, usize, usize)> = Vec::new();
    for (kind, shape) in cells.kinds.iter().zip(&cells.shapes) {
        if kind.nodes() == shape.nodes() {
            continue;
        }
        match changed.iter_mut().find(|(known, ..)| known == kind) {
            Some((_, _, count)) => *count += 1,
            None => changed.push((*kind, shape.nodes(), 1)),
        }
    }
    remarks.extend(changed.into_iter().map(|(kind, nodes, number)| raised(kind, nodes, number)));
}

/// What is to be said of cells of a kind that get so many nodes.
pub fn raised(kind: Kind, nodes: usize, number: usize) -> String {
    format!("{} ({}) raised to {nodes} nodes", count(number, "cell"), kind.name())
}

/// Makes room for the nodes that are to come, so many for each shape; until then they are [`NONE`].
pub fn make_room(cells: &mut Cells, nodes_of: impl Fn(Shape) -> usize) {
    let length = cells.shapes.iter().map(|shape| nodes_of(*shape)).sum();
    let mut nodes = Vec::with_capacity(length);
    let mut start = Vec::with_capacity(cells.start.len());
    start.push(0);
    for (cell, shape) in cells.shapes.iter().enumerate() {
        let range = cells.start[cell] as usize..cells.start[cell + 1] as usize;
        let end = nodes.len() + nodes_of(*shape);
        nodes.extend_from_slice(&cells.nodes[range]);
        nodes.resize(end, NONE);
        start.push(end as u32);
    }
    (cells.nodes, cells.start) = (nodes, start);
}

/// Gives nodes to the middles of edges that have none; all middles by the ends of their edges,
/// rising.
///
/// # Arguments
/// * `middles` of each shape, by its number
pub fn fill_edges(
    cells: &mut Cells,
    middles: &[Middles],
    place: Place<'_>,
) -> Vec<([u32; 2], u32)> {
    let things = || {
        let cells = &*cells;
        (0..cells.shapes.len()).flat_map(move |cell| {
            let from = cells.start[cell] as usize;
            middles[cells.shapes[cell] as usize].edges.iter().map(move |(node, ends)| {
                let (first, rest) = split::<1>(ends.iter().map(|end| cells.nodes[from + end]));
                (first, Entry { rest, id: (from + node) as u32 })
            })
        })
    };
    let buckets = Buckets::new(cells.points.len(), things);
    let mut found = Vec::new();
    for (first, run) in buckets.runs() {
        let node = known(cells, run).unwrap_or_else(|| {
            let (cell, local) = owner(cells, run[0].id);
            let edges = &middles[cells.shapes[cell] as usize].edges;
            let edge = edges.iter().find(|(node, _)| *node == local);
            let point = place(cells, cell, edge.map_or(&[], |(_, ends)| ends));
            push(cells, point)
        });
        fill(cells, run, node);
        found.push(([first, run[0].rest[0]], node));
    }
    found
}

/// Gives nodes to the middles of quadrilaterals that have none; all middles by their corners, the
/// first of which is the lowest, in rising order. Arguments as of [`fill_edges`].
pub fn fill_faces(
    cells: &mut Cells,
    middles: &[Middles],
    place: Place<'_>,
) -> Vec<([u32; 4], u32)> {
    let things = || {
        let cells = &*cells;
        (0..cells.shapes.len()).flat_map(move |cell| {
            let from = cells.start[cell] as usize;
            middles[cells.shapes[cell] as usize].faces.iter().map(move |(node, corners)| {
                let (first, rest) = split::<3>(corners.iter().map(|c| cells.nodes[from + c]));
                (first, Entry { rest, id: (from + node) as u32 })
            })
        })
    };
    let buckets = Buckets::new(cells.points.len(), things);
    let mut found = Vec::new();
    for (first, run) in buckets.runs() {
        let node = known(cells, run).unwrap_or_else(|| {
            let (cell, local) = owner(cells, run[0].id);
            let faces = &middles[cells.shapes[cell] as usize].faces;
            let face = faces.iter().find(|(node, _)| *node == local);
            let point = place(cells, cell, face.map_or(&[], |(_, corners)| corners));
            push(cells, point)
        });
        fill(cells, run, node);
        let [b, c, d] = run[0].rest;
        found.push(([first, b, c, d], node));
    }
    found
}

/// Gives nodes to the middles of cells that have none. Arguments as of [`fill_edges`].
pub fn fill_centres(cells: &mut Cells, middles: &[Middles], place: Place<'_>) {
    for cell in 0..cells.shapes.len() {
        let Some(local) = middles[cells.shapes[cell] as usize].centre else { continue };
        let at = cells.start[cell] as usize + local;
        if cells.nodes[at] == NONE {
            let corners: Vec<usize> = (0..cells.shapes[cell].corners().nodes()).collect();
            let point = place(cells, cell, &corners);
            cells.nodes[at] = push(cells, point);
        }
    }
}

/// The mean of some corners (m).
pub fn mean(cells: &Cells, cell: usize, corners: &[usize]) -> [f64; 3] {
    let from = cells.start[cell] as usize;
    let mut sum = [0.0; 3];
    for corner in corners {
        let point = cells.points[cells.nodes[from + corner] as usize];
        sum.iter_mut().zip(point).for_each(|(sum, x)| *sum += x);
    }
    // Two, four or eight: to multiply is exact.
    sum.map(|x| x * (1.0 / corners.len() as f64))
}

/// The middle of a quadrilateral (4 corners) or a hexahedron (8) by the serendipity interpolation:
/// -1/4 at each corner, and 1/2 or 1/4 at the middle of each edge. Where the edges are straight,
/// it is the mean of the corners.
fn serendipity(cells: &Cells, cell: usize, of_shape: &Middles, corners: &[usize]) -> [f64; 3] {
    let of_edge = if corners.len() == 4 { 0.5 } else { 0.25 };
    let from = cells.start[cell] as usize;
    let mut sum = [0.0; 3];
    let mut add = |local: usize, weight: f64| {
        let point = cells.points[cells.nodes[from + local] as usize];
        sum.iter_mut().zip(point).for_each(|(sum, x)| *sum += weight * x);
    };
    corners.iter().for_each(|corner| add(*corner, -0.25));
    let is_inside = |ends: &[usize; 2]| ends.iter().all(|end| corners.contains(end));
    let edges = of_shape.edges.iter().filter(|(_, ends)| is_inside(ends));
    edges.for_each(|(node, _)| add(*node, of_edge));
    sum
}

/// The node that one of the cells has already.
fn known<const R: usize>(cells: &Cells, run: &[Entry<R>]) -> Option<u32> {
    run.iter().map(|entry| cells.nodes[entry.id as usize]).find(|node| *node != NONE)
}

/// The cell of a place in the connectivity, and its local node there.
fn owner(cells: &Cells, place: u32) -> (usize, usize) {
    let cell = cells.start.partition_point(|start| *start <= place) - 1;
    (cell, (place - cells.start[cell]) as usize)
}

fn push(cells: &mut Cells, point: [f64; 3]) -> u32 {
    cells.points.push(point);
    (cells.points.len() - 1) as u32
}

fn fill<const R: usize>(cells: &mut Cells, run: &[Entry<R>], node: u32) {
    for entry in run {
        let place = &mut cells.nodes[entry.id as usize];
        if *place == NONE {
            *place = node;
        }
    }
}

/// Finds the corners of which each node is the middle: one pair for an edge, both diagonals for a
/// quadrilateral, four for a hexahedron.
pub fn middles(shape: Shape) -> Middles {
    let points = shape.node_points();
    let corners = shape.corners().nodes();
    let mut found = Middles { edges: Vec::new(), faces: Vec::new(), centre: None };
    for (node, point) in points.iter().enumerate().skip(corners) {
        let mut around = Vec::new();
        for a in 0..corners {
            for b in a + 1..corners {
                if (0..3).all(|i| 0.5 * (points[a][i] + points[b][i]) == point[i]) {
                    around.extend([a, b]);
                }
            }
        }
        match *around {
            [a, b] => found.edges.push((node, [a, b])),
            [a, b, c, d] => found.faces.push((node, [a, b, c, d])),
            _ => found.centre = Some(node),
        }
    }
    found
}
