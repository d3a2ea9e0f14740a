//! A task: since when and why it is due, and how often it was done.

use jde_schema::prelude::*;

use crate::wait::Wait;

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
    wait: Wait,
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
        self.resume(cx, reason);
    }

    /// Makes it due again, as before a reload.
    pub(crate) fn resume(&mut self, cx: &Context, reason: &str) {
        self.due = Some(Due {
            since: cx.now(),
            reason: reason.to_owned(),
            wait: Wait::begin(cx.now()),
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

    /// Returns what has become of it since it is due, at `place` if it has one: done, or failed for a reason. `None` while
    /// it is under way.
    pub(crate) fn outcome(
        &self,
        cx: &Context,
        mission: &Import<Mission>,
        place: Option<&Pose2D>,
    ) -> Option<Result<(), String>> {
        outcome(cx, mission, self.due.as_ref()?.since, place)
    }

    /// Returns whether its child has been awake for `patience` without being READY.
    pub(crate) fn is_stuck(&mut self, cx: &Context, child: &Child, patience: Duration) -> bool {
        let due = self.due.as_mut();
        due.is_some_and(|due| due.wait.ends(cx, child, false, patience))
    }

    /// Begins anew to wait for its child.
    pub(crate) fn wait_anew(&mut self, now: Duration) {
        if let Some(due) = &mut self.due {
            due.wait = Wait::begin(now);
        }
    }
}

/// Returns how a mission has ended after `since`, at `place` if it has one. An older value, or one for another place, is of
/// something else.
pub(crate) fn outcome(
    cx: &Context,
    mission: &Import<Mission>,
    since: Duration,
    place: Option<&Pose2D>,
) -> Option<Result<(), String>> {
    let mission = mission.get(cx).filter(|mission| mission.time() > since)?;
    if place.is_some_and(|place| mission.target != *place) {
        return None;
    }
    match mission.state {
        Mission::DONE => Some(Ok(())),
        Mission::FAILED => Some(Err(mission.note.as_str().to_owned())),
        _ => None,
    }
}
