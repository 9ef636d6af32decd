//! PLY, as text or binary: its vertices, their normals, and faces, by the crate `ply-rs-bw`.

use super::Raw;
use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

/// A row of the file, with what is wanted of it.
#[derive(Default)]
struct Row {
    numbers: [f64; 6],
    corners: Vec<i64>,
}

/// A row of which nothing is wanted: however many there are, they take no memory.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }

    fn set_property(&mut self, _: &str, _: Property) -> PropertyAccessResult {
        PropertyAccessResult::Set
    }
}

const NUMBERS: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

impl PropertyAccess for Row {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(place) = NUMBERS.iter().position(|known| *known == name) {
            let Some(number) = number(&property) else { return PropertyAccessResult::UnsupportedType };
            self.numbers[place] = number;
        } else if CORNERS.contains(&name) {
            let Some(corners) = integers(property) else { return PropertyAccessResult::UnsupportedType };
            self.corners = corners;
        }
        PropertyAccessResult::Set
    }
}

fn number(property: &Property) -> Option<f64> {
    match *property {
        Property::Char(x) => Some(x.into()),
        Property::UChar(x) => Some(x.into()),
        Property::Short(x) => Some(x.into()),
        Property::UShort(x) => Some(x.into()),
        Property::Int(x) => Some(x.into()),
        Property::UInt(x) => Some(x.into()),
        Property::Float(x) => Some(x.into()),
        Property::Double(x) => Some(x),
        _ => None,
    }
}

fn integers(property: Property) -> Option<Vec<i64>> {
    fn wide<T: Into<i64>>(list: Vec<T>) -> Option<Vec<i64>> {
        Some(list.into_iter().map(Into::into).collect())
    }
    match property {
        Property::ListChar(list) => wide(list),
        Property::ListUChar(list) => wide(list),
        Property::ListShort(list) => wide(list),
        Property::ListUShort(list) => wide(list),
        Property::ListInt(list) => wide(list),
        Property::ListUInt(list) => wide(list),
        _ => None,
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw, String> {
    let parser = Parser::<Row>::new();
    let mut reader = Reader::new(bytes);
    let header = parser.read_header(&mut reader).map_err(|error| describe(&error))?;
    let mut raw = Raw::default();
    for (name, element) in &header.elements {
        check_length(element, header.encoding, reader.get_ref().len())?;
        if !["vertex", "face"].contains(&name.as_str()) {
            let rows = Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header);
            rows.map_err(|error| describe(&error))?;
            continue;
        }
        let rows = parser
            .read_payload_for_element(&mut reader, element, &header)
            .map_err(|error| describe(&error))?;
        let has = |property: &str| element.properties.contains_key(property);
        match name.as_str() {
            "vertex" => {
                if let Some(missing) = NUMBERS[..3].iter().find(|name| !has(name)) {
                    return Err(format!("its vertices have no `{missing}`; they need x, y and z"));
                }
                raw.points = rows.iter().map(|row| DVec3::from_slice(&row.numbers)).collect();
                if NUMBERS[3..].iter().all(|name| has(name)) {
                    let normals: Vec<_> =
                        rows.iter().map(|row| DVec3::from_slice(&row.numbers[3..])).collect();
                    raw.normals = Some(normals.into_iter().map(|normal| [normal; 3]).collect());
                }
            }
            "face" => {
                if !CORNERS.iter().any(|name| has(name)) {
                    return Err("its faces have no list `vertex_indices` of vertices".into());
                }
                raw.too_short = rows.iter().filter(|row| row.corners.len() < 3).count();
                raw.triangles = triangles(&rows, header.elements.get("vertex").map_or(0, |e| e.count))?;
            }
            _ => {}
        }
    }
    if !header.elements.contains_key("vertex") {
        return Err("it has no vertices: an `element vertex` is missing from its header".into());
    }
    // By vertex in the file, by corner from here on.
    raw.normals = raw.normals.map(|of_vertices| {
        let at = |triangle: &[u32; 3]| triangle.map(|vertex| of_vertices[vertex as usize][0]);
        raw.triangles.iter().map(at).collect()
    });
    Ok(raw)
}

/// Polygons as fans of triangles.
fn triangles(rows: &[Row], vertices: usize) -> Result<Vec<[u32; 3]>, String> {
    let mut triangles = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        if let Some(corner) = row.corners.iter().find(|corner| !(0..vertices as i64).contains(corner)) {
            let vertices = format!("the vertices are 0 to {}", vertices as i64 - 1);
            return Err(format!("face {} names vertex {corner}, but {vertices}", index + 1));
        }
        let corner = |k: usize| row.corners[k] as u32;
        triangles.extend((2..row.corners.len()).map(|k| [corner(0), corner(k - 1), corner(k)]));
    }
    Ok(triangles)
}

/// Refuses elements that cannot be there: rows of the least size are longer than the rest of the file.
fn check_length(element: &ElementDef, encoding: Encoding, rest: usize) -> Result<(), String> {
    let ElementDef { name, count, properties, .. } = element;
    if properties.is_empty() && *count > 0 {
        return Err(format!("its element `{name}` has no properties"));
    }
    let least: usize = match encoding {
        // A digit and what parts it from the next; the last line may end with the file.
        Encoding::Ascii => 2 * properties.len(),
        _ => properties.values().map(|property| least_bytes(&property.data_type)).sum(),
    };
    let needed = count.saturating_mul(least).saturating_sub(usize::from(encoding == Encoding::Ascii));
    if needed > rest {
        let promise = format!("its header promises {count} of `{name}`, at least {needed} bytes");
        return Err(format!(
            "{promise}, but {rest} bytes are left; the file is cut off or its header is wrong"
        ));
    }
    Ok(())
}

fn least_bytes(kind: &PropertyType) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = kind;
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The crate's message on one line, of readable length.
fn describe(error: &ParseError) -> String {
    const LONGEST: usize = 200;
    let text = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    let shown: String = text.chars().take(LONGEST).collect();
    let dots = if shown.len() < text.len() { "…" } else { "" };
    format!("it is not a valid PLY file: {shown}{dots}")
}
