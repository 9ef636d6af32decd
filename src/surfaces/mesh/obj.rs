//! Wavefront OBJ: its vertices, normals and faces, by the crate `tobj`.

use super::Raw;
use glam::DVec3;
use tobj::{LoadError, LoadOptions};

pub(super) fn read(bytes: &[u8]) -> Result<Raw, String> {
    // Names and comments may be in any encoding.
    let text = String::from_utf8_lossy(bytes);
    // A byte order mark is no part of the first line.
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let every_corner_has_a_normal = check_indices(text)?;
    let options =
        LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let mut rest = text.as_bytes();
    let read = tobj::load_obj_buf(&mut rest, &options, |_| Ok(Default::default()));
    let (models, _) = read.map_err(|error| {
        let line = text.as_bytes()[..text.len() - rest.len()].iter().filter(|&&byte| byte == b'\n').count();
        format!("line {}: {}", line.max(1), expected(&error))
    })?;
    let mut raw = Raw { normals: every_corner_has_a_normal.then(Vec::new), ..Raw::default() };
    for mesh in models.iter().map(|model| &model.mesh) {
        let first = raw.points.len() as u32;
        raw.points.extend(mesh.positions.chunks_exact(3).map(DVec3::from_slice));
        raw.triangles.extend(mesh.indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| first + t[k])));
        if let Some(normals) = &mut raw.normals {
            let normal = |index: u32| DVec3::from_slice(&mesh.normals[3 * index as usize..]);
            normals.extend(mesh.normal_indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| normal(t[k]))));
        }
    }
    Ok(raw)
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

/// Checks that faces name what there is, and says whether every corner of a face has a normal.
///
/// The crate checks positions too, but does not say where; other indices out of range may overflow in it.
fn check_indices(text: &str) -> Result<bool, String> {
    const KINDS: [&str; 3] = ["v", "vt", "vn"];
    let count = |kind: &str| text.lines().filter(|line| line.split_whitespace().next() == Some(kind)).count();
    let totals = KINDS.map(count);
    let mut so_far = [0_i64; 3];
    let mut normals = true;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if let Some(kind) = KINDS.iter().position(|kind| *kind == first) {
            so_far[kind] += 1;
        }
        if first != "f" && first != "l" {
            continue;
        }
        for corner in words {
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
    }
    Ok(normals && totals[2] > 0)
}
