//! The perceptive schema that looks ahead: a network that gives commands of the near future. It commands nothing; a motor
//! schema gives each of them when it comes due.

use jde_schema::Imports;
use jde_schema::prelude::*;
use jde_schema::types::Chunk;

use crate::held::{Held, Stated};
use crate::mind::{Mind, Plain, twist};
use crate::steps::MOST_BLENDED;

/// Exports what a network decides ahead, as a chunk: for policy/steps, which drives by it.
///
/// The network may take longer than the time from one command to the next. A chunk has the time at which the network began to
/// look, so its commands come due as if it had taken no time.
#[derive(Describe)]
#[schema(perceptive, period = "500ms", budget = "300ms")]
pub struct Chunks {
    #[ports]
    stated: Stated,
    /// What the policy sees, by the names of its file.
    #[imports(default = Plain::DEFAULT)]
    inputs: Imports<Plain>,
    /// The commands, and when they come due. Each chunk has its own end, and no longer one is made.
    #[export(validity = "10s")]
    chunk: Export<Chunk>,
    /// How unsure the policy is, in the unit of its file; none if the file states no doubt.
    #[export]
    doubt: Export<f64>,
    /// What the policy expects of the future; none if the file names no value.
    #[export]
    value: Export<f64>,
    held: Held,
    /// Whether it does not know what to do.
    is_unsure: bool,
    /// When it decided last.
    decided: Option<Duration>,
}

impl Schema for Chunks {
    fn awake(&mut self, cx: &Context) -> Result {
        self.is_unsure = false;
        self.decided = None;
        self.held.awake(cx, &mut self.stated, &self.inputs, chunks)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let mind = self.held.step(cx, &mut self.stated, &self.inputs, chunks);
        let Some((mind, Ok(decision))) = mind.map(|mind| (mind, &mind.decided)) else {
            self.chunk.retract(cx);
            self.doubt.retract(cx);
            self.value.retract(cx);
            return Ok(());
        };
        decision.doubt.inspect(|doubt| self.doubt.write(cx, *doubt));
        decision.value.inspect(|value| self.value.write(cx, *value));
        self.is_unsure = decision.leaves_unsure(self.is_unsure);
        let (Some(rule), Some(seen)) = (mind.policy.chunk(), mind.decided_at()) else {
            return Ok(());
        };
        // A turn between two steps repeats the decision, which is as old as it is.
        if self.decided.replace(seen) == Some(seen) {
            return Ok(());
        }
        let mut chunk = self.chunk.loan(cx);
        chunk.padding = Padding::ZERO;
        chunk.spacing = rule.spacing;
        chunk.certainty = if self.is_unsure { 0.0 } else { decision.certainty };
        chunk.blend = rule.blend.unwrap_or(1.0);
        chunk.blended = rule
            .blend
            .map_or(0, |_| mind.decisions_before().min(MOST_BLENDED));
        let commands = mind.runner.commands();
        for (room, command) in chunk.commands.resize(commands.len()).iter_mut().zip(commands) {
            *room = twist(*command);
        }
        chunk.publish_at(seen);
        Ok(())
    }
}

/// Refuses a policy that decides one command at a time.
fn chunks(mind: &Mind) -> Result<(), String> {
    match mind.policy.chunk() {
        Some(_) => Ok(()),
        None => Err("the policy has no [chunk]: policy/onnx commands one step at a time".to_owned()),
    }
}

impl Inspect for Chunks {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.stated.inspect(cx, &self.inputs, chunks, problems);
    }
}
