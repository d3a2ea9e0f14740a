//! The perceptive schema: what a network makes of what is sensed. It commands nothing.

use jde_schema::Imports;
use jde_schema::prelude::*;

use crate::held::{Held, Stated};
use crate::mind::{Mind, Plain};

/// The most scores that are exported.
const MOST_SCORES: usize = 256;

/// Scores of what a network tells apart, in the order of its output.
#[derive(Clone, Copy, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Scores")]
pub(crate) struct Scores {
    /// As the network gives them.
    pub(crate) data: Seq<f32, MOST_SCORES>,
}

/// Exports what a network estimates: scores, a value, how unsure it is.
///
/// Without a value of something that it sees, or with a number that is not finite, it exports nothing.
#[derive(Describe)]
#[schema(perceptive, period = "100ms", budget = "20ms")]
pub struct Estimate {
    #[ports]
    stated: Stated,
    /// What the network sees, by the names of its file.
    #[imports(default = Plain::DEFAULT)]
    inputs: Imports<Plain>,
    /// The numbers of the output that the file names as scores.
    #[export]
    scores: Export<Scores>,
    /// The number that the file names as value.
    #[export]
    value: Export<f64>,
    /// How unsure the network is, in the unit of its file.
    #[export]
    doubt: Export<f64>,
    held: Held,
}

impl Schema for Estimate {
    fn awake(&mut self, cx: &Context) -> Result {
        self.held.awake(cx, &mut self.stated, &self.inputs, fits)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let mind = self.held.step(cx, &mut self.stated, &self.inputs, fits);
        let Some((mind, Ok(decision))) = mind.map(|mind| (mind, &mind.decided)) else {
            self.scores.retract(cx);
            self.value.retract(cx);
            self.doubt.retract(cx);
            return Ok(());
        };
        let scores = mind.runner.scores();
        if !scores.is_empty() {
            let data = Seq::from_slice(scores)?;
            self.scores.write(cx, Scores { data });
        }
        decision.doubt.inspect(|doubt| self.doubt.write(cx, *doubt));
        decision.value.inspect(|value| self.value.write(cx, *value));
        Ok(())
    }
}

/// Refuses a network with more scores than fit.
fn fits(mind: &Mind) -> Result<(), String> {
    match mind.runner.scores().len() {
        ..=MOST_SCORES => Ok(()),
        many => Err(format!("the network gives {many} scores, and {MOST_SCORES} fit")),
    }
}

impl Inspect for Estimate {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.stated.inspect(cx, &self.inputs, fits, problems);
    }
}
