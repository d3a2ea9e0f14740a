//! A value of a sensor with what is known of it: how old it is, or why there is none. It draws nothing.

use jde_core::State;
use jde_link::message::VariableInfo;
use jde_link::{Rate, Sample};
use jde_types::Value;

use crate::session::Session;

/// A value of a driver that iterates slowly is stale after so many of its periods.
const PERIODS: f64 = 4.0;
/// No value is stale sooner, s: the network has a say too.
const SOONEST: f64 = 0.5;
/// Of an application that says nothing for so long, s, nobody knows how things are.
const SILENT: f64 = 1.0;

/// What a variable says.
#[derive(Clone, Debug, Default)]
pub(super) enum Reading<T> {
    /// The application has no such variable.
    #[default]
    Absent,
    /// It has one, of this name, and there is no value.
    None(String, NoReading),
    /// The newest value.
    Here(T, Freshness),
}

/// Why there is no value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoReading {
    /// It has not come yet.
    Waiting,
    /// Whoever exports it sleeps.
    Asleep(String),
    /// Whoever exports it took it back, or never gave one.
    Silent(String),
    /// It cannot be listened to.
    Trouble(String),
}

/// Of which variable a value is, and how old.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Freshness {
    /// The variable.
    pub(super) name: String,
    /// s.
    pub(super) age: f64,
    /// It is so old that things may be otherwise.
    pub(super) stale: bool,
    /// Whoever exports it sleeps.
    pub(super) asleep: Option<String>,
}

impl<T> Reading<T> {
    /// The value, however old.
    pub(super) fn value(&self) -> Option<&T> {
        match self {
            Self::Here(value, _) => Some(value),
            Self::Absent | Self::None(..) => None,
        }
    }

    /// Whether there is a value that tells how things are.
    pub(super) fn is_fresh(&self) -> bool {
        matches!(self, Self::Here(_, fresh) if !fresh.stale)
    }

    /// The schema that sleeps, if that is why there is no new value.
    pub(super) fn sleeper(&self) -> Option<&str> {
        match self {
            Self::None(_, NoReading::Asleep(owner)) => Some(owner),
            Self::Here(_, fresh) if fresh.stale => fresh.asleep.as_deref(),
            Self::Absent | Self::None(..) | Self::Here(..) => None,
        }
    }

    /// The variable.
    pub(super) fn name(&self) -> Option<&str> {
        match self {
            Self::Absent => None,
            Self::None(name, _) | Self::Here(_, Freshness { name, .. }) => Some(name),
        }
    }

    fn map<U>(self, to: impl FnOnce(T) -> Option<U>) -> Reading<U> {
        match self {
            Self::Absent => Reading::Absent,
            Self::None(name, why) => Reading::None(name, why),
            Self::Here(value, fresh) => match to(value) {
                Some(value) => Reading::Here(value, fresh),
                None => Reading::None(fresh.name, NoReading::Trouble("it is of another type".to_owned())),
            },
        }
    }
}

impl NoReading {
    /// In words.
    pub(super) fn words(&self) -> String {
        match self {
            Self::Waiting => "waiting for the first value".to_owned(),
            Self::Asleep(owner) => format!("no value: {owner} sleeps, for nobody needs it"),
            Self::Silent(owner) => format!("no value: {owner} has none now"),
            Self::Trouble(trouble) => format!("no value: {trouble}"),
        }
    }
}

impl Freshness {
    /// In words.
    pub(super) fn words(&self) -> String {
        match (&self.asleep, self.stale) {
            (Some(owner), true) => format!("{}, {owner} sleeps", ago(self.age)),
            (None, true) => ago(self.age),
            (_, false) => "live".to_owned(),
        }
    }
}

/// The newest value of a variable; of none, that it is absent. To be asked for in every frame.
pub(super) fn read<T: Value>(session: &Session, variable: Option<&VariableInfo>, rate: Rate) -> Reading<T> {
    sampled(session, variable, rate).map(|sample| T::from_bytes(sample.bytes.as_deref()?))
}

/// As [`read`], for what is too large to copy.
pub(super) fn sampled(
    session: &Session,
    variable: Option<&VariableInfo>,
    rate: Rate,
) -> Reading<std::sync::Arc<Sample>> {
    let Some(VariableInfo { name, owner, .. }) = variable else {
        return Reading::Absent;
    };
    let view = session.view(owner);
    let sleeps = view.is_some_and(|view| view.state == State::Slept);
    let asleep = sleeps.then(|| owner.clone());
    let Some(sample) = session.value(name, rate) else {
        let why = match session.trouble(name) {
            Some(trouble) => NoReading::Trouble(trouble),
            None => NoReading::Waiting,
        };
        return Reading::None(name.clone(), why);
    };
    if sample.bytes.is_none() {
        let why = match asleep {
            Some(owner) => NoReading::Asleep(owner),
            None => NoReading::Silent(owner.clone()),
        };
        return Reading::None(name.clone(), why);
    }
    // The application's time stands still with it.
    let silent = session.silent().as_secs_f64();
    let silent = if silent > SILENT { silent } else { 0.0 };
    let age = (session.now() - sample.time as f64 / 1e9).max(0.0) + silent;
    let period = view.map_or(0.0, |view| view.period as f64 / 1e9);
    let fresh = Freshness {
        name: name.clone(),
        age,
        stale: session.is_gone() || silent > 0.0 || age > SOONEST.max(PERIODS * period),
        asleep,
    };
    Reading::Here(sample, fresh)
}

/// An age in words.
fn ago(age: f64) -> String {
    match age {
        age if age < 10.0 => format!("{age:.1} s ago"),
        age if age < 120.0 => format!("{age:.0} s ago"),
        age if age < 7200.0 => format!("{:.0} min ago", age / 60.0),
        age => format!("{:.0} h ago", age / 3600.0),
    }
}
