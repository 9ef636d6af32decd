//! Where the weight of a scattering render's paths went, in words, and what of it is a failure.

use crate::render::PathLedger;
use crate::scene::{Method, Orders, Scattering};
use serde_json::{Value, json};

/// The share of the paths' weight that `max_order` may cut before the summary warns.
const MUCH_CUT: f64 = 1e-3;

/// The share that Russian roulette may add or remove before the line tells it: what is left of its noise.
const MUCH_GAINED: f64 = 5e-3;

/// One line: the shares of the paths' weight, and what a path cost.
pub fn line(ledger: &PathLedger, method: &Method) -> String {
    let cut = if ledger.cut == 0.0 {
        String::new()
    } else {
        format!(", {} {}", percent(ledger.share(ledger.cut)), cut_by(method))
    };
    let gained = ledger.share(ledger.gained);
    let roulette = if gained.abs() < MUCH_GAINED {
        String::new()
    } else {
        let did = if gained > 0.0 { "added" } else { "removed" };
        format!("; Russian roulette {did} {}", percent(gained.abs()))
    };
    format!(
        "energy: {} escaped, {} absorbed{cut}{roulette}; {:.1} look-ups per path, {} of them null collisions",
        percent(ledger.share(ledger.escaped)),
        percent(ledger.share(ledger.absorbed)),
        ledger.lookups as f64 / ledger.paths.max(1) as f64,
        percent(ledger.null_share()),
    )
}

/// What the user should know about the picture: that `max_order` darkens it.
pub fn warning(ledger: &PathLedger, method: &Method) -> Option<String> {
    let Method::Scattering(Scattering { orders: Orders::Multiple { max: Some(max) }, .. }) = method else {
        return None;
    };
    let share = ledger.share(ledger.cut);
    (share > MUCH_CUT).then(|| {
        format!(
            "method.max_order = {max} cuts {} of the paths' weight: the picture is darker than without it",
            percent(share)
        )
    })
}

/// Why the picture is not to be trusted, if it is not. `rejected`: samples that the film refused.
pub fn failure(ledger: &PathLedger, rejected: u64) -> Option<String> {
    if ledger.above_majorant > 0 {
        return Some(format!(
            "{} of {} look-ups found more extinction than the majorant: this is a bug of svetlo, and the image is not \
             to be trusted; please report it with the scene",
            ledger.above_majorant, ledger.lookups
        ));
    }
    (ledger.unfinished > 0).then(|| {
        format!(
            "the device did not follow {rejected} samples to their ends, and they were left out: the image is not to be \
             trusted; some compilers end loops after a number of turns, so another device may do, as may \
             method.max_order or fewer method.paths"
        )
    })
}

/// The ledger for programs; shares are of what all paths start with.
pub fn report(ledger: &PathLedger) -> Value {
    json!({
        "meaning": "weights of paths, which start with 1: escaped + absorbed + cut = 1 + gained, where cut is the \
                    share lost to the limit on scatterings and gained what Russian roulette added, net",
        "count": ledger.paths,
        "escaped": ledger.share(ledger.escaped),
        "absorbed": ledger.share(ledger.absorbed),
        "cut": ledger.share(ledger.cut),
        "gained": ledger.share(ledger.gained),
        "imbalance": ledger.imbalance(),
        "lookups": ledger.lookups,
        "collisions": ledger.collisions,
        "null_collisions": ledger.null_collisions(),
        "above_majorant": ledger.above_majorant,
        "unfinished": ledger.unfinished,
    })
}

fn cut_by(method: &Method) -> &'static str {
    match method {
        Method::Scattering(Scattering { orders: Orders::Single, .. }) => {
            "left out beyond the first scattering"
        }
        _ => "cut by max_order",
    }
}

/// Two digits or more: 83 %, 0.42 %, 0.0031 %.
pub(super) fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if percent == 0.0 || percent.abs() >= 10.0 {
        return format!("{percent:.0} %");
    }
    let digits = (1.0 - percent.abs().log10().floor()).clamp(1.0, 8.0);
    format!("{percent:.*} %", digits as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Transmittance;

    fn method(orders: Orders) -> Method {
        let transmittance = Transmittance::Auto;
        Method::Scattering(Scattering { orders, transmittance, majorant_scale: 1.0, paths: None })
    }

    fn ledger() -> PathLedger {
        PathLedger {
            paths: 1000,
            lookups: 12_340,
            collisions: 6170,
            escaped: 831.0,
            absorbed: 167.0,
            cut: 2.0,
            ..PathLedger::default()
        }
    }

    #[test]
    fn the_line_has_shares_and_costs() {
        let limited = method(Orders::Multiple { max: Some(8) });
        assert_eq!(
            line(&ledger(), &limited),
            "energy: 83 % escaped, 17 % absorbed, 0.20 % cut by max_order; 12.3 look-ups per path, 50 % of them null \
             collisions"
        );
        assert!(
            line(&ledger(), &method(Orders::Single)).contains("0.20 % left out beyond the first scattering")
        );
        let noisy = PathLedger { gained: -31.0, escaped: 800.0, ..ledger() };
        assert!(line(&noisy, &limited).starts_with(
            "energy: 80 % escaped, 17 % absorbed, 0.20 % cut by max_order; Russian roulette removed 3.1 %;"
        ),);
        let whole = PathLedger { cut: 0.0, ..ledger() };
        assert!(line(&whole, &limited).contains("17 % absorbed; 12.3 look-ups"));
    }

    #[test]
    fn only_a_limit_that_cuts_much_is_a_warning() {
        let limited = method(Orders::Multiple { max: Some(8) });
        assert_eq!(
            warning(&ledger(), &limited).unwrap(),
            "method.max_order = 8 cuts 0.20 % of the paths' weight: the picture is darker than without it"
        );
        assert_eq!(warning(&PathLedger { cut: 0.9, ..ledger() }, &limited), None);
        assert_eq!(warning(&ledger(), &method(Orders::Single)), None);
    }

    #[test]
    fn mistakes_and_unfinished_samples_are_failures() {
        assert_eq!(failure(&ledger(), 3), None);
        let above = failure(&PathLedger { above_majorant: 3, unfinished: 1, ..ledger() }, 64).unwrap();
        assert!(
            above.starts_with("3 of 12340 look-ups found more extinction than the majorant: this is a bug")
        );
        let unfinished = failure(&PathLedger { unfinished: 1, ..ledger() }, 64).unwrap();
        assert!(unfinished.starts_with("the device did not follow 64 samples to their ends"));
    }

    #[test]
    fn shares_in_percent() {
        let texts = [0.0, 1.0, 0.834, 0.0999, 0.0025, 3.14e-5, -0.002].map(percent);
        assert_eq!(texts, ["0 %", "100 %", "83 %", "10.0 %", "0.25 %", "0.0031 %", "-0.20 %"]);
    }
}
