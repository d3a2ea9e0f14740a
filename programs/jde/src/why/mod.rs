//! Why a schema won: a question, the selection that answers it, and the text of the answer. It depends on
//! neither recordings nor networks: callers supply the selections.

mod answer;
mod asleep;
mod missing;
mod question;
mod steps;
#[cfg(test)]
mod tests;
mod text;

pub(crate) use answer::{Answer, KnownSpan};
pub(crate) use asleep::{Asleep, Past, is_cause};
pub(crate) use missing::MissingValue;
pub(crate) use question::Question;
pub(crate) use steps::DueStep;
pub(crate) use text::write;
