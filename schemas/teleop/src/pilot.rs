//! The father of a person's base and head. It commands no actuator itself.

use jde_schema::prelude::*;

use crate::setpoint::{Drive, Look, is_in_force};

/// Lets a person drive the base and turn the head at the same time.
///
/// It is ready while there is a wish for either. The roots are one group, in which one schema wins; this
/// father has two groups, so that a person who drives can look around, and the base stands still for a person
/// who only looks around.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Pilot {
    /// The wish for the base: the modulation `want` of the child.
    #[import]
    drive: Import<Drive>,
    /// The wish for the head: the modulation `want` of the child.
    #[import]
    look: Import<Look>,
    /// Oldest wish that counts; equal to that of the children.
    #[modulation(default = 0.5, unit = "s", min = 0.05, max = 10.0)]
    patience: Modulation<f64>,
    /// Drives the base.
    #[child(group = "base")]
    base: Child,
    /// Turns the head.
    #[child(group = "head")]
    head: Child,
}

impl Schema for Pilot {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let patience = self.patience.get(cx);
        let drive = self.drive.get(cx);
        let look = self.look.get(cx);
        let drive_wish = drive.is_some_and(|wish| is_in_force(cx, wish.wanted, wish.time(), patience));
        let head_wish = look.is_some_and(|wish| is_in_force(cx, wish.wanted, wish.time(), patience));
        Ok((drive_wish || head_wish).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.wake(cx);
        self.head.wake(cx);
        Ok(())
    }
}

impl Arbitrate for Pilot {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        // Each group has one child, so this call occurs only when no child is READY. The base may still
        // execute the command of its previous schema; choosing `base` stops it.
        Ok(if level.candidate(&self.base).is_some() {
            Verdict::choose(&self.base, "nothing is wanted of the base, so it stands")
        } else {
            Verdict::nobody("nothing is wanted of the head")
        })
    }
}
