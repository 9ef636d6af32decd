//! Just enough of a reader of HTML to tell whether a page is well-formed and stands alone.

/// Elements that have no end tag.
const VOID: [&str; 14] = [
    "area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "param", "source", "track",
    "wbr",
];
/// Elements that load or run something, or send the reader elsewhere.
const FORBIDDEN: [&str; 14] = [
    "script",
    "iframe",
    "object",
    "embed",
    "base",
    "form",
    "audio",
    "video",
    "source",
    "track",
    "image",
    "use",
    "foreignobject",
    "frame",
];

/// A start tag with its attributes.
#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub attributes: Vec<(String, String)>,
    /// The text up to its end tag, of its descendants too.
    pub text: String,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(found, _)| found == name).map(|(_, value)| value.as_str())
    }

    pub fn has_class(&self, class: &str) -> bool {
        self.attribute("class").is_some_and(|classes| classes.split(' ').any(|found| found == class))
    }
}

/// A page.
pub struct Document {
    /// In the order of their start tags.
    pub elements: Vec<Element>,
}

impl Document {
    /// Reads a page; panics where it is not well-formed.
    pub fn parse(source: &str) -> Self {
        let mut document = Self { elements: Vec::new() };
        let mut open: Vec<usize> = Vec::new();
        let mut rest = source.strip_prefix("<!DOCTYPE html>").expect("a doctype");
        while let Some(start) = rest.find('<') {
            document.add_text(&open, &rest[..start]);
            rest = &rest[start + 1..];
            if let Some(tail) = rest.strip_prefix('/') {
                let (name, tail) = tail.split_once('>').expect("an end tag that ends");
                let index = open.pop().unwrap_or_else(|| panic!("</{name}> without a start"));
                assert_eq!(document.elements[index].name, name, "crossed tags");
                rest = tail;
                continue;
            }
            let (element, tail) = start_tag(rest);
            rest = tail;
            if element.name == "style" {
                // Its text is no markup.
                let (style, tail) = rest.split_once("</style>").expect("a style that ends");
                document.elements.push(Element { text: style.into(), ..element });
                rest = tail;
                continue;
            }
            if !VOID.contains(&element.name.as_str()) {
                open.push(document.elements.len());
            }
            document.elements.push(element);
        }
        assert!(
            open.is_empty(),
            "not ended: {:?}",
            open.iter().map(|&i| &document.elements[i].name).collect::<Vec<_>>()
        );
        assert_eq!(rest.trim(), "", "text behind the page");
        document
    }

    fn add_text(&mut self, open: &[usize], text: &str) {
        assert!(!open.is_empty() || text.trim().is_empty(), "text outside of the page: {text}");
        let text = unescaped(text);
        open.iter().for_each(|&index| self.elements[index].text.push_str(&text));
    }

    /// All elements of a name.
    pub fn all(&self, name: &str) -> impl Iterator<Item = &Element> {
        self.elements.iter().filter(move |element| element.name == name)
    }

    /// The section with this id.
    pub fn section(&self, id: &str) -> &str {
        let section = self.all("section").find(|section| section.attribute("id") == Some(id));
        &section.unwrap_or_else(|| panic!("no section {id}")).text
    }

    /// All text of the page.
    pub fn text(&self) -> &str {
        &self.all("body").next().expect("a body").text
    }

