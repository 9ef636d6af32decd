//! Failures of device calls on demand: how tests show what becomes of a render whose device fails.
//!
//! A plan of [`Faults`] counts the calls of a [`Device`](super::Device) and makes some fail as a driver would: in place
//! of the call, with its status. Without a plan a call costs one comparison more.

use crate::{Error, Result};
use std::collections::{BTreeSet, HashMap};
use std::fmt::{self, Display};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};

/// The environment variable that makes calls fail: see [`Faults::of_environment`].
pub const VARIABLE: &str = "SVETLO_FAULT";

/// What may fail on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// Opening it: `clCreateContext`, `clCreateCommandQueue`.
    Open,
    /// Building a program: `clBuildProgram`.
    Build,
    /// Taking a kernel of a program: `clCreateKernel`.
    Kernel,
    /// Allocating a buffer: `clCreateBuffer`.
    Allocate,
    /// Copying to a buffer: `clEnqueueWriteBuffer`.
    Write,
    /// Copying from a buffer: `clEnqueueReadBuffer`.
    Read,
    /// Starting a kernel: `clEnqueueNDRangeKernel`.
    Launch,
    /// Waiting for what was started: `clFinish`.
    Finish,
}

/// The status of every call on a device that is lost: `CL_INVALID_COMMAND_QUEUE`.
const LOST: i32 = -36;

impl Call {
    /// All of them, in the order in which a render meets the first of each.
    pub const ALL: [Self; 8] = [
        Self::Open,
        Self::Build,
        Self::Kernel,
        Self::Allocate,
        Self::Write,
        Self::Launch,
        Self::Finish,
        Self::Read,
    ];

    /// Its name in [`VARIABLE`].
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Build => "build",
            Self::Kernel => "kernel",
            Self::Allocate => "allocate",
            Self::Write => "write",
            Self::Read => "read",
            Self::Launch => "launch",
            Self::Finish => "finish",
        }
    }

    /// The status that drivers return most often when it fails.
    fn status(self) -> i32 {
        match self {
            Self::Open => -2,
            Self::Build => -11,
            Self::Kernel => -6,
            Self::Allocate => -4,
            Self::Write | Self::Read | Self::Launch => -5,
            Self::Finish => -14,
        }
    }
}

/// One thing to go wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// The call of this kind and number, from 1 on, fails; those after it do not.
    Fail(Call, u64),
    /// The call of this number, whatever its kind, fails, and all after it: the device is lost.
    Lose(u64),
}

/// A plan of failures, and how many calls there were.
#[derive(Debug, Default)]
pub struct Faults {
    rules: Vec<Rule>,
    all: AtomicU64,
    counts: [AtomicU64; Call::ALL.len()],
    lost: AtomicBool,
    struck: AtomicBool,
    /// Calls of this kind wait as long as it is there.
    stalled: Mutex<Option<Call>>,
    going_on: Condvar,
    /// The kernels that were launched.
    kernels: Mutex<BTreeSet<&'static str>>,
}

impl Faults {
    /// The `number`-th call of this kind fails, counted from 1; later ones do not.
    pub fn fail(call: Call, number: u64) -> Self {
        Self { rules: vec![Rule::Fail(call, number)], ..Self::default() }
    }

    /// The `number`-th call fails, whatever its kind, counted from 1, and all that follow: the device is lost.
    pub fn lose(number: u64) -> Self {
        Self { rules: vec![Rule::Lose(number)], ..Self::default() }
    }

    /// Calls of this kind come to no end until [`go_on`](Self::go_on): the device is as slow as one can be.
    pub fn stall(call: Call) -> Self {
        Self { stalled: Mutex::new(Some(call)), ..Self::default() }
    }

    /// Ends what [`stall`](Self::stall) began.
    pub fn go_on(&self) {
        *self.stalled.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.going_on.notify_all();
    }

    /// Calls so far, of all kinds.
    pub fn calls(&self) -> u64 {
        self.all.load(Ordering::Relaxed)
    }

    /// Calls of one kind so far.
    pub fn calls_of(&self, call: Call) -> u64 {
        self.counts[call as usize].load(Ordering::Relaxed)
    }

    /// The names of the kernels that were launched so far.
    pub fn kernels(&self) -> BTreeSet<&'static str> {
        self.kernels.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Notes the launch of a kernel.
    pub(super) fn launched(&self, kernel: &'static str) {
        self.kernels.lock().unwrap_or_else(PoisonError::into_inner).insert(kernel);
    }

    /// Whether any call has failed: launches follow the time they take, so that there may be fewer than once before.
    pub fn struck(&self) -> bool {
        self.struck.load(Ordering::Relaxed)
    }

