//! A father whose children act one after another, each within a time and with some further tries. It arbitrates nothing and
//! commands nothing.

use jde_schema::prelude::*;

/// Lets its children act one after another, in the order in which the application names them.
///
/// Only the present one is awake. It is done when it has acted and has not been READY since for `settle`. A try fails when
/// `timeout` is over, or without a timeout when the child becomes Faulted; the next try then waits until it no longer is. After
/// the last try the mission has failed, and after the last child it is done. Then the schema is not READY, so that a sibling
/// acts. A try that is interrupted, because a sibling of this schema acts, begins again.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "5ms")]
pub struct Steps {
    /// The longest time of a try; 0 for none.
    #[modulation(default = 0.0, unit = "s", min = 0.0)]
    timeout: Modulation<f64>,
    /// How often a child is tried again that has failed.
    #[modulation(default = 0)]
    retries: Modulation<u32>,
    /// How long a child that has acted is not READY before it is done: longer than the retry of its guard.
    #[modulation(default = 0.6, unit = "s", min = 0.0)]
    settle: Modulation<f64>,
    /// Whether the first child follows the last.
    #[modulation(default = Flag::FALSE)]
    repeat: Modulation<Flag>,
    /// The progress. A target is a child.
    #[export(lasting)]
    mission: Export<Mission>,
    /// The children, in their order.
    #[child(group = "step")]
    steps: Children,
    present: usize,
    attempt: Attempt,
    state: u8,
}

/// A try of a child.
#[derive(Clone, Copy, Debug, Default)]
struct Attempt {
    /// How many there were before.
    before: u32,
    /// When it began; `None` before that.
    since: Option<Duration>,
    acted: bool,
    /// Since when the child has not been READY, after it has acted.
    idle: Option<Duration>,
    /// Whether the child was Faulted in the last turn: each fault ends one try.
    was_faulted: bool,
}

impl Schema for Steps {
    fn awake(&mut self, _: &Context) -> Result {
        self.attempt = self.attempt.again();
        Ok(())
    }

    fn check(&mut self, _: &Context) -> Result<Precondition> {
        Ok((self.state == Mission::RUNNING).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let children: Vec<_> = self.steps.iter(cx).collect();
        if children.is_empty() {
            self.state = Mission::DONE;
        }
        // While a sibling acts, the children sleep, but this schema stays awake (R5).
        let present = children.get(self.present).and_then(|child| child.status(cx));
        if present.is_some_and(|status| status.state == State::Slept && !status.faulted) {
            self.attempt = self.attempt.again();
        }
        for (place, child) in children.iter().enumerate() {
            if place == self.present {
                child.wake(cx);
            } else if child.state(cx) != State::Slept {
                child.sleep(cx);
            }
        }
        if let Some(child) = children.get(self.present) {
            match self
                .attempt
                .end(cx, child, self.timeout.get(cx), self.settle.get(cx))
            {
                None => {}
                Some(Ok(())) => {
                    child.sleep(cx);
                    self.present += 1;
                    self.attempt = Attempt::default();
                    if self.present == children.len() && bool::from(self.repeat.get(cx)) {
                        self.present = 0;
                    } else if self.present == children.len() {
                        self.state = Mission::DONE;
                    }
                }
                Some(Err(reason)) => {
                    // Whoever acts next finds it asleep, and a further try begins anew.
                    child.sleep(cx);
                    self.attempt = Attempt {
                        before: self.attempt.before + 1,
                        ..self.attempt.again()
                    };
                    warn!(
                        cx,
                        "step {}: {reason}, try {}",
                        self.present + 1,
                        self.attempt.before
                    );
                    if self.attempt.before > self.retries.get(cx) {
                        self.state = Mission::FAILED;
                    }
                }
            }
        }
        self.publish(cx, children.len());
        Ok(())
    }
}

impl Steps {
    fn publish(&mut self, cx: &Context, total: usize) {
        let (step, tries) = (self.present + 1, self.attempt.before);
        let note = match (self.state, tries) {
            (Mission::DONE, _) => String::from("all steps are done"),
            (Mission::FAILED, _) => format!("step {step} of {total} has failed, {tries} tries"),
            (_, 0) => format!("step {step} of {total}"),
            (_, _) => format!("step {step} of {total}, try {}", tries + 1),
        };
        let mission = Mission {
            state: self.state,
            reached: self.present as u32,
            total: total as u32,
            note: Text::truncated(&note),
            ..Mission::default()
        };
        self.mission.write(cx, mission);
    }
}

impl Attempt {
    /// Returns this try as it is before it begins.
    fn again(self) -> Self {
        Self {
            before: self.before,
            was_faulted: self.was_faulted,
            ..Self::default()
        }
    }

    /// Returns whether it has ended, and how.
    fn end(
        &mut self,
        cx: &Context,
        child: &Child,
        timeout: f64,
        settle: f64,
    ) -> Option<Result<(), &'static str>> {
        let now = cx.now();
        let took = |since: Duration| now.saturating_sub(since).as_secs_f64();
        let since = *self.since.get_or_insert(now);
        let status = child.status(cx)?;
        let is_new_fault = status.faulted && !self.was_faulted;
        self.was_faulted = status.faulted;
        match status.state {
            State::Winner => (self.acted, self.idle) = (true, None),
            State::Ready => self.idle = None,
            State::Checking if self.acted => {
                let idle = *self.idle.get_or_insert(now);
                if took(idle) >= settle {
                    return Some(Ok(()));
                }
            }
            State::Checking => {}
            // It is Faulted, or an operator stops it. What it did before does not count.
            State::Slept => (self.acted, self.idle) = (false, None),
        }
        if timeout > 0.0 && took(since) >= timeout {
            return Some(Err("it took too long"));
        }
        (timeout == 0.0 && is_new_fault).then_some(Err("it faulted"))
    }
}

jde_schema::export!(
    "sequence",
    "A father whose children act one after another.",
    [Steps]
);

#[cfg(test)]
mod tests;
