//! One condition and where it stands: whether it was true when it was last looked at, and of whom.

use std::collections::{BTreeMap, BTreeSet};

use jde_board::Nanos;
use jde_host::chatter::Chatter;

use super::Condition;
use super::condition::What;
use super::expression::Expression;
use super::facts::Fact;

/// The least time between two looks at an expression.
const BETWEEN: Nanos = 10_000_000;

/// One condition, and where it stands.
pub(super) struct Trigger {
    pub(super) condition: Condition,
    pub(super) state: State,
}

pub(super) enum State {
    /// Of which groups or schemas it is true now.
    Of(BTreeSet<String>),
    /// The last switches of every group, and whether they are too many.
    Switches(BTreeMap<String, Chatter<()>>),
    /// An expression's values.
    Values(Box<Looked>),
}

pub(super) struct Looked {
    pub(super) expression: Expression,
    last: bool,
    /// When it was last looked at.
    at: Option<Nanos>,
    /// A value has come that was not looked at.
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

    /// What has come true by a fact, if anything has.
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
                // A pause in between is a new beginning.
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

/// Whether it becomes true of one of whom it was not.
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

    /// Whether it comes true with this look.
    pub(super) fn look(&mut self, time: Nanos) -> bool {
        self.at = Some(time);
        self.put_off = false;
        let now = self.expression.is_true();
        let before = std::mem::replace(&mut self.last, now);
        now && !before
    }
}
