//! The elements of a step: their types, the orders of their nodes, their connectivity.

use super::archive::{Folder, Told};
use crate::mesh::import::Kind;

/// A type of elements of the format.
pub struct Type {
    name: &'static str,
    /// Our kind.
    pub kind: Kind,
    /// The place in the file's element of each of our nodes: cells have the opposite orientation.
    pub order: &'static [u8],
}

#[rustfmt::skip]
static TYPES: [Type; 18] = [
    Type { name: "PO1", kind: Kind::Point1, order: &[0] },
    Type { name: "SE2", kind: Kind::Line2, order: &[0, 1] },
    Type { name: "SE3", kind: Kind::Line3, order: &[0, 1, 2] },
    Type { name: "TR3", kind: Kind::Tri3, order: &[0, 1, 2] },
    Type { name: "TR6", kind: Kind::Tri6, order: &[0, 1, 2, 3, 4, 5] },
    Type { name: "QU4", kind: Kind::Quad4, order: &[0, 1, 2, 3] },
    Type { name: "QU8", kind: Kind::Quad8, order: &[0, 1, 2, 3, 4, 5, 6, 7] },
    Type { name: "QU9", kind: Kind::Quad9, order: &[0, 1, 2, 3, 4, 5, 6, 7, 8] },
    Type { name: "TE4", kind: Kind::Tet4, order: &[0, 2, 1, 3] },
    Type { name: "T10", kind: Kind::Tet10, order: &[0, 2, 1, 3, 6, 5, 4, 7, 9, 8] },
    Type { name: "PE6", kind: Kind::Prism6, order: &[0, 2, 1, 3, 5, 4] },
    Type {
        name: "P15", kind: Kind::Prism15,
        order: &[0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13],
    },
    Type {
        name: "P18", kind: Kind::Prism18,
        order: &[0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13, 17, 16, 15],
    },
    Type { name: "PY5", kind: Kind::Pyramid5, order: &[0, 3, 2, 1, 4] },
    Type {
        name: "P13", kind: Kind::Pyramid13,
        order: &[0, 3, 2, 1, 4, 8, 7, 6, 5, 9, 12, 11, 10],
    },
    Type { name: "HE8", kind: Kind::Hex8, order: &[0, 3, 2, 1, 4, 7, 6, 5] },
    Type {
        name: "H20", kind: Kind::Hex20,
        order: &[0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17],
    },
    Type {
        name: "H27", kind: Kind::Hex27,
        order: &[
            0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17,
            21, 23, 24, 22, 20, 25, 26,
        ],
    },
];

/// What types are that are not read.
const REFUSED: [(&str, &str); 7] = [
    ("TR7", "triangles of 7 nodes"),
    ("SE4", "lines of 4 nodes"),
    ("O12", "prisms over hexagons"),
    ("POG", "polygons"),
    ("PG2", "polygons of second order"),
    ("POE", "polyhedra"),
    ("POL", "polyhedra"),
];

/// Elements of one type as the file has them.
pub struct Cells {
    /// Their kind.
    pub kind: Kind,
    /// Where they are in the file.
    pub path: String,
    /// Indices of nodes from 0, `kind.nodes()` per element, in the order of VTK.
    pub nodes: Vec<u32>,
    /// The file's numbers.
    pub numbers: Vec<u64>,
    /// The number of the family of each.
    pub families: Vec<i64>,
}

/// The type of elements of a name.
pub fn element(name: &str) -> Option<&'static Type> {
    TYPES.iter().find(|element| element.name == name)
}

