//! The hierarchy of boxes over shapes: split where the surface area heuristic says so (MacDonald and Booth 1990), in
//! bins (Wald 2007). The same boxes give the same hierarchy.

use super::bounds::Bounds;
use super::types::DeviceNode;
use glam::DVec3;

/// Most shapes in a leaf.
const LEAF: usize = 4;
/// Bins per axis.
const BINS: usize = 16;
/// The most levels below the root: NODE_STACK in `cl/surfaces/nodes.cl`. Halves of 2³² shapes take 30.
pub const DEPTH: u32 = 32;

/// The nodes over boxes, root first, and the boxes' indices in the order of the leaves.
pub fn build(boxes: &[Bounds]) -> (Vec<DeviceNode>, Vec<usize>) {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let mut nodes = Vec::new();
    if boxes.is_empty() {
        return (nodes, order);
    }
    nodes.push(leaf(boxes, 0..0));
    // Nodes whose boxes are not divided yet: node, range of `order`, level.
    let mut open = vec![(0, 0..boxes.len(), 0)];
    while let Some((node, range, level)) = open.pop() {
        let part = &mut order[range.clone()];
        let bounds = enclosing(boxes, part);
        if part.len() <= LEAF {
            nodes[node] = device_node(&bounds, range.start, range.len());
            continue;
        }
        let middle = range.start + split(boxes, part, level);
        let children = nodes.len();
        nodes[node] = device_node(&bounds, children, 0);
        nodes.resize(children + 2, nodes[node]);
        open.push((children + 1, middle..range.end, level + 1));
        open.push((children, range.start..middle, level + 1));
    }
    (nodes, order)
}

fn leaf(boxes: &[Bounds], range: std::ops::Range<usize>) -> DeviceNode {
    device_node(&boxes[0], range.start, range.len())
}

fn enclosing(boxes: &[Bounds], part: &[usize]) -> Bounds {
    part.iter().skip(1).fold(boxes[part[0]], |bounds, &i| bounds.with(&boxes[i]))
}

/// Reorders `part` so that its two sides come one after the other, and gives the length of the first.
fn split(boxes: &[Bounds], part: &mut [usize], level: u32) -> usize {
    let halves = part.len().div_ceil(LEAF).next_power_of_two().ilog2();
    // Level by level, halves reach the leaves in time whatever the boxes are.
    let best = if level + halves < DEPTH { best_plane(boxes, part) } else { None };
    let centres = Bounds::of(part.iter().map(|&i| boxes[i].centre())).expect("a part is not empty");
    let Some((axis, bin)) = best else {
        let axis = longest_axis(centres.size());
        let middle = part.len() / 2;
        let key = |i: &usize| boxes[*i].centre()[axis];
        part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        return middle;
    };
    let (mut first, second): (Vec<usize>, Vec<usize>) =
        part.iter().partition(|&&i| bin_of(&boxes[i], &centres, axis) < bin);
    let middle = first.len();
    first.extend(second);
    part.copy_from_slice(&first);
    middle
}

/// The axis and the first bin of the second side of the cheapest split; `None` where all centres fall together.
fn best_plane(boxes: &[Bounds], part: &[usize]) -> Option<(usize, usize)> {
    let centres = Bounds::of(part.iter().map(|&i| boxes[i].centre()))?;
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| centres.size()[axis] > 0.0) {
        let mut bins: [(usize, Option<Bounds>); BINS] = [(0, None); BINS];
        for &i in part {
            let (count, bounds) = &mut bins[bin_of(&boxes[i], &centres, axis)];
            *count += 1;
            *bounds = Some(bounds.map_or(boxes[i], |bounds| bounds.with(&boxes[i])));
        }
        for at in 1..BINS {
            let cost = |side: &[(usize, Option<Bounds>)]| {
                let count: usize = side.iter().map(|(count, _)| count).sum();
                let bounds = Bounds::around(side.iter().filter_map(|(_, bounds)| *bounds))?;
                Some(count as f64 * bounds.half_area())
            };
            let (Some(first), Some(second)) = (cost(&bins[..at]), cost(&bins[at..])) else { continue };
            if best.is_none_or(|(least, _, _)| first + second < least) {
                best = Some((first + second, axis, at));
            }
        }
    }
    best.map(|(_, axis, at)| (axis, at))
}

