//! Surfaces into a drawing: what is farther first, so that what is nearer covers it.

use std::collections::BTreeSet;

use super::bands::{Corner, bands, shares};
use super::cover::Cover;
use super::drawing::{Drawing, Item, Paint, Place, Stroke};
use super::features::Features;
use super::levels::{Levels, lit};
use super::skin::{Facet, Skin};
use super::vector::Vector;
use super::view::Camera;

/// Values that are drawn as colours.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Values<'a> {
    /// At the points of the skin.
    PerPoint(&'a [f64]),
    /// At its facets.
    PerFacet(&'a [f64]),
}

/// A surface and how it is drawn.
pub(crate) struct Surface<'a> {
    pub skin: &'a Skin,
    pub features: &'a Features,
    /// Where its points are (m), perhaps moved.
    pub points: &'a [Vector],
    pub values: Values<'a>,
    pub levels: &'a Levels,
    /// Whether both sides are seen; else only what is turned to the eye.
    pub both_sides: bool,
    /// Whether the edges of its facets are drawn.
    pub edges: bool,
}

/// Width of lines (pixels).
const THIN: f64 = 0.5;
/// Around areas without a line of their own, so that nothing shines through between them.
const SEAM: f64 = 0.9;
const SHARP: f64 = 1.4;
/// Edges of facets are left out where these are smaller in the mean (pixels).
const SMALLEST: f64 = 3.5;

impl Surface<'_> {
    /// Draws it.
    pub fn paint(&self, drawing: &mut Drawing, camera: &Camera) {
        let mut seen: Vec<(f64, u32)> = Vec::new();
        for (index, facet) in self.skin.facets.iter().enumerate() {
            let area = self.skin.area(facet, self.points);
            if self.both_sides || camera.view.turned(area) > 1e-9 {
                let middle = self.skin.middle(facet, self.points);
                seen.push((camera.view.nearness(middle), index as u32));
            }
        }
        seen.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let places: Vec<Place> = self.points.iter().map(|p| camera.place(*p)).collect();
        let edges = self.edges && self.size(&seen, &places) > SMALLEST;
        for (_, index) in seen {
            self.facet(drawing, camera, &places, Which { index: index as usize, edges });
        }
        self.outline(drawing, camera);
    }

    /// The typical length of an edge of a facet (pixels).
    fn size(&self, seen: &[(f64, u32)], places: &[Place]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (_, index) in seen {
            for [a, b] in self.skin.edges(&self.skin.facets[*index as usize]) {
                let [a, b] = [a, b].map(|i| places[i as usize]);
                sum += (a[0] - b[0]).hypot(a[1] - b[1]);
                count += 1;
            }
        }
        if count > 0 { sum / f64::from(count) } else { 0.0 }
    }

    fn facet(&self, drawing: &mut Drawing, camera: &Camera, places: &[Place], which: Which) {
        let Which { index, edges } = which;
        let facet = &self.skin.facets[index];
        let light = self.light(facet, camera);
        let ring: Vec<Place> = self.skin.ring(facet).map(|i| places[i as usize]).collect();
        let patch = self.features.patches[index];
        let edge = |band: usize| Stroke::new(edge_on(self.levels.color(band)), THIN);
        let mut push = |points: Vec<Place>, band: usize, edge: Option<Stroke>| {
            let fill = lit(self.levels.color(band), light);
            let edge = edge.unwrap_or(Stroke::new(fill, SEAM));
            drawing.items.push(Item::Area { points, fill, edge: Some(edge), patch });
        };
        match self.bands_of(facet, index) {
            [low, high] if low == high => push(ring, low, edges.then(|| edge(low))),
            [low, _] => {
                for (band, part) in self.parts(facet, places) {
                    push(part, band, None);
                }
                if edges {
                    let around = ring.iter().chain(ring.first()).copied().collect();
                    drawing.line(around, edge(low));
                }
            }
        }
    }

    /// The least and the greatest band of a facet.
    fn bands_of(&self, facet: &Facet, index: usize) -> [usize; 2] {
        match self.values {
            Values::PerFacet(values) => [self.levels.band(values[index]); 2],
            Values::PerPoint(values) => {
                let of = self.skin.of_facet(facet).iter().map(|i| values[*i as usize]);
                let bands = of.map(|value| self.levels.band(value));
                let low = bands.clone().min().unwrap_or_default();
                [low, bands.max().unwrap_or_default()]
            }
        }
    }

    /// The parts of a facet that have one colour each.
    fn parts(&self, facet: &Facet, places: &[Place]) -> Vec<(usize, Vec<Place>)> {
        let Values::PerPoint(values) = self.values else { return Vec::new() };
        let corner = |i: u32| -> Corner { (places[i as usize], values[i as usize]) };
        if self.levels.can_be_cut() {
            let nodes: Vec<Corner> = self.skin.of_facet(facet).iter().map(|i| corner(*i)).collect();
            bands(facet.shape, &nodes, self.levels)
        } else {
            // States have no numbers between them: each point has what is nearest to it.
            let ring: Vec<Corner> = self.skin.ring(facet).map(corner).collect();
            let parts = shares(&ring).into_iter();
            parts.map(|(value, part)| (self.levels.band(value), part)).collect()
        }
    }

    /// What is turned to the eye and up is brighter.
    fn light(&self, facet: &Facet, camera: &Camera) -> f64 {
        if self.skin.dim < 3 {
            return 1.0;
        }
        let normal = super::vector::unit(self.skin.area(facet, self.points));
        let turned = super::vector::dot(normal, camera.view.toward).abs();
        (0.80 + 0.12 * turned + 0.12 * normal[2].max(0.0)).min(1.0)
    }

    /// The sharp edges that are seen.
    fn outline(&self, drawing: &mut Drawing, camera: &Camera) {
        let cover = Cover::new(self.skin, self.points, camera);
        let mut drawn = BTreeSet::new();
        for facet in &self.skin.facets {
            let corners = self.skin.corners(facet).len().max(1);
            let ring: Vec<u32> = self.skin.ring(facet).collect();
            let step = ring.len() / corners;
            for (i, [a, b]) in self.skin.edges(facet).enumerate() {
                if !self.features.is_sharp([a, b]) || !drawn.insert([a.min(b), a.max(b)]) {
                    continue;
                }
                for k in i * step..(i + 1) * step {
                    let ends = [k, k + 1].map(|k| self.points[ring[k % ring.len()] as usize]);
                    for part in cover.seen(ends, camera) {
                        drawing.line(part.to_vec(), Stroke::new(Paint::Ink, SHARP));
                    }
                }
            }
        }
    }
}

/// What edges of cells are drawn with on a colour: darker, or lighter where that is dark.
fn edge_on(color: [u8; 3]) -> Paint {
    let [r, g, b] = color.map(f64::from);
    let is_dark = 0.3 * r + 0.59 * g + 0.11 * b < 95.0;
    if is_dark { Paint::Color(color.map(|c| c / 2 + 90)) } else { Paint::Edge }
}

#[derive(Clone, Copy)]
struct Which {
    index: usize,
    edges: bool,
}

/// The sharp edges of a skin, whoever hides them: what a body was before it moved.
pub(crate) fn ghost(drawing: &mut Drawing, camera: &Camera, skin: &Skin, features: &Features) {
    for ends in features.edges() {
        let points = ends.map(|i| camera.place(skin.points[i as usize])).to_vec();
        drawing.line(points, Stroke::new(Paint::Rule, 0.8));
    }
}
