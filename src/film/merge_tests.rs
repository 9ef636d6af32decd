use super::*;
use proptest::prelude::*;

/// Samples are these integers times 2^-20, plus an offset.
const SCALE: f64 = 1.0 / (1 << 20) as f64;

/// Mean and sum of squared deviations, exactly: numerators over the number of samples.
fn exact(samples: &[i64]) -> (i128, i128) {
    let n = samples.len() as i128;
    let sum: i128 = samples.iter().map(|&x| i128::from(x)).sum();
    let squares: i128 = samples.iter().map(|&x| i128::from(x) * i128::from(x)).sum();
    (sum, n * squares - sum * sum)
}

/// A numerator over a count, times a power of two, as a film keeps it.
fn rounded(numerator: i128, count: usize, scale: f64) -> (f32, f32, f64) {
    // Halves of 63 bits are exact in two float64 each.
    let (low, high) = (numerator & i128::from(u64::MAX), numerator >> 64);
    let whole = Double::of_count(low as u64) + Double::from(high as f64) * 2_f64.powi(64);
    let exact = whole.over(count as f64) * scale;
    pair(exact, exact.value().abs())
}

/// The pixel of these samples: the same in all channels but for their factors 1, 2, 4 and 8.
fn pixel(samples: &[i64]) -> (FilmPixel, FilmRest) {
    let (mut pixel, mut rest) = (FilmPixel::zeroed(), FilmRest::zeroed());
    if samples.is_empty() {
        return (pixel, rest);
    }
    let (sum, squares) = exact(samples);
    for c in 0..4 {
        let factor = f64::from(1 << c) * SCALE;
        let (mean, m2) =
            (rounded(sum, samples.len(), factor), rounded(squares, samples.len(), factor * factor));
        (pixel.mean[c], pixel.mean_low[c]) = (mean.0, mean.1);
        (pixel.m2[c], pixel.m2_low[c]) = (m2.0, m2.1);
        (rest.mean_low[c], rest.mean_high[c]) = halves(mean.2);
        (rest.m2_low[c], rest.m2_high[c]) = halves(m2.2);
    }
    let depth = Double::of_count(samples.len() as u64) * SCALE;
    let left;
    (pixel.depth, left) = single(depth, 0.0);
    (rest.depth_low, rest.depth_high) = halves(left);
    pixel.count = samples.len() as u32;
    pixel.hits = pixel.count.div_ceil(2);
    pixel.lookups_low = u32::MAX - 2;
    (pixel, rest)
}

fn merged(groups: &[&(FilmPixel, FilmRest)]) -> Moments {
    let all = groups.iter().map(|(pixel, rest)| Moments::of(pixel, rest));
    all.reduce(|a, b| a.plus(&b)).unwrap_or_default()
}

/// Groups of samples: some empty, some of one, some all equal, with offsets from none to 2^20 times their spread.
fn groups(offset: i64) -> impl Strategy<Value = Vec<Vec<i64>>> {
    let offset = prop_oneof![Just(0_i64), Just(offset), -offset..=offset];
    let group = prop_oneof![
        3 => prop::collection::vec(-(1_i64 << 20)..(1 << 20), 0..7),
        1 => (0_usize..5, -100_i64..100).prop_map(|(n, value)| vec![value; n]),
    ];
    (offset, prop::collection::vec(group, 1..6)).prop_map(|(offset, groups)| {
        groups.into_iter().map(|group| group.into_iter().map(|x| x + offset).collect()).collect()
    })
}

