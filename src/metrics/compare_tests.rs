//! Metrics against sums by hand and against known noise.

use super::*;
use crate::metrics::{
    Removed, Thresholds,
    test_pictures::{noisy, row},
};

#[track_caller]
fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1e-3), "{a} and {b}");
}

#[test]
fn metrics_by_hand() {
    // d = (0.5, −1, 0, 0.5), r = (0.5, 2, 1, 0.5), mean r = 1, floor 0.1, ε = 0.01.
    let result = compare(&row(&[1.0, 1.0, 1.0, 1.0]), &row(&[0.5, 2.0, 1.0, 0.5])).unwrap();
    assert_eq!((result.channels.as_slice(), result.pixels), (&["Y"][..], 4));
    close(result.mse.value, 1.5 / 4.0);
    close(result.rmse, 0.375_f64.sqrt());
    close(result.bias.mean, 0.0);
    close(result.bias.relative.unwrap(), 0.0);
    close(result.relmse.unwrap().value, (2.0 * 0.25 / 0.26 + 1.0 / 4.01) / 4.0);
    close(result.mape.unwrap().value, (2.0 * 0.5 / 0.6 + 1.0 / 2.1) / 4.0);
    assert_eq!(result.psnr.peak, 2.0);
    close(result.psnr.linear_db.unwrap(), 10.0 * (4.0_f64 / 0.375).log10());
    // On codes: 1 against code(0.5) twice, the clamped 2 and the 1 agree.
    let code = 1.055 * 0.5_f64.powf(1.0 / 2.4) - 0.055;
    close(result.psnr.display_db.unwrap(), -10.0 * ((1.0 - code).powi(2) / 2.0).log10());
    assert!(result.corrected.is_empty() && result.pixel_z.is_none() && result.bias.standard_error.is_none());
}

#[test]
fn equal_pictures_and_a_black_reference() {
    let equal = compare(&row(&[0.0, 1.0]), &row(&[0.0, 1.0])).unwrap();
    assert_eq!((equal.rmse, equal.psnr.linear_db), (0.0, None));
    assert!(equal.to_string().contains("infinite"));
    let black = compare(&row(&[0.0, 1.0]), &row(&[0.0, 0.0])).unwrap();
    assert!(black.relmse.is_none() && black.mape.is_none() && black.psnr.linear_db.is_none());
    assert!(black.to_string().contains("undefined"));
    let strict = Thresholds { max_relmse: Some(1.0), min_psnr: Some(20.0), ..Thresholds::default() };
    assert_eq!(strict.violations(&black).len(), 2);
    assert!(strict.violations(&equal).is_empty());
    let both = compare(&row(&[0.0]), &row(&[0.0])).unwrap();
    assert!(strict.violations(&both).is_empty());
}

#[test]
fn bad_pixels_are_left_out_and_counted() {
    let image = row(&[f32::NAN, 1.0, f32::INFINITY, 3.0]);
    let reference = row(&[0.0, 2.0, f32::NAN, 3.0]);
    let result = compare(&image, &reference).unwrap();
    assert_eq!((result.pixels, result.non_finite), (2, NonFinite { image: 2, reference: 1 }));
    close(result.mse.value, 0.5);
    let lax = Thresholds { max_rmse: Some(9.0), ..Thresholds::default() };
    assert_eq!(lax.violations(&result), ["2 pixels of the image are not finite"]);
    assert!(Thresholds::default().violations(&result).is_empty());
    assert_eq!(compare(&row(&[f32::NAN]), &row(&[1.0])).unwrap_err().exit_code(), 2);
}

#[test]
fn sizes_and_channels_must_fit() {
    let text = compare(&row(&[1.0]), &row(&[1.0, 2.0])).unwrap_err().to_string();
    assert!(text.contains("1×1") && text.contains("2×1"), "{text}");
    let depth = Picture::new(1, 1).with_channel("Z", vec![1.0]);
    assert!(compare(&row(&[1.0]), &depth).unwrap_err().to_string().contains("it has Z"));
    let colour = (["R", "G", "B"].into_iter().zip([1.0, 2.0, 4.0]))
        .fold(Picture::new(1, 1), |picture, (name, value)| picture.with_channel(name, vec![value]));
    let grey = compare(&colour, &row(&[1.0])).unwrap();
    assert_eq!(grey.channels, ["R", "G", "B"]);
    close(grey.mse.value, 10.0 / 3.0);
    let broken = Picture::new(2, 2).with_channel("Y", vec![1.0]);
    assert_eq!(compare(&broken, &broken).unwrap_err().exit_code(), 2);
}

