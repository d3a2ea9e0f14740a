//! The panels: what the policy decided, or which command came due, or why none.

use jde_schema::prelude::*;
use jde_schema::types::ChunkStep;

use crate::onnx::Onnx;
use crate::steps::Steps;

impl Panel for Onnx {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        let Some(mind) = self.mind() else {
            pen.text("It has no policy");
            return;
        };
        match &mind.decided {
            Err(words) => pen.text(format!("It does not decide: {words}")),
            Ok(decision) => {
                let [x, y, turn] = decision.command;
                pen.text(if self.is_unsure() {
                    "It does not know what to do here"
                } else {
                    "It knows what to do here"
                });
                if let Some(choice) = decision.choice {
                    pen.text(format!("It chose command {choice}"));
                }
                pen.value("Ahead", x, "m/s");
                pen.value("To the left", y, "m/s");
                pen.value("Turn rate", turn, "rad/s");
                pen.value("Sure", decision.certainty, "1");
            }
        }
        pen.text(format!("Network {}", &mind.runner.hash()[..12]));
    }
}

impl Panel for Steps {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        match self.decided() {
            Err(words) => pen.text(format!("It commands nothing: {words}")),
            Ok(step) => {
                let ChunkStep {
                    chunk,
                    step,
                    steps,
                    age,
                    ..
                } = step;
                pen.text(format!(
                    "Step {step} of {steps} of chunk {chunk}, seen {age:.2} s before"
                ));
            }
        }
    }
}
