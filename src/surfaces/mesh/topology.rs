//! How triangles hang together. Corners in one place are one vertex, whatever their indices.

use super::{Mesh, area_normal};
use glam::DVec3;
use std::collections::HashMap;

/// The vertex of each point, counted in the order in which places first occur.
fn vertices(mesh: &Mesh) -> (Vec<u32>, usize) {
    let mut known = HashMap::with_capacity(mesh.points.len());
    // + 0.0: −0 is 0.
    let key = |point: &DVec3| point.to_array().map(|x| (x + 0.0).to_bits());
    let vertex = |point: &DVec3| {
        let next = known.len() as u32;
        *known.entry(key(point)).or_insert(next)
    };
    let vertices: Vec<u32> = mesh.points.iter().map(vertex).collect();
    let count = vertices.iter().max().map_or(0, |last| *last as usize + 1);
    (vertices, count)
}

/// What makes a mesh doubtful as the surface of a solid, one sentence each.
pub(super) fn doubts(mesh: &Mesh) -> impl Iterator<Item = String> {
    let (vertices, _) = vertices(mesh);
    // How often each edge is run along from its lower to its higher vertex, and back.
    let mut edges: HashMap<[u32; 2], [u32; 2]> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| vertices[corner as usize]);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            edges.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
        }
    }
    let open = edges.values().filter(|runs| runs.iter().sum::<u32>() == 1).count();
    let odd = edges.values().filter(|runs| runs.iter().sum::<u32>() > 1 && runs[0] != runs[1]).count();
    // Six times the volume, about the first point so that little cancels.
    let about = mesh.points.first().copied().unwrap_or_default();
    let volume: f64 = mesh.faces().map(|([a, b, c], _)| (a - about).dot((b - about).cross(c - about))).sum();
    let edges = |count: usize| if count == 1 { "1 edge".into() } else { format!("{count} edges") };
    [
        (open > 0).then(|| {
            format!(
                "the mesh is not closed ({} of one triangle only): light finds its way in without refraction",
                edges(open)
            )
        }),
        (odd > 0).then(|| format!("the triangles at {} do not agree which side is outside", edges(odd))),
        (open == 0 && odd == 0 && volume < 0.0)
            .then(|| "its triangles face inward: what is around it counts as the inside".into()),
    ]
    .into_iter()
    .flatten()
}

/// At the corners of each triangle the sum of the normals of the triangles there, weighted by area.
pub(super) fn mean_normals(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    let (vertices, count) = vertices(mesh);
    let mut sums = vec![DVec3::ZERO; count];
    for (triangle, (corners, _)) in mesh.triangles.iter().zip(mesh.faces()) {
        for &corner in triangle {
            sums[vertices[corner as usize] as usize] += area_normal(corners);
        }
    }
    let at = |triangle: &[u32; 3]| triangle.map(|corner| sums[vertices[corner as usize] as usize]);
    mesh.triangles.iter().map(at).collect()
}