    /// Panics where the page loads, runs or links to anything outside of itself, or a link leads nowhere.
    pub fn assert_stands_alone(&self) {
        let ids: Vec<&str> = self.elements.iter().filter_map(|element| element.attribute("id")).collect();
        for (i, id) in ids.iter().enumerate() {
            assert!(!ids[..i].contains(id), "two of id {id}");
        }
        for element in &self.elements {
            let name = element.name.to_ascii_lowercase();
            assert!(!FORBIDDEN.contains(&name.as_str()), "<{name}>");
            for (attribute, value) in &element.attributes {
                assert!(!attribute.starts_with("on") && attribute != "style", "{attribute} of <{name}>");
                let inside = match attribute.as_str() {
                    "src" => value.starts_with("data:image/png;base64,"),
                    "href" => {
                        value == "data:," || value.strip_prefix('#').is_some_and(|id| ids.contains(&id))
                    }
                    "srcset" | "action" | "background" | "poster" | "xlink:href" => false,
                    _ => true,
                };
                assert!(inside, "{attribute}={value} of <{name}>");
            }
            let loads = ["url(", "@import", "image-set("];
            assert!(name != "style" || !loads.iter().any(|load| element.text.contains(load)), "style loads");
            assert!(name != "img" || element.attribute("alt").is_some(), "a picture without a description");
        }
    }
}

/// Reads behind the `<` of a start tag: the element, and what follows.
fn start_tag(source: &str) -> (Element, &str) {
    let end = source.find(|c: char| !c.is_ascii_alphanumeric()).expect("a tag that ends");
    let (name, mut rest) = source.split_at(end);
    assert!(name.starts_with(|c: char| c.is_ascii_alphabetic()), "a bare < before {:.20}", source);
    let mut attributes: Vec<(String, String)> = Vec::new();
    loop {
        rest = rest.trim_start();
        if let Some(tail) = rest.strip_prefix('>') {
            return (Element { name: name.into(), attributes, text: String::new() }, tail);
        }
        let end = rest.find(['=', '>', ' ']).expect("an attribute that ends");
        let (attribute, tail) = rest.split_at(end);
        assert!(
            attribute.chars().all(|c| c.is_ascii_alphanumeric() || "-:".contains(c)),
            "attribute {attribute}"
        );
        assert!(attributes.iter().all(|(known, _)| known != attribute), "two of {attribute}");
        let value = match tail.strip_prefix("=\"") {
            Some(tail) => {
                let (value, tail) = tail.split_once('"').expect("a value that ends");
                rest = tail;
                value
            }
            None => {
                rest = tail;
                ""
            }
        };
        assert!(!value.contains('<'), "< in {attribute}");
        attributes.push((attribute.into(), unescaped(value)));
    }
}

fn unescaped(text: &str) -> String {
    let mut parts = text.split('&');
    let mut whole = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, tail) = part.split_once(';').expect("an entity that ends");
        whole.push(match name {
            "amp" => '&',
            "lt" => '<',
            "gt" => '>',
            "quot" => '"',
            other => panic!("unknown entity &{other};"),
        });
        whole.push_str(tail);
    }
    whole
}

#[test]
fn what_is_wrong_is_noticed() {
    let page = |body: &str| Document::parse(&format!("<!DOCTYPE html><html><body>{body}</body></html>"));
    page("<p id=\"a\">1 &lt; 2<br><a href=\"#a\">b</a></p><img src=\"data:image/png;base64,AA\" alt=\"\">")
        .assert_stands_alone();
    for bad in [
        "<p>",
        "</p>",
        "<p><b></p></b>",
        "a < b",
        "a & b",
        "<p a=\"<\"></p>",
        "<p a=\"1\" a=\"2\"></p>",
        "<p a=\"1></p>",
    ] {
        assert!(std::panic::catch_unwind(|| page(bad)).is_err(), "{bad}");
    }
    for bad in [
        "<script></script>",
        "<p onclick=\"x\"></p>",
        "<img src=\"a.png\" alt=\"\">",
        "<img src=\"data:image/png;base64,AA\">",
        "<a href=\"https://example.org\">a</a>",
        "<a href=\"#nowhere\">a</a>",
        "<p id=\"a\"></p><p id=\"a\"></p>",
        "<style>p { background: url(x) }</style>",
        "<p style=\"color: red\"></p>",
    ] {
        assert!(std::panic::catch_unwind(|| page(bad).assert_stands_alone()).is_err(), "{bad}");
    }
}
