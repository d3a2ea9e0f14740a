//! The trigger: a condition in the recorder's syntax. When it becomes true, the window moves to that moment
//! and shows what led to it. The recorder's own code evaluates the condition.

use std::sync::Arc;

use jde_conditions::{Condition, Firing, Names, Triggers};
use jde_link::message::{Schemas, VariableInfo};
use jde_records::RunRecord;
use jde_records::event::StateChange;
use jde_timeline::Timeline;
use serde::{Deserialize, Serialize};

use super::axis::Axis;

/// What the window does after the trigger fired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Mode {
    /// Follows the present again if the trigger does not fire for two widths of the window.
    #[default]
    Auto,
    /// Stays until the trigger fires again.
    Normal,
    /// Pauses.
    Single,
}

/// The state of the trigger.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum TriggerPhase {
    /// There is no condition.
    #[default]
    Off,
    /// Waits for the condition.
    Armed,
    /// Fired; the window fills with what follows.
    Fired { at: f64 },
    /// Fired in mode [`Mode::Single`] and does not fire again.
    Done { at: f64 },
}

/// The part of the trigger that is saved for the next start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct SavedTrigger {
    /// The condition.
    pub(super) text: String,
    pub(super) mode: Mode,
    /// The position of the moment in the window, from 0 to 1.
    pub(super) share: f64,
}

/// The trigger.
#[derive(Default)]
pub(super) struct Trigger {
    pub(super) saved: SavedTrigger,
    /// Why the text is not a condition.
    pub(super) trouble: Option<String>,
    phase: TriggerPhase,
    /// The last time in s at which it fired, and why.
    last: Option<(f64, String)>,
    watched: Option<Triggers>,
    processed: (u64, u64),
    names: Option<Names>,
}

impl Default for SavedTrigger {
    fn default() -> Self {
        Self {
            text: String::new(),
            mode: Mode::default(),
            share: 0.5,
        }
    }
}

impl Mode {
    pub(super) const ALL: [Self; 3] = [Self::Auto, Self::Normal, Self::Single];

    pub(super) fn label_and_hint(self) -> (&'static str, &'static str) {
        match self {
            Self::Auto => (
                "auto",
                "Follows the present again if the trigger does not fire for a while.",
            ),
            Self::Normal => ("normal", "Shows the last firing until the next one."),
            Self::Single => ("single", "Pauses at the first firing."),
        }
    }
}

impl Trigger {
    pub(super) fn new(saved: SavedTrigger) -> Self {
        Self {
            saved,
            ..Self::default()
        }
    }

    pub(super) fn phase(&self) -> &TriggerPhase {
        &self.phase
    }

    /// The last time in s at which it fired, and why.
    pub(super) fn last(&self) -> Option<&(f64, String)> {
        self.last.as_ref()
    }

    /// Parses the text as the condition and arms the trigger. An empty text switches it off.
    pub(super) fn arm(&mut self, schemas: &Schemas, variables: &[VariableInfo], timeline: &Timeline) {
        (self.trouble, self.watched, self.phase) = (None, None, TriggerPhase::Off);
        let text = self.saved.text.trim();
        if text.is_empty() {
            return;
        }
        let names = self.names.get_or_insert_with(|| names(schemas, variables));
        match Condition::new(text, names) {
            Ok(condition) => {
                let mut watched = Triggers::new(names.clone(), vec![condition]);
                for schema in &names.schemas {
                    if let Some(last) = timeline.schema(schema).and_then(|known| known.states.last()) {
                        let known = StateChange {
                            time: last.from,
                            schema: schema.clone(),
                            from: last.value,
                            to: last.value,
                        };
                        watched.process_record(&RunRecord::State(known), &mut Vec::new());
                    }
                }
                (self.watched, self.processed) = (Some(watched), position(timeline));
                self.rearm(timeline);
            }
            Err(error) => self.trouble = Some(error.to_string()),
        }
    }

    /// Arms the trigger for lines from now on.
    pub(super) fn rearm(&mut self, timeline: &Timeline) {
        if self.watched.is_some() {
            self.process_lines(timeline);
            self.phase = TriggerPhase::Armed;
        }
    }

