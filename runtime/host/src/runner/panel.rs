//! A schema's own panel, in its own turns: drawn after an iteration or check while it is viewed, and touched
//! before the next. The rate is measured by the machine's clock, in lockstep too: decisions never depend on a
//! viewer.

use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_records::turn::TurnKind;

use super::Runner;
use super::deadlines::Work;
use super::phase::Phase;

impl Runner {
    /// Delivers the first of the waiting gestures. The next has another turn, so that urgent work waits for
    /// at most one (R17).
    pub(super) fn take_gesture(&mut self) {
        let Some((by, gesture)) = self.engine.take_gesture(self.number) else {
            return;
        };
        let Some(instance) = self.phase.instance() else {
            return self.engine.report_undelivered(self.number, 1);
        };
        let number = self.engine.report_gesture(&by, self.number, &gesture);
        self.record.begin(TurnKind::Touched { number });
        let result = instance.touch(&by, &gesture);
        self.record.add_look(instance);
        if let Err(reason) = result {
            self.fault(reason);
        }
        self.record.finish();
    }

    /// Draws the panel from the values read in this turn, if it is viewed and the time has come. In real time
    /// the drawing has the budget of an iteration, on which the contract relies (R17): a drawing that took
    /// longer is not shown.
    pub(super) fn draw(&mut self) {
        let Some(every) = self.engine.panels.requested_interval(self.number) else {
            return self.record_no_drawing();
        };
        let start = Instant::now();
        let Some(instance) = self.phase.instance() else {
            return;
        };
        if self.pace.wait(start).is_some() {
            return;
        }
        let Some(mut list) = instance.draw() else {
            return;
        };
        let took = start.elapsed();
        self.pace.record_drawing(start, took, every);
        let in_time = !self.engine.clock.is_real()
            || self.record_drawing_time(self.engine.clock.scale_machine_time(took));
        if !in_time && list.is_ok() {
            let budget = Duration::from_nanos(self.budget());
            list = Err(format!(
                "drawing took {took:.1?}, more than the schema's budget of {budget:.1?}"
            ));
        }
        let time = self.engine.clock.now();
        let failed = list.as_ref().err().cloned();
        self.engine.panels.publish(self.number, time, took, list);
        if let Some(reason) = failed {
            self.handle_failed_call(&reason);
        }
    }

    /// Draws the panel of a sleeping schema from the newest values. Returns when to draw it again, in real
    /// time.
    pub(crate) fn draw_asleep(&mut self) -> Option<Nanos> {
        if !matches!(self.phase, Phase::Slept(_)) {
            return None;
        }
        if self.engine.panels.requested_interval(self.number).is_none() {
            self.record_no_drawing();
            return None;
        }
        self.draw();
        if let Phase::Slept(installed) = &mut self.phase {
            installed.instance.release_values();
        }
        let clock = &self.engine.clock;
        let wait = self.pace.wait(Instant::now()).unwrap_or_default();
        Some(clock.now().saturating_add(clock.scale_machine_time(wait)))
    }

    /// Records the duration of a drawing. Returns whether it kept to the budget, on which the contract relies
    /// (R17).
    fn record_drawing_time(&mut self, took: Nanos) -> bool {
        let late = took > self.budget();
        let begun = self.engine.clock.now().saturating_sub(took);
        self.record_lateness(Work::Drawing, begun, took, late);
        !late
    }

    /// Records that nothing is drawn, which is never late.
    fn record_no_drawing(&mut self) {
        if self.lateness.is_late(Work::Drawing) {
            self.record_lateness(Work::Drawing, 0, 0, false);
        }
    }
}
