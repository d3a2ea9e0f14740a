//! The phrases of a scenario: times, policies, effects and records.
//!
//! Each value has exactly one phrase.

use jde_core::{
    Absence, Case, Cause, Decider, Effect, GroupId, Health, Nanos, Policy, PolicyKind, SchemaId, Spec, State,
    Timer,
};

pub(super) fn time(text: &str) -> Result<Nanos, String> {
    let unit = |suffix: &str, nanos: f64| {
        let number: f64 = text.strip_suffix(suffix)?.trim().parse().ok()?;
        // The finest time in a scenario is a whole microsecond, which a float represents exactly.
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to be positive and small"
        )]
        (0.0..1e6)
            .contains(&number)
            .then(|| (number * nanos).round() as Nanos)
    };
    unit("us", 1e3)
        .or_else(|| unit("ms", 1e6))
        .or_else(|| unit("s", 1e9))
        .ok_or(format!("`{text}` is not a time: write 5ms, 0.2s or 50us"))
}

pub(super) fn policy(text: &str) -> Result<Policy, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let (name, time, margin) = match *words.as_slice() {
        [name] => (name, 0, 0.0),
        [name, duration] => (name, time(duration)?, 0.0),
        [name, duration, "by", margin] => (name, time(duration)?, number(margin)?),
        _ => return Err(format!("`{text}` is not a policy")),
    };
    let kind = PolicyKind::named(name).ok_or(format!("`{name}` is not a policy"))?;
    Ok(Policy::new(kind, time, margin))
}

pub(super) fn absence(
    text: &str,
    find: impl FnOnce(&str) -> Result<SchemaId, String>,
) -> Result<Absence, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    Ok(match words.as_slice() {
        ["brake"] => Absence::Brake,
        ["hold", for_] => Absence::Hold { for_: time(for_)? },
        ["fallback", name] => Absence::Fallback(find(name)?),
        _ => return Err(format!("`{text}` is not an absence policy")),
    })
}

pub(super) fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("`{text}` is not a number"))
}

pub(super) fn state(state: State) -> &'static str {
    match state {
        State::Slept => "slept",
        State::Checking => "checking",
        State::Ready => "ready",
        State::Winner => "winner",
    }
}

pub(super) fn health(health: &Health) -> String {
    match health {
        Health::Ok => "ok".into(),
        Health::Overrun => "overrun".into(),
        Health::ArbitrationFailed(reason) => format!("arbitration failed: {reason}"),
        Health::Faulted(reason) => format!("faulted: {reason}"),
    }
}

pub(super) fn case(case: Case) -> &'static str {
    match case {
        Case::Alone => "alone",
        Case::Collision => "collision",
        Case::Absence => "absence",
        Case::Forced => "forced",
    }
}

pub(super) fn decider(decider: Decider) -> &'static str {
    match decider {
        Decider::Nobody => "nobody",
        Decider::Policy(policy) => policy.name(),
        Decider::Father => "father",
        Decider::ArbitrationFailed => "arbitration failed",
        Decider::AbsencePolicy => "absence policy",
        Decider::Operator => "operator",
    }
}

/// The names of schemas and groups.
#[derive(Copy, Clone)]
pub(super) struct Names<'a>(pub(super) &'a Spec);

impl<'a> Names<'a> {
    pub(super) fn schema(self, id: SchemaId) -> &'a str {
        &self.0.schemas[id].name
    }

    pub(super) fn optional(self, id: Option<SchemaId>) -> &'a str {
        id.map_or("nobody", |id| self.schema(id))
    }

    pub(super) fn group(self, id: GroupId) -> &'a str {
        &self.0.groups[id].name
    }

    pub(super) fn find(self, name: &str) -> Result<SchemaId, String> {
        let index = self.0.schemas.iter().position(|s| s.name == name);
        let index = index.ok_or(format!("the scenario has no schema `{name}`"))?;
        Ok(SchemaId(u32::try_from(index).expect("few schemas")))
    }

    pub(super) fn find_group(self, name: &str) -> Result<GroupId, String> {
        let group = self.0.groups.find(|g| g.name == name);
        group.ok_or(format!("the scenario has no group `{name}`"))
    }

    pub(super) fn cause(self, cause: Cause) -> String {
        match cause {
            Cause::Start => "the application started".into(),
            Cause::Readiness(id) => format!("{} was checked", self.schema(id)),
            Cause::Woken(id) => format!("{} woke", self.schema(id)),
            Cause::Slept(id) => format!("{} was put to sleep", self.schema(id)),
            Cause::Faulted(id) => format!("{} faulted", self.schema(id)),
            Cause::Iterated(id) => format!("{} iterated", self.schema(id)),
            Cause::Refused(id) => format!("the guard refused a command of {}", self.schema(id)),
            Cause::PolicyChanged => "the policy changed".into(),
            Cause::Operator(id) => format!("an operator handled {}", self.schema(id)),
            Cause::Timer(Timer::Patience(_)) => "patience ended".into(),
            Cause::Timer(Timer::Retry(_)) => "the retry ended".into(),
            Cause::Timer(Timer::Turn(_)) => "the turn ended".into(),
            Cause::Timer(other) => format!("{other:?}"),
        }
    }

    pub(super) fn effect(self, effect: &Effect) -> String {
        match effect {
            Effect::Woken(id) => format!("{} wakes", self.schema(*id)),
            Effect::Slept { id, abandoned: false } => format!("{} sleeps", self.schema(*id)),
            Effect::Slept { id, abandoned: true } => format!("{} sleeps, abandoned", self.schema(*id)),
            Effect::TakesOver { id, .. } => format!("{} takes over the commands", self.schema(*id)),
            Effect::Refused(id) => format!("{} is refused", self.schema(*id)),
            Effect::Retries(id) => format!("{} may try again", self.schema(*id)),
            Effect::Lapsed(id) => format!("what {} did not write lapses", self.schema(*id)),
            Effect::Granted(id) => format!("{} gains authority", self.schema(*id)),
            Effect::Withdrawn(id) => format!("{} loses authority", self.schema(*id)),
            Effect::Promoted(id) => format!("{} is promoted", self.schema(*id)),
            Effect::Demoted(id) => format!("{} is demoted", self.schema(*id)),
            Effect::Arbitrate { group, .. } => {
                let father = self.0.groups[*group].father;
                format!("{} is asked about {}", self.optional(father), self.group(*group))
            }
            Effect::Brake { group } => format!("{} brakes", self.group(*group)),
            Effect::Hold { group, until } => format!("{} holds until {}", self.group(*group), Time(*until)),
            Effect::Changed { id, from, to } => {
                format!(
                    "{} goes from {} to {}",
                    self.schema(*id),
                    state(*from),
                    state(*to)
                )
            }
            Effect::Health { id, health: current } => format!("{} is {}", self.schema(*id), health(current)),
            Effect::Decided(record) => {
                format!(
                    "{} chooses {}",
                    self.group(record.group),
                    self.optional(record.choice)
                )
            }
            Effect::TookOver { id, latency, .. } => {
                format!("{} takes over after {}", self.schema(*id), Time(*latency))
            }
        }
    }
}

/// A time as a scenario writes it.
pub(super) struct Time(pub(super) Nanos);

impl std::fmt::Display for Time {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_multiple_of(1_000_000) {
            write!(f, "{}ms", self.0 / 1_000_000)
        } else {
            write!(f, "{}us", self.0 / 1_000)
        }
    }
}