    /// Passes the new lines to the condition. Returns its firings.
    fn process_lines(&mut self, timeline: &Timeline) -> Vec<Firing> {
        let (before, now) = (self.processed, position(timeline));
        self.processed = now;
        let mut fired = Vec::new();
        if let Some(watched) = self.watched.as_mut().filter(|_| now.0 == before.0) {
            for line in timeline.log().since(before.1) {
                watched.process_record(&line, &mut fired);
            }
        }
        fired
    }

    /// The variables whose values [`Self::step`] needs.
    pub(super) fn variables(&self) -> Vec<String> {
        let watched = self.watched.iter().flat_map(Triggers::variables);
        watched.map(str::to_owned).collect()
    }

    /// Evaluates the new lines and values, and moves the window if the trigger fires. Returns that time in s.
    /// Each value is its time in ns, its variable and its bytes; `now` is in ns.
    pub(super) fn step(
        &mut self,
        timeline: &Timeline,
        values: &[(u64, &str, Option<&[u8]>)],
        now: u64,
        axis: &mut Axis,
    ) -> Option<f64> {
        let mut fired = self.process_lines(timeline);
        let watched = self.watched.as_mut()?;
        for &(time, variable, bytes) in values {
            match bytes {
                Some(bytes) => watched.process_value(time, variable, bytes, &mut fired),
                None => watched.process_retraction(time, variable, &mut fired),
            }
        }
        watched.advance(now, &mut fired);
        let now = now as f64 / 1e9;
        if let TriggerPhase::Fired { at } = self.phase
            && now >= at + (1.0 - self.saved.share) * axis.span()
        {
            match self.saved.mode {
                Mode::Single => {
                    self.phase = TriggerPhase::Done { at };
                    axis.pause(now);
                }
                Mode::Auto | Mode::Normal => self.phase = TriggerPhase::Armed,
            }
        }
        // While paused, only the user moves the window.
        if axis.is_paused() {
            return None;
        }
        match (&self.phase, fired.into_iter().next()) {
            (TriggerPhase::Armed, Some(firing)) => {
                let at = firing.time as f64 / 1e9;
                self.last = Some((at, firing.text));
                self.phase = TriggerPhase::Fired { at };
                axis.show_at(at, self.saved.share);
                return Some(at);
            }
            (TriggerPhase::Armed, None) if self.saved.mode == Mode::Auto && !axis.is_live() => {
                let quiet = self
                    .last
                    .as_ref()
                    .is_none_or(|(at, _)| now > at + 2.0 * axis.span());
                if quiet {
                    axis.follow();
                }
            }
            _ => {}
        }
        None
    }
}

/// How often the time went back, and how many records have arrived.
fn position(timeline: &Timeline) -> (u64, u64) {
    (timeline.rewinds(), timeline.log().received())
}

fn names(schemas: &Schemas, variables: &[VariableInfo]) -> Names {
    let typed =
        |variable: &VariableInfo| Some((variable.name.clone(), Arc::new(variable.value_type().ok()?)));
    Names {
        schemas: schemas.schemas.iter().map(|schema| schema.name.clone()).collect(),
        groups: schemas.groups.iter().map(|group| group.name.clone()).collect(),
        variables: variables.iter().filter_map(typed).collect(),
        seed: None,
    }
}

#[cfg(test)]
mod tests {
    use jde_core::{Case, State};

    use super::super::fixture::{self, Fixed};
    use super::*;

    fn armed(text: &str, mode: Mode) -> (Trigger, Fixed, Axis) {
        let fixed = fixture::navigation();
        let mut trigger = Trigger::new(SavedTrigger {
            text: text.to_owned(),
            mode,
            share: 0.2,
        });
        trigger.arm(&fixed.schemas, &[], &fixed.timeline);
        (trigger, fixed, Axis::new(10.0))
    }

    fn collide(fixed: &mut Fixed, number: u64, time: f64) {
        for (number, case) in [(number, Case::Alone), (number + 1, Case::Collision)] {
            let selection = fixture::selection(number, time, "example/base", Some("goon"), "vff", case);
            fixed.timeline.add(&RunRecord::Decision(selection));
        }
    }

