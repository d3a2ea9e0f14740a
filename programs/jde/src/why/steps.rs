//! The commands of chunks that came due: which of them a schema gave while it had authority. Prints nothing.

use jde_records::Decision;
use jde_types::ChunkStep;
use serde::Serialize;

/// A command of a chunk that came due.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct DueStep {
    /// The schema that gave it.
    pub(crate) schema: String,
    /// When it gave it, s since the application's start.
    pub(crate) time_s: f64,
    /// The number of the chunk.
    pub(crate) chunk: u64,
    /// The place of the command in the chunk, from 1.
    pub(crate) step: u32,
    /// How many commands the chunk has.
    pub(crate) steps: u32,
    /// How old the chunk was, s.
    pub(crate) age_s: f64,
}

impl DueStep {
    pub(crate) fn new(schema: &str, time_s: f64, step: &ChunkStep) -> Self {
        Self {
            schema: schema.to_owned(),
            time_s,
            chunk: step.chunk,
            step: step.step,
            steps: step.steps,
            age_s: step.age,
        }
    }

    /// Whether it is the same command of the same chunk, given again.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        (&self.schema, self.chunk, self.step) == (&other.schema, other.chunk, other.step)
    }

    /// Returns it in words.
    pub(crate) fn text(&self) -> String {
        let Self {
            chunk,
            step,
            steps,
            age_s,
            ..
        } = self;
        format!("step {step} of {steps} of chunk {chunk}, seen {age_s:.3} s before")
    }
}

/// Returns the first and the last step of the schema that a decision chose, until `until`; or of the schema before, if it
/// chose none, which are those that led to it.
pub(crate) fn of_decision<'d>(decision: &Decision, until: f64, steps: &'d [DueStep]) -> Vec<&'d DueStep> {
    let (schema, times) = match (&decision.choice, &decision.before) {
        (Some(choice), _) => (choice, decision.time_s..=until),
        (None, Some(before)) => (before, 0.0..=decision.time_s),
        (None, None) => return Vec::new(),
    };
    let mut of = steps
        .iter()
        .filter(|step| step.schema == *schema && times.contains(&step.time_s));
    let first = of.next();
    first.into_iter().chain(of.next_back()).collect()
}
