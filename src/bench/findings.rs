//! What the reader of results should know: every finding follows from the results alone.

use super::results::{
    Case, Finding, FindingKind, Judged, Metrics, Point, Quantity, Refusal, Results, Severity,
};
use super::suite::{Gates, Suite};

/// A mean this many standard errors off its reference is no noise. With two tests per case, one false alarm in some 200
/// cases is expected.
const BIAS_Z: f64 = 3.0;
/// Standard errors in the half width of a 95 % interval, nearly.
const HALF_WIDTH: f64 = 2.0;
/// A reference whose variance is above this share of the measured MSE is unconverged: its error is not below half of
/// the measured one, and what remains after taking it out depends on how well it is known.
const REFERENCE_SHARE: f64 = 0.25;
/// Times whose quartiles are further apart than this, over the median, say little.
const TIME_SPREAD: f64 = 0.25;

/// Every finding, the worst first.
pub fn of(results: &Results, suite: &Suite) -> Vec<Finding> {
    let mut findings = Vec::new();
    for case in &results.cases {
        let gates = suite.cases.iter().find(|spec| spec.name == case.name).map(|spec| spec.gates);
        findings.extend(of_case(case, &gates.unwrap_or_default()));
    }
    findings.extend(results.refusals.iter().filter(|refusal| !refusal.right()).map(not_refused));
    if results.cases.iter().any(|case| case.device.selftest.is_none()) {
        let text =
            "the self-test was not run: whether the devices compute what they should is not known".into();
        findings.push(Finding {
            severity: Severity::Note,
            kind: FindingKind::Selftest,
            case: None,
            device: None,
            text,
        });
    }
    if !results.complete {
        let text = "the bench was interrupted: run it again with the same suite and folder to go on".into();
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::Incomplete,
            case: None,
            device: None,
            text,
        });
    }
    sort(&mut findings);
    findings
}

/// The worst first, in the order of the cases.
pub fn sort(findings: &mut [Finding]) {
    findings.sort_by_key(|finding| finding.severity);
}

/// A finding about a case.
pub fn about(case: &Case, severity: Severity, kind: FindingKind, text: String) -> Finding {
    let device = Some(case.device.selector.clone());
    Finding { severity, kind, case: Some(case.name.clone()), device, text }
}

/// What a case says by itself.
pub fn of_case(case: &Case, gates: &Gates) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut add = |severity: Severity, kind: FindingKind, text: Option<String>| {
        found.extend(text.map(|text| about(case, severity, kind, text)));
    };
    if case.device.selftest == Some(false) {
        let failed = case.device.selftest_failures.join(", ");
        let text = format!("the self-test failed on this device ({failed}): nothing was measured");
        add(Severity::Failure, FindingKind::Selftest, Some(text));
    }
    add(Severity::Failure, FindingKind::Rejected, wrong_samples(case));
    let failed = case.failed.as_ref().map(|text| format!("not measured: {}", text.trim()));
    add(Severity::Failure, FindingKind::Failed, failed);
    add(Severity::Failure, FindingKind::Truth, case.truth.as_ref().and_then(untrue));
    if case.is_only_truth() {
        for text in gate_failures(case, gates) {
            add(Severity::Failure, FindingKind::Gate, Some(text));
        }
        return found;
    }
    let model = case.reference.method.as_ref().filter(|method| **method != case.method);
    match (&case.pooled, model) {
        // Neighbouring pixels share the noise of a light volume, and samples do not remove it: neither is a fault.
        (Some(_), None) if case.summary.light.is_some() => {}
        (Some(pooled), None) => {
            add(Severity::Warning, FindingKind::Bias, bias(pooled));
            add(Severity::Warning, FindingKind::Slope, slope(case));
        }
        (Some(pooled), Some(model)) => {
            add(Severity::Note, FindingKind::Bias, model_error(case, pooled, model));
        }
        (None, _) => {}
    }
    add(Severity::Warning, FindingKind::Reference, unconverged(case));
    add(Severity::Note, FindingKind::Spread, time_spread(case));
    for text in gate_failures(case, gates) {
        add(Severity::Failure, FindingKind::Gate, Some(text));
    }
    found
}

fn percent(share: f64) -> String {
    let percent = share * 100.0;
    let digits = if percent.abs() >= 10.0 { 1 } else { 3 };
    format!("{percent:.digits$} %")
}

/// How a picture deviates from what is known of it.
fn untrue(judged: &Judged) -> Option<String> {
    if judged.right {
        return None;
    }
    let count = |count: u64, what: &str| (count > 0).then(|| format!("{count} values are {what}"));
    let numbers = |of: [f64; 3]| match of {
        [r, g, b] if r == g && g == b => format!("{r:.6e}"),
        of => of.map(|value| format!("{value:.6e}")).join(", "),
    };
    let off = judged.share.is_none_or(|share| share > 1.0).then(|| {
        let what = match judged.of {
            Quantity::Mean => "the mean",
            Quantity::Each => "a pixel",
        };
        let z = judged.z.map(|z| format!("{z:+.1} σ"));
        let by: Vec<String> =
            z.into_iter().chain(judged.relative.map(|share| format!("{:+.3e} of it", share))).collect();
        let (found, value) = (numbers(judged.found), numbers(judged.value));
        let by = if by.is_empty() { String::new() } else { format!(" ({})", by.join(", ")) };
        format!("off: {what} is {found}, not {value}{by}")
    });
    let faults =
        [off, count(judged.not_finite, "not finite"), count(judged.negative, "negative beyond their noise")];
    Some(faults.into_iter().flatten().collect::<Vec<_>>().join("; "))
}

