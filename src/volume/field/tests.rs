//! Fields against published or independently computed values, and gradients against central differences.

use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

/// Box coordinates of a point of `[−1, 1]³`.
fn unit(q: [f64; 3]) -> DVec3 {
    (DVec3::from_array(q) + 1.0) / 2.0
}

fn hydrogen(n: u32, l: u32, m: i32) -> Hydrogen {
    Hydrogen::new(n, l, m, Hydrogen::default_extent(n), DVec3::ONE).unwrap()
}

/// Values and gradients computed independently from the published formula, f = 6, α = 0.25.
#[test]
fn marschner_lobb_values_and_gradients() {
    let field = MarschnerLobb::new(6.0, 0.25).unwrap();
    let rows = [
        ([0.0, 0.0, 0.0], 0.6, [0.0, 0.0, -0.6283185307179586]),
        ([0.5, 0.0, 0.0], 0.5046223450489282, [4.1828427999752655, 0.0, -0.6283185307179586]),
        (
            [0.25, 0.25, -0.5],
            0.8643811010546392,
            [1.2781188802213226, 1.2781188802213226, -0.4442882938158366],
        ),
    ];
    for (q, value, gradient) in rows {
        assert!((field.value(unit(q)) - value).abs() < 1e-12, "{q:?}");
        let error = field.gradient(unit(q)) - DVec3::from_array(gradient);
        assert!(error.abs().max_element() < 1e-12, "{q:?}: {error}");
    }
}

/// Points in and around the ellipsoids; the last three tell the two rotations apart.
#[test]
fn shepp_logan_points() {
    let rows = [
        ([0.0, 0.0, 0.0], 0.2, 0.2),
        ([0.22, 0.0, 0.0], 0.0, 0.0),
        ([-0.22, 0.1, 0.05], 0.0, 0.0),
        ([0.0, 0.35, -0.15], 0.3, 0.3),
        ([0.0, 0.1, 0.25], 0.3, 0.3),
        ([0.0, -0.605, 0.0], 0.3, 0.3),
        ([0.67, 0.0, 0.0], 1.0, 1.0),
        ([0.9, 0.9, 0.9], 0.0, 0.0),
        ([0.3, -0.25, 0.0], 0.2, 0.2),
        ([-0.05, -0.37, -0.1], 0.0, 0.2),
        ([-0.14, 0.14, -0.12], 0.2, 0.0),
        ([0.26, -0.19, -0.14], 0.0, 0.2),
    ];
    let (schabel, own) = (SheppLogan::new(Rotation::Schabel), SheppLogan::new(Rotation::OwnAxis));
    for (q, by_schabel, by_own) in rows {
        assert!((schabel.value(unit(q)) - by_schabel).abs() < 1e-12, "{q:?}");
        assert!((own.value(unit(q)) - by_own).abs() < 1e-12, "{q:?}");
    }
}

