//! Every case with its pictures and numbers.

use maud::{Markup, html};

use super::{anchor, fact, pictures::thumbnail, sentence, summary, user};
use crate::{
    bench::results::{Case, Images, Metrics, Point, ReferenceInfo, Repeat, Spread},
    report::{
        numbers,
        view::{Member, View},
    },
};

/// All cases, in the order of the groups.
pub fn all(view: &View<'_>) -> Markup {
    html! { @for member in view.members() { (case(view, member)) } }
}

fn case(view: &View<'_>, member: &Member<'_>) -> Markup {
    let case = member.case;
    html! {
        article.case id=(anchor(member.index)) {
            h3 { (user(&member.label)) }
            @if view.findings_of(case).next().is_some() {
                ul.findings {
                    @for finding in view.findings_of(case) {
                        li class={ "finding " (summary::class(finding.severity)) } {
                            strong { (summary::word(finding.severity)) } " " (sentence(&finding.text))
                        }
                    }
                }
            }
            (pictures(view, &case.images))
            (facts(case))
            @if let Some(pooled) = &case.pooled { (metrics(case, pooled)) }
            @if case.summary.points.is_empty() { p { "Nothing of this case has been measured." } }
            @else { (points(case)) }
            @if !case.repeats.is_empty() { (repeats(case)) }
        }
    }
}

fn pictures(view: &View<'_>, images: &Images) -> Markup {
    let picture = |name: &Option<String>| name.as_ref().and_then(|name| thumbnail(view.folder, name));
    let (image, reference) = (picture(&images.preview), picture(&images.reference_preview));
    let difference = picture(&images.difference);
    if image.is_none() && reference.is_none() && difference.is_none() {
        return html! { p.hint { "No pictures." } };
    }
    html! {
        div.pictures {
            @if let Some(data) = image { (figure(&data, "all repeats taken together")) }
            @if let Some(data) = reference { (figure(&data, "reference")) }
            @if let Some(data) = difference {
                figure {
                    img src=(data) alt="image less reference, in false colours";
                    @if let Some(scale) = images.difference_scale {
                        @let scale = numbers::significant(scale, 2);
                        div.scale { span { "−" (scale) } span.ramp {} span { "+" (scale) } }
                    }
                    figcaption { "image − reference, linear; blue is too dark, red too bright" }
                }
            }
        }
    }
}

fn figure(data: &str, caption: &str) -> Markup {
    html! { figure { img src=(data) alt=(caption); figcaption { (caption) } } }
}

fn facts(case: &Case) -> Markup {
    let [x, y, z] = case.voxels;
    let spread = |spread: Option<Spread>| known(spread.map(|of| numbers::seconds(of.median)));
    let scene = html! {
        code { (user(&case.scene)) }
        @if !case.overrides.is_empty() {
            " with"
            ul.sets { @for set in &case.overrides { li { code { (user(set)) } } } }
        }
    };
    let method = html! {
        (user(&case.method))
        @for phrase in &case.estimators { ", " (user(phrase)) }
        @if case.deterministic { "; nothing in it is random, so its error does not fall with samples" }
    };
    let memory = numbers::bytes(case.device_bytes as f64);
    let size = format!("{}×{} pixels, {x}×{y}×{z} voxels, {memory} on the device", case.width, case.height);
    let (build, prepare) = (spread(case.summary.build), spread(case.summary.prepare));
    let beforehand = format!("building the program {build}, loading and planning {prepare}");
    let light = case.summary.light.map(|light| {
        let rate = case.summary.light_iterations_per_second;
        let rate = rate.map_or(String::new(), |rate| {
            format!(", {} iterations per second", numbers::significant(rate.median, 3))
        });
        format!("computed in {}{rate}; its time counts", numbers::seconds(light.median))
    });
    let photons = case.summary.trace_seconds.zip(case.summary.sort_seconds).map(|(trace, sort)| {
        let [trace, sort] = [trace, sort].map(|time| numbers::seconds(time.median));
        format!("a pass takes {trace} to trace them and {sort} to bring them in order; both count")
    });
    html! {
        dl.facts {
            (fact("Scene", &scene))
            (fact("Method", &method))
            (fact("Size", &html! { (size) }))
            (fact("Reference", &reference(&case.reference)))
            (fact("Beforehand", &html! { (beforehand) }))
            @if let Some(light) = light { (fact("Light volume", &html! { (light) })) }
            @if let Some(photons) = photons { (fact("Photons", &html! { (photons) })) }
        }
    }
}

fn reference(reference: &ReferenceInfo) -> Markup {
    let own = reference.relative_error.filter(|error| *error > 0.0);
    html! {
        (user(&reference.description))
        @if reference.seconds > 0.0 { ", in " (numbers::seconds(reference.seconds)) }
        @match own {
            Some(error) => {
                "; its own standard error is " (numbers::share(error)) " of its mean"
                @if let Some(wanted) = reference.wanted_error { " (asked for: " (numbers::share(wanted)) ")" }
            },
            None => "; free of noise",
        }
    }
}

