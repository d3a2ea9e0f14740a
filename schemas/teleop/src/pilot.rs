//! A person who has both base and head: the father of the two. It commands nothing itself.

use jde_schema::prelude::*;

use crate::wish::{Drive, Look, counts};

/// Gives a person the base and the head of a robot at once.
///
/// It is ready while anything is wanted of either. Roots are one group, of which one schema acts; this one has two groups below
/// it, so that whoever drives can look around, and whoever looks around lets the base stand.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Pilot {
    /// What is wanted of the base: the modulation `want` of the child.
    #[import]
    drive: Import<Drive>,
    /// What is wanted of the head: the modulation `want` of the child.
    #[import]
    look: Import<Look>,
    /// How old a wish may be and still count; as long as that of the children.
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
        let drives = drive.is_some_and(|wish| counts(cx, wish.wanted, wish.time(), patience));
        let looks = look.is_some_and(|wish| counts(cx, wish.wanted, wish.time(), patience));
        Ok((drives || looks).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.wake(cx);
        self.head.wake(cx);
        Ok(())
    }
}

impl Arbitrate for Pilot {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        // Asked where nobody is ready, for each group has one child: the base may be driving still as its last schema had it.
        Ok(if level.candidate(&self.base).is_some() {
            Verdict::choose(&self.base, "nothing is wanted of the base, so it stands")
        } else {
            Verdict::nobody("nothing is wanted of the head")
        })
    }
}