    /// What the variable `SVETLO_FAULT` plans for the device of this selector, if anything. Every device has one plan as
    /// long as the process lives: one that is lost cannot be opened again.
    ///
    /// It holds `CALL=N@SELECTOR`, with commas between several: the N-th call of that kind (`open`, `build`, `kernel`,
    /// `allocate`, `write`, `read`, `launch`, `finish`) on that device fails; with `lost` for CALL, its N-th call of any
    /// kind and all after it. Without `@SELECTOR` each device has such a plan.
    ///
    /// # Errors
    /// [`Error::Input`] when the variable is not of that form.
    pub fn of_environment(selector: &str) -> Result<Option<Arc<Self>>> {
        static TEXT: OnceLock<Option<String>> = OnceLock::new();
        static PLANS: OnceLock<Mutex<HashMap<String, Arc<Faults>>>> = OnceLock::new();
        let text = TEXT.get_or_init(|| {
            let value = std::env::var_os(VARIABLE).filter(|value| !value.is_empty())?;
            Some(value.to_string_lossy().into_owned())
        });
        let Some(text) = text else { return Ok(None) };
        let rules = rules_for(text, selector)?;
        if rules.is_empty() {
            return Ok(None);
        }
        let mut plans = PLANS.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner);
        let plan = || Arc::new(Self { rules, ..Self::default() });
        Ok(Some(Arc::clone(plans.entry(selector.to_owned()).or_insert_with(plan))))
    }

    /// Counts a call, and says the status it is to fail with, if it is.
    pub(super) fn next(&self, call: Call) -> Option<i32> {
        let all = self.all.fetch_add(1, Ordering::Relaxed) + 1;
        let number = self.counts[call as usize].fetch_add(1, Ordering::Relaxed) + 1;
        if self.rules.iter().any(|rule| matches!(rule, Rule::Lose(first) if all >= *first)) {
            self.lost.store(true, Ordering::Relaxed);
        }
        let status = if self.lost.load(Ordering::Relaxed) {
            Some(LOST)
        } else {
            self.rules.contains(&Rule::Fail(call, number)).then(|| call.status())
        };
        if status.is_some() {
            self.struck.store(true, Ordering::Relaxed);
        }
        let mut stalled = self.stalled.lock().unwrap_or_else(PoisonError::into_inner);
        while *stalled == Some(call) {
            stalled = self.going_on.wait(stalled).unwrap_or_else(PoisonError::into_inner);
        }
        status
    }
}

/// What the text of the variable plans for one device.
fn rules_for(text: &str, selector: &str) -> Result<Vec<Rule>> {
    let mut rules = Vec::new();
    for part in text.split(',') {
        let (rule, device) = match part.split_once('@') {
            Some((rule, device)) => (rule, Some(device)),
            None => (part, None),
        };
        let rule = rule_of(rule).filter(|_| device != Some("")).ok_or_else(|| wrong(part))?;
        if device.is_none_or(|device| device == selector) {
            rules.push(rule);
        }
    }
    Ok(rules)
}

/// `CALL=N`.
fn rule_of(text: &str) -> Option<Rule> {
    let (name, number) = text.split_once('=')?;
    let digits = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    let number = number.parse().ok().filter(|number| digits && *number > 0)?;
    if name == "lost" {
        return Some(Rule::Lose(number));
    }
    let call = Call::ALL.into_iter().find(|call| call.name() == name)?;
    Some(Rule::Fail(call, number))
}

fn wrong(part: &str) -> Error {
    let calls = Call::ALL.map(Call::name).join(", ");
    Error::Input(format!(
        "{VARIABLE}: `{part}` is no fault; write CALL=N or CALL=N@SELECTOR, N from 1 on, CALL one of {calls}, lost"
    ))
}

impl Display for Call {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_call_fails_and_a_lost_device_fails_for_good() {
        let faults = Faults::fail(Call::Write, 2);
        let found = [Call::Write, Call::Read, Call::Write, Call::Write].map(|call| faults.next(call));
        assert_eq!(found, [None, None, Some(-5), None]);
        assert_eq!((faults.calls(), faults.calls_of(Call::Write), faults.calls_of(Call::Build)), (4, 3, 0));
        let faults = Faults::lose(2);
        let found = [Call::Write, Call::Read, Call::Finish].map(|call| faults.next(call));
        assert_eq!(found, [None, Some(LOST), Some(LOST)]);
    }

    #[test]
    fn the_variable_says_which_device() {
        let text = "launch=7@0:0,lost=12@1:0,read=1";
        let read = Rule::Fail(Call::Read, 1);
        assert_eq!(rules_for(text, "0:0").unwrap(), [Rule::Fail(Call::Launch, 7), read]);
        assert_eq!(rules_for(text, "1:0").unwrap(), [Rule::Lose(12), read]);
        assert_eq!(rules_for(text, "2:0").unwrap(), [read]);
        for call in Call::ALL {
            assert_eq!(rule_of(&format!("{call}=3")), Some(Rule::Fail(call, 3)));
        }
    }

    #[test]
    fn what_is_no_fault_is_refused_whatever_the_device() {
        for bad in
            ["", "launch", "launch=0", "launch=+1", "launch=-1", "launch=1@", "LOST=1", "read=1,", "x=1"]
        {
            let error = rules_for(bad, "0:0").unwrap_err();
            assert_eq!(error.exit_code(), 2, "{bad}");
            assert!(error.to_string().contains("is no fault; write CALL=N"), "{error}");
        }
        assert!(rules_for("nonsense=1@1:0", "0:0").is_err());
    }
}
