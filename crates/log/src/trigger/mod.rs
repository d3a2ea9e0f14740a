//! Reasons to look: conditions over selections, health and variables, and the moments at which they come true.
//!
//! A [`Condition`] is checked against what an application has before it starts; [`Triggers`] hear what happens and answer with
//! a [`Firing`] whenever one goes from false to true. They see what they are given, in its order, so a run in virtual time
//! fires the same every time. They have no thread, no clock and no file, and what follows a firing is somebody else's business.

mod check;
mod condition;
mod expression;
mod facts;
mod kind;
mod names;
mod view;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use jde_board::Nanos;
use jde_host::event::Event;
use jde_host::story::Line;

use condition::What;
pub use condition::{BadCondition, Condition, Reason};
use expression::Expression;
use facts::Fact;
pub use names::Names;

/// The time over which switches count as chattering.
const CHATTER: Nanos = 1_000_000_000;
/// The least time between two looks at an expression.
const BETWEEN: Nanos = 10_000_000;

/// Conditions that are watched together.
pub struct Triggers {
    names: Names,
    list: Vec<Trigger>,
}

/// A condition came true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Firing {
    /// When, ns since the application's start.
    pub time: Nanos,
    /// Place of the condition among those that are watched.
    pub condition: usize,
    /// What came true, in words: `collision in example/base`, or the expression.
    pub text: String,
}

/// One condition, and where it stands.
struct Trigger {
    condition: Condition,
    state: State,
}

enum State {
    /// Of which groups or schemas it is true now.
    Of(BTreeSet<String>),
    /// The last switches of every group, and whether they are too many.
    Switches(BTreeMap<String, (VecDeque<Nanos>, bool)>),
    /// An expression's values.
    Values(Box<Looked>),
}

struct Looked {
    expression: Expression,
    last: bool,
    /// When it was last looked at.
    at: Option<Nanos>,
    /// A value has come that was not looked at.
    put_off: bool,
}

impl Triggers {
    /// Watches conditions of an application that has these names.
    #[must_use]
    pub fn new(names: Names, conditions: Vec<Condition>) -> Self {
        let list = conditions
            .into_iter()
            .map(|condition| Trigger {
                state: State::of(&condition.what),
                condition,
            })
            .collect();
        Self { names, list }
    }

    /// The full names of the variables whose values they must be given, each once.
    #[must_use]
    pub fn variables(&self) -> BTreeSet<&str> {
        let named = self
            .list
            .iter()
            .filter_map(|trigger| match &trigger.condition.what {
                What::Expression(expression) => Some(expression.variables()),
                _ => None,
            });
        named.flatten().collect()
    }

    /// The text of a condition, as it was given.
    #[must_use]
    pub fn condition(&self, place: usize) -> Option<&str> {
        self.list
            .get(place)
            .map(|trigger| trigger.condition.text.as_str())
    }

    /// Hears an event of the application whose names these are.
    pub fn event(&mut self, event: &Event, fired: &mut Vec<Firing>) {
        if let Some((time, fact)) = facts::of_event(event, &self.names) {
            each_fact(&mut self.list, time, &fact, fired);
        }
    }

    /// Hears a message of an application elsewhere.
    pub fn line(&mut self, line: &Line, fired: &mut Vec<Firing>) {
        if let Some(fact) = facts::of_line(line) {
            each_fact(&mut self.list, line.time(), &fact, fired);
        }
    }

    /// Has a new value of a variable: all the bytes of its type.
    pub fn value(&mut self, time: Nanos, variable: &str, bytes: &[u8], fired: &mut Vec<Firing>) {
        self.each(time, fired, |looked| {
            looked.expression.take(variable, Some(bytes))
        });
    }

    /// The value of a variable was taken back: there is none.
    pub fn retracted(&mut self, time: Nanos, variable: &str, fired: &mut Vec<Firing>) {
        self.each(time, fired, |looked| looked.expression.take(variable, None));
    }

    /// Time goes on: looks at what came too soon after the look before.
    pub fn pass(&mut self, time: Nanos, fired: &mut Vec<Firing>) {
        self.each(time, fired, |_| false);
    }

    fn each(&mut self, time: Nanos, fired: &mut Vec<Firing>, take: impl Fn(&mut Looked) -> bool) {
        for (condition, trigger) in self.list.iter_mut().enumerate() {
            let State::Values(looked) = &mut trigger.state else {
                continue;
            };
            // What was put off is looked at as it was before this value.
            let before = looked.due(time) && looked.look(time);
            looked.put_off |= take(looked);
            let now = looked.due(time) && looked.look(time);
            if before || now {
                fired.push(Firing {
                    time,
                    condition,
                    text: trigger.condition.text.clone(),
                });
            }
        }
    }
}

fn each_fact(list: &mut [Trigger], time: Nanos, fact: &Fact<'_>, fired: &mut Vec<Firing>) {
    for (condition, trigger) in list.iter_mut().enumerate() {
        if let Some(text) = trigger.fact(time, fact) {
            fired.push(Firing {
                time,
                condition,
                text,
            });
        }
    }
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
    /// What has come true by a fact, if anything has.
    fn fact(&mut self, time: Nanos, fact: &Fact<'_>) -> Option<String> {
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
                let (switches, chatters) = groups.entry((*group).to_owned()).or_default();
                while switches.pop_front_if(|then| *then + CHATTER <= time).is_some() {}
                // A pause in between is a new beginning.
                *chatters &= switches.len() > *more_than;
                switches.push_back(time);
                let count = switches.len();
                (count > *more_than && !std::mem::replace(chatters, true))
                    .then(|| format!("chattering: {count} switches within a second in {group}"))
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
    fn due(&self, time: Nanos) -> bool {
        self.put_off && self.at.is_none_or(|at| time >= at.saturating_add(BETWEEN))
    }

    /// Whether it comes true with this look.
    fn look(&mut self, time: Nanos) -> bool {
        self.at = Some(time);
        self.put_off = false;
        let now = self.expression.is_true();
        let before = std::mem::replace(&mut self.last, now);
        now && !before
    }
}

#[cfg(test)]
mod tests;
