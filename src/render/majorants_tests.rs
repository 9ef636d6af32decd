use super::*;
use crate::config;
use crate::render::grid::StoredWindow;
use crate::render::local::LocalFrame;
use crate::scene::Scene;
use crate::volume::{Volume, Voxels};
use std::path::Path;

const WINDOW: (f64, f64) = (0.0, 1.0);

/// The table of a `[medium]` (`sigma_max` = 10) and `[transfer]`, in units of 1.
pub(in crate::render) fn table(transfer: &str) -> MediumTable {
    let text = format!(
        "[image]\nwidth = 1\nheight = 1\n[camera]\nposition = [0, 0, -9]\ntarget = [0, 0, 0]\nfov = 30\n\
         [volume]\nfield = {{ kind = \"constant\" }}\ndims = [1, 1, 1]\n[medium]\nsigma_max = 10\n\
         [transfer]\n{transfer}\n[method]\nkind = \"emission-absorption\"\n"
    );
    let scene = Scene::from_loaded(&config::parse("test.toml", &text, &[]).unwrap(), Path::new("")).unwrap();
    MediumTable::new(&scene.transfer, &scene.medium, WINDOW, 1.0).unwrap()
}

fn volume(dims: [usize; 3], voxel: impl Fn([usize; 3]) -> f32) -> Volume {
    let [nx, ny, nz] = dims;
    let voxels: Vec<f32> = (0..nx * ny * nz).map(|k| voxel([k % nx, k / nx % ny, k / (nx * ny)])).collect();
    Volume::new(dims, DVec3::ONE, Voxels::F32(voxels)).unwrap()
}

fn majorants(volume: &Volume, shift: u32, table: &MediumTable) -> (BrickRanges, Majorants) {
    let frame = LocalFrame::new(DVec3::ZERO, volume.spacing, volume.dims);
    let grid = Grid::new(volume, StoredWindow::new(volume, WINDOW), frame);
    let bricks = grid.brick_ranges(shift);
    let gradients = grid.brick_gradients(&bricks);
    let majorants = Majorants::new(&grid, &bricks, Some(&gradients), table);
    (bricks, majorants)
}

/// Noise in 0..1 from the voxel's indices.
fn noise([x, y, z]: [usize; 3]) -> f32 {
    (DVec3::new(x as f64, y as f64, z as f64).dot(DVec3::new(12.9898, 78.233, 37.719)).sin() * 43758.5453)
        .rem_euclid(1.0) as f32
}

#[test]
fn empty_bricks_reach_as_far_as_nothing_is() {
    // Two specks, one of which four bricks share along x: voxel 22 lies at the plane 24.
    let specks = [[22, 3, 3], [50, 0, 9]];
    let volume = volume([64, 6, 10], |voxel| if specks.contains(&voxel) { 1.0 } else { 0.0 });
    for shift in [1, 2, 3] {
        let (bricks, majorants) = majorants(&volume, shift, &table(""));
        let occupied: Vec<[usize; 3]> = (0..bricks.ranges.len())
            .filter(|&index| bricks.ranges[index][1] > 0.0)
            .map(|index| brick(&bricks, index))
            .collect();
        for (index, [majorant, minorant]) in majorants.bounds.iter().enumerate() {
            let here = brick(&bricks, index);
            let distance = |there: &[usize; 3]| (0..3).map(|a| here[a].abs_diff(there[a])).max().unwrap();
            let nearest = occupied.iter().map(distance).min().unwrap();
            if nearest == 0 {
                assert!(*majorant >= 10.0 && *minorant == 0.0);
            } else {
                assert_eq!(*majorant, -(nearest as f32), "{here:?} at shift {shift}");
            }
        }
    }
}

#[test]
fn the_occupied_box_is_that_of_the_bricks_and_inside_the_cells() {
    let (_, one) = majorants(&volume([64, 6, 10], |v| f32::from(v == [22, 3, 3])), 2, &table(""));
    // Grid coordinates 24, 5, 5: on the plane between two bricks along x, inside one along y and z.
    assert_eq!(one.occupied, Some(([20, 4, 4], [28, 8, 8])));
    let (_, corner) = majorants(&volume([64, 6, 10], |v| f32::from(v == [0, 5, 9])), 2, &table(""));
    // Cells start at 1 and end at n + 2.
    assert_eq!(corner.occupied, Some(([1, 4, 8], [4, 8, 12])));
}

#[test]
fn nothing_is_empty_everywhere() {
    let (_, nothing) = majorants(&volume([9, 5, 3], |_| 0.0), 1, &table(""));
    assert!(nothing.bounds.iter().all(|bounds| *bounds == [-127.0, 0.0]));
    let (occupied, constant, color) = (nothing.occupied, nothing.constant, nothing.constant_color);
    assert_eq!((occupied, constant, color, nothing.largest), (None, Some(0.0), None, 0.0));
    // The shares are sums of products of exact halves over 9, 5 and 3.
    assert!((nothing.statistics.empty - 1.0).abs() < 1e-14);
    assert_eq!((nothing.statistics.majorant, nothing.statistics.sigma), (0.0, 0.0));
}

