//! Explicit diffusion of scattered light against closed forms and against its twin in double precision.

#[path = "common/cells.rs"]
mod cells;
mod common;

use cells::Medium;
use common::{EPS, close, device, largest, noise};
use glam::DVec3;
use svetlo::device::{Buffer, Device};
use svetlo::irradiance::{DirectLight, Spreading, check_diffusion, largest_diffusion};
use svetlo::reference::convection::Spreading as Twin;

/// Roundings of a step in units of the largest light: six differences, products and sums of at most one weight in all,
/// and the weights' own.
const STEPPED: f64 = 24.0 * EPS;

fn direct(device: &Device, fluence: &[[f64; 3]]) -> DirectLight {
    let rgbw: Vec<[f32; 4]> = fluence.iter().map(|&[r, g, b]| [r, g, b, 0.5].map(|v| v as f32)).collect();
    DirectLight {
        fluence: Buffer::from_slice(device, &rgbw).unwrap(),
        reduced: None,
        flow: None,
        extent: None,
    }
}

/// All light, direct and scattered, after some steps, per channel.
fn spread(medium: &Medium, fluence: &[[f64; 3]], diffusion: f64, steps: u32) -> Vec<[f64; 3]> {
    let device = device();
    let direct = direct(&device, fluence);
    let mut spreading = Spreading::new(&device, &medium.grid, &medium.cells(&device), diffusion).unwrap();
    // In two parts: the same steps.
    spreading.advance(&device, &direct, steps / 3).unwrap();
    spreading.advance(&device, &direct, steps - steps / 3).unwrap();
    assert_eq!(spreading.steps(), u64::from(steps));
    let scattered = spreading.fluence().read(&device).unwrap();
    assert!(scattered.iter().all(|cell| cell[3] == 0.0));
    // As a float32 sum, which is what the steps hold.
    let sum =
        |(cell, direct): (&[f32; 4], &[f64; 3])| [0, 1, 2].map(|c| f64::from(cell[c] + direct[c] as f32));
    scattered.iter().zip(fluence).map(sum).collect()
}

fn uniform(dims: [usize; 3], cell: DVec3) -> Medium {
    Medium::grey(dims, cell, |_| [2.0, 0.0])
}

/// Light in the middle cell only.
fn spark(medium: &Medium) -> Vec<[f64; 3]> {
    let mut fluence = vec![[0.0; 3]; medium.grid.cells()];
    fluence[medium.grid.cells() / 2] = [1.0, 2.0, 0.5];
    fluence
}

#[test]
fn a_spark_keeps_its_light_and_widens_by_twice_the_weight_each_step() {
    let medium = uniform([23, 21, 25], DVec3::new(1.0, 1.25, 2.0));
    let steps = 10;
    let diffusion = largest_diffusion(&medium.grid);
    let light = spread(&medium, &spark(&medium), diffusion, steps);
    let roundings = f64::from(steps + 2) * STEPPED;
    for channel in 0..3 {
        let power = [1.0, 2.0, 0.5][channel];
        let sum: f64 = light.iter().map(|cell| cell[channel]).sum();
        // The error of each cell is relative to the largest light near it: all cells together have at most the roundings
        // of the light itself.
        close("sum", sum, power, roundings * power);
        for axis in 0..3 {
            let edge = medium.grid.cell[axis];
            let middle = medium.centre(medium.grid.cells() / 2)[axis];
            let moment = light
                .iter()
                .enumerate()
                .map(|(i, cell)| cell[channel] * (medium.centre(i)[axis] - middle).powi(2));
            let weight = diffusion / (edge * edge);
            let variance = f64::from(steps) * 2.0 * weight * edge * edge * power;
            let farthest = (f64::from(steps) * edge).powi(2);
            close("variance", moment.sum(), variance, roundings * farthest * power);
        }
    }
}

#[test]
fn what_reaches_the_sides_is_lost() {
    // One cell: a face of weight w on either side of each axis, and darkness behind it.
    let medium = uniform([1, 1, 1], DVec3::new(1.0, 2.0, 4.0));
    let light = spread(&medium, &spark(&medium), 0.25, 7);
    let kept = 1.0 - 2.0 * 0.25 * (1.0 + 0.25 + 0.0625_f64);
    close("one cell", light[0][1], 2.0 * kept.powi(7), 2.0 * 9.0 * STEPPED);
    // All light of a slab leaves in the end, the direct light's too: the equation has no other steady state.
    let medium = uniform([4, 1, 3], DVec3::ONE);
    let fluence = vec![[1.0; 3]; medium.grid.cells()];
    let left = spread(&medium, &fluence, 1.0 / 6.0, 200);
    // Across the one cell that is thick along y, a third of it leaves each step.
    let bound = (2.0_f64 / 3.0).powi(200) + 202.0 * STEPPED;
    assert!(largest(left.iter().map(|cell| cell[0])) <= bound, "{left:?}");
}

