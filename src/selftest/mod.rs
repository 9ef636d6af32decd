//! Proof that a device computes what it should: every kernel that renders, held against truths from outside.
//!
//! A [`Check`] is data: a name, what it proves, and a function that renders or computes something on the device and
//! says what should have come out. Tolerances are those of float32 rounding, or k known standard errors; seeds are
//! fixed, so a device that passes passes every time. The kernels are the ones that render, built with the same options.

mod bits;
mod closed_forms;
mod functions;
mod light;
mod photons;
mod scattering;
mod workbench;

use crate::device::{Device, DeviceInfo, ProgramSpec};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use workbench::{Measurement, Workbench};

/// A check that takes longer hangs: the slowest takes a second on two cores, compiling aside.
const PATIENCE: Duration = Duration::from_secs(180);

/// How a comparison ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Within its tolerance.
    Passed,
    /// Outside, or it could not be made.
    Failed,
    /// Outside for a reason that is known and documented, or that no render passes over in silence.
    Limited,
}

/// One comparison of a check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The check it belongs to.
    pub check: String,
    /// What the check proves.
    pub proves: String,
    /// What was measured, with its unit where it has one.
    pub quantity: String,
    /// The number found on the device; none where the check could not run.
    pub measured: Option<f64>,
    /// The number that is right.
    pub expected: f64,
    /// By how much `measured` may differ from it.
    pub tolerance: f64,
    /// Where the tolerance comes from.
    pub reason: String,
    /// How it ended.
    pub status: Status,
    /// Why it failed or is limited, where that is known.
    pub problem: Option<String>,
    /// Time since the comparison before it, building programs included.
    pub seconds: f64,
}

/// What is checked, and how.
pub struct Check {
    /// One word.
    pub name: &'static str,
    /// What it proves, a clause.
    pub proves: &'static str,
    run: fn(&Workbench) -> Result<Vec<Measurement>>,
}

/// All checks, from the smallest parts to whole renders.
pub const CHECKS: &[Check] = &[
    Check {
        name: "layout",
        proves: "host and device agree on every shared struct, byte for byte",
        run: functions::layout,
    },
    Check { name: "random", proves: "random numbers are the published ones", run: functions::random },
    Check { name: "film", proves: "means and variances of many samples stay exact", run: functions::film },
    Check {
        name: "emission-absorption",
        proves: "radiance and opacity have the closed form",
        run: closed_forms::emission_absorption,
    },
    Check { name: "mip", proves: "the largest value along a ray is found", run: closed_forms::mip },
    Check {
        name: "isosurface",
        proves: "the surface of a sphere is hit where it lies",
        run: closed_forms::isosurface,
    },
    Check { name: "furnace", proves: "paths lose no light and make none", run: scattering::furnace },
    Check {
        name: "slab",
        proves: "a homogeneous slab returns and passes what is published",
        run: scattering::slab,
    },
    Check {
        name: "grid",
        proves: "so does a grid of uneven layers with the same optical depth: grid = homogeneous",
        run: scattering::grid,
    },
    Check {
        name: "tracking",
        proves: "null-collision tracking passes e^-depth of the light",
        run: scattering::tracking,
    },
    Check {
        name: "sunlight",
        proves: "single scattering of a directional light has the closed form",
        run: scattering::sunlight,
    },
    Check {
        name: "audit",
        proves: "no look-up exceeds its majorant, and the paths' energy adds up",
        run: scattering::audit,
    },
    Check {
        name: "direct-light",
        proves: "direct light in the cells of a light volume has the closed form",
        run: light::direct_light,
    },
    Check {
        name: "convection",
        proves: "light that is carried upwind through uneven layers leaves the closed form's share in each",
        run: light::convection,
    },
    Check {
        name: "diffusion",
        proves: "scattered light in uneven layers is that of their resistances in series",
        run: light::diffusion,
    },
    Check { name: "sort", proves: "photons are put in order, and found in their cells", run: photons::sort },
    Check {
        name: "caustics",
        proves: "photons lose no light, glass passes what is published, and what is gathered is an irradiance",
        run: photons::caustics,
    },
    Check {
        name: "launches",
        proves: "launch and work-group sizes do not change a bit of the picture",
        run: bits::launches,
    },
    Check { name: "loops", proves: "loops of more than 65535 turns come to their ends", run: bits::loops },
];

/// Whether nothing failed.
pub fn passed(verdicts: &[Verdict]) -> bool {
    verdicts.iter().all(|verdict| verdict.status != Status::Failed)
}

/// Runs all checks on a device; `each` sees every verdict as it is reached.
///
/// A check that cannot run, or does not come back, is a failed verdict.
///
/// # Errors
/// [`Error::Failed`] when the device cannot be opened.
pub fn run(device: &DeviceInfo, each: &mut dyn FnMut(&Verdict)) -> Result<Vec<Verdict>> {
    run_altered(device, &CHECKS.iter().collect::<Vec<_>>(), |spec| spec, each)
}

