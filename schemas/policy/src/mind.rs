//! A policy in an application: its variables, its steps, its last decision.

use std::path::Path;

use jde_policy::{Decision, Observer, Policy, Runner, Values};
use jde_schema::describe::Type;
use jde_schema::prelude::*;
use jde_schema::{Imports, ListedImport};

/// A list of variables without settings.
#[derive(Clone, Copy, Debug, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/PolicyInput")]
pub(crate) struct Plain {
    padding: Padding<1>,
}

/// How much longer than the trained one a step may be, before the log says it.
const SLOW_STEP: f64 = 1.5;

/// A policy that is ready to decide.
pub(crate) struct Mind {
    pub(crate) policy: Policy,
    pub(crate) runner: Runner,
    observer: Observer,
    /// The entry of the application for each role.
    entries: Vec<usize>,
    last: Option<Duration>,
    /// How many decisions followed each other without a gap, the last one included.
    decisions: u32,
    /// What it decided last, or what it lacks.
    pub(crate) decided: Result<Decision, String>,
    given: Option<[f64; 3]>,
    is_slow: bool,
}

/// What of an application does not fit a policy.
pub(crate) enum Unfit {
    /// The file, or what of the application it lacks.
    File(String),
    /// An entry of the list, by its number.
    Entry(usize, String),
}

/// The values of one call.
struct Sensed<'a, 'call> {
    samples: Vec<Option<Sample<'call, [u8]>>>,
    target: Option<Pose2D>,
    entries: &'a [usize],
}

impl Values for Sensed<'_, '_> {
    fn role(&self, role: usize) -> Option<&[u8]> {
        self.samples[self.entries[role]].as_deref()
    }

    fn target(&self) -> Option<Pose2D> {
        self.target
    }
}

impl Plain {
    pub(crate) const DEFAULT: Self = Self {
        padding: Padding::ZERO,
    };
}

impl Mind {
    /// Reads a policy, and finds its variables among those of the application.
    ///
    /// # Errors
    /// All that does not fit.
    pub(crate) fn load(file: &str, inputs: &Imports<Plain>) -> Result<Self, Vec<Unfit>> {
        if file.is_empty() {
            let words = "`file` names no policy: give the text file that describes one";
            return Err(vec![Unfit::File(words.to_owned())]);
        }
        let loaded = Policy::load(Path::new(file)).map_err(|faults| vec![Unfit::File(format!("{faults:#}"))]);
        let (policy, runner) = loaded?;
        let mut unfit = Vec::new();
        for (index, entry) in inputs.iter().enumerate() {
            if !policy.roles().any(|role| role == entry.label()) {
                let known: Vec<&str> = policy.roles().collect();
                let words = format!("the policy sees no `{}`, but {}", entry.label(), known.join(", "));
                unfit.push(Unfit::Entry(index, words));
            }
        }
        let mut entries = Vec::new();
        for role in policy.roles() {
            match inputs.iter().position(|entry| entry.label() == role) {
                Some(index) => entries.push(index),
                None => {
                    let words =
                        format!("the policy sees `{role}`: state `inputs.{role} = \"schema.variable\"`");
                    unfit.push(Unfit::File(words));
                }
            }
        }
        if !unfit.is_empty() {
            return Err(unfit);
        }
        let types: Vec<&Type> = entries
            .iter()
            .map(|index| &**inputs[*index].value_type())
            .collect();
        let observer = policy.observer(&types).map_err(|wrong| {
            let entry = |role: &str| inputs.iter().position(|entry| entry.label() == role);
            let unfit = |(role, words): (String, String)| match entry(&role) {
                Some(index) => Unfit::Entry(index, words),
                None => Unfit::File(words),
            };
            wrong.into_iter().map(unfit).collect::<Vec<_>>()
        })?;
        Ok(Self {
            policy,
            runner,
            observer,
            entries,
            last: None,
            decisions: 0,
            decided: Err("it has not decided yet".to_owned()),
            given: None,
            is_slow: false,
        })
    }

    /// Forgets what was before.
    pub(crate) fn reset(&mut self) {
        self.observer.reset();
        self.runner.reset();
        self.last = None;
        self.decisions = 0;
        self.given = None;
        self.decided = Err("it has not decided yet".to_owned());
    }

    /// Decides, if the time of a step has passed; otherwise the last decision stays. Returns whether the network failed.
    pub(crate) fn step(&mut self, cx: &Context, inputs: &Imports<Plain>, target: Option<Pose2D>) -> bool {
        let (now, period) = (cx.now(), self.policy.period());
        let since = self.last.map(|last| now.saturating_sub(last).as_secs_f64());
        // Half a period: a turn may come early or late.
        if since.is_some_and(|since| since < period / 2.0) {
            return false;
        }
        if since.is_some_and(|since| since > SLOW_STEP * period)
            && !core::mem::replace(&mut self.is_slow, true)
        {
            let since = since.unwrap_or_default();
            warn!(
                cx,
                "a step took {since:.3} s, and the policy's file states {period} s"
            );
        }
        self.last = Some(now);
        self.observer.commanded(self.given.take().unwrap_or_default());
        let sensed = Sensed {
            samples: inputs
                .iter()
                .map(|entry: &ListedImport<Plain>| entry.get(cx))
                .collect(),
            target,
            entries: &self.entries,
        };
        let observed = self.observer.observe(&sensed).map(drop);
        let is_seen = observed.is_ok();
        let decided = observed.and_then(|()| self.runner.step(self.observer.numbers()));
        let has_failed = is_seen && decided.is_err();
        self.decisions = self.decisions.saturating_add(1);
        if let Err(words) = &decided {
            if self.decided.is_ok() {
                warn!(cx, "it does not decide: {words}");
            }
            self.observer.reset();
            self.runner.reset();
            self.decisions = 0;
        }
        self.decided = decided;
        has_failed
    }

    /// Returns what the network saw last.
    pub(crate) fn seen(&self) -> &[f32] {
        self.observer.numbers()
    }

    /// Returns when it began its last step.
    pub(crate) fn decided_at(&self) -> Option<Duration> {
        self.last
    }

    /// Returns how many decisions came before the last one, without a gap.
    pub(crate) fn decisions_before(&self) -> u32 {
        self.decisions.saturating_sub(1)
    }

    /// Keeps what it commanded.
    pub(crate) fn gave(&mut self, command: [f64; 3]) {
        self.given = Some(command);
    }
}

impl core::fmt::Display for Unfit {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::File(words) | Self::Entry(_, words) => f.write_str(words),
        }
    }
}

/// A decision as a velocity of the base.
pub(crate) fn twist([ahead, left, turn]: [f64; 3]) -> Twist {
    let mut twist = Twist::planar(ahead, turn);
    twist.linear.y = left;
    twist
}

/// All that does not fit, as the reason of a fault.
pub(crate) fn words(unfit: &[Unfit]) -> String {
    unfit.iter().map(Unfit::to_string).collect::<Vec<_>>().join("; ")
}
