//! A drawing as SVG: text stays text, colours are attributes that a page's style sheet may override by class.

use std::fmt::Write;

use maud::{Markup, PreEscaped, html};

use super::{
    drawing::{Anchor, Drawing, Ink, Place, Shape},
    font,
};

/// A file of its own.
pub fn document(drawing: &Drawing) -> String {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned();
    text += &printable(&element(drawing).into_string());
    text.push('\n');
    text
}

/// The element, to stand in a page or in a file.
pub fn element(drawing: &Drawing) -> Markup {
    let (width, height) = (number(drawing.width), number(drawing.height));
    html! {
        svg xmlns="http://www.w3.org/2000/svg" width=(width) height=(height)
            viewBox={ "0 0 " (width) " " (height) } font-family=(font::FAMILY) role="img" aria-label=(drawing.title)
        {
            @for shape in &drawing.shapes { (markup(shape)) }
        }
    }
}

/// XML has no escape for most control characters; neither has anyone who reads the text.
pub fn printable(text: &str) -> String {
    let allowed = |c: char| !c.is_control() || matches!(c, '\n' | '\t');
    let allowed = |c: char| allowed(c) && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().map(|c| if allowed(c) { c } else { char::REPLACEMENT_CHARACTER }).collect()
}

fn markup(shape: &Shape) -> Markup {
    match shape {
        Shape::Line { points, ink, width, dash } => {
            let dash = dash.map(|[on, off]| format!("{} {}", number(on), number(off)));
            html! {
                polyline class={ "stroke-" (ink.class()) } points=(path(points)) fill="none" stroke=(hex(*ink))
                    stroke-width=(number(*width)) stroke-linejoin="round" stroke-dasharray=[dash] {}
            }
        }
        Shape::Area { points, ink, opacity, hint } => html! {
            polygon class={ "fill-" (ink.class()) } points=(path(points)) fill=(hex(*ink))
                fill-opacity=[(*opacity < 1.0).then(|| number(*opacity))]
            {
                @if let Some(hint) = hint { title { (hint) } }
            }
        },
        Shape::Text { at: [x, y], text, size, ink, anchor, turned } => {
            let (x, y) = (number(*x), number(*y));
            let anchor = match anchor {
                Anchor::Start => None,
                Anchor::Middle => Some("middle"),
                Anchor::End => Some("end"),
            };
            html! {
                text class={ "fill-" (ink.class()) } x=(x) y=(y) font-size=(number(*size)) fill=(hex(*ink))
                    text-anchor=[anchor] transform=[turned.then(|| format!("rotate(-90 {x} {y})"))] { (text) }
            }
        }
    }
}

fn hex(ink: Ink) -> String {
    let [r, g, b] = ink.rgb();
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Two decimals are finer than any screen.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".into() } else { short.to_owned() }
}

fn path(points: &[Place]) -> PreEscaped<String> {
    let mut text = String::new();
    for [x, y] in points {
        let gap = if text.is_empty() { "" } else { " " };
        let _ = write!(text, "{gap}{},{}", number(*x), number(*y));
    }
    PreEscaped(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_texts_stay_texts() {
        let hostile = "<script>alert(\"1\")</script> & ' \u{0} \u{1b}[31m \u{202e} ]]> 日本";
        let mut drawing = Drawing::new(100.0, 50.0, hostile);
        drawing.text([1.0, 2.0], Anchor::Start, 12.0, Ink::Text, hostile);
        drawing.marker([5.0, 5.0], 3, false, Some(hostile.into()));
        let text = document(&drawing);
        let parsed = roxmltree::Document::parse(&text).expect("well-formed XML");
        let names: Vec<_> = parsed
            .descendants()
            .filter(|node| node.is_element())
            .map(|node| node.tag_name().name())
            .collect();
        assert_eq!(names, ["svg", "polygon", "text", "polygon", "polygon", "title"]);
        let shown = parsed.descendants().find(|node| node.has_tag_name("text")).and_then(|node| node.text());
        assert_eq!(shown, Some(printable(hostile).as_str()));
        assert_eq!(parsed.root_element().attribute("aria-label"), Some(printable(hostile).as_str()));
    }

    #[test]
    fn numbers_are_short() {
        let texts = [1.0, -0.001, 12.346, 100.0, 0.5].map(number);
        assert_eq!(texts, ["1", "0", "12.35", "100", "0.5"].map(String::from));
    }
}