/// Runs some checks with programs that `alter` has changed, which shows what they find.
///
/// # Errors
/// As [`run`].
pub fn run_altered(
    device: &DeviceInfo,
    checks: &[&'static Check],
    alter: fn(ProgramSpec) -> ProgramSpec,
    each: &mut dyn FnMut(&Verdict),
) -> Result<Vec<Verdict>> {
    Device::open(device)?;
    let bench = Workbench { info: device.clone(), alter };
    let (sender, receiver) = channel();
    let list = checks.to_vec();
    // A thread of its own: a kernel that never ends can only be left behind.
    std::thread::Builder::new()
        .name("selftest".into())
        .spawn(move || {
            for check in list {
                // Nobody listens any more when an earlier check took too long.
                if sender.send((check.run)(&bench)).is_err() {
                    return;
                }
            }
        })
        .map_err(|error| Error::Failed(format!("cannot start a thread: {error}")))?;
    Ok(collect(checks, &receiver, PATIENCE, each))
}

fn collect(
    checks: &[&Check],
    results: &Receiver<Result<Vec<Measurement>>>,
    patience: Duration,
    each: &mut dyn FnMut(&Verdict),
) -> Vec<Verdict> {
    let mut verdicts = Vec::new();
    let mut gone = None;
    for check in checks {
        let start = Instant::now();
        let result = match &gone {
            Some(first) => Err(Error::Failed(format!("not run, because {first} did not come back"))),
            None => results.recv_timeout(patience).unwrap_or_else(|error| {
                gone = Some(check.name);
                Err(Error::Failed(match error {
                    RecvTimeoutError::Timeout => {
                        format!("no answer in {} s: the device hangs", patience.as_secs())
                    }
                    RecvTimeoutError::Disconnected => "it ended without an answer".into(),
                }))
            }),
        };
        let first = verdicts.len();
        verdicts.extend(judge(check, result, start.elapsed().as_secs_f64()));
        verdicts[first..].iter().for_each(&mut *each);
    }
    verdicts
}

fn judge(check: &Check, result: Result<Vec<Measurement>>, seconds: f64) -> Vec<Verdict> {
    let verdict = |m: Measurement, measured, status, problem, seconds| Verdict {
        check: check.name.into(),
        proves: check.proves.into(),
        quantity: m.quantity,
        measured,
        expected: m.expected,
        tolerance: m.tolerance,
        reason: m.reason,
        status,
        problem,
        seconds,
    };
    match result {
        Ok(measurements) => {
            let share = seconds / measurements.len() as f64;
            let judged = measurements.into_iter().map(|mut m| {
                let measured = Some(m.measured).filter(|value| value.is_finite());
                let within = measured.is_some_and(|value| (value - m.expected).abs() <= m.tolerance);
                let (status, problem) = match m.limit.take() {
                    _ if within => (Status::Passed, None),
                    Some(limit) => (Status::Limited, Some(limit)),
                    None if measured.is_none() => (Status::Failed, Some("no finite number came out".into())),
                    None => (Status::Failed, None),
                };
                verdict(m, measured, status, problem, share)
            });
            judged.collect()
        }
        Err(error) => {
            let nothing = Measurement::exact("checks that ran", 0.0, 1.0);
            vec![verdict(nothing, None, Status::Failed, Some(error.to_string()), seconds)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_that_does_not_come_back_fails_and_so_does_what_follows() {
        let (sender, receiver) = channel();
        sender.send(Ok(vec![Measurement::exact("a", 0.0, 0.0)])).unwrap();
        let mut seen = 0;
        let verdicts =
            collect(&[&CHECKS[0], &CHECKS[1], &CHECKS[2]], &receiver, Duration::from_millis(1), &mut |_| {
                seen += 1
            });
        assert_eq!(
            verdicts.iter().map(|v| v.status).collect::<Vec<_>>(),
            [Status::Passed, Status::Failed, Status::Failed]
        );
        assert_eq!((seen, passed(&verdicts)), (3, false));
        assert!(verdicts[1].problem.as_ref().unwrap().contains("the device hangs"), "{verdicts:?}");
        assert!(verdicts[2].problem.as_ref().unwrap().contains("random did not come back"), "{verdicts:?}");
    }

    #[test]
    fn only_finite_numbers_within_the_tolerance_pass() {
        let limited =
            |measured| Measurement::within("", measured, 2.0, 0.5, "").limited(Some("known".into()));
        let plain = |measured| Measurement::within("", measured, 2.0, 0.5, "");
        let all = vec![
            plain(2.5),
            plain(1.4),
            plain(f64::NAN),
            plain(f64::INFINITY),
            limited(2.0),
            limited(f64::NAN),
        ];
        let verdicts = judge(&CHECKS[0], Ok(all), 6.0);
        assert_eq!(
            verdicts.iter().map(|v| v.status).collect::<Vec<_>>(),
            [Status::Passed, Status::Failed, Status::Failed, Status::Failed, Status::Passed, Status::Limited]
        );
        assert_eq!(verdicts[4].problem, None);
        assert_eq!(verdicts[5].problem.as_deref(), Some("known"));
        assert_eq!(verdicts[0].seconds, 1.0);
        assert!(passed(&verdicts[4..]) && !passed(&verdicts));
    }

    #[test]
    fn verdicts_come_back_from_json() {
        let broken = judge(&CHECKS[1], Err(Error::Failed("no".into())), 1.0);
        let text = serde_json::to_string(&broken).unwrap();
        assert_eq!(serde_json::from_str::<Vec<Verdict>>(&text).unwrap(), broken);
        assert_eq!(broken[0].status, Status::Failed);
    }
}