    #[test]
    fn earlier_events_do_not_fire_a_trigger_that_is_armed_later() {
        let (mut trigger, fixed, mut axis) = armed("conflict", Mode::Auto);
        trigger.step(&fixed.timeline, &[], 10_000_000_000, &mut axis);
        assert_eq!(trigger.phase(), &TriggerPhase::Armed);
        assert!(axis.is_live());
    }

    #[test]
    fn a_firing_is_shown_at_its_share_of_the_window_and_the_trigger_rearms_when_the_window_is_full() {
        let (mut trigger, mut fixed, mut axis) = armed("conflict:example/base", Mode::Normal);
        collide(&mut fixed, 10, 11.0);
        trigger.step(&fixed.timeline, &[], 11_050_000_000, &mut axis);
        assert_eq!(trigger.phase(), &TriggerPhase::Fired { at: 11.0 });
        let scale = axis.scale(11.05, eframe::egui::Rangef::new(0.0, 100.0));
        assert!((scale.x(11.0) - 20.0).abs() < 1e-3);
        // While the window fills, the condition does not fire again.
        collide(&mut fixed, 12, 12.0);
        trigger.step(&fixed.timeline, &[], 12_000_000_000, &mut axis);
        assert_eq!(trigger.last().expect("the trigger fired").0, 11.0);
        trigger.step(&fixed.timeline, &[], 19_000_000_000, &mut axis);
        assert_eq!(trigger.phase(), &TriggerPhase::Armed);
        assert!(!axis.is_live(), "in mode normal, the window stays");
    }

    #[test]
    fn mode_auto_returns_to_the_present_and_mode_single_pauses() {
        let (mut auto, mut fixed, mut axis) = armed("conflict", Mode::Auto);
        collide(&mut fixed, 10, 11.0);
        for time in [11, 20, 32] {
            auto.step(&fixed.timeline, &[], time * 1_000_000_000, &mut axis);
        }
        assert!(axis.is_live());

        let (mut single, mut fixed, mut axis) = armed("conflict", Mode::Single);
        collide(&mut fixed, 10, 11.0);
        for time in [11, 20, 32] {
            single.step(&fixed.timeline, &[], time * 1_000_000_000, &mut axis);
        }
        assert_eq!(single.phase(), &TriggerPhase::Done { at: 11.0 });
        assert!(axis.is_paused());
    }

    #[test]
    fn an_invalid_condition_is_refused_with_the_nearest_name() {
        let (trigger, ..) = armed("conflit", Mode::Auto);
        let trouble = trigger.trouble.as_deref().unwrap_or_default();
        assert!(trouble.contains("did you mean `conflict`?"), "{trouble}");
        assert_eq!(trigger.phase(), &TriggerPhase::Off);
        let (trigger, ..) = armed("conflict:example/bose", Mode::Auto);
        let trouble = trigger.trouble.as_deref().unwrap_or_default();
        assert!(trouble.contains("`example/base`"), "{trouble}");
    }

    #[test]
    fn states_before_the_trigger_is_armed_are_known_and_later_ones_fire_it() {
        let (mut trigger, mut fixed, mut axis) = armed("goon.won and not vff.won", Mode::Normal);
        let win = |fixed: &mut Fixed, schema: &str, to: State| {
            let change = StateChange {
                time: 11_000_000_000,
                schema: schema.to_owned(),
                from: State::Ready,
                to,
            };
            fixed.timeline.add(&RunRecord::State(change));
        };
        win(&mut fixed, "vff", State::Winner);
        win(&mut fixed, "goon", State::Winner);
        trigger.arm(&fixed.schemas, &[], &fixed.timeline);
        trigger.step(&fixed.timeline, &[], 11_500_000_000, &mut axis);
        assert_eq!(trigger.phase(), &TriggerPhase::Armed, "vff has won");
        win(&mut fixed, "vff", State::Ready);
        trigger.step(&fixed.timeline, &[], 12_000_000_000, &mut axis);
        assert!(matches!(trigger.phase(), TriggerPhase::Fired { .. }));
    }
}