#[test]
fn each_limit_is_checked() {
    let result = compare(&row(&[1.0, 1.0]), &row(&[0.5, 1.0])).unwrap();
    let all = |bound: f64, psnr: f64| Thresholds {
        max_rmse: Some(bound),
        min_psnr: Some(psnr),
        max_relmse: Some(bound),
        max_mape: Some(bound),
        max_bias: Some(bound),
    };
    assert_eq!(all(0.01, 60.0).violations(&result).len(), 5);
    assert!(all(2.0, 1.0).violations(&result).is_empty());
}

/// Two independent noisy pictures of one truth, an offset of 0.02 on the image. With M values,
/// v = Var(x−r) and offset b, the plain MSE has mean v + b² and variance (2v² + 4vb²)/M; the
/// corrections subtract constants. All within 4 standard deviations.
#[test]
fn corrections_recover_the_known_error() {
    let (size, sigma, offset) = (96, 0.5, 0.02);
    let (x, r) = (noisy(1, size, 1.0 + offset, sigma, 16), noisy(2, size, 1.0, sigma, 64));
    let result = compare(&x, &r).unwrap();
    let m = (3 * size * size) as f64;
    let (vx, vr) = (sigma * sigma / 16.0, sigma * sigma / 64.0);
    let v = vx + vr;
    let four = 4.0 * ((2.0 * v * v + 4.0 * v * offset * offset) / m).sqrt();
    let near = |value: f64, expected: f64| assert!((value - expected).abs() < four, "{value} and {expected}");
    near(result.mse.value, v + offset * offset);
    for (removed, expected) in [(Removed::Reference, vx), (Removed::Image, vr), (Removed::Both, 0.0)] {
        let found = result.corrected.iter().find(|corrected| corrected.removed == removed).unwrap();
        near(found.mse.value, expected + offset * offset);
        assert_eq!(found.unknown, 0);
    }
    // The channels are independent here; the standard error is the bound for full correlation.
    let error = result.bias.standard_error.unwrap();
    assert!((error / ((3.0 * v / m).sqrt()) - 1.0).abs() < 1e-6);
    assert!((result.bias.mean - offset).abs() < 4.0 * (v / m).sqrt());
    for channel in &result.bias.channels {
        let error = channel.standard_error.unwrap();
        assert!((error / (3.0 * v / m).sqrt() - 1.0).abs() < 1e-6);
        assert!((channel.mean - offset).abs() < 4.0 * error);
    }
}

#[test]
fn without_bias_one_value_in_twenty_is_beyond_two_sigma() {
    let result = compare(&noisy(3, 96, 1.0, 0.3, 4), &noisy(4, 96, 1.0, 0.3, 8)).unwrap();
    let z = result.pixel_z.unwrap();
    let sigma = (0.05 * 0.95 / z.values as f64).sqrt();
    assert!((z.beyond_1_96 - 0.05).abs() < 4.0 * sigma, "{}", z.beyond_1_96);
    assert!(result.bias.z.unwrap().abs() < 4.0);
}

#[test]
fn a_negative_correction_is_reported_as_such() {
    let x = row(&[1.0, 1.0]).with_channel("variance.Y", vec![4.0; 2]).with_counts("samples", vec![2, 1]);
    let result = compare(&x, &row(&[1.0, 1.5])).unwrap();
    let corrected = result.corrected[0];
    assert_eq!((corrected.removed, corrected.unknown), (Removed::Image, 1));
    close(corrected.mse.value, -2.0);
    assert_eq!(corrected.rmse, None);
    assert!(result.to_string().contains("below noise"), "{result}");
    assert_eq!(result.bias.standard_error, None);
}

#[test]
fn a_large_offset_does_not_drown_a_small_difference() {
    let base = 16_777_216.0_f32;
    let result = compare(&row(&[base + 2.0; 1000]), &row(&[base; 1000])).unwrap();
    assert_eq!((result.mse.value, result.bias.mean), (4.0, 2.0));
}
