//! The top of the page: what was measured, what was found, what to use.

use maud::{Markup, html};

use super::{case_link, fact, sentence, truths, user};
use crate::{
    bench::results::{Finding, FindingKind, Severity},
    report::{
        advice::{self, Choice},
        numbers,
        view::{Member, View},
    },
};

/// Title and the facts in brief.
pub fn header(view: &View<'_>) -> Markup {
    let results = view.results;
    let repeats = results.cases.iter().map(|case| case.repeats.len());
    let (least, most) = (repeats.clone().min().unwrap_or(0), repeats.max().unwrap_or(0));
    let repeats = if least == most { most.to_string() } else { format!("{least} to {most}") };
    let mut devices: Vec<String> = Vec::new();
    for device in results.cases.iter().map(|case| format!("{} ({})", case.device.name, case.device.platform))
    {
        if !devices.contains(&device) {
            devices.push(device);
        }
    }
    let machine = html! {
        (user(&results.machine.cpu)) ", " (plural(results.machine.cores, "core")) "; "
        @for (i, device) in devices.iter().enumerate() { @if i > 0 { ", " } (user(device)) }
    };
    let measured = format!("{}, {repeats} independent repeats each", plural(results.cases.len(), "case"));
    let when = format!("{}, took {}", date(&results.started), numbers::seconds(results.seconds));
    html! {
        p.kind { "svetlo bench: what pictures cost, and how wrong they are" }
        h1 { (user(&results.suite.title)) }
        @if !results.suite.about.is_empty() { p.about { (user(&results.suite.about)) } }
        dl.facts {
            (fact("Measured", &html! { (measured) }))
            (fact("On", &machine))
            @if !results.cases.is_empty() { (fact("Self-test", &html! { (selftest(view)) })) }
            @if !view.groups.is_empty() { (fact("Errors", &html! { (errors(view)) })) }
            (fact("When", &html! { (when) }))
        }
        nav {
            @let measured = !view.groups.is_empty() || !truths::any(view);
            @for (id, title, shown) in [("findings", "Found", true), ("truths", "Known", truths::any(view)),
                ("use", "Use", measured), ("cases", "Cases", measured), ("plots", "Plots", measured),
                ("details", "Pictures", measured), ("machine", "Machine", true), ("terms", "Terms", true),
                ("again", "Again", true)] {
                @if shown { a href={ "#" (id) } { (title) } " " }
            }
        }
    }
}

/// `2026-01-31T12:00:00Z` without the letters.
fn date(started: &str) -> String {
    match started.split_once('T').and_then(|(day, time)| Some((day, time.strip_suffix('Z')?))) {
        Some((day, time)) => format!("{day} {time} UTC"),
        None => started.to_owned(),
    }
}

/// Whether the devices were seen to compute what they should.
fn selftest(view: &View<'_>) -> &'static str {
    let all = || view.results.cases.iter().map(|case| case.device.selftest);
    match () {
        () if all().any(|passed| passed == Some(false)) => "failed on a device: nothing was measured there",
        () if all().any(|passed| passed.is_none()) => "not run",
        () => "passed on every device",
    }
}

/// From where to where the errors are at the end.
fn errors(view: &View<'_>) -> String {
    let last = view.members().filter_map(|member| member.case.summary.points.last());
    let errors = last.filter_map(|point| point.relative_rmse).map(|rmse| rmse.value);
    let (least, most) =
        errors.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), error| (error.min(a), error.max(b)));
    match least {
        _ if least > most => "none could be told".into(),
        _ if least == most => format!("{} of the reference's mean", numbers::share(least)),
        _ => format!(
            "{} to {} of the reference's mean (RMSE at the end)",
            numbers::share(least),
            numbers::share(most)
        ),
    }
}

fn plural(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// The findings, the worst first.
pub fn findings(view: &View<'_>) -> Markup {
    let results = view.results;
    let count = |severity| results.findings.iter().filter(|finding| finding.severity == severity).count();
    let (failures, warnings) = (count(Severity::Failure), count(Severity::Warning));
    let (class, verdict) = match (failures, warnings) {
        _ if results.cases.is_empty() && results.refusals.is_empty() => {
            ("warning", "Nothing was measured.".to_owned())
        }
        (0, 0) if !results.complete => {
            ("warning", "Nothing wrong so far, but the bench is not finished.".into())
        }
        (0, 0) => (
            "good",
            "Nothing wrong: no bias, no failure, every reference well below the errors measured.".into(),
        ),
        (0, n) => ("warning", format!("{}: read these numbers with care.", plural(n, "warning"))),
        (n, 0) => ("failure", format!("{}.", plural(n, "failure"))),
        (n, m) => ("failure", format!("{} and {}.", plural(n, "failure"), plural(m, "warning"))),
    };
    let told = results.findings.iter().any(|finding| finding.kind == FindingKind::Incomplete);
    html! {
        p class={ "verdict " (class) } { (verdict) }
        @if !results.complete && !told {
            p class="finding warning" {
                strong { "Incomplete" } " The bench was interrupted. Everything below is of what had been finished; the same "
                "command goes on from there."
            }
        }
        ul.findings { @for finding in &results.findings { (finding_item(view, finding)) } }
    }
}

fn finding_item(view: &View<'_>, finding: &Finding) -> Markup {
    let about = view.results.cases.iter().position(|case| {
        finding.case.as_ref() == Some(&case.name)
            && finding.device.as_ref().is_none_or(|device| *device == case.device.selector)
    });
    html! {
        li class={ "finding " (class(finding.severity)) } {
            strong { (word(finding.severity)) } " "
            @match (about, &finding.case, &finding.device) {
                (Some(index), ..) => { (case_link(index, &view.label(index))) ": " },
                (None, Some(case), _) => { (user(case)) ": " },
                (None, None, Some(device)) => { "device " (user(device)) ": " },
                (None, None, None) => {},
            }
            (sentence(&finding.text))
        }
    }
}

/// Its name in the style sheet.
pub fn class(severity: Severity) -> &'static str {
    match severity {
        Severity::Failure => "failure",
        Severity::Warning => "warning",
        Severity::Note => "note",
    }
}

