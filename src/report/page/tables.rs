//! Tables: all cases at a glance, published numbers, machine and devices.

use maud::{Markup, html};

use super::{case_link, summary, user};
use crate::{
    bench::results::{Case, DeviceDescription, Interval, Measure, Ours, Published},
    report::{
        figures::relative_efficiency,
        numbers,
        view::{Member, View},
    },
};

/// One line per case.
pub fn cases(view: &View<'_>) -> Markup {
    html! {
        p.hint {
            "At the last checkpoint. In brackets and as ±: 95 % intervals; times are medians. Errors are shares of the "
            "reference's mean, with the reference's own noise taken out. " a href="#terms" { "What the columns mean" } "."
        }
        div.scroll {
            table {
                thead {
                    tr {
                        th { "case" } th { "verdict" } th { "method" } th.n { "samples" } th.n { "time" }
                        th.n { "per sample" } th.n { "RMSE, %" } th.n { "PSNR, dB" } th.n { "bias, %" } th.n { "slope" }
                        th.n { "efficiency, 1/s" } th.n { "reference, %" }
                    }
                }
                @for group in &view.groups {
                    tbody {
                        tr.group { th colspan="12" { (user(group.name)) } }
                        @for member in &group.members { (case_row(view, member)) }
                    }
                }
            }
        }
    }
}

fn case_row(view: &View<'_>, member: &Member<'_>) -> Markup {
    let case = member.case;
    let summary = &case.summary;
    let last = summary.points.last();
    let known = |value: Option<String>| value.unwrap_or_else(|| numbers::UNKNOWN.into());
    let efficiency =
        relative_efficiency(summary.efficiency, case.reference.mean).filter(|_| !case.deterministic);
    html! {
        tr {
            td { (case_link(member.index, &member.label)) }
            td { (verdict(view, case)) }
            td { (user(&case.method)) }
            td.n { (known(last.map(|last| numbers::count(last.samples)))) }
            td.n { (known(last.map(|last| numbers::seconds(last.seconds.median)))) }
            td.n { (known(summary.samples_per_second.map(|rate| numbers::seconds(1.0 / rate.median)))) }
            td.n { (error(case)) }
            td.n { (known(last.and_then(|last| last.psnr_linear_db).map(|psnr| numbers::significant(psnr, 3)))) }
            td.n { (bias(case)) }
            td.n { (spread(summary.slope.filter(|_| !case.deterministic), &|value| numbers::significant(value, 3))) }
            td.n { (spread(efficiency, &|value| numbers::significant(value, 3))) }
            td.n { (reference(case)) }
        }
    }
}

fn percent(value: f64) -> String {
    numbers::percent(value, 3)
}

/// A number, its interval small below it.
fn spread(of: Option<Interval>, show: &dyn Fn(f64) -> String) -> Markup {
    html! {
        @match of {
            Some(of) => {
                (show(of.value))
                @if let Some(range) = numbers::range(&of, show) { " " span.range { (range) } }
            },
            None => (numbers::UNKNOWN),
        }
    }
}

fn error(case: &Case) -> Markup {
    match case.summary.points.last() {
        Some(last) if last.rmse.is_none() => html! { "below noise" },
        Some(last) if last.relative_rmse.is_some_and(|rmse| rmse.value == 0.0) => html! { "0" },
        Some(last) if case.deterministic => spread(last.relative_rmse.map(alone), &percent),
        Some(last) => spread(last.relative_rmse, &percent),
        None => html! { (numbers::UNKNOWN) },
    }
}

/// Without an interval.
fn alone(of: Interval) -> Interval {
    Interval { low: None, high: None, ..of }
}

/// Bias in percent of the reference's mean, and half its interval.
fn bias(case: &Case) -> Markup {
    let Some((pooled, relative)) =
        case.pooled.as_ref().and_then(|pooled| Some((pooled, pooled.relative_bias?)))
    else {
        return html! { (numbers::UNKNOWN) };
    };
    let mean = case.reference.mean.abs();
    let half = pooled.bias.low.zip(pooled.bias.high).map(|(low, high)| 0.5 * (high - low) / mean);
    html! {
        (numbers::percent(relative, 2))
        @if let Some(half) = half.filter(|half| *half > 0.0) { " " span.range { "± " (numbers::percent(half, 2)) } }
    }
}

