//! Cases of which something is known: one row each, one column per device.

use maud::{Markup, html};

use super::{anchor, pictures::thumbnail, user};
use crate::{
    bench::{
        results::{Case, Judged, Refusal},
        truth_table::{Row, Verdict, deviations, devices, number, rows},
    },
    report::{numbers, view::View},
};

/// Whether there are any.
pub fn any(view: &View<'_>) -> bool {
    !rows(view.results).is_empty()
}

/// All of them, group by group.
pub fn all(view: &View<'_>) -> Markup {
    let devices = devices(view.results);
    html! {
        p.hint {
            "Closed forms and published numbers. A case is right where every channel deviates by no more than some standard "
            "errors (σ, of the picture and of the truth) and a share of the value that rounding or a known error of the "
            "method may take; where every value is finite, and none is negative beyond its noise."
        }
        div.scroll {
            table {
                thead { tr {
                    th { "case" } th { "method" } th.n { "truth" }
                    @for device in &devices { th { (user(device)) } }
                } }
                @for (group, rows) in rows(view.results) {
                    tbody {
                        tr.group { th colspan=(3 + devices.len()) { (user(group)) } }
                        @for row in rows {
                            @match row {
                                Row::Case(cases) => (case_row(view, &cases)),
                                Row::Refusal(refusal) => (refusal_row(refusal, devices.len())),
                            }
                        }
                    }
                }
            }
        }
    }
}

fn case_row(view: &View<'_>, cases: &[Option<&Case>]) -> Markup {
    let Some(first) = cases.iter().flatten().next() else { return html! {} };
    let picture = first.images.preview.as_ref().and_then(|name| thumbnail(view.folder, name));
    let place = |case: &Case| view.results.cases.iter().position(|other| std::ptr::eq(other, case));
    html! {
        tr {
            td {
                @if let Some(data) = picture { img.truth src=(data) alt="the picture"; " " }
                (user(&first.name))
                @if !first.about.is_empty() { br; span.range { (user(&first.about)) } }
            }
            td { (user(&first.method)) }
            td.n {
                @match &first.truth {
                    Some(judged) => (truth(judged)),
                    None => (numbers::UNKNOWN),
                }
            }
            @for case in cases {
                @match case {
                    Some(case) => { td id=[place(case).map(anchor)] { (cell(case)) } },
                    None => { td { (numbers::UNKNOWN) } },
                }
            }
        }
    }
}

fn truth(judged: &Judged) -> Markup {
    html! {
        (number(judged.value))
        @if judged.error > 0.0 { " ± " (numbers::significant(judged.error, 2)) }
        @if !judged.source.is_empty() { br; span.range { (user(&judged.source)) } }
    }
}

fn cell(case: &Case) -> Markup {
    let verdict = Verdict::of(case);
    let class = match verdict {
        Verdict::Right | Verdict::Refused => "badge good",
        Verdict::Off | Verdict::Failed | Verdict::Taken => "badge failure",
        Verdict::None => "badge note",
    };
    html! {
        span class=(class) { (verdict.word()) }
        @if let Some(judged) = &case.truth {
            @let (z, share) = deviations(judged);
            " " (number(judged.found)) br;
            span.range { (z) ", " (share) }
        }
        @if let Some(last) = case.summary.points.last() { span.range { ", " (numbers::seconds(last.seconds.median)) } }
        @if let Some(text) = &case.failed { br; span.range { (user(text)) } }
    }
}

fn refusal_row(refusal: &Refusal, devices: usize) -> Markup {
    let right = refusal.right();
    html! {
        tr {
            td {
                (user(&refusal.name))
                @if !refusal.about.is_empty() { br; span.range { (user(&refusal.about)) } }
            }
            td { (numbers::UNKNOWN) }
            td.n { "refused: “" (user(&refusal.wanted)) "”" }
            td colspan=(devices.max(1)) {
                span class=(if right { "badge good" } else { "badge failure" }) {
                    (Verdict::of_refusal(refusal).word())
                }
                @if let Some(message) = refusal.message.as_ref().filter(|_| !right) { " " (user(message)) }
            }
        }
    }
}