#[test]
fn constant_media_are_known() {
    let dims = [7, 6, 5];
    let ramp =
        table("points = [{ value = 0, opacity = 0 }, { value = 1, opacity = 1, color = \"#ff0000\" }]");
    let (_, data) = majorants(&volume(dims, |_| 0.25), 2, &ramp);
    // 0.25 is entry 255 of 1020; a quarter of 10, as float32 numbers hold it.
    assert_eq!(data.constant, Some(2.5));
    assert!(data.constant_color.is_some());
    let (_, neither) = majorants(&volume(dims, noise), 2, &ramp);
    assert_eq!((neither.constant, neither.constant_color), (None, None));

    let flat = "points = [{ value = 0, opacity = 0.5, color = \"#ff0000\" }, \
                { value = 0.99, opacity = 0.5, color = \"#ff0000\" }, { value = 1, opacity = 0.7 }]";
    let (_, inside) = majorants(&volume(dims, |v| 0.9 * noise(v)), 2, &table(flat));
    assert_eq!((inside.constant, inside.constant_color), (Some(5.0), Some([1.0, 0.0, 0.0])));
    let (_, beyond) = majorants(&volume(dims, |v| 2.0 * noise(v)), 2, &table(flat));
    assert_eq!((beyond.constant, beyond.constant_color), (None, None));

    let two_d = "kind = \"2d\"\ngradient_max = 1\n\
                 shapes = [{ shape = \"rectangle\", centre = [0.5, 0.5], size = [4, 4], color = \"#00ff00\" }]";
    let (_, two_d) = majorants(&volume(dims, noise), 2, &table(two_d));
    assert_eq!((two_d.constant, two_d.constant_color), (Some(10.0), Some([0.0, 1.0, 0.0])));
}

#[test]
fn the_mean_of_a_linear_medium_is_its_middle() {
    // Voxels 0, 1/31, …, 1 along x, constant beyond the outer centres: the mean is 1/2 of 10.
    let volume = volume([32, 3, 4], |[x, ..]| x as f32 / 31.0);
    let (bricks, majorants) = majorants(&volume, 3, &table(""));
    // Bricks end at the planes 8, 16, 24, 32, 40, which are voxels 6, 14, 22, 30 and beyond 31; the box runs from 1.5
    // to 33.5.
    assert_eq!(bricks.counts[0], 5);
    let parts = [(6.5, 6.0), (8.0, 14.0), (8.0, 22.0), (8.0, 30.0), (1.5, 31.0)];
    let expected = parts.iter().map(|(cells, voxel)| cells / 32.0 * 10.0 * voxel / 31.0).sum::<f64>();
    let found = majorants.statistics;
    // Bounds are widened by 16 + 4 roundings of 2^-24, and the values' ends by up to 3.1 · 3 of them.
    assert!(found.majorant > expected && found.majorant < expected + 10.0 * 30.0 / (1 << 24) as f64);
    // Independent points would have a standard deviation of 10 / √12 / 256.
    assert!((found.sigma - 5.0).abs() < 3.0 * 10.0 / 12.0_f64.sqrt() / 256.0, "{found:?}");
    assert!((found.lookups() - expected / 5.0).abs() < 0.01);
    assert_eq!(found.empty, 0.0);
}

#[test]
fn gradients_narrow_the_bounds() {
    let transfer = "kind = \"2d\"\ngradient_max = 0.5\n\
                    shapes = [{ shape = \"rectangle\", centre = [0.5, 0.9], size = [4, 0.2] }]";
    let table = table(transfer);
    // A slope of 1/15 per voxel: row 1/15 / 0.5 = 0.13, below the shape.
    let slope = volume([16; 3], |[x, ..]| x as f32 / 15.0);
    let (bricks, with) = majorants(&slope, 2, &table);
    assert_eq!(with.occupied, None);
    let frame = LocalFrame::new(DVec3::ZERO, slope.spacing, slope.dims);
    let grid = Grid::new(&slope, StoredWindow::new(&slope, WINDOW), frame);
    let without = Majorants::new(&grid, &bricks, None, &table);
    assert!(without.bounds.iter().all(|bounds| bounds[0] >= 10.0));
    // Away from the border's copies the gradient is 1/15 everywhere: known to rounding, from both sides.
    let gradients = grid.brick_gradients(&bricks);
    let [least, largest] = gradients[(2 * bricks.counts[1] + 2) * bricks.counts[0] + 2].map(f64::from);
    let bound = 60.0 / f64::from(1 << 24);
    assert!(least <= 1.0 / 15.0 && largest >= 1.0 / 15.0 && largest - least < bound, "{least} {largest}");
}

#[test]
fn scaled_bounds_stay_bounds_and_keep_the_reach() {
    let (_, specks) = majorants(&volume([24, 6, 6], |v| f32::from(v == [3, 3, 3])), 2, &table(""));
    let scaled = specks.scaled(3.0, 0.5);
    for ([a, b], [c, d]) in specks.bounds.iter().zip(&scaled) {
        assert_eq!((*c, *d), (if *a < 0.0 { *a } else { 3.0 * a }, 0.5 * b));
    }
    let third = specks.scaled(1.0 / 3.0, 1.0);
    let exact = |a: f32| f64::from(a) / 3.0;
    assert!(specks.bounds.iter().zip(&third).all(|(a, b)| a[0] < 0.0 || f64::from(b[0]) >= exact(a[0])));
}