proptest! {
    /// Whatever the groups, the moments are those of all samples: the mean to the last bit of both floats, the squares,
    /// which offsets cancel from, to that of their sum.
    #[test]
    fn moments_are_those_of_all_samples(groups in groups(1 << 40)) {
        let pixels: Vec<_> = groups.iter().map(|group| pixel(group)).collect();
        let (found, _) = merged(&pixels.iter().collect::<Vec<_>>()).pixel();
        let (expected, _) = pixel(&groups.concat());
        prop_assert_eq!(found.count, expected.count);
        for c in 0..4 {
            prop_assert_eq!(found.mean[c], expected.mean[c]);
            prop_assert_eq!(found.mean_low[c], expected.mean_low[c]);
            let [sum, wanted] = [&found, &expected].map(|pixel| f64::from(pixel.m2[c]) + f64::from(pixel.m2_low[c]));
            prop_assert!((sum - wanted).abs() <= 2_f64.powi(-47) * wanted, "{} {}", sum, wanted);
        }
    }

    /// ... and without the rests, as films come from devices, to what pairs of floats hold of the groups' own moments:
    /// 2^-48 of the values, whose squares may cancel.
    #[test]
    fn pairs_of_floats_keep_their_precision(groups in groups(1 << 40)) {
        let pixels: Vec<_> = groups.iter().map(|group| (pixel(group).0, FilmRest::zeroed())).collect();
        let (found, _) = merged(&pixels.iter().collect::<Vec<_>>()).pixel();
        let all = groups.concat();
        let largest = all.iter().map(|x| (*x as f64).abs()).fold(0.0, f64::max) * SCALE;
        let spread = groups.iter().filter(|group| !group.is_empty()).map(|group| {
            group.iter().sum::<i64>() as f64 / group.len() as f64 * SCALE
        });
        let (low, high) = spread.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        let (expected, _) = pixel(&all);
        for c in 0..4 {
            let factor = f64::from(1 << c);
            let eps = 2_f64.powi(-48);
            let error = (found.mean()[c] - expected.mean()[c]).abs();
            // The groups' means, and the result.
            prop_assert!(error <= 2.0 * eps * factor * largest, "mean off by {}", error);
            let sum = |pixel: &FilmPixel| f64::from(pixel.m2[c]) + f64::from(pixel.m2_low[c]);
            let error = (sum(&found) - sum(&expected)).abs();
            // d(delta^2 n_a n_b / n) for each group, and the sums' own rounding.
            let delta = 2.0 * factor * (high - low).max(0.0) + 2.0 * eps * factor * largest;
            let bound = all.len() as f64 * 2.0 * delta * eps * factor * largest + 2.0 * eps * sum(&expected);
            prop_assert!(error <= bound, "m2 off by {}, not below {}", error, bound);
        }
    }

    /// Bit for bit the same in any order, and in any groups of groups that go through files.
    #[test]
    fn order_and_groups_do_not_show(groups in groups(1 << 10), turn in 0_usize..6, cut in 0_usize..6) {
        let pixels: Vec<_> = groups.iter().map(|group| pixel(group)).collect();
        let mut all: Vec<_> = pixels.iter().collect();
        let expected = merged(&all).pixel().0;
        let turn = turn % all.len();
        all.rotate_left(turn);
        prop_assert_eq!(merged(&all).pixel().0, expected);
        all.reverse();
        prop_assert_eq!(merged(&all).pixel().0, expected);
        let (first, second) = all.split_at(cut % all.len());
        let (first, second) = (merged(first).pixel(), merged(second).pixel());
        prop_assert_eq!(merged(&[&first, &second]).pixel().0, expected);
    }

    /// A pixel alone comes back as it was, and what its floats cannot hold, to 2^-100.
    #[test]
    fn a_single_film_is_left_as_it_is(group in prop::collection::vec(any::<i32>(), 1..5)) {
        let group: Vec<i64> = group.into_iter().map(i64::from).collect();
        let (before, rest) = pixel(&group);
        let (after, more) = merged(&[&(before, rest)]).pixel();
        prop_assert_eq!(after, before);
        for c in 0..4 {
            let [a, b] = [more, rest].map(|rest| joined(rest.mean_low[c], rest.mean_high[c]));
            prop_assert!((a - b).abs() <= 2_f64.powi(-100) * before.mean()[c].abs(), "{} {}", a, b);
        }
    }
}

#[test]
fn lookups_count_beyond_32_bits_and_hits_weigh_depths() {
    let deep = FilmPixel { depth: 4.0, hits: 3, count: 5, lookups_low: u32::MAX, ..FilmPixel::zeroed() };
    let near =
        FilmPixel { depth: 2.0, hits: 1, count: 7, lookups_low: 3, rejected: 2, ..FilmPixel::zeroed() };
    let none = FilmPixel { count: 1, ..FilmPixel::zeroed() };
    let rest = FilmRest::zeroed();
    let (all, _) = merged(&[&(none, rest), &(deep, rest), &(near, rest)]).pixel();
    assert_eq!((all.depth, all.hits, all.count, all.rejected), (3.5, 4, 13, 2));
    assert_eq!(all.lookups(), u64::from(u32::MAX) + 3);
}

#[test]
fn squares_beyond_float32_stay_unknown() {
    let large = FilmPixel {
        mean: [1e25; 4],
        m2: [f32::INFINITY; 4],
        m2_low: [f32::NAN; 4],
        count: 5,
        ..FilmPixel::zeroed()
    };
    let small = FilmPixel { mean: [1.0; 4], m2: [2.0; 4], count: 3, ..FilmPixel::zeroed() };
    let rest = FilmRest::zeroed();
    for order in [[large, small], [small, large]] {
        let (all, more) = merged(&[&(order[0], rest), &(order[1], rest)]).pixel();
        assert_eq!(all.variance(), Some([f64::INFINITY; 4]));
        assert_eq!((all.m2, all.m2_low), ([f32::INFINITY; 4], [0.0; 4]));
        assert!((all.mean()[0] / (5e25 / 8.0) - 1.0).abs() < 1e-6);
        assert_eq!(more.m2_high, [0; 4]);
    }
    // Means so far apart that their squares are: the same.
    let far = FilmPixel { mean: [-1e25; 4], m2: [0.0; 4], count: 1, ..FilmPixel::zeroed() };
    assert_eq!(merged(&[&(small, rest), &(far, rest)]).pixel().0.variance(), Some([f64::INFINITY; 4]));
}
