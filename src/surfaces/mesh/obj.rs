//! Wavefront OBJ: its vertices, normals and faces, by the crate `tobj`.

use super::Raw;
use glam::DVec3;
use std::borrow::Cow;
use tobj::{LoadError, LoadOptions};

pub(super) fn read(bytes: &[u8]) -> Result<Raw, String> {
    // Names and comments may be in any encoding.
    let text = String::from_utf8_lossy(bytes);
    // A byte order mark is no part of the first line.
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let text = &*joined(text);
    let Faces { have_normals, too_short } = check_indices(text)?;
    let options =
        LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let mut rest = text.as_bytes();
    let read = tobj::load_obj_buf(&mut rest, &options, |_| Ok(Default::default()));
    let (models, _) = read.map_err(|error| {
        let line = text.as_bytes()[..text.len() - rest.len()].iter().filter(|&&byte| byte == b'\n').count();
        format!("line {}: {}", line.max(1), expected(&error))
    })?;
    let mut raw = Raw { normals: have_normals.then(Vec::new), too_short, ..Raw::default() };
    for mesh in models.iter().map(|model| &model.mesh) {
        let first = raw.points.len() as u32;
        raw.points.extend(mesh.positions.chunks_exact(3).map(DVec3::from_slice));
        raw.triangles.extend(mesh.indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| first + t[k])));
        if let Some(normals) = &mut raw.normals {
            // The crate ends an object with the normals that it has read by then.
            if mesh.normal_indices.len() != mesh.indices.len() {
                return Err(
                    "faces name normals that come after their object or group; `vn` lines must stand before \
                            the faces that name them"
                        .into(),
                );
            }
            let normal = |index: u32| DVec3::from_slice(&mesh.normals[3 * index as usize..]);
            normals.extend(mesh.normal_indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| normal(t[k]))));
        }
    }
    Ok(raw)
}

/// The text with what a `\\` at the end of a line continues on that line, and as many lines as before. Of what is read alone: a
/// comment or a name may end so, too.
fn joined(text: &str) -> Cow<'_, str> {
    const CONTINUED: [&str; 5] = ["v", "vt", "vn", "f", "l"];
    if !text.contains("\\\n") && !text.contains("\\\r\n") {
        return text.into();
    }
    let mut joined = String::with_capacity(text.len());
    let mut pending = 0;
    let mut continues = false;
    for line in text.lines() {
        let known = continues || line.split_whitespace().next().is_some_and(|word| CONTINUED.contains(&word));
        match line.strip_suffix('\\').filter(|_| known) {
            Some(start) => {
                joined.push_str(start);
                joined.push(' ');
                (pending, continues) = (pending + 1, true);
            }
            None => {
                joined.push_str(line);
                joined.extend(std::iter::repeat_n('\n', 1 + pending));
                (pending, continues) = (0, false);
            }
        }
    }
    joined.into()
}

fn expected(error: &LoadError) -> String {
    match error {
        LoadError::PositionParseError => "a vertex needs three numbers: `v x y z`".into(),
        LoadError::NormalParseError => "a normal needs three numbers: `vn x y z`".into(),
        LoadError::TexcoordParseError => "a texture coordinate needs two numbers: `vt u v`".into(),
        LoadError::FaceParseError => {
            "a face needs the numbers of its vertices: `f 1 2 3` or `f 1//1 2//2 3//3`".into()
        }
        other => other.to_string(),
    }
}

/// What indices say of the faces.
struct Faces {
    /// Whether every corner of a face has a normal.
    have_normals: bool,
    /// Faces of fewer than three vertices.
    too_short: usize,
}

/// Checks that faces name what there is.
///
/// The crate checks positions too, but does not say where; other indices out of range may overflow in it.
fn check_indices(text: &str) -> Result<Faces, String> {
    const KINDS: [&str; 3] = ["v", "vt", "vn"];
    let count = |kind: &str| text.lines().filter(|line| line.split_whitespace().next() == Some(kind)).count();
    let totals = KINDS.map(count);
    let mut so_far = [0_i64; 3];
    let mut normals = true;
    let mut too_short = 0;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if let Some(kind) = KINDS.iter().position(|kind| *kind == first) {
            so_far[kind] += 1;
        }
        if first != "f" && first != "l" {
            continue;
        }
        let mut corners = 0;
        for corner in words {
            corners += 1;
            let mut count = 0;
            for (kind, index) in corner.split('/').enumerate().take(3) {
                count = if index.is_empty() { count } else { kind + 1 };
                let Ok(index) = index.parse::<i64>() else { continue };
                // Negative ones count back from here.
                let place = if index < 0 { so_far[kind].saturating_add(index) } else { index - 1 };
                if !(0..totals[kind] as i64).contains(&place) {
                    let what = ["vertices", "texture coordinates", "normals"][kind];
                    let problem = format!("`{corner}` names `{}` {index}", KINDS[kind]);
                    return Err(format!(
                        "line {}: {problem}, but the file has {} {what}",
                        number + 1,
                        totals[kind]
                    ));
                }
            }
            normals &= count == 3 || first == "l";
        }
        too_short += usize::from(first == "f" && (1..3).contains(&corners));
    }
    Ok(Faces { have_normals: normals && totals[2] > 0, too_short })
}