/// Integrals along lines from the exact chords of the ellipsoids.
#[test]
fn shepp_logan_line_integrals() {
    let rows = [
        ([0.0, -2.0, 0.0], [0.0, 1.0, 0.0], 0.42882941902213956, 0.4500294334306536),
        ([-2.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.2080912463872695, 0.2050449005504792),
        ([0.0, 0.0, -2.0], [0.0, 0.0, 1.0], 0.3722765957480785, 0.3722765957480785),
        ([-2.0, 0.1, 0.25], [1.0, 0.0, 0.0], 0.3196196882722465, 0.2940646553887858),
        ([0.22, -2.0, 0.1], [0.0, 1.0, 0.0], 0.31865457124696484, 0.31863274562093213),
        ([-1.5, -1.2, -0.9], [1.5, 1.25, 1.0], 0.28911912334559164, 0.2911745215575415),
        ([-2.0, -0.605, 0.0], [1.0, 0.0, 0.0], 0.2723661051044688, 0.2723661051044688),
    ];
    for (origin, direction, by_schabel, by_own) in rows {
        for (rotation, exact) in [(Rotation::Schabel, by_schabel), (Rotation::OwnAxis, by_own)] {
            let (integral, bound) = integrate(&SheppLogan::new(rotation), origin, direction);
            assert!((integral - exact).abs() < bound, "{origin:?} {rotation:?}: {integral} {exact}");
        }
    }
}

/// The midpoint rule over a length of 5, and a bound of its error: at each of the two ends of the chord of each
/// ellipsoid at most half a step is counted wrongly, and the densities add up to 2.8 in magnitude.
fn integrate(field: &SheppLogan, origin: [f64; 3], direction: [f64; 3]) -> (f64, f64) {
    const STEPS: u32 = 200_000;
    let step = 5.0 / f64::from(STEPS);
    let (origin, direction) = (DVec3::from_array(origin), DVec3::from_array(direction).normalize());
    let at = |i: u32| field.value(unit((origin + direction * (f64::from(i) + 0.5) * step).to_array()));
    let sum: f64 = (0..STEPS).into_par_iter().map(at).sum();
    (sum * step, 2.8 * step)
}

/// `∫|ψ|² d³x = 1`, by the midpoint rule, which converges fast for a smooth function that decays.
#[test]
fn hydrogen_densities_integrate_to_one() {
    for (n, l, m) in [(2, 1, 0), (3, 2, 1), (3, 2, -2), (4, 3, 0), (4, 1, -1)] {
        let extent = f64::from(n * n) * 4.0 + 10.0;
        let orbital = Hydrogen::new(n, l, m, extent, DVec3::ONE).unwrap();
        let count = 96;
        let cell = (2.0 * extent / f64::from(count)).powi(3);
        let row = |k: u32| -> f64 {
            (0..count * count)
                .map(|i| {
                    let p = DVec3::new(f64::from(i % count), f64::from(i / count), f64::from(k)) + 0.5;
                    orbital.value(p / f64::from(count))
                })
                .sum()
        };
        let total = (0..count).into_par_iter().map(row).sum::<f64>() * orbital.peak() * cell;
        assert!((total - 1.0).abs() < 2e-3, "{n} {l} {m}: {total}");
    }
}

/// Closed forms in atomic units: `|ψ₁₀₀|² = e^{−2r}/π` and `|ψ₂₁₀|² = z² e^{−r}/(32π)`.
#[test]
fn hydrogen_closed_forms() {
    let (s, p) = (hydrogen(1, 0, 0), hydrogen(2, 1, 0));
    assert!((s.peak() * PI - 1.0).abs() < 1e-14);
    // The maximum of z² e^{−r} is at z = r = 2.
    assert!((p.peak() / (4.0 * (-2.0f64).exp() / (32.0 * PI)) - 1.0).abs() < 1e-14);
    let at = DVec3::new(0.6, 0.45, 0.7);
    let x = (2.0 * at - 1.0) * Hydrogen::default_extent(1);
    assert!((s.value(at) / (-2.0 * x.length()).exp() - 1.0).abs() < 1e-13);
    let x = (2.0 * at - 1.0) * Hydrogen::default_extent(2);
    let exact = x.z * x.z * (-x.length()).exp() / (32.0 * PI * p.peak());
    assert!((p.value(at) / exact - 1.0).abs() < 1e-13);
}

/// Unsöld's theorem: the densities of a full subshell add up to a sphere.
#[test]
fn a_full_subshell_is_round() {
    let sum = |direction: DVec3| -> f64 {
        let p = 0.5 + 0.2 * direction.normalize();
        (-3..=3).map(|m| hydrogen(5, 3, m)).map(|orbital| orbital.value(p) * orbital.peak()).sum()
    };
    let along_z = sum(DVec3::Z);
    for direction in [DVec3::X, DVec3::new(1.0, -2.0, 0.5), DVec3::new(-0.3, 0.4, 1.0)] {
        assert!((sum(direction) / along_z - 1.0).abs() < 1e-12);
    }
}

#[test]
fn hydrogen_is_at_most_one() {
    for (n, l, m) in [(1, 0, 0), (3, 2, 0), (4, 2, -1), (6, 3, 2), (10, 9, 9), (10, 0, 0)] {
        let volume = sample(&hydrogen(n, l, m), [33, 33, 33]).unwrap();
        let (low, high) = volume.data_range().unwrap();
        assert!(low >= 0.0 && high <= 1.0 && high > 0.2, "{n} {l} {m}: {low} {high}");
    }
}

#[test]
fn parameters_out_of_range_are_told_what_would_be_right() {
    let orbital = |n, l, m| Hydrogen::new(n, l, m, 10.0, DVec3::ONE).unwrap_err().to_string();
    assert_eq!(orbital(0, 0, 0), "`n` is 0; it must be from 1 to 10");
    assert_eq!(orbital(11, 0, 0), "`n` is 11; it must be from 1 to 10");
    assert_eq!(orbital(2, 2, 0), "`l` is 2; it must be from 0 to 1 for n = 2");
    assert_eq!(orbital(3, 1, -2), "`m` is -2; it must be from -1 to 1 for l = 1");
    assert!(Hydrogen::new(1, 0, i32::MIN, 1.0, DVec3::ONE).is_err());
    assert!(Hydrogen::new(1, 0, 0, f64::NAN, DVec3::ONE).is_err());
    assert!(Hydrogen::new(1, 0, 0, 1.0, DVec3::new(1.0, 2.0, 1.0)).is_err());
    assert!(Constant::new(1e39).is_err() && Constant::new(f64::NAN).is_err());
    assert!(Ramp::new(0.0, f64::INFINITY, Axis::X).is_err());
    assert!(Sphere::new(DVec3::ZERO, 0.0, DVec3::ONE).is_err());
    assert!(Sphere::new(DVec3::new(0.0, f64::NAN, 0.0), 1.0, DVec3::ONE).is_err());
    assert!(MarschnerLobb::new(0.0, 0.25).is_err() && MarschnerLobb::new(6.0, -1.0).is_err());
}

#[test]
fn a_ramp_is_sampled_at_voxel_centres() {
    let volume = sample(&Ramp::new(1.0, 5.0, Axis::Z).unwrap(), [2, 3, 4]).unwrap();
    for z in 0..4 {
        assert_eq!(volume.value(1, 2, z), 1.5 + z as f64);
    }
    assert_eq!(volume.dims, [2, 3, 4]);
}

/// Voxels (64,64,64), (70,60,75), (40,64,64), (64,64,100) and (0,0,0) of the 128³ cloud, from an independent
/// program that evaluates the formula in double precision and rounds to float32.
#[test]
fn the_cloud_has_its_known_voxels() {
    let volume = sample(&Cloud, [128, 128, 128]).unwrap();
    for ([x, y, z], known) in CLOUD_VOXELS {
        assert_eq!(volume.value(x, y, z) as f32, known, "{x} {y} {z}");
    }
}

const CLOUD_VOXELS: [([usize; 3], f32); 5] = [
    ([64, 64, 64], 0.4201222),
    ([70, 60, 75], 0.46386743),
    ([40, 64, 64], 0.42991158),
    ([64, 64, 100], 0.12256363),
    ([0, 0, 0], 0.0),
];

#[test]
fn a_sphere_stays_round_in_a_flat_box() {
    let sphere = Sphere::new(DVec3::splat(0.5), 0.25, DVec3::new(1.0, 1.0, 0.5)).unwrap();
    assert!(sphere.value(DVec3::new(0.75, 0.5, 0.5)).abs() < 1e-15);
    assert!(sphere.value(DVec3::new(0.5, 0.5, 1.0)).abs() < 1e-15);
    assert_eq!(sphere.gradient(DVec3::splat(0.5)), DVec3::ZERO);
}

#[test]
fn an_impossible_grid_is_refused() {
    let constant = Constant::new(1.0).unwrap();
    assert!(sample(&constant, [0, 1, 1]).is_err());
    assert!(sample(&constant, [usize::MAX, 1, 1]).is_err());
    assert_eq!(sample(&constant, [1, 1, 1]).unwrap().value(0, 0, 0), 1.0);
}

/// Every smooth field; the centre of the sphere, its one kink, is outside the box.
fn smooth_field() -> impl Strategy<Value = AnyField> {
    prop_oneof![
        (-9.0..9.0f64).prop_map(|v| AnyField::Constant(Constant::new(v).unwrap())),
        (-9.0..9.0f64, -9.0..9.0f64).prop_map(|(a, b)| AnyField::Ramp(Ramp::new(a, b, Axis::Y).unwrap())),
        (1.1..1.9f64, 0.1..1.0f64).prop_map(|(c, a)| {
            let aspect = DVec3::new(1.0, a, 1.0);
            AnyField::Sphere(Sphere::new(DVec3::new(c, 0.5, 0.4), 0.3, aspect).unwrap())
        }),
        (0.5..8.0f64, 0.0..2.0f64)
            .prop_map(|(f, a)| AnyField::MarschnerLobb(MarschnerLobb::new(f, a).unwrap())),
        (1..=10u32, 0..10u32, -9..=9i32).prop_map(|(n, l, m)| {
            let (l, aspect) = (l % n, DVec3::new(1.0, 0.5, 1.0));
            let m = m % (l as i32 + 1);
            AnyField::Hydrogen(Hydrogen::new(n, l, m, 2.0 * f64::from(n * n), aspect).unwrap())
        }),
        Just(AnyField::Cloud(Cloud)),
    ]
}

proptest! {
    /// Central differences with steps h and h/2, extrapolated. Their difference bounds what is left of the
    /// truncation error; rounding adds about 1e-12/h.
    #[test]
    fn gradients_agree_with_central_differences(
        field in smooth_field(), x in 0.01..0.99f64, y in 0.01..0.99f64, z in 0.01..0.99f64,
    ) {
        const H: f64 = 1e-4;
        let p = DVec3::new(x, y, z);
        // Away from the kinks: the nucleus, the middle of the cloud and its rim.
        let from_centre = (p - 0.5).length();
        prop_assume!(from_centre > 0.05 && (from_centre - 0.4).abs() > 2.0 * H);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let difference = |h: f64| (field.value(p + axis * h) - field.value(p - axis * h)) / (2.0 * h);
            let (coarse, fine) = (difference(H), difference(H / 2.0));
            let numeric = (4.0 * fine - coarse) / 3.0;
            let exact = field.gradient(p).dot(axis) * field.extent().dot(axis);
            let bound = (fine - coarse).abs() + 1e-8 * (1.0 + exact.abs());
            prop_assert!((numeric - exact).abs() < bound, "{numeric} {exact} {bound}");
        }
    }

    #[test]
    fn fields_are_finite_everywhere(field in smooth_field(), x in -2.0..3.0f64, y in 0.0..1.0f64, z in 0.0..1.0f64) {
        let p = DVec3::new(x, y, z);
        prop_assert!(field.value(p).is_finite() && field.gradient(p).is_finite());
        let centre = DVec3::splat(0.5);
        prop_assert!(field.value(centre).is_finite() && field.gradient(centre).is_finite());
    }
}
