//! Results made by hand.

use crate::bench::results::*;

pub fn interval(value: f64, half: f64) -> Interval {
    Interval { value, low: Some(value - half), high: Some(value + half) }
}

pub fn spread(median: f64) -> Spread {
    Spread { median, low: 0.9 * median, high: 1.2 * median, count: 3 }
}

/// Metrics of a picture whose reference has mean 0.5 and largest value 2.
pub fn metrics(relative_rmse: f64) -> Metrics {
    let rmse = 0.5 * relative_rmse;
    Metrics {
        mse: interval(rmse * rmse, 0.1 * rmse * rmse),
        rmse: Some(interval(rmse, 0.05 * rmse)),
        relative_rmse: Some(relative_rmse),
        reference_noise: 1e-10,
        own_noise: Some(rmse * rmse),
        psnr_peak: 2.0,
        psnr_linear_db: Some(20.0 * (2.0 / rmse).log10()),
        psnr_display_db: Some(30.0),
        relmse: Some(interval(1e-3, 1e-4)),
        mape: Some(interval(0.02, 0.001)),
        bias: interval(1e-5, 4e-5),
        relative_bias: Some(2e-5),
        bias_z: Some(0.5),
        squared_bias: Some(interval(1e-9, 4e-9)),
    }
}

fn checkpoint(samples: u64, seconds: f64, relative_rmse: f64) -> Checkpoint {
    Checkpoint {
        samples,
        seconds,
        device_seconds: 0.95 * seconds,
        launches: samples,
        lookups: 1000 * samples,
        bytes: 32_000 * samples,
        rejected: 0,
        faults: 0,
        metrics: metrics(relative_rmse),
    }
}

/// A case that takes `per_sample` seconds a sample, with a relative error of `noise` after one sample: 1 to 64 samples
/// in three repeats. It reaches an error e after `per_sample` (`noise`/e)² seconds.
pub fn case(name: &str, group: &str, per_sample: f64, noise: f64) -> Case {
    let samples = [1_u64, 4, 16, 64];
    let error = |n: u64| noise / (n as f64).sqrt();
    let repeat = |seed| Repeat {
        seed,
        build_seconds: 0.2,
        build_cached: seed > 1,
        prepare_seconds: 0.1,
        warmup_seconds: 0.05,
        light: None,
        photons: None,
        checkpoints: samples.iter().map(|&n| checkpoint(n, per_sample * n as f64, error(n))).collect(),
    };
    let point = |n: u64| Point {
        samples: n as f64,
        seconds: spread(per_sample * n as f64),
        device_seconds: spread(0.95 * per_sample * n as f64),
        rmse: Some(interval(0.5 * error(n), 0.02 * error(n))),
        relative_rmse: Some(interval(error(n), 0.04 * error(n))),
        psnr_linear_db: Some(20.0 * (4.0 / error(n)).log10()),
        relmse: Some(1e-3),
        mape: Some(0.02),
        launches: n as f64,
        lookups: 1000.0 * n as f64,
        bytes: 32_000.0 * n as f64,
    };
    let arrival = |relative_error: f64| TimeToError {
        relative_error,
        seconds: per_sample * (noise / relative_error).powi(2),
        measured: relative_error >= error(64),
    };
    Case {
        name: name.into(),
        about: String::new(),
        group: group.into(),
        curve: None,
        scene: "../cloud.toml".into(),
        overrides: vec!["image.width=64".into(), "method={kind=\"mip\"}".into()],
        scene_hash: "0123".into(),
        device: device("0:0"),
        method: "multiple-scattering".into(),
        estimators: vec!["transmittance auto".into()],
        width: 64,
        height: 48,
        voxels: [32, 16, 8],
        device_bytes: 5 << 20,
        deterministic: false,
        reference: ReferenceInfo {
            kind: ReferenceKind::Computed,
            description: "the same scene by 4096 samples of an independent stream".into(),
            method: Some("multiple-scattering".into()),
            relative_error: Some(0.0012),
            wanted_error: Some(0.001),
            mean: 0.5,
            seconds: 75.0,
            samples: Some(4096),
            image: Some(format!("references/{group}.exr")),
        },
        repeats: (1..=3).map(repeat).collect(),
        pooled: Some(metrics(error(192))),
        summary: Summary {
            points: samples.map(point).into(),
            slope: Some(interval(-0.5, 0.012)),
            efficiency: Some(interval(4.0 / (noise * noise * per_sample), 0.1)),
            time_to_error: [0.1, 0.05, 0.02, 0.01].map(arrival).into(),
            build: Some(spread(0.2)),
            prepare: Some(spread(0.1)),
            light: None,
            light_iterations_per_second: None,
            trace_seconds: None,
            sort_seconds: None,
            samples_per_second: Some(Spread { median: 1.0 / per_sample, ..spread(1.0 / per_sample) }),
            lookups_per_sample: Some(7.5),
            lookups_per_second: Some(2e6),
        },
        images: Images::default(),
        truth: None,
        failed: None,
    }
}

/// A case that is judged by a truth: 0.5, and found to be off by so many of its standard errors of 0.01, 5 of which are
/// allowed.
pub fn true_case(name: &str, group: &str, sigmas: f64) -> Case {
    let mut case = case(name, group, 0.1, 0.1);
    case.about = "why it is hard".into();
    case.reference.kind = ReferenceKind::Truth;
    let found = 0.5 + 0.01 * sigmas;
    case.truth = Some(Judged {
        value: [0.5; 3],
        of: Quantity::Mean,
        region: [0, 0, 64, 48],
        error: 0.0,
        tolerance: 1e-5,
        sigmas: 5.0,
        source: "closed form".into(),
        found: [found; 3],
        standard_error: Some([0.01; 3]),
        z: Some(sigmas),
        relative: Some(0.02 * sigmas),
        share: Some(sigmas.abs() / 5.0),
        not_finite: 0,
        negative: 0,
        right: sigmas.abs() <= 5.0,
    });
    case
}

/// A case that must be refused, and what was said.
pub fn refusal(name: &str, message: Option<&str>) -> Refusal {
    Refusal {
        name: name.into(),
        about: "why it is hard".into(),
        group: "refusals".into(),
        scene: "../cloud.toml".into(),
        overrides: vec!["image.width=0".into()],
        wanted: "out of range".into(),
        message: message.map(String::from),
    }
}

pub fn device(selector: &str) -> DeviceDescription {
    DeviceDescription {
        selector: selector.into(),
        name: format!("Device {selector}"),
        platform: "Platform".into(),
        driver: "1.2.3".into(),
        version: "3.0".into(),
        compute_units: 2,
        selftest: Some(true),
        selftest_failures: Vec::new(),
    }
}

pub fn finding(severity: Severity, kind: FindingKind, case: Option<&str>, text: &str) -> Finding {
    let device = case.map(|_| "0:0".to_owned());
    Finding { severity, kind, case: case.map(String::from), device, text: text.into() }
}

pub fn results(cases: Vec<Case>) -> Results {
    Results {
        format: FORMAT,
        version: "1.2.3".into(),
        suite: SuiteInfo {
            title: "Clouds".into(),
            about: "Two ways to a cloud.".into(),
            file: "clouds.toml".into(),
            hash: "abcdef".into(),
        },
        machine: Machine {
            cpu: "Processor 9".into(),
            cores: 2,
            memory_bytes: Some(24 << 30),
            os: "Linux".into(),
        },
        started: "2026-01-31T12:00:00Z".into(),
        seconds: 100.0,
        complete: true,
        cases,
        refusals: Vec::new(),
        published: Vec::new(),
        findings: Vec::new(),
    }
}
