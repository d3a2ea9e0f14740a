//! Why somebody won: a question, the selection that answers it, and how that is told. It knows neither recordings nor networks:
//! selections come from whoever has them.

mod answer;
mod question;
#[cfg(test)]
mod tests;
mod words;

pub(crate) use answer::{Answer, Known};
pub(crate) use question::Question;
pub(crate) use words::{line, tell};
