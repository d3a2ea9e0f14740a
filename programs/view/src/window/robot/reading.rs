//! A sensor's value with its age, or why there is none. It draws nothing.

use jde_core::State;
use jde_link::message::VariableInfo;
use jde_link::{Rate, Sample};
use jde_types::Value;

use crate::session::WindowSession;

/// A value is stale after this many periods of its driver.
const STALE_PERIODS: f64 = 4.0;
/// Minimum age of a stale value, in s. It allows for delays of the network.
const MIN_STALE_AGE: f64 = 0.5;
/// Without a snapshot for this time, in s, all values of the application are stale.
const SNAPSHOT_TIMEOUT: f64 = 1.0;

/// The state of a variable.
#[derive(Clone, Debug, Default)]
pub(super) enum VariableState<T> {
    /// The application has no such variable.
    #[default]
    Absent,
    /// The variable of this name has no value.
    None(String, NoReading),
    /// The newest value.
    Present(T, Freshness),
}

/// Why there is no value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoReading {
    /// The first value has not arrived yet.
    Waiting,
    /// The exporting schema is SLEPT.
    Asleep(Sleeper),
    /// The exporting schema, of this name, withdrew its value.
    Silent(String),
    /// The exporting schema, of this name, has never written one: it may lack the sensor.
    Never(String),
    /// Subscribing failed, for this reason.
    Trouble(String),
}

/// A schema that is SLEPT, and why.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Sleeper {
    pub(super) schema: String,
    /// The stop of an operator that keeps it asleep, in words: "stopped by ana@laptop".
    pub(super) stop: Option<String>,
}

/// The name and age of a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Freshness {
    /// The name of the variable.
    pub(super) name: String,
    /// In s.
    pub(super) age: f64,
    /// Whether the value is too old to describe the present.
    pub(super) stale: bool,
    /// The exporting schema, if it is SLEPT.
    pub(super) asleep: Option<Sleeper>,
}

impl<T> VariableState<T> {
    /// The value, of any age.
    pub(super) fn value(&self) -> Option<&T> {
        match self {
            Self::Present(value, _) => Some(value),
            Self::Absent | Self::None(..) => None,
        }
    }

    /// Whether there is a value that is not stale.
    pub(super) fn is_fresh(&self) -> bool {
        matches!(self, Self::Present(_, fresh) if !fresh.stale)
    }

    /// The exporting schema, if it is SLEPT and there is therefore no new value.
    pub(super) fn sleeper(&self) -> Option<&Sleeper> {
        match self {
            Self::None(_, NoReading::Asleep(sleeper)) => Some(sleeper),
            Self::Present(_, fresh) if fresh.stale => fresh.asleep.as_ref(),
            Self::Absent | Self::None(..) | Self::Present(..) => None,
        }
    }

    /// The name of the variable.
    pub(super) fn name(&self) -> Option<&str> {
        match self {
            Self::Absent => None,
            Self::None(name, _) | Self::Present(_, Freshness { name, .. }) => Some(name),
        }
    }

    fn map<U>(self, convert: impl FnOnce(T) -> Option<U>) -> VariableState<U> {
        match self {
            Self::Absent => VariableState::Absent,
            Self::None(name, reason) => VariableState::None(name, reason),
            Self::Present(value, fresh) => match convert(value) {
                Some(value) => VariableState::Present(value, fresh),
                None => VariableState::None(fresh.name, NoReading::Trouble("it has another type".to_owned())),
            },
        }
    }
}

impl NoReading {
    /// The reason as a message for the user.
    pub(super) fn message(&self) -> String {
        match self {
            Self::Waiting => "waiting for the first value".to_owned(),
            Self::Asleep(sleeper) => format!("no value: {}", sleeper.message()),
            Self::Silent(owner) => format!("no value from {owner} any more"),
            Self::Never(owner) => format!("no value from {owner} yet"),
            Self::Trouble(trouble) => format!("no value: {trouble}"),
        }
    }
}

impl Sleeper {
    /// Why it sleeps, as a message for the user.
    pub(super) fn message(&self) -> String {
        match &self.stop {
            Some(stop) => format!("{} sleeps, because it was {stop}", self.schema),
            None => format!("{} sleeps, because no schema needs it", self.schema),
        }
    }
}

impl Freshness {
    /// The age as a text for the user.
    pub(super) fn message(&self) -> String {
        match (&self.asleep, self.stale) {
            (Some(_), true) => format!("{}, asleep", ago(self.age)),
            (None, true) => ago(self.age),
            (_, false) => "live".to_owned(),
        }
    }
}

/// The newest value of a variable; [`VariableState::Absent`] for `None`. Call in each frame.
pub(super) fn read<T: Value>(
    session: &WindowSession,
    variable: Option<&VariableInfo>,
    rate: Rate,
) -> VariableState<T> {
    sampled(session, variable, rate).map(|sample| T::from_bytes(sample.bytes.as_deref()?))
}

/// As [`read`], for values that are too large to copy.
pub(super) fn sampled(
    session: &WindowSession,
    variable: Option<&VariableInfo>,
    rate: Rate,
) -> VariableState<std::sync::Arc<Sample>> {
    let Some(VariableInfo { name, owner, .. }) = variable else {
        return VariableState::Absent;
    };
    let view = session.view(owner);
    let asleep = view
        .filter(|view| view.state == State::Slept)
        .map(|view| Sleeper {
            schema: owner.clone(),
            stop: view.stop().map(ToString::to_string),
        });
    let Some(sample) = session.value(name, rate) else {
        let reason = match session.trouble(name) {
            Some(trouble) => NoReading::Trouble(trouble),
            None => NoReading::Waiting,
        };
        return VariableState::None(name.clone(), reason);
    };
    if sample.bytes.is_none() {
        // A driver that has run without a value for it may lack the sensor, whether or not it sleeps now.
        let has_run = view.is_some_and(|view| view.iterations > 0);
        let reason = match asleep {
            _ if sample.sequence == 0 && has_run => NoReading::Never(owner.clone()),
            Some(sleeper) => NoReading::Asleep(sleeper),
            None if sample.sequence == 0 => NoReading::Never(owner.clone()),
            None => NoReading::Silent(owner.clone()),
        };
        return VariableState::None(name.clone(), reason);
    }
    // Without snapshots, `now` does not advance, so the silence is added to the age.
    let silent = session.silent().as_secs_f64();
    let silent = if silent > SNAPSHOT_TIMEOUT { silent } else { 0.0 };
    let age = (session.now() - sample.time as f64 / 1e9).max(0.0) + silent;
    let period = view.map_or(0.0, |view| view.period as f64 / 1e9);
    let fresh = Freshness {
        name: name.clone(),
        age,
        stale: session.is_over() || silent > 0.0 || age > MIN_STALE_AGE.max(STALE_PERIODS * period),
        asleep,
    };
    VariableState::Present(sample, fresh)
}

/// Formats an age in s.
fn ago(age: f64) -> String {
    match age {
        age if age < 10.0 => format!("{age:.1} s ago"),
        age if age < 120.0 => format!("{age:.0} s ago"),
        age if age < 7200.0 => format!("{:.0} min ago", age / 60.0),
        age => format!("{:.0} h ago", age / 3600.0),
    }
}
