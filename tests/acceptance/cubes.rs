//! Mesh files of blocks that are cut into cells of all kinds, straight or turned.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::any_mesh::TURN;
use crate::scene::fresh;

/// Corners of a cube, by the axes along which they lie high.
const CUBE: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
/// Its faces, which run round the left way seen from inside.
const FACES: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];

/// What cubes are cut into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cut {
    /// Squares, in the plane.
    Squares,
    /// Themselves.
    Hexahedra,
    /// Two each.
    Prisms,
    /// Twelve each, around the middle.
    Tetrahedra,
    /// Every other one six pyramids around the middle.
    Pyramids,
}

/// Cells and facets: their type in the file, nodes, and number of the group.
type Element = (u8, Vec<usize>, usize);

/// A mesh that grows block by block.
#[derive(Default)]
pub struct Blocks {
    points: Vec<[f64; 3]>,
    /// First point of the block that is filled.
    first: usize,
    elements: Vec<Element>,
    sides: Vec<Vec<usize>>,
    groups: Vec<(usize, String)>,
}

impl Blocks {
    /// A block between two corners (m), of so many cubes, which shares no node with those before.
    pub fn block(mut self, low: [f64; 3], high: [f64; 3], count: [usize; 3], cut: Cut) -> Self {
        self.first = self.points.len();
        if self.groups.is_empty() {
            self.groups.push((if cut == Cut::Squares { 2 } else { 3 }, "rock".into()));
        }
        let layers = count[2].max(1);
        for cube in (0..count[0] * count[1] * layers)
            .map(|i| [i % count[0], i / count[0] % count[1], i / (count[0] * count[1])])
        {
            let at = |part: [f64; 3]| -> [f64; 3] {
                std::array::from_fn(|i| {
                    let along = (cube[i] as f64 + part[i]) / count[i].max(1) as f64;
                    low[i] + (high[i] - low[i]) * along
                })
            };
            let corners = CUBE.map(|c| self.node(at(c.map(|c| c as f64))));
            let has_middle = cut == Cut::Tetrahedra
                || cut == Cut::Pyramids && cube.iter().sum::<usize>() % 2 == 1;
            let middle = has_middle.then(|| self.node(at([0.5; 3])));
            self.cut(cut, corners, middle);
        }
        self
    }

    fn node(&mut self, at: [f64; 3]) -> usize {
        let is_there = |x: &[f64; 3]| (0..3).all(|i| (x[i] - at[i]).abs() < 1e-9);
        let known = self.points[self.first..].iter().position(is_there);
        known.map_or_else(
            || {
                self.points.push(at);
                self.points.len() - 1
            },
            |place| self.first + place,
        )
    }