/// Reads all elements of a step of `points` nodes.
pub fn read(step: &Folder, points: usize) -> Told<Vec<Cells>> {
    let all = step.folder("MAI")?;
    let mut found = Vec::new();
    for name in all.members()? {
        let of_type = all.folder(&name)?;
        let Some(element) = element(&name) else {
            let known = REFUSED.iter().find(|(refused, _)| *refused == name);
            let what = known.map_or("a type that is not known here", |(_, what)| what);
            return Err(format!(
                "{}: elements of type {name} ({what}) cannot be read; mesh the part anew \
                 with simplices, prisms, pyramids or hexahedra",
                of_type.path()
            ));
        };
        let cells = of_one_type(&of_type, element, points)?;
        if !cells.numbers.is_empty() {
            found.push(cells);
        }
    }
    if found.is_empty() {
        return Err(format!("{}: there are no elements in it", all.path()));
    }
    Ok(found)
}

fn of_one_type(of_type: &Folder, element: &Type, points: usize) -> Told<Cells> {
    if !of_type.has("NOD") && of_type.has("DES") {
        return Err(format!(
            "{}: its elements are told by their faces (descending connectivity), which is not \
             read; write them by their nodes",
            of_type.path()
        ));
    }
    whole(of_type)?;
    let path = of_type.inner("NOD");
    let file = of_type.integers("NOD")?;
    let (count, width) = (of_type.rows("NOD")?, element.kind.nodes());
    if count.checked_mul(width) != Some(file.len()) {
        return Err(format!(
            "{path}: {} entries where NBR says {count} elements of {width} nodes",
            file.len()
        ));
    }
    // All first nodes come before all second ones.
    if let Some(at) = file.iter().position(|node| *node < 1 || *node > points as i64) {
        return Err(format!(
            "{path}: node {} of element {} is {}; nodes go from 1 to {points}",
            at / count + 1,
            at % count + 1,
            file[at]
        ));
    }
    let mut nodes = Vec::with_capacity(file.len());
    for cell in 0..count {
        let of_cell = element.order.iter().map(|place| file[usize::from(*place) * count + cell]);
        nodes.extend(of_cell.map(|node| (node - 1) as u32));
    }
    let (path, kind) = (of_type.path().to_owned(), element.kind);
    let numbers = numbers(of_type, count)?;
    Ok(Cells { kind, path, nodes, numbers, families: families(of_type, count)? })
}

/// Refuses what is told of a part of the nodes or elements only.
pub fn whole(folder: &Folder) -> Told<()> {
    match folder.text("PFL")? {
        Some(profile) if profile != "MED_NO_PROFILE_INTERNAL" && !profile.is_empty() => {
            Err(format!(
                "{}: it tells a part of the mesh only (profile {profile}), which is not read",
                folder.path()
            ))
        }
        _ => Ok(()),
    }
}

/// The file's numbers of nodes or elements: those of NUM, or from 1 on.
pub fn numbers(folder: &Folder, count: usize) -> Told<Vec<u64>> {
    let Some(numbers) = counted(folder, "NUM", count)? else {
        return Ok((1..=count as u64).collect());
    };
    let number = |number: i64| {
        let negative = || format!("{}: it holds the number {number}", folder.inner("NUM"));
        u64::try_from(number).map_err(|_| negative())
    };
    numbers.into_iter().map(number).collect()
}

/// The number of the family of each node or element, 0 for none.
pub fn families(folder: &Folder, count: usize) -> Told<Vec<i64>> {
    Ok(counted(folder, "FAM", count)?.unwrap_or_else(|| vec![0; count]))
}

fn counted(folder: &Folder, name: &str, count: usize) -> Told<Option<Vec<i64>>> {
    let found = folder.find_integers(name)?;
    match &found {
        Some(list) if list.len() != count => Err(format!(
            "{}: {} entries where there are {count} of {}",
            folder.inner(name),
            list.len(),
            folder.path()
        )),
        _ => Ok(found),
    }
}

#[cfg(test)]
mod tests {
    use super::TYPES;

    #[test]
    fn every_order_is_a_permutation() {
        for element in &TYPES {
            let mut sorted = element.order.to_vec();
            sorted.sort_unstable();
            let wanted: Vec<u8> = (0..element.kind.nodes() as u8).collect();
            assert_eq!(sorted, wanted, "{}", element.name);
        }
    }
}
