//! What the photons of a render did, in words.

use super::energy::percent;
use crate::caustics::{PassFacts, PassLedger};
use serde_json::{Value, json};

/// The share of the flux that `depth` may cut before the summary warns.
const MUCH_TRUNCATED: f64 = 1e-3;

/// One line: how many there were, and where their flux went. Nothing where there were none.
pub fn line(ledger: &PassLedger, facts: &PassFacts) -> Option<String> {
    let (flux, bounced) = (&ledger.flux, &ledger.bounced);
    if flux.photons + bounced.photons == 0 {
        return None;
    }
    let share = |part: f64| percent(part / flux.emitted);
    let parts = [
        ("stored", flux.stored),
        ("left to direct light", flux.direct),
        ("absorbed", flux.absorbed),
        ("absorbed by the volume", flux.medium_absorbed),
        ("escaped", flux.escaped),
        ("cut by method.depth", flux.truncated),
    ];
    let mut parts: Vec<String> = parts
        .into_iter()
        .filter(|(_, part)| *part != 0.0)
        .map(|(what, part)| format!("{} {what}", share(part)))
        .collect();
    if let Some(first) = parts.first_mut() {
        first.insert_str(0, "of their flux ");
    }
    if bounced.photons > 0 {
        parts.push(format!(
            "diffuse surfaces reflected {:.3} W to each other in a pass, by {} photons",
            bounced.received / f64::from(ledger.passes),
            bounced.photons
        ));
    }
    let within = if facts.bounce_radius > 0.0 {
        format!(" ({:.4} these)", facts.bounce_radius)
    } else {
        String::new()
    };
    Some(format!(
        "photons: {} in {} passes; {}; gathered within {:.4}{within} at last; {:.2} s to trace, {:.2} s to sort",
        flux.photons + bounced.photons,
        ledger.passes,
        parts.join(", "),
        facts.radius,
        facts.trace_seconds,
        facts.key_seconds + facts.sort_seconds + facts.fill_seconds + facts.order_seconds,
    ))
}

/// What the user should know about the picture: that `depth` darkens it.
pub fn warning(ledger: &PassLedger, depth: u32) -> Option<String> {
    let (flux, bounced) = (&ledger.flux, &ledger.bounced);
    let share = (flux.truncated + bounced.truncated) / (flux.emitted + bounced.emitted);
    (share > MUCH_TRUNCATED).then(|| {
        format!("method.depth = {depth} cuts {} of the photons' flux: more would be brighter", percent(share))
    })
}

/// The same for programs: flux in W, sums over passes. `facts`: of this run, if it traced any.
pub fn report(ledger: &PassLedger, facts: Option<&PassFacts>) -> Value {
    let (flux, bounced) = (&ledger.flux, &ledger.bounced);
    json!({
        "passes": ledger.passes,
        "photons": flux.photons,
        "in_maps": flux.stored_photons,
        "flux": {
            "emitted": flux.emitted,
            "stored": flux.stored,
            "direct": flux.direct,
            "absorbed": flux.absorbed,
            "escaped": flux.escaped,
            "truncated": flux.truncated,
            "medium_absorbed": flux.medium_absorbed,
            "medium_scattered": flux.medium_scattered,
            "imbalance": flux.imbalance(),
        },
        "bounced": {
            "photons": bounced.photons,
            "in_maps": bounced.stored_photons,
            "emitted": bounced.emitted,
            "others": bounced.others,
            "absorbed": bounced.absorbed,
            "escaped": bounced.escaped,
            "truncated": bounced.truncated,
            "beyond": bounced.beyond,
            "received": bounced.received,
            "imbalance": bounced.imbalance(),
        },
        "this_run": facts,
    })
}