#[test]
fn steps_follow_their_twin() {
    for (dims, cell) in [
        ([7, 9, 5], DVec3::ONE),
        ([12, 5, 11], DVec3::new(1.0, 1.3, 1.7)),
        ([1, 13, 8], DVec3::new(2.0, 1.0, 1.5)),
        ([19, 1, 1], DVec3::ONE),
        ([1, 1, 1], DVec3::new(1.0, 3.0, 1.2)),
    ] {
        let medium = Medium::random(dims, cell, true, 7);
        let random = noise(3 * medium.grid.cells(), 8);
        let fluence: Vec<[f64; 3]> = (0..medium.grid.cells())
            .map(|i| [0, 1, 2].map(|c| f64::from(random[3 * i + c] as f32)))
            .collect();
        let diffusion = largest_diffusion(&medium.grid);
        let found = spread(&medium, &fluence, diffusion, 15);
        let most = largest((0..3).flat_map(|c| medium.extinction(c, 1.0)));
        for channel in 0..3 {
            let weight = medium.scattering.iter().map(|s| diffusion * f64::from(s[channel]) / most).collect();
            let ratio = cell.min_element() / cell;
            let twin = Twin { dims, along: ratio * ratio, weight };
            let mut light: Vec<f64> = fluence.iter().map(|cell| cell[channel]).collect();
            for _ in 0..15 {
                light = twin.step(&light);
            }
            for (found, exact) in found.iter().zip(light) {
                close("light", found[channel], exact, 19.0 * STEPPED);
            }
        }
    }
}

#[test]
fn all_light_stays_between_nothing_and_the_most_there_was() {
    for (dims, cell) in [([8, 7, 9], DVec3::ONE), ([9, 8, 6], DVec3::new(1.7, 1.0, 1.2))] {
        for medium in [uniform(dims, cell), Medium::random(dims, cell, true, 19)] {
            // Checkers of light and none: the roughest there is.
            let bright = |i: usize| (i % dims[0] + i / dims[0] % dims[1] + i / dims[0] / dims[1]) % 2;
            let fluence: Vec<[f64; 3]> = (0..medium.grid.cells()).map(|i| [bright(i) as f64; 3]).collect();
            for steps in [1, 2, 30] {
                for cell in spread(&medium, &fluence, largest_diffusion(&medium.grid), steps) {
                    for light in cell {
                        // What is returned is the difference from the direct light, which rounds once.
                        assert!((-EPS..=1.0 + f64::from(steps) * STEPPED).contains(&light), "{light}");
                    }
                }
            }
        }
    }
}

#[test]
fn what_is_taken_from_direct_light_shows_as_less_than_nothing() {
    let device = device();
    let medium = uniform([5, 5, 5], DVec3::ONE);
    let fluence = spark(&medium);
    let mut spreading = Spreading::new(&device, &medium.grid, &medium.cells(&device), 0.125).unwrap();
    spreading.advance(&device, &direct(&device, &fluence), 1).unwrap();
    let scattered = spreading.fluence().read(&device).unwrap();
    assert_eq!(scattered[62][0], -0.75);
    assert_eq!(scattered[61][0], 0.125);
    // The light goes out: what was taken from it cannot be had back.
    spreading.advance(&device, &direct(&device, &vec![[0.0; 3]; 125]), 1).unwrap();
    let scattered = spreading.fluence().read(&device).unwrap();
    assert!(scattered.iter().flatten().all(|&light| light >= 0.0));
    assert_eq!(scattered[62][0], 6.0 * 0.125 * 0.125);
}

#[test]
fn media_that_do_not_scatter_spread_nothing() {
    for sigma in [[0.0, 0.0], [0.0, 3.0]] {
        let medium = Medium::grey([4, 3, 5], DVec3::ONE, |_| sigma);
        let fluence = vec![[1.0, 0.5, 0.25]; 60];
        assert_eq!(spread(&medium, &fluence, 0.1, 6), fluence);
        assert_eq!(spread(&medium, &fluence, 0.1, 0), fluence);
    }
}

#[test]
fn weights_that_are_unstable_are_refused_with_the_largest() {
    let cubes = uniform([3, 3, 3], DVec3::ONE).grid;
    check_diffusion(0.0, &cubes).unwrap();
    check_diffusion(1.0 / 6.0, &cubes).unwrap();
    check_diffusion(0.1666, &cubes).unwrap();
    let error = check_diffusion(0.1667, &cubes).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert_eq!(
        error.to_string(),
        "`method.spreading` = 0.1667 is too large: a cell would give its neighbours more light than it has, which is unstable; \
         with this volume's cells it must be at most 0.1666"
    );
    let plates = uniform([3, 3, 3], DVec3::new(1.0, 2.0, 1.0)).grid;
    close("plates", largest_diffusion(&plates), 0.5 / 2.25, 1e-15);
    for wrong in [-0.1, f64::NAN] {
        let error = check_diffusion(wrong, &cubes).unwrap_err().to_string();
        assert!(error.contains("must not be below 0"), "{error}");
    }
    let device = device();
    let medium = uniform([3, 3, 3], DVec3::ONE);
    assert!(Spreading::new(&device, &medium.grid, &medium.cells(&device), 0.17).is_err());
}

#[test]
fn the_memory_that_is_announced_is_what_is_allocated() {
    let grid = uniform([4, 5, 6], DVec3::ONE).grid;
    // Weights and two boxes of light with padding; the scattered fluence.
    assert_eq!(Spreading::memory(&grid).total(), 16 * (3 * 6 * 7 * 8 + 4 * 5 * 6));
}