    fn cut(&mut self, cut: Cut, corners: [usize; 8], middle: Option<usize>) {
        let of = |list: &[usize]| list.iter().map(|c| corners[*c]).collect::<Vec<_>>();
        let mut add = |kind: u8, nodes: Vec<usize>| self.elements.push((kind, nodes, 0));
        let mut sides: Vec<Vec<usize>> = FACES.iter().map(|face| of(face)).collect();
        match (cut, middle) {
            (Cut::Squares, _) => {
                add(3, of(&[0, 1, 2, 3]));
                sides = [[0, 1], [1, 2], [2, 3], [3, 0]].map(|side| of(&side)).to_vec();
            }
            (Cut::Prisms, _) => {
                add(6, of(&[0, 1, 2, 4, 5, 6]));
                add(6, of(&[0, 2, 3, 4, 6, 7]));
                sides.drain(..2);
                sides.extend([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]].map(|side| of(&side)));
            }
            (Cut::Tetrahedra, Some(middle)) => {
                sides.clear();
                for face in FACES {
                    // From the corner that neighbours take too.
                    let first = (0..4).min_by_key(|i| CUBE[face[*i]]).unwrap_or(0);
                    let [a, b, c, d] = std::array::from_fn(|i| face[(first + i) % 4]);
                    for side in [[a, b, c], [a, c, d]] {
                        add(4, [of(&side), vec![middle]].concat());
                        sides.push(of(&side));
                    }
                }
            }
            (_, Some(middle)) => {
                FACES.iter().for_each(|face| add(7, [of(face), vec![middle]].concat()));
            }
            _ => add(5, of(&[0, 1, 2, 3, 4, 5, 6, 7])),
        }
        self.sides.extend(sides);
    }

    /// A group of the facets all of whose points are where `is_there` says, of the last block; more
    /// of them where there is one of this name.
    pub fn group(mut self, name: &str, is_there: impl Fn([f64; 3]) -> bool) -> Self {
        let group = (self.groups[0].0 - 1, name.to_owned());
        let known = self.groups.iter().position(|other| *other == group);
        let number = known.unwrap_or(self.groups.len());
        if known.is_none() {
            self.groups.push(group);
        }
        let mut seen: Vec<Vec<usize>> = Vec::new();
        for side in &self.sides {
            let mut sorted = side.clone();
            sorted.sort_unstable();
            let is_of_block = side.iter().all(|n| *n >= self.first);
            let fits = side.iter().all(|n| is_there(self.points[*n]));
            if fits && is_of_block && !seen.contains(&sorted) {
                let kind = [0, 0, 1, 2, 3][side.len()];
                self.elements.push((kind, side.clone(), number));
                seen.push(sorted);
            }
        }
        self
    }

    /// A group of the point at a place.
    pub fn point(mut self, name: &str, at: [f64; 3]) -> Self {
        self.groups.push((0, name.into()));
        let is_there = |x: &[f64; 3]| (0..3).all(|i| (x[i] - at[i]).abs() < 1e-9);
        let point = self.points.iter().position(is_there).expect("a point there");
        self.elements.push((15, vec![point], self.groups.len() - 1));
        self
    }

    /// The same mesh with its points elsewhere.
    pub fn mapped(mut self, place: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        self.points.iter_mut().for_each(|point| *point = place(*point));
        self
    }

    /// Groups of the faces of a box from the origin, called as those of a column: those along the
    /// last axis bottom and top.
    pub fn faces(mut self, size: &[f64]) -> Self {
        self.first = 0;
        let names = [["left", "right"], ["front", "back"], ["bottom", "top"]];
        for (axis, length) in size.iter().enumerate() {
            let [low, high] = names[if axis + 1 == size.len() { 2 } else { axis }];
            self = self.group(low, |x| x[axis].abs() < 1e-9);
            self = self.group(high, |x| (x[axis] - length).abs() < 1e-9);
        }
        self
    }

    /// Writes the mesh, turned or not; the path of the file.
    pub fn write(&self, is_turned: bool) -> String {
        let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n");
        writeln!(text, "{}", self.groups.len()).expect("a string");
        for (number, (dim, name)) in self.groups.iter().enumerate() {
            writeln!(text, "{dim} {} \"{name}\"", number + 1).expect("a string");
        }
        write!(text, "$EndPhysicalNames\n$Nodes\n{}\n", self.points.len()).expect("a string");
        for (node, at) in self.points.iter().enumerate() {
            let [x, y, z] = if is_turned { turned(*at) } else { *at };
            writeln!(text, "{} {x:?} {y:?} {z:?}", node + 1).expect("a string");
        }
        write!(text, "$EndNodes\n$Elements\n{}\n", self.elements.len()).expect("a string");
        for (number, (kind, nodes, group)) in self.elements.iter().enumerate() {
            let nodes: Vec<String> = nodes.iter().map(|n| (n + 1).to_string()).collect();
            let (number, group) = (number + 1, group + 1);
            writeln!(text, "{number} {kind} 2 {group} {group} {}", nodes.join(" "))
                .expect("a string");
        }
        text.push_str("$EndElements\n");
        let path = fresh().join("blocks.msh");
        fs::write(&path, text).expect("the build directory is writable");
        Path::to_string_lossy(&path).into_owned()
    }
}

/// A vector turned by 30 degrees about (1, 2, 3).
pub fn turned(v: [f64; 3]) -> [f64; 3] {
    TURN.map(|row| row.iter().zip(v).map(|(r, v)| r * v).sum())
}
