use super::canvas::Figure;
use super::*;

fn panels() -> Panels {
    let line = |style, points: &[(f64, f64)]| Line {
        name: format!("method {style}, order ≥ 2"),
        points: points.to_vec(),
        spreads: vec![(1.0, 0.02, 0.05)],
        failed: vec![3.0],
        style: Some(style),
        look: Look::Marked,
        labels: Vec::new(),
    };
    let lines = (0..6).map(|s| line(s, &[(1.0, 0.03), (10.0, 1e-5 * (s + 1) as f64)])).collect();
    let panel = Panel {
        x: Scale::Log(0.5, 20.0),
        y: Scale::Log(1e-6, 0.1),
        x_label: "core-seconds [s]".into(),
        y_label: "error".into(),
        lines,
        front: vec![(1.0, 0.03)],
    };
    Panels { title: "Error against cost".into(), panels: vec![panel], below: false }
}

#[test]
fn a_chart_is_drawn_without_any_font_of_the_machine() {
    let figure = panels();
    let text = svg(&figure).unwrap();
    let (width, height) = figure.size();
    let size = format!("<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 ");
    assert!(text.starts_with(&size) && text.trim_end().ends_with("</svg>"), "{text}");
    for words in ["core-seconds [s]", "method 3, order ≥ 2", "10⁻³", "Pareto front", "failed"]
    {
        assert!(text.contains(words), "{words}");
    }
    let image = png(&figure).unwrap();
    assert_eq!(&image[1..4], b"PNG");
    let reader = png::Decoder::new(std::io::Cursor::new(&image)).read_info().unwrap();
    assert_eq!(reader.info().width % 2, 0);
}

#[test]
fn an_empty_chart_is_drawn_too() {
    let empty = Panel {
        x: Scale::over(std::iter::empty(), true),
        y: Scale::over(std::iter::empty(), false),
        x_label: String::new(),
        y_label: String::new(),
        lines: Vec::new(),
        front: Vec::new(),
    };
    assert!(
        svg(&Panels { title: String::new(), panels: vec![empty], below: false })
            .unwrap()
            .contains("<svg")
    );
}
