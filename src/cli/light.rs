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
            format!(" with {} updates of the flux limiter", list(&|channel| channel.outer.to_string()))
        } else {
            String::new()
        };
        parts.push(format!("diffusion in {iterations} iterations{outer} to a residual of {residual:.1e}"));
    }
    format!("light in the volume: {}; {:.2} s", parts.join("; "), facts.seconds)
}

/// What the user should know about how it went.
pub fn warnings(facts: &LightFacts) -> Vec<String> {
    let stuck = facts.channels.iter().filter(|channel| !channel.converged).count();
    let mut warnings = Vec::new();
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
