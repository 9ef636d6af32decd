//! The page: one HTML file that needs nothing else, for readers who were not there.
//!
//! | file | what |
//! | --- | --- |
//! | `summary` | title, what was found, what to use |
//! | `tables` | all cases at a glance, published numbers, devices |
//! | `truths` | cases of which something is known, by devices |
//! | `cases` | pictures and numbers of every case |
//! | `pictures` | thumbnails as data URIs |
//! | `explain` | metrics, methods, how to do it again |

mod cases;
mod explain;
mod pictures;
mod summary;
mod tables;
mod truths;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    plot::{Drawing, element, printable},
    view::View,
};

/// Nothing is loaded, nothing runs: a browser is told to hold the page to it.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// The plots of one group.
pub struct Plots {
    /// The name that their files begin with.
    pub name: String,
    /// End of the name, and what is drawn.
    pub drawings: Vec<(&'static str, Drawing)>,
}

/// The whole page; `plots` are those of the groups, in their order.
pub fn page(view: &View<'_>, plots: &[Plots]) -> String {
    let title = format!("{}: speed against error", view.results.suite.title);
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                header { (summary::header(view)) }
                main {
                    (section("findings", "What was found", &summary::findings(view)))
                    @if truths::any(view) { (section("truths", "What is known", &truths::all(view))) }
                    @if !only_truths(view) {
                        (section("use", "What to use", &summary::advice(view)))
                        (section("cases", "All cases", &tables::cases(view)))
                        (section("plots", "Plots", &groups(plots, view)))
                    }
                    @if !view.results.published.is_empty() {
                        (section("published", "What others published", &tables::published(view)))
                    }
                    @if !only_truths(view) { (section("details", "Case by case", &cases::all(view))) }
                    (section("machine", "Machine and devices", &tables::machine(view)))
                    (section("terms", "How to read it", &explain::terms(view)))
                    (section("again", "How to do it again", &explain::again(view)))
                }
                footer {
                    p {
                        "Written by svetlo " (view.results.version) ". The numbers are in " code { "results.json" } " and "
                        code { "results.csv" } " beside this page, the plots in " code { "plots/" } ", the pictures in "
                        code { "images/" } "."
                    }
                }
            }
        }
    };
    printable(&markup.into_string())
}

/// Whether every case is judged by its truth alone.
fn only_truths(view: &View<'_>) -> bool {
    view.groups.is_empty() && truths::any(view)
}

fn section(id: &str, title: &str, content: &Markup) -> Markup {
    html! { section id=(id) { h2 { (title) } (content) } }
}

fn groups(plots: &[Plots], view: &View<'_>) -> Markup {
    html! {
        p.hint {
            "Bands and whiskers are 95 % intervals of errors and quartiles of times. Where a pointer rests on a "
            "marker, its numbers are shown. Each plot is also in " code { "plots/" } " as SVG and PNG."
        }
        @for (group, plots) in view.groups.iter().zip(plots) {
            h3 { (user(group.name)) }
            @if !plots.drawings.iter().any(|(name, _)| name.starts_with("error")) {
                p.hint { "No error of this group is above its noise: there is nothing to plot against cost." }
            }
            div.plots {
                @for (_, drawing) in &plots.drawings {
                    figure.plot { (element(drawing)) }
                }
            }
        }
    }
}

/// An entry of a description list.
fn fact(term: &str, content: &Markup) -> Markup {
    html! { div { dt { (term) } dd { (content) } } }
}

/// A text of the user's, kept apart from what is around it whatever direction it is written in.
fn user(text: &str) -> Markup {
    html! { bdi { (text) } }
}

/// A sentence of svetlo's own, with `code` between backticks.
fn sentence(text: &str) -> Markup {
    html! {
        bdi {
            @for (i, part) in text.split('`').enumerate() {
                @if i % 2 == 1 { code { (part) } } @else { (part) }
            }
        }
    }
}

/// The place of a case on the page.
fn anchor(index: usize) -> String {
    format!("case-{}", index + 1)
}

/// A link to a case.
fn case_link(index: usize, label: &str) -> Markup {
    html! { a href={ "#" (anchor(index)) } { (user(label)) } }
}
