//! The state of one condition: whether it was true at the last evaluation, and for which schemas or groups.

use std::collections::{BTreeMap, BTreeSet};

use jde_board::Nanos;
use jde_host::chatter::Chatter;

use super::Condition;
use super::condition::What;
use super::expression::Expression;
use super::facts::Fact;

/// The shortest time between two evaluations of an expression, in ns.
const BETWEEN: Nanos = 10_000_000;

/// A condition and its state.
pub(super) struct Trigger {
    pub(super) condition: Condition,
    pub(super) state: State,
}

pub(super) enum State {
    /// The groups or schemas for which the condition is true now.
    Of(BTreeSet<String>),
    /// The last switches of every group, and whether they are too many.
    Switches(BTreeMap<String, Chatter<()>>),
    /// The values of an expression.
    Values(Box<Looked>),
}

pub(super) struct Looked {
    pub(super) expression: Expression,
    last: bool,
    /// The time of the last evaluation.
    at: Option<Nanos>,
    /// Whether a value has arrived since the last evaluation.
    pub(super) put_off: bool,
}

impl State {
    fn of(what: &What) -> Self {
        match what {
            What::Expression(expression) => Self::Values(Box::new(Looked {
                expression: expression.clone(),
                last: false,
                at: None,
                put_off: false,
            })),
            What::Chatter { .. } => Self::Switches(BTreeMap::new()),
            What::Collision(_)
            | What::Absence(_)
            | What::Overrun(_)
            | What::Fault(_)
            | What::Refused
            | What::Operator => Self::Of(BTreeSet::new()),
        }
    }
}

impl Trigger {
    pub(super) fn new(condition: Condition) -> Self {
        Self {
            state: State::of(&condition.what),
            condition,
        }
    }

    /// Returns what became true by a fact, if anything did.
    pub(super) fn fact(&mut self, time: Nanos, fact: &Fact<'_>) -> Option<String> {
        let fits = |only: &Option<String>, name: &str| only.as_deref().is_none_or(|only| only == name);
        match (&self.condition.what, &mut self.state, fact) {
            (What::Collision(only), State::Of(of), Fact::Selected { group, collision, .. })
                if fits(only, group) =>
            {
                rises(of, group, *collision).then(|| format!("collision in {group}"))
            }
            (What::Absence(only), State::Of(of), Fact::Selected { group, absence, .. })
                if fits(only, group) =>
            {
                rises(of, group, *absence).then(|| format!("nobody wins in {group}"))
            }
            (
                What::Chatter {
                    more_than,
                    group: only,
                },
                State::Switches(groups),
                Fact::Selected {
                    group,
                    switched: true,
                    ..
                },
            ) if fits(only, group) => {
                // A pause between switches starts a new series.
                let chatter = groups
                    .entry((*group).to_owned())
                    .or_insert_with(|| Chatter::new(*more_than, *more_than));
                let count = chatter.switched(time, ())?;
                Some(format!("chattering: {count} switches within a second in {group}"))
            }
            (What::Overrun(only), State::Of(of), Fact::Health { schema, overrun, .. })
                if fits(only, schema) =>
            {
                rises(of, schema, *overrun).then(|| format!("overrun of {schema}"))
            }
            (What::Fault(only), State::Of(of), Fact::Health { schema, fault, .. }) if fits(only, schema) => {
                rises(of, schema, fault.is_some())
                    .then(|| format!("fault of {schema}: {}", fault.unwrap_or_default()))
            }
            (What::Refused, _, Fact::Refused { schema, text }) => {
                Some(format!("refused to {schema}: {text}"))
            }
            (What::Operator, _, Fact::Operator(text)) => Some(format!("operator: {text}")),
            _ => None,
        }
    }
}

/// Returns whether a condition becomes true for a schema or group for which it was false.
fn rises(of: &mut BTreeSet<String>, whom: &str, now: bool) -> bool {
    if now {
        of.insert(whom.to_owned())
    } else {
        of.remove(whom);
        false
    }
}

impl Looked {
    pub(super) fn due(&self, time: Nanos) -> bool {
        self.put_off && self.at.is_none_or(|at| time >= at.saturating_add(BETWEEN))
    }

    /// Evaluates the expression. Returns whether it becomes true.
    pub(super) fn look(&mut self, time: Nanos) -> bool {
        self.at = Some(time);
        self.put_off = false;
        let now = self.expression.is_true();
        let before = std::mem::replace(&mut self.last, now);
        now && !before
    }
}
