//! What of a run can be drawn.

use std::cell::RefCell;
use std::rc::Rc;

use crate::case::{BULK, Case};
use crate::chart::Unit;
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::results::{Directory, FieldGrid, Snapshot};

use super::levels::four;
use super::skin::Skin;
use super::thin::{Thinned, thinned};
use super::view::View;

/// A run that has written fields.
pub(crate) struct Scene<'a> {
    pub case: &'a Case,
    directory: &'a Directory,
    /// The instants at which fields were written (s), rising; at least one.
    pub written: Vec<f64>,
    /// The grid that was read last, and its skin: mostly that of all instants.
    kept: RefCell<Option<Rc<Kept>>>,
}

struct Kept {
    grid: FieldGrid,
    skin: Rc<Skin>,
}

/// What is drawn at one instant.
pub(crate) struct Stage {
    pub snapshot: Snapshot,
    /// The whole skin of the mesh.
    pub whole: Rc<Skin>,
    /// The skin that is drawn.
    pub skin: Rc<Skin>,
    /// The cells in words.
    pub cells: String,
    /// The grid on which points were merged (m), and of how many facets one is drawn.
    merged: Option<(f64, usize)>,
}

impl<'a> Scene<'a> {
    /// The scene of a run; none where it has written no fields.
    ///
    /// # Errors
    /// `System` when the directory cannot be read.
    pub fn open(directory: &'a Directory, case: &'a Case) -> Result<Option<Self>> {
        if !directory.fields()?.iter().any(|name| name == BULK) {
            return Ok(None);
        }
        let written = directory.series(BULK)?.times();
        let found = !written.is_empty();
        Ok(found.then(|| Self { case, directory, written, kept: RefCell::default() }))
    }

    /// The first instant that was written.
    ///
    /// # Errors
    /// As [`Scene::at`].
    pub fn first(&self, most: usize) -> Result<Stage> {
        self.at(self.written[0], most)
    }

    /// The bulk at an instant, as a skin of at most `most` facets.
    ///
    /// # Errors
    /// `Input` when no fields were written then, `System` when they cannot be read.
    pub fn at(&self, time: f64, most: usize) -> Result<Stage> {
        let snapshot = self.directory.series(BULK)?.at(time)?;
        let kept = self.kept(&snapshot)?;
        let whole = kept.skin.clone();
        let (skin, merged) = match thinned(&whole, most) {
            Some(Thinned { skin, edge, every }) => (Rc::new(skin), Some((edge, every))),
            None => (whole.clone(), None),
        };
        Ok(Stage { snapshot, whole, skin, cells: cells_in_words(&kept.grid), merged })
    }

    /// The grid of a file; that of another instant where it is the same.
    fn kept(&self, snapshot: &Snapshot) -> Result<Rc<Kept>> {
        let grid = snapshot.grid()?;
        if let Some(kept) = self.kept.borrow().as_ref().filter(|kept| kept.grid == grid) {
            return Ok(kept.clone());
        }
        let skin = Rc::new(Skin::of(&grid));
        if skin.facets.is_empty() {
            return Err(Error::Input("the field files hold no cells: nothing to draw".to_owned()));
        }
        let kept = Rc::new(Kept { grid, skin });
        Ok(self.kept.borrow_mut().insert(kept).clone())
    }

    /// The fields of an interface at an instant, with its facets; none where it has none.
    ///
    /// # Errors
    /// As [`Scene::at`].
    pub fn interface(&self, name: &str, time: f64) -> Result<Option<(Snapshot, Skin)>> {
        if !self.directory.fields()?.iter().any(|other| other == name) {
            return Ok(None);
        }
        let snapshot = self.directory.series(name)?.at(time)?;
        let mut skin = Skin::of(&snapshot.grid()?);
        if skin.dim == 1 {
            // A straight interface lies in many planes, its bodies in one.
            skin.depth = self.kept(&self.directory.series(BULK)?.at(time)?)?.skin.depth;
        }
        Ok((!skin.facets.is_empty()).then_some((snapshot, skin)))
    }

    /// The facets of an interface.
    ///
    /// # Errors
    /// As [`Scene::at`].
    pub fn interface_skin(&self, name: &str) -> Result<Option<Skin>> {
        Ok(self.interface(name, self.written[0])?.map(|(_, skin)| skin))
    }

    /// The view of the mesh.
    pub fn view(&self, skin: &Skin) -> View {
        if skin.dim == 3 { View::of_body() } else { View::of_plane(skin.depth) }
    }
}

impl Stage {
    /// What was left out of the drawing; nothing where all is drawn.
    pub fn thinned_words(&self) -> String {
        self.merged.map_or_else(String::new, |(edge, every)| {
            let every = if every > 1 { format!("one of {every}, ") } else { String::new() };
            format!(
                " The surface has {} facets; points were merged on a grid of {}, and {every}{} facets are drawn.",
                grouped(self.whole.facets.len()),
                Unit::text("m", four(edge)),
                grouped(self.skin.facets.len())
            )
        })
    }
}

/// A count with its digits in groups of three.
pub(super) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{a0}');
        }
        text.push(digit);
    }
    text
}

/// How many cells of which kinds.
fn cells_in_words(grid: &FieldGrid) -> String {
    let word = |shape: Shape| match shape {
        Shape::Line2 | Shape::Line3 => "lines",
        Shape::Tri3 | Shape::Tri6 => "triangles",
        Shape::Quad4 | Shape::Quad9 => "quadrilaterals",
        Shape::Tet4 | Shape::Tet10 => "tetrahedra",
        Shape::Prism6 | Shape::Prism18 => "prisms",
        Shape::Pyramid5 => "pyramids",
        Shape::Hex8 | Shape::Hex27 => "hexahedra",
    };
    let mut found = Vec::new();
    for kind in Shape::ALL {
        let count = grid.shapes.iter().filter(|shape| **shape == kind).count();
        if count > 0 {
            found.push(format!("{} {} of {} nodes", grouped(count), word(kind), kind.nodes()));
        }
    }
    found.join(", ")
}
