//! Whether a target can be reached: for how long no way has led there. It plans nothing.

use jde_schema::prelude::*;

use crate::situation::Situation;

/// The judgement of the present target.
#[derive(Default)]
pub(crate) struct Verdict {
    target: Option<Pose2D>,
    /// Since when no way has led there, or when that was last said.
    since: Option<Duration>,
    /// What was last said: a state of a mission.
    said: Option<u8>,
}

impl Verdict {
    /// Returns what is to be said: RUNNING for a new target or one that has a way again, FAILED each time that no way has
    /// led there for `patience`; `None` if nothing is new.
    pub(crate) fn judge(
        &mut self,
        target: Pose2D,
        situation: &Situation,
        now: Duration,
        patience: Duration,
    ) -> Option<u8> {
        if self.target.replace(target) != Some(target) {
            (self.since, self.said) = (None, None);
        }
        if !situation.is_without_way() {
            self.since = None;
            return self.say(Mission::RUNNING);
        }
        let since = *self.since.get_or_insert(now);
        if now.saturating_sub(since) < patience {
            return self.said.is_none().then(|| self.say(Mission::RUNNING)).flatten();
        }
        self.since = Some(now);
        self.said = None;
        self.say(Mission::FAILED)
    }

    fn say(&mut self, state: u8) -> Option<u8> {
        (self.said.replace(state) != Some(state)).then_some(state)
    }
}
