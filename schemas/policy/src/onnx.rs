//! The motor schema. It proposes commands; the guards of its groups judge them as those of any schema.

use jde_schema::Imports;
use jde_schema::prelude::*;

use crate::held::{Held, Stated};
use crate::mind::{Mind, Plain, twist};

/// Drives by a learned policy: the network of an ONNX file, described by a text file.
///
/// It is ready while all that the policy sees has a value, the network gives finite numbers, and the policy knows enough.
/// Its urgency is how sure it is, from 0 to 1: 1 up to the doubt `certain` of the file. From `unsure` on it is not ready, until
/// it is certain again. It commands nothing of its own accord: the guards of its groups judge what it commands.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Onnx {
    #[ports]
    stated: Stated,
    /// What the policy sees, by the names of its file.
    #[imports(default = Plain::DEFAULT)]
    inputs: Imports<Plain>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    /// How unsure the policy is, in the unit of its file; none if the file states no doubt.
    #[export]
    doubt: Export<f64>,
    /// What the policy expects of the future; none if the file names no value.
    #[export]
    value: Export<f64>,
    held: Held,
    /// Whether it does not know what to do.
    is_unsure: bool,
}

impl Schema for Onnx {
    fn awake(&mut self, cx: &Context) -> Result {
        self.is_unsure = false;
        self.held.awake(cx, &mut self.stated, &self.inputs, commands)
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let mind = self.held.step(cx, &mut self.stated, &self.inputs, commands);
        let Some(Ok(decision)) = mind.map(|mind| &mind.decided) else {
            self.doubt.retract(cx);
            self.value.retract(cx);
            return Ok(false.into());
        };
        decision.doubt.inspect(|doubt| self.doubt.write(cx, *doubt));
        decision.value.inspect(|value| self.value.write(cx, *value));
        self.is_unsure = decision.leaves_unsure(self.is_unsure);
        Ok(Precondition::from(!self.is_unsure).urgency(decision.certainty))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let decision = self.held.mind().and_then(|mind| mind.decided.as_ref().ok());
        let Some([x, y, turn]) = decision.map(|decision| decision.command) else {
            self.base.command(cx, Twist::ZERO);
            return Ok(());
        };
        if self.base.command(cx, twist([x, y, turn])).accepted() {
            self.held.gave([x, y, turn]);
        }
        Ok(())
    }
}

/// Refuses a policy that only estimates.
fn commands(mind: &Mind) -> Result<(), String> {
    match (mind.policy.commands(), mind.policy.chunk()) {
        (_, Some(_)) => Err(
            "the policy has a [chunk]: policy/chunks makes chunks, and policy/steps drives by them"
                .to_owned(),
        ),
        (false, None) => Err(
            "the policy has no [[output]] and no [choices]; policy/estimate is for one that only judges"
                .to_owned(),
        ),
        (true, None) => Ok(()),
    }
}

impl Inspect for Onnx {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.stated.inspect(cx, &self.inputs, commands, problems);
    }
}

impl Onnx {
    /// Returns the policy, if it is awake.
    pub(crate) fn mind(&self) -> Option<&Mind> {
        self.held.mind()
    }

    /// Whether it does not know what to do.
    pub(crate) fn is_unsure(&self) -> bool {
        self.is_unsure
    }
}
