//! Conditions and expressions over the selections, health and variables of a run.
//!
//! An [`Expression`] is checked against the [`Names`] of an application before it starts, and evaluated many
//! times: 20 ns for `clearance < 0.2`. Its inputs are variables and [`Signals`]; what they mean is in
//! `docs/recordings.md`. A [`Condition`] is an expression or a keyword such as `conflict`; [`Triggers`]
//! process events and values and report a [`Firing`] whenever a condition changes from false to true.
//!
//! All depend only on what they receive, in its order, so a run in virtual time always gives the same result.
//! They have no thread, no clock and no file. Their user acts on the results.
//!
//! ```
//! use std::{collections::BTreeMap, sync::Arc};
//! use jde_conditions::{Expression, Names, Signals};
//! use jde_types::{Truth, Value};
//!
//! let names = Names {
//!     schemas: vec!["vff".to_owned()],
//!     groups: vec!["roots".to_owned()],
//!     variables: BTreeMap::from([("pioneer.truth".to_owned(), Arc::new(Truth::describe()))]),
//!     seed: None,
//! };
//! let mut near = Expression::condition("time > 2 and clearance < 0.2", &names)?;
//! let mut speed = Expression::number("pioneer.truth.twist.linear.x * 3.6", &names)?;
//!
//! let mut signals = Signals::new(&names);
//! let truth = Truth { clearance: 0.1, ..Truth::default() };
//! signals.process_value("pioneer.truth", Some(truth.as_bytes()));
//! signals.advance(2_500_000_000);
//!
//! // The places are found once. Then only what changes is set.
//! let places: Vec<_> = near.inputs().map(|name| signals.find(name)).collect();
//! signals.take_changes(|signal, value| {
//!     for (place, _) in places.iter().enumerate().filter(|(_, input)| **input == Some(signal)) {
//!         near.set(place, value);
//!     }
//! });
//! assert!(near.is_true());
//!
//! assert_eq!(speed.value(), None, "there is no value yet");
//! speed.set(0, Some(truth.as_bytes()));
//! assert_eq!(speed.value(), Some(0.0));
//! # Ok::<(), jde_conditions::BadCondition>(())
//! ```

mod check;
mod compiled;
mod condition;
mod expression;
mod facts;
mod kind;
mod names;
mod signals;
mod triggers;
mod value_view;
mod watch;
mod words;

pub use condition::{BadCondition, Condition, Reason};
pub use expression::Expression;
pub use names::Names;
pub use signals::Signals;
pub use triggers::{Firing, Triggers};

#[cfg(test)]
mod tests;