/// The errors of all repeats as one picture.
fn metrics(case: &Case, pooled: &Metrics) -> Markup {
    let plain = |value: f64| numbers::significant(value, 3);
    let decibels = |value: Option<f64>| known(value.map(|value| format!("{} dB", plain(value))));
    let rmse = pooled.rmse.map_or("below noise".into(), |rmse| numbers::interval(&rmse, plain));
    let z = pooled.bias_z.map_or(String::new(), |z| format!(", {} σ", plain(z)));
    let entries = [
        ("RMSE", rmse),
        ("RMSE / mean", known(pooled.relative_rmse.map(numbers::share))),
        (&format!("PSNR, peak {}", plain(pooled.psnr_peak)), decibels(pooled.psnr_linear_db)),
        ("PSNR of sRGB codes, peak 1", decibels(pooled.psnr_display_db)),
        ("relMSE", known(pooled.relmse.map(|of| numbers::interval(&of, plain)))),
        ("MAPE", known(pooled.mape.map(|of| numbers::interval(&of, numbers::share)))),
        ("bias", numbers::interval(&pooled.bias, plain) + &z),
        ("squared bias", known(pooled.squared_bias.map(|of| numbers::interval(&of, plain)))),
    ];
    html! {
        h4 { "All " (case.repeats.len()) " repeats as one picture" }
        dl.metrics { @for (term, value) in &entries { (fact(term, &html! { (value) })) } }
    }
}

/// A value, or what stands for one that is not known.
fn known(value: Option<String>) -> String {
    value.unwrap_or_else(|| numbers::UNKNOWN.into())
}

fn points(case: &Case) -> Markup {
    let several = case.summary.points.len() > 1;
    html! {
        h4 { @if several { "Checkpoints" } @else { "Measurement" } }
        div.scroll {
            table {
                thead { tr {
                    th.n { "samples" } th.n { "time" } th.n { "quartiles" } th.n { "in kernels" }
                    th.n { "RMSE, %" } th.n { "95 %" } th.n { "PSNR, dB" } th.n { "relMSE" } th.n { "MAPE, %" }
                    th.n { "launches" } th.n { "look-ups" } th.n { "bytes asked for" }
                } }
                tbody { @for point in &case.summary.points { (point_row(point)) } }
            }
        }
    }
}

fn point_row(point: &Point) -> Markup {
    let percent = |value: f64| numbers::percent(value, 3);
    let quartiles = (point.seconds.count > 1).then(|| {
        format!("{} … {}", numbers::seconds(point.seconds.low), numbers::seconds(point.seconds.high))
    });
    let error = match (&point.rmse, &point.relative_rmse) {
        (None, _) => "below noise".to_owned(),
        (_, error) => known(error.map(|error| percent(error.value))),
    };
    html! {
        tr {
            td.n { (numbers::count(point.samples)) }
            td.n { (numbers::seconds(point.seconds.median)) }
            td.n.range { (known(quartiles)) }
            td.n { (numbers::seconds(point.device_seconds.median)) }
            td.n { (error) }
            td.n.range { (known(point.relative_rmse.and_then(|error| numbers::range(&error, percent)))) }
            td.n { (known(point.psnr_linear_db.map(|psnr| numbers::significant(psnr, 3)))) }
            td.n { (known(point.relmse.map(|value| numbers::significant(value, 3)))) }
            td.n { (known(point.mape.map(percent))) }
            td.n { (numbers::count(point.launches)) }
            td.n { (numbers::count(point.lookups)) }
            td.n { (numbers::bytes(point.bytes)) }
        }
    }
}

/// The repeats one by one, folded.
fn repeats(case: &Case) -> Markup {
    html! {
        details {
            summary { "The repeats one by one" }
            div.scroll {
                table {
                    thead { tr {
                        th.n { "seed" } th.n { "building" } th { "from the cache" } th.n { "loading" }
                        th.n { "warm-up" } th.n { "samples" } th.n { "time" } th.n { "RMSE, %" }
                        th.n { "bias, σ" } th.n { "rejected" } th.n { "faults" }
                    } }
                    tbody { @for repeat in &case.repeats { (repeat_row(repeat)) } }
                }
            }
        }
    }
}

fn repeat_row(repeat: &Repeat) -> Markup {
    let last = repeat.checkpoints.last();
    html! {
        tr {
            td.n { (repeat.seed) }
            td.n { (numbers::seconds(repeat.build_seconds)) }
            td { @if repeat.build_cached { "yes" } @else { "no" } }
            td.n { (numbers::seconds(repeat.prepare_seconds)) }
            td.n { (numbers::seconds(repeat.warmup_seconds)) }
            td.n { (known(last.map(|last| numbers::count(last.samples as f64)))) }
            td.n { (known(last.map(|last| numbers::seconds(last.seconds)))) }
            td.n { (known(last.and_then(|last| last.metrics.relative_rmse).map(|error| numbers::percent(error, 3)))) }
            td.n { (known(last.and_then(|last| last.metrics.bias_z).map(|z| numbers::significant(z, 2)))) }
            td.n { (known(last.map(|last| last.rejected.to_string()))) }
            td.n { (known(last.map(|last| last.faults.to_string()))) }
        }
    }
}