/// How sure the reference is.
fn reference(case: &Case) -> String {
    match case.reference.relative_error {
        Some(error) if error > 0.0 => format!("± {}", percent(error)),
        _ => "exact".into(),
    }
}

fn verdict(view: &View<'_>, case: &Case) -> Markup {
    match view.worst_of(case) {
        _ if case.repeats.is_empty() => html! { span.badge.note { "not run" } },
        Some(severity) => {
            html! { span class={ "badge " (summary::class(severity)) } { (summary::word(severity)) } }
        }
        None => html! { span.badge.good { "fine" } },
    }
}

/// Published numbers beside ours.
pub fn published(view: &View<'_>) -> Markup {
    html! {
        p.hint {
            "Other machines, other programs, often other data: see the remarks before comparing. In brackets: quartiles."
        }
        div.scroll {
            table {
                thead { tr {
                    th { "source" } th { "measured on" } th { "case" } th.n { "published" } th { "unit" }
                    th.n { "here" } th { "unit" } th.n { "here / published" } th { "remark" }
                } }
                tbody { @for entry in &view.results.published { (published_row(view, entry)) } }
            }
        }
    }
}

fn published_row(view: &View<'_>, entry: &Published) -> Markup {
    let unit = match entry.measure {
        Measure::SamplesPerSecond => "samples/s",
        Measure::SecondsPerSample => "s/sample",
        Measure::IterationsPerSecond => "iterations/s",
        Measure::SortMilliseconds => "ms",
        Measure::Psnr => "dB",
        Measure::Rmse => "linear radiance",
    };
    let number = |value: f64| numbers::significant(value, 3);
    let link = |device: Option<&str>| {
        let same = |member: &&Member<'_>| {
            member.case.name == entry.case
                && device.is_none_or(|device| member.case.device.selector == device)
        };
        match view.members().find(same) {
            Some(member) => case_link(member.index, &member.label),
            None => user(&entry.case),
        }
    };
    let cells = |ours: Option<&Ours>| {
        html! {
            tr {
                td { (user(&entry.source)) }
                td { (user(&entry.label)) }
                td { (link(ours.map(|ours| ours.device.as_str()))) }
                td.n { (number(entry.value)) }
                td { (user(&entry.unit)) }
                @match ours {
                    Some(ours) => {
                        td.n {
                            (number(ours.value))
                            @if let Some([low, high]) = ours.quartiles {
                            " " span.range { "[" (number(low)) ", " (number(high)) "]" }
                        }
                        }
                        td { (unit) }
                        td.n { (numbers::significant(ours.value / entry.value, 2)) }
                    },
                    None => { td.n { (numbers::UNKNOWN) } td { (unit) } td.n { (numbers::UNKNOWN) } },
                }
                td { (user(&entry.note)) }
            }
        }
    };
    html! {
        @if entry.ours.is_empty() { (cells(None)) }
        @for ours in &entry.ours { (cells(Some(ours))) }
    }
}

/// The host and every device.
pub fn machine(view: &View<'_>) -> Markup {
    let machine = &view.results.machine;
    let memory = machine.memory_bytes.map_or("of unknown size".into(), |bytes| numbers::bytes(bytes as f64));
    let mut devices: Vec<&DeviceDescription> = Vec::new();
    for device in view.results.cases.iter().map(|case| &case.device) {
        if devices.iter().all(|known| known.selector != device.selector) {
            devices.push(device);
        }
    }
    html! {
        p {
            (user(&machine.cpu)) ", " (machine.cores) " cores for this program, memory " (memory) ". "
            (user(&machine.os)) "."
        }
        div.scroll {
            table {
                thead { tr {
                    th { "device" } th { "platform" } th { "driver" } th { "OpenCL" } th.n { "compute units" }
                    th { "selector" } th { "self-test" }
                } }
                tbody {
                    @for device in devices {
                        tr {
                            td { (user(&device.name)) } td { (user(&device.platform)) } td { (user(&device.driver)) }
                            td { (user(&device.version)) } td.n { (device.compute_units) }
                            td { code { (user(&device.selector)) } }
                            td { (selftest(device)) }
                        }
                    }
                }
            }
        }
    }
}

fn selftest(device: &DeviceDescription) -> Markup {
    match device.selftest {
        Some(true) => html! { span.badge.good { "passed" } },
        Some(false) => html! {
            span.badge.failure { "failed" }
            @for check in &device.selftest_failures { " " (user(check)) }
        },
        None => html! { span.badge.note { "not run" } },
    }
}