fn bin_of(bounds: &Bounds, centres: &Bounds, axis: usize) -> usize {
    let place = (bounds.centre()[axis] - centres.low[axis]) / centres.size()[axis];
    ((place * BINS as f64) as usize).min(BINS - 1)
}

fn longest_axis(size: DVec3) -> usize {
    (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).expect("three axes")
}

fn device_node(bounds: &Bounds, first: usize, count: usize) -> DeviceNode {
    // Rounded outward.
    let low = bounds
        .low
        .to_array()
        .map(|x| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 });
    let high =
        bounds.high.to_array().map(|x| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 });
    DeviceNode {
        low: [low[0], low[1], low[2], f32::from_bits(first as u32)],
        high: [high[0], high[1], high[2], f32::from_bits(count as u32)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubes(places: impl IntoIterator<Item = DVec3>, half: f64) -> Vec<Bounds> {
        places.into_iter().map(|p| Bounds { low: p - half, high: p + half }).collect()
    }

    /// Checks that every box is in one leaf within the boxes above it, and gives the deepest level.
    fn check(boxes: &[Bounds]) -> u32 {
        let (nodes, order) = build(boxes);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..boxes.len()));
        let mut next = 0;
        let mut deepest = 0;
        let mut open = vec![(0, 0, Vec::new())];
        let mut visited = 0;
        while let Some((node, level, above)) = open.pop() {
            visited += 1;
            deepest = level.max(deepest);
            let DeviceNode { low, high } = nodes[node];
            let (first, count) = (low[3].to_bits() as usize, high[3].to_bits() as usize);
            let above: Vec<usize> = above.iter().copied().chain([node]).collect();
            if count == 0 {
                open.push((first + 1, level + 1, above.clone()));
                open.push((first, level + 1, above));
                continue;
            }
            assert!(first == next && count <= LEAF, "{first} {next} {count}");
            next += count;
            for (&i, node) in order[first..next].iter().flat_map(|i| above.iter().map(move |node| (i, node)))
            {
                for axis in 0..3 {
                    assert!(f64::from(nodes[*node].low[axis]) <= boxes[i].low[axis]);
                    assert!(f64::from(nodes[*node].high[axis]) >= boxes[i].high[axis]);
                }
            }
        }
        assert_eq!((next, visited), (boxes.len(), nodes.len()));
        deepest
    }

    #[test]
    fn leaves_hold_every_box_once() {
        for count in [1, 4, 5, 9, 1000] {
            let place =
                |i: usize| DVec3::new((i * 37 % 101) as f64, (i * 53 % 97) as f64 / 3.0, (i % 7) as f64);
            check(&cubes((0..count).map(place), 0.1));
        }
    }

    #[test]
    fn boxes_in_one_place_are_divided_all_the_same() {
        assert_eq!(check(&cubes([DVec3::ONE; 1000], 1.0)), 8);
    }

    /// Each split of the heuristic would take one box away.
    #[test]
    fn places_that_grow_exponentially_stay_within_the_stack() {
        let places =
            (0..2000).map(|i| DVec3::X * 1.5_f64.powi(i % 200) * if i % 2 == 0 { 1.0 } else { -1.0 });
        let deepest = check(&cubes(places, 1e-3));
        assert!((10..=DEPTH).contains(&deepest), "{deepest}");
    }

    #[test]
    fn two_clusters_are_told_apart_first() {
        let places = (0..10).map(|i| DVec3::new(if i < 7 { 0.0 } else { 100.0 }, i as f64, 0.0));
        let (nodes, _) = build(&cubes(places, 0.5));
        assert_eq!((nodes[1].high[0], nodes[2].low[0]), (0.5, 99.5));
    }
}
