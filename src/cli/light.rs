//! What the computation of a light volume did, for people.

use super::energy::percent;
use crate::irradiance::{ChannelFacts, LightFacts};

/// One line for the end of a render.
pub fn line(facts: &LightFacts) -> String {
    let mut parts = Vec::new();
    if let Some(estimates) = facts.estimates {
        let error = match facts.relative_error {
            Some(error) if error.is_finite() => format!(" (error {})", percent(error)),
            _ => String::new(),
        };
        parts.push(format!("{} of direct light per cell{error}", count(estimates, "estimate")));
    }
    if let Some(steps) = facts.steps {
        parts.push(format!("{} in time", count(steps, "step")));
    }
    if !facts.channels.is_empty() {
        let list = |of: &dyn Fn(&ChannelFacts) -> String| {
            facts.channels.iter().map(of).collect::<Vec<_>>().join(" + ")
        };
        let iterations = list(&|channel| channel.iterations.to_string());
        let residual = facts.channels.iter().fold(0.0, |most: f64, channel| most.max(channel.residual));
        let outer = if facts.channels.iter().any(|channel| channel.outer > 0) {
            let updates = list(&|channel| channel.outer.to_string());
            format!(" with {updates} update{} of the flux limiter", if updates == "1" { "" } else { "s" })
        } else {
            String::new()
        };
        let imbalance = facts.channels.iter().fold(0.0, |most: f64, channel| most.max(channel.imbalance));
        parts.push(format!(
            "diffusion in {iterations} iteration{}{outer} to a residual of {residual:.1e} and an imbalance of {imbalance:.1e}",
            if iterations == "1" { "" } else { "s" }
        ));
        parts.extend(floor(facts));
    }
    format!("light in the volume: {}; {:.2} s", parts.join("; "), facts.seconds)
}

/// What the floor of the optical thickness changes, if anything.
fn floor(facts: &LightFacts) -> Option<String> {
    let (floor, cells) = (facts.floor?, facts.cells?);
    let below = facts.channels.iter().map(|channel| channel.floor_cells).max().filter(|&below| below > 0)?;
    let share = percent(below as f64 / cells as f64);
    Some(format!(
        "{share} of the cells are thinner than `method.steady.floor` = {floor} and diffuse as if they were not"
    ))
}

/// Relative errors of direct light that are worth a note.
const NOISY: f64 = 0.1;

/// What the user should know about how it went.
pub fn warnings(facts: &LightFacts) -> Vec<String> {
    let stuck = facts.channels.iter().filter(|channel| !channel.converged).count();
    let mut warnings = Vec::new();
    if let Some(error) = facts.relative_error.filter(|error| error.is_finite() && *error > NOISY) {
        warnings.push(format!(
            "the direct light of the cells is off by {} (RMS), and all light with it, in every view: {:.0} times the \
             `method.iterations` would leave a tenth; a rectangle light that touches the volume is best moved off it",
            percent(error),
            (error / NOISY).powi(2).ceil()
        ));
    }
    if stuck > 0 {
        let worst = facts.channels.iter().fold(0.0, |most: f64, c| most.max(c.nonlinear.max(c.residual)));
        warnings.push(format!(
            "the diffusion equation of {stuck} of {} channels is not solved to its tolerances (the largest residual is \
             {worst:.1e}): another `method.steady.solver`, a larger `method.steady.floor` or the limiter \"none\" may do",
            facts.channels.len()
        ));
    }
    warnings
}

fn count(n: u32, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}
