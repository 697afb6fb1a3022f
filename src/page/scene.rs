//! The scene: the mesh, deformed shapes, maps of interfaces.

use std::fmt::Write;

use super::Run;
use crate::error::Result;
use crate::html::{escaped, inlined};
use crate::scene::{Picture, Pictures, pictures};

/// The pictures of a run, or why there are none.
pub(super) fn drawn(run: &Run<'_>) -> Pictures {
    let none = |words: Vec<String>| Pictures { words, ..Pictures::default() };
    let Some(directory) = run.directory else { return none(Vec::new()) };
    // A run is not lost for a picture.
    pictures(directory, run.case, run.history)
        .unwrap_or_else(|error| none(vec![format!("The scene is not drawn: {error}")]))
}

/// The mesh and what becomes of it.
pub(super) fn bodies(html: &mut String, pictures: &Pictures) -> Result<()> {
    if pictures.body.is_empty() && pictures.words.is_empty() {
        return Ok(());
    }
    html.push_str("<h2>Scene</h2>\n");
    for sentence in &pictures.words {
        let _ = writeln!(html, "<p>{}</p>", escaped(sentence));
    }
    figures(html, &pictures.body)
}

/// The interfaces laid flat.
pub(super) fn interfaces(html: &mut String, pictures: &Pictures) -> Result<()> {
    if pictures.interfaces.is_empty() {
        return Ok(());
    }
    html.push_str("<h2>Interfaces, place by place</h2>\n");
    figures(html, &pictures.interfaces)
}

fn figures(html: &mut String, pictures: &[Picture]) -> Result<()> {
    html.push_str("<div class=\"charts\">\n");
    for picture in pictures {
        let wide = if picture.is_wide() { " class=\"wide\"" } else { "" };
        let svg = picture.svg(false)?;
        let _ = write!(
            html,
            "<figure id=\"{}\"{wide}>\n<div class=\"chart\" role=\"img\" aria-label=\"{}\">{}</div>\n",
            escaped(&picture.id),
            escaped(&picture.words()),
            inlined(&svg).trim_end()
        );
        if !picture.caption.is_empty() {
            let _ = writeln!(html, "<figcaption>{}</figcaption>", escaped(picture.caption.trim()));
        }
        html.push_str("</figure>\n");
    }
    html.push_str("</div>\n");
    Ok(())
}
