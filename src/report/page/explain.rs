//! What the words mean, and how to get the numbers again.

use maud::{Markup, html};

use super::user;
use crate::{bench::results::Case, report::view::View};

/// Methods as scene files name them, and what they compute.
const METHODS: [(&str, &str); 8] = [
    ("mip", "maximum intensity projection: the largest value along the ray"),
    ("isosurface", "the first point where the volume has a given value, shaded as a surface"),
    ("emission-absorption", "what a glowing and absorbing medium shows; light is not scattered"),
    ("single-scattering", "light of lamps and background, scattered at most once, with all shadows"),
    ("multiple-scattering", "light scattered any number of times: the whole radiative transfer equation"),
    ("convection-diffusion", "light carried in by convection and spread by diffusion: an approximation"),
    ("hybrid-diffusion", "direct light by following paths, scattered light by diffusion: an approximation"),
    ("caustics", "light that surfaces focus, by photons"),
];

/// Words of the page.
const TERMS: [(&str, &str); 12] = [
    (
        "RMSE",
        "√mean (x − r)², with the variance of the reference taken out. “Below noise”: what remained was not above 0.",
    ),
    (
        "relative, %",
        "divided by the mean of the reference: 1 % is an error of a hundredth of the average brightness.",
    ),
    (
        "bias",
        "mean (x − r): an error that more samples do not remove. It is no noise when it is beyond 3 standard errors \
         (σ). The squared bias is that of single pixels, the noise of both sides taken out.",
    ),
    (
        "PSNR",
        "10 log₁₀(P²/MSE) in decibels, more is better; P is the largest value of the reference, or 1 where sRGB \
         codes are compared.",
    ),
    (
        "relMSE, MAPE",
        "mean (x − r)²/(r² + (0.1 mean r)²), and mean |x − r|/(|r| + 0.1 mean r): errors in proportion to each \
         pixel's own brightness.",
    ),
    (
        "slope",
        "the exponent of RMSE against samples. Independent samples give −½: four times the samples, half the error. \
         Well-spread samples can do better (below −½); a bias makes the curve flat.",
    ),
    (
        "efficiency",
        "1/(MSE · time), with the MSE relative to the reference's mean: 10⁴ per second is an error of 1 % after one \
         second. Twice the efficiency is the same picture in half the time.",
    ),
    (
        "time",
        "wall time of the measured steps, without building programs, loading and warming up, which are listed apart.",
    ),
    (
        "95 % interval",
        "made so that it holds the true value in 95 of 100 benches; from the scatter of repeats and of blocks of the \
         picture.",
    ),
    ("quartiles", "half of the repeats were between them."),
    (
        "reference",
        "“exact” is known from theory or free of noise; a rendered one has an error of its own (± its standard \
         error), and errors not well above it are called out.",
    ),
    (
        "look-ups, bytes",
        "how often the volume was sampled, and the bytes of the eight voxels each asks for, before any cache.",
    ),
];

/// The glossary.
pub fn terms(view: &View<'_>) -> Markup {
    let used = |method: &str| view.results.cases.iter().any(|case| case.method == method);
    html! {
        p {
            "Every case was rendered several times with random numbers of its own. At checkpoints the clock stopped, "
            "and the picture was compared with a reference that shares no random numbers with it. x is a value of "
            "the picture, r of the reference, in linear light; means are over all pixels and colours."
        }
        dl.terms {
            @for (term, meaning) in TERMS { dt { (term) } dd { (meaning) } }
            @for (name, meaning) in METHODS.iter().filter(|(name, _)| used(name)) {
                dt { code { (name) } } dd { (meaning) }
            }
        }
    }
}

/// The commands.
pub fn again(view: &View<'_>) -> Markup {
    let suite = &view.results.suite;
    let example = view.results.cases.iter().find(|case| case.images.image.is_some());
    html! {
        p { "With svetlo " (view.results.version) " and the suite's file (hash " code { (user(&suite.hash)) } "):" }
        pre { code { "svetlo bench " (quoted(&suite.file)) } }
        p { "To see whether something became slower or noisier since, with exit code 3 if it did:" }
        pre { code { "svetlo bench " (quoted(&suite.file)) " -o again --baseline results.json" } }
        @if let Some(case) = example {
            p {
                "One case by itself, from the folder of the suite, and the errors of its picture, from this folder:"
            }
            pre { code { (render(case)) "\n" (compare(case)) } }
        }
    }
}

fn render(case: &Case) -> String {
    let sets: String = case.overrides.iter().map(|set| format!(" --set {}", quoted(set))).collect();
    let samples =
        case.summary.points.last().map_or(String::new(), |last| format!(" --samples {:.0}", last.samples));
    let seed = case.repeats.first().map_or(String::new(), |repeat| format!(" --seed {}", repeat.seed));
    format!(
        "svetlo render {}{sets} --device {}{samples}{seed} -o case.exr",
        quoted(&case.scene),
        quoted(&case.device.selector)
    )
}

fn compare(case: &Case) -> String {
    let file = |name: &Option<String>| quoted(name.as_deref().unwrap_or_default());
    format!("svetlo compare {} {}", file(&case.images.image), file(&case.reference.image))
}

/// A word for a POSIX shell.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        for (text, word) in [
            ("a/b.toml", "a/b.toml"),
            ("", "''"),
            ("a b", "'a b'"),
            ("it's $x", r"'it'\''s $x'"),
            ("m={k=\"v\"}", "'m={k=\"v\"}'"),
        ] {
            assert_eq!(quoted(text), word);
        }
    }
}