/// Its name for readers.
pub fn word(severity: Severity) -> &'static str {
    match severity {
        Severity::Failure => "Failure",
        Severity::Warning => "Warning",
        Severity::Note => "Note",
    }
}

/// Sentences where there is a choice, then the times of every case to every error.
pub fn advice(view: &View<'_>) -> Markup {
    let levels = advice::levels(view.results.cases.iter());
    if levels.is_empty() {
        return html! { p { "No time to an error is known, so nothing can be recommended." } };
    }
    html! {
        @for group in &view.groups {
            @for target in group.targets().iter().filter(|target| target.len() > 1) {
                (recommendation(view, group.name, target, &levels))
            }
        }
        (times(view, &levels))
    }
}

fn recommendation(view: &View<'_>, group: &str, target: &[&Member<'_>], levels: &[f64]) -> Markup {
    let label = |index: usize| {
        let label = target.iter().find(|member| member.index == index).map_or("", |member| &member.label);
        case_link(index, label)
    };
    let warned = |index: usize| {
        let worst =
            target.iter().find(|member| member.index == index).and_then(|found| view.worst_of(found.case));
        worst.is_some_and(|severity| severity <= Severity::Warning)
    };
    let choices = advice::choices(view, target, levels);
    html! {
        div.advice {
            p { strong { (user(group)) } ": of " (names(target)) ", the cheapest for an error of" }
            ul {
                @for choice in &choices {
                    li {
                        (range(choice)) ": "
                        @match (choice.first, choice.arrival) {
                            (Some(first), Some(arrival)) => {
                                strong { (label(first)) } ", " (numbers::seconds(arrival.seconds))
                                @if choice.errors[0] != choice.errors[1] { " for " (percent(choice.errors[1])) }
                                @if !arrival.measured { " (extrapolated)" }
                                @if warned(first) { " (see its warning)" }
                                @if let Some(next) = choice.next {
                                    @if !next.certain { "; " (label(next.index)) " may be as fast: the quartiles overlap" }
                                    @else {
                                        @let ratio = numbers::significant(next.ratio, 2);
                                        "; " (label(next.index)) " takes " (ratio) " times as long"
                                    }
                                }
                                @else { "; no other gets there" }
                            },
                            _ => "none of them gets there",
                        }
                    }
                }
                @if let Some((member, error, seconds)) = most_accurate(view, target) {
                    li { "the smallest error measured: " (case_link(member.index, &member.label)) ", "
                        (numbers::share(error)) " after " (numbers::seconds(seconds)) }
                }
            }
        }
    }
}

/// The names of cases that there is a choice of, unless they are many.
fn names(target: &[&Member<'_>]) -> Markup {
    html! {
        @if target.len() > 4 { (target.len()) " cases with the same reference" }
        @else {
            @for (i, member) in target.iter().enumerate() {
                @if i > 0 { @if i + 1 == target.len() { " and " } @else { ", " } }
                (user(&member.label))
            }
        }
    }
}

/// The member with the smallest error at its end, where that is known.
fn most_accurate<'m, 'a>(view: &View<'_>, target: &[&'m Member<'a>]) -> Option<(&'m Member<'a>, f64, f64)> {
    let end = |member: &&'m Member<'a>| {
        let last = member.case.summary.points.last().filter(|_| advice::is_trusted(view, member.case))?;
        Some((*member, last.relative_rmse?.value, last.seconds.median))
    };
    target.iter().filter_map(end).min_by(|(_, a, _), (_, b, _)| a.total_cmp(b))
}

fn range(choice: &Choice) -> String {
    match choice.errors {
        [largest, smallest] if largest == smallest => percent(largest),
        [largest, smallest] => format!("{} to {}", percent(largest), percent(smallest)),
    }
}

/// A level, as short as it was written.
fn percent(level: f64) -> String {
    format!("{}\u{a0}%", numbers::tick(100.0 * level))
}

fn times(view: &View<'_>, levels: &[f64]) -> Markup {
    html! {
        p.hint {
            "Wall time to an RMSE of so much of the reference's mean, without building and loading. "
            span.best { "Bold" } ": the first among cases with the same reference. ≈: beyond what was measured, by the n"
            sup { "−½" } " law. –: not reached, or not known."
        }
        div.scroll {
            table {
                thead { tr { th { "case" } @for &level in levels { th.n { (percent(level)) } } } }
                @for group in &view.groups {
                    tbody {
                        tr.group { th colspan=(levels.len() + 1) { (user(group.name)) } }
                        @for target in group.targets() {
                            @for member in &target { (row(view, &target, member, levels)) }
                        }
                    }
                }
            }
        }
    }
}

fn row(view: &View<'_>, target: &[&Member<'_>], member: &Member<'_>, levels: &[f64]) -> Markup {
    let first = |level: f64| advice::choices(view, target, &[level])[0].first == Some(member.index);
    html! {
        tr {
            td { (case_link(member.index, &member.label)) }
            @for &level in levels {
                @match advice::arrival(view, member.case, level) {
                    Some(arrival) => {
                        td.n.best[target.len() > 1 && first(level)].beyond[!arrival.measured] {
                            @if !arrival.measured { "≈ " }
                            (numbers::seconds(arrival.seconds))
                        }
                    },
                    None => { td.n { (numbers::UNKNOWN) } },
                }
            }
        }
    }
}