fn not_refused(refusal: &Refusal) -> Finding {
    let text = match &refusal.message {
        None => format!("not refused; it must be, with \"{}\"", refusal.wanted),
        Some(message) => {
            let line = message.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
            format!("refused for another reason than \"{}\": {line}", refusal.wanted)
        }
    };
    let case = Some(refusal.name.clone());
    Finding { severity: Severity::Failure, kind: FindingKind::Refusal, case, device: None, text }
}

fn wrong_samples(case: &Case) -> Option<String> {
    let last = case.repeats.iter().filter_map(|repeat| repeat.checkpoints.last());
    let (rejected, faults) = last.fold((0, 0), |sum, last| (sum.0 + last.rejected, sum.1 + last.faults));
    (rejected + faults > 0).then(|| {
        format!(
            "{rejected} samples were not finite and {faults} paths went wrong: the picture is not to be trusted"
        )
    })
}

/// A mean that is off, or a difference that noise does not explain, whose sign changes over the picture.
fn bias(pooled: &Metrics) -> Option<String> {
    let share = pooled.relative_bias.map_or(String::new(), |bias| format!(" ({} of it)", percent(bias)));
    if let Some(z) = pooled.bias_z.filter(|z| z.abs() > BIAS_Z) {
        return Some(format!(
            "biased: its mean differs from the reference's by {:.3e}{share}, {:.1} standard errors",
            pooled.bias.value,
            z.abs()
        ));
    }
    if pooled.own_noise.is_none_or(|noise| noise == 0.0) {
        return None;
    }
    let square = pooled.squared_bias?;
    let error = (square.value - square.low?) / HALF_WIDTH;
    (error > 0.0 && square.value > BIAS_Z * error).then(|| {
        format!(
            "biased: pixels differ from the reference by {:.3e} (RMS) more than noise explains",
            square.value.sqrt()
        )
    })
}

/// Where the reference is by another method, the difference is what it is about.
fn model_error(case: &Case, pooled: &Metrics, model: &str) -> Option<String> {
    let mean = case.reference.mean.abs();
    let error = pooled.squared_bias.filter(|square| square.value > 0.0 && mean > 0.0)?.value.sqrt() / mean;
    Some(format!(
        "measured against {model}: the models differ by {} (RMS over the mean), which no number of samples removes",
        percent(error)
    ))
}

fn unconverged(case: &Case) -> Option<String> {
    let checkpoints = case.repeats.iter().filter_map(|repeat| repeat.checkpoints.last());
    let metrics: Vec<&Metrics> = checkpoints.map(|last| &last.metrics).collect();
    let noise = metrics.first()?.reference_noise;
    let mse = metrics.iter().map(|metrics| metrics.mse.value).sum::<f64>() / metrics.len() as f64 + noise;
    (noise > REFERENCE_SHARE * mse).then(|| {
        let own = case.reference.relative_error.map_or_else(|| format!("{:.2e}", noise.sqrt()), percent);
        format!(
            "unconverged reference: its own standard error ({own}) is {} of what was measured against it; \
             ask for a smaller `reference.error`",
            percent((noise / mse).sqrt())
        )
    })
}

/// An error that certainly does not fall with the root of the samples.
fn slope(case: &Case) -> Option<String> {
    let slope = case.summary.slope.filter(|_| !case.deterministic)?;
    let error = (slope.value - slope.low?) / HALF_WIDTH;
    (slope.value - BIAS_Z * error > -0.5).then(|| {
        let (low, high) = (slope.low.unwrap_or(slope.value), slope.high.unwrap_or(slope.value));
        format!(
            "the error falls with samples^{:.3} (95 %: {low:.3} to {high:.3}), slower than the -1/2 of an unbiased \
             estimate",
            slope.value
        )
    })
}

fn time_spread(case: &Case) -> Option<String> {
    let last: &Point = case.summary.points.last()?;
    let spread = (last.seconds.high - last.seconds.low) / last.seconds.median;
    (last.seconds.count > 1 && spread > TIME_SPREAD).then(|| {
        format!("times vary: the quartiles are {} of the median apart; look-ups do not vary", percent(spread))
    })
}

fn gate_failures(case: &Case, gates: &Gates) -> Vec<String> {
    let Some(last) = case.summary.points.last() else { return Vec::new() };
    let pooled = case.pooled.as_ref();
    let above = |what: &str, value: Option<f64>, limit: Option<f64>, show: &dyn Fn(f64) -> String| {
        let (value, limit) = (value?, limit?);
        (value > limit).then(|| format!("{what} is {}, above {}", show(value), show(limit)))
    };
    let plain = |value: f64| format!("{value:.3}");
    let relative_rmse = last.relative_rmse.map(|rmse| rmse.value);
    let below = gates.min_psnr.zip(last.psnr_linear_db).filter(|(limit, psnr)| psnr < limit);
    [
        above("the relative RMSE", relative_rmse, gates.max_relative_rmse, &percent),
        above(
            "|bias| in standard errors",
            pooled.and_then(|p| Some(p.bias_z?.abs())),
            gates.max_bias_z,
            &plain,
        ),
        above(
            "the relative |bias|",
            pooled.and_then(|p| Some(p.relative_bias?.abs())),
            gates.max_relative_bias,
            &percent,
        ),
        above("the low end of the slope", case.summary.slope.and_then(|s| s.low), gates.max_slope, &plain),
        below.map(|(limit, psnr)| format!("the PSNR is {psnr:.2} dB, below {limit} dB")),
    ]
    .into_iter()
    .flatten()
    .collect()
}
