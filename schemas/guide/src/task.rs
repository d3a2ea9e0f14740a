//! A task: since when and why it is due, and how often it was done.

use jde_schema::prelude::*;

/// A task of the guide.
#[derive(Debug, Default)]
pub(crate) struct Task {
    due: Option<Due>,
    done: u32,
}

#[derive(Debug)]
struct Due {
    since: Duration,
    reason: String,
    /// When its child was READY last.
    ready_at: Duration,
}

impl Task {
    pub(crate) fn is_due(&self) -> bool {
        self.due.is_some()
    }

    /// Returns why it is due.
    pub(crate) fn reason(&self) -> Option<&str> {
        self.due.as_ref().map(|due| due.reason.as_str())
    }

    /// Returns how often it was done.
    pub(crate) fn done(&self) -> u32 {
        self.done
    }

    pub(crate) fn set_done(&mut self, done: u32) {
        self.done = done;
    }

    /// Makes it due.
    pub(crate) fn begin(&mut self, cx: &Context, reason: &str) {
        info!(cx, "{reason}");
        self.due = Some(Due {
            since: cx.now(),
            reason: reason.to_owned(),
            ready_at: cx.now(),
        });
    }

    /// Ends it, if it is due, and counts it if it was done.
    pub(crate) fn end(&mut self, cx: &Context, is_done: bool, words: &str) {
        let Some(due) = self.due.take() else { return };
        if is_done {
            self.done += 1;
            info!(cx, "done: {}; {words}", due.reason);
        } else {
            warn!(cx, "given up: {}; {words}", due.reason);
        }
    }

    /// Returns what has become of it since it is due: done, or failed for a reason. `None` while it is under way.
    pub(crate) fn outcome(&self, mission: &Import<Mission>, cx: &Context) -> Option<Result<(), String>> {
        outcome(mission, cx, self.due.as_ref()?.since)
    }

    /// Returns whether its child has not been READY for `patience`.
    pub(crate) fn is_stuck(&mut self, now: Duration, is_ready: bool, patience: Duration) -> bool {
        let Some(due) = &mut self.due else {
            return false;
        };
        if is_ready {
            due.ready_at = now;
        }
        now.saturating_sub(due.ready_at) > patience
    }
}

/// Returns how a mission has ended after `since`. An older value is of an earlier time that the task was due.
pub(crate) fn outcome(
    mission: &Import<Mission>,
    cx: &Context,
    since: Duration,
) -> Option<Result<(), String>> {
    let mission = mission.get(cx).filter(|mission| mission.time() > since)?;
    match mission.state {
        Mission::DONE => Some(Ok(())),
        Mission::FAILED => Some(Err(mission.note.as_str().to_owned())),
        _ => None,
    }
}
