//! The hierarchy oscilloscope: the states of all schemas over time, the winners, and the reasons of switches.
//! An operator acts on the same rows.
//!
//! It refuses to decide: each input becomes a request to the application, whose reply is shown.

mod axis;
mod bands;
mod bar;
mod body;
mod cells;
mod chart;
mod columns;
mod cursors;
mod event_signs;
pub(crate) mod field;
#[cfg(test)]
pub(crate) mod fixture;
mod group;
mod input;
mod keys;
mod operate;
mod paint;
mod period;
mod pointer;
mod rows;
mod ruler;
mod signal;
mod signals;
pub(crate) mod source;
mod strips;
mod switches;
mod table;
mod traces;
mod trigger;
mod why;

use std::collections::BTreeSet;
use std::time::Instant;

use eframe::egui;
use eframe::egui::{Panel, Rangef};
use jde_link::Rate;
use jde_link::message::VariableInfo;
use serde::{Deserialize, Serialize};

use super::Window;
use crate::recorded::Recorded;
use crate::session::{STEERING, WindowSession};
use crate::style::Style;
use axis::Axis;
use cursors::Cursors;
use input::Input;
pub(crate) use input::Request;
use period::Period;
use rows::Filter;
use signals::Signals;
use trigger::{SavedTrigger as KeptTrigger, Trigger};
use why::SwitchDetails;

/// Rate of the values for traces and conditions.
const RATE: Rate = Rate::Hz(50);

/// Height of the actions on the selected schema in one line, in points.
const OPERATE_HEIGHT: f32 = 40.0;

/// Greatest delay of a position of a recording, s.
const MAX_DELAY_S: f64 = 0.25;

/// The window.
pub(crate) struct Scope {
    axis: Axis,
    filter: Filter,
    folded: BTreeSet<String>,
    signals: Signals,
    trigger: Trigger,
    cursors: Cursors,
    why: SwitchDetails,
    editing: Period,
    /// The selected schema.
    selected: Option<String>,
    /// Fraction of the width that the table takes.
    share: f32,
    /// Scroll offset of the rows, in points.
    scrolled: f32,
    /// The height that all rows and traces need, in points.
    needed: f32,
    /// Whether the traces have the keyboard focus, and their keys act.
    focused: bool,
    /// Whether the selected schema has a row, and the keys act on it.
    has_row: bool,
    /// The height that the actions on the selected schema need, in points.
    operate_height: f32,
    /// Scroll to the row of the selected schema.
    reveal: bool,
    /// The last position of a recording, and when it was read.
    played: Option<(f64, Instant)>,
    /// Number of schemas that the filter hides.
    left_out: usize,
    /// Saved state that is restored with the first frame, once the variables are known.
    waiting: Option<SavedState>,
}

/// The state saved for the next start.
#[derive(Debug, Serialize, Deserialize)]
#[serde(default)]
struct SavedState {
    span: f64,
    share: f32,
    filter: Filter,
    folded: BTreeSet<String>,
    traces: Vec<String>,
    trigger: KeptTrigger,
    cursors: Cursors,
}

impl Default for SavedState {
    fn default() -> Self {
        Self {
            span: 20.0,
            share: 0.52,
            filter: Filter::default(),
            folded: BTreeSet::new(),
            traces: Vec::new(),
            trigger: KeptTrigger::default(),
            cursors: Cursors::default(),
        }
    }
}

impl Scope {
    /// Opens the window with its saved state.
    pub(crate) fn open(saved: &serde_json::Value) -> Self {
        // State saved by another version may be unreadable; the defaults are used then.
        let mut saved: SavedState = serde_json::from_value(saved.clone()).unwrap_or_default();
        Self {
            axis: Axis::new(saved.span),
            filter: std::mem::take(&mut saved.filter),
            folded: std::mem::take(&mut saved.folded),
            signals: Signals::default(),
            trigger: Trigger::new(saved.trigger.clone()),
            cursors: saved.cursors,
            why: SwitchDetails::default(),
            editing: Period::default(),
            selected: None,
            share: saved.share.clamp(0.2, 0.8),
            scrolled: 0.0,
            needed: f32::INFINITY,
            focused: false,
            has_row: false,
            operate_height: OPERATE_HEIGHT,
            reveal: false,
            played: None,
            left_out: 0,
            waiting: Some(saved),
        }
    }

    /// Draws the window. Returns the user's requests.
    fn draw(
        &mut self,
        ui: &mut egui::Ui,
        seen: &Input<'_>,
        variables: &[VariableInfo],
        style: &Style,
    ) -> Vec<Request> {
        let mut requests = Vec::new();
        self.axis.set_end(seen.end_s);
        let scale = self.axis.scale(seen.now(), Rangef::new(0.0, 1.0));
        self.bar(ui, seen, variables, &scale, style);
        let height = ui.available_height();
        // The rows take what they need. What they leave is not empty: the reasons take it.
        let most = (height - 120.0).max(41.0);
        let least = (height - self.needed - self.operate_height).clamp(40.0, most);
        let reason_panel = Panel::bottom(ui.scope_id().with("why"))
            .resizable(true)
            .default_size((height * 0.36).clamp(100.0, 200.0).max(least))
            .size_range(least..=most)
            .frame(egui::Frame::NONE.inner_margin(egui::Margin {
                top: 4,
                ..egui::Margin::ZERO
            }));
        let shown = reason_panel.show(ui, |ui| self.why.show(ui, seen, style)).inner;
        if let Some(time) = shown {
            self.go_to(time, seen, &mut requests);
        }
        Panel::bottom(ui.scope_id().with("operate"))
            .exact_size(self.operate_height)
            .frame(egui::Frame::NONE)
            .show(ui, |ui| self.operate(ui, seen, &mut requests));
        egui::CentralPanel::no_frame().show(ui, |ui| self.body(ui, seen, style, &mut requests));
        requests
    }

    /// Shows a time. A recording goes on from there.
    fn go_to(&mut self, time: f64, seen: &Input<'_>, requests: &mut Vec<Request>) {
        match seen.is_recording {
            true => {
                self.axis.follow();
                requests.push(Request::Seek(time));
            }
            false => self.axis.reveal(time, seen.now()),
        }
    }

    fn run_or_pause(&mut self, seen: &Input<'_>) {
        if self.axis.is_paused() {
            self.axis.follow();
            self.trigger.rearm(seen.timeline);
        } else {
            self.axis.pause(seen.now());
        }
    }

    /// Whether the position of a recording has changed by more than what was played since the last call.
    fn jumps(&mut self, session: &WindowSession) -> bool {
        let (now, instant) = (session.now(), Instant::now());
        let (before, then) = self.played.replace((now, instant)).unwrap_or((now, instant));
        let speed = session.read::<f64>(&format!("{STEERING}.speed"), Rate::Hz(1));
        let speed = speed.map_or(1.0, |(speed, _)| speed.max(1.0));
        // The position arrives 20 times a second.
        (now - before).abs() > speed * ((instant - then).as_secs_f64() + MAX_DELAY_S)
    }

    /// Reads the new values of the traces and of the trigger.
    fn read_values(&mut self, session: &WindowSession) {
        let jumped = session.is_recording() && self.jumps(session);
        for signal in self.signals.list.iter_mut().flat_map(|chart| &mut chart.signals) {
            if let Some(recorded) = session.recorded() {
                signal.whole = recorded.curve(&signal.name, &signal.source);
            }
            if jumped {
                signal.interrupt();
            }
            let variables = signal.source.variables();
            let mut samples = Vec::new();
            for variable in &variables {
                let values = session.values(variable, RATE, &signal.name);
                samples.extend(values.into_iter().map(|sample| (sample, variable)));
            }
            samples.sort_by_key(|(sample, _)| sample.time);
            for (sample, variable) in samples {
                signal.take(sample.time as f64 / 1e9, variable, sample.bytes.as_deref());
            }
        }
        let variables = self.trigger.variables();
        let mut samples = Vec::new();
        for variable in &variables {
            for sample in session.values(variable, RATE, "trigger") {
                samples.push((variable.as_str(), sample));
            }
        }
        samples.sort_by_key(|(_, sample)| sample.time);
        let values: Vec<_> = samples
            .iter()
            .map(|(variable, sample)| (sample.time, *variable, sample.bytes.as_deref()))
            .collect();
        let now = session.snapshot().time;
        if let Some(at) = self
            .trigger
            .step(session.timeline(), &values, now, &mut self.axis)
        {
            self.why.open_at(session.timeline().log(), at);
        }
    }
}

impl Window for Scope {
    /// A trace has no gap where it was behind another window.
    fn follow(&mut self, session: &WindowSession) {
        if let Some(saved) = self.waiting.take() {
            for trace in &saved.traces {
                if let Err(reason) = self.signals.add(trace, session.variables()) {
                    tracing::info!("a saved trace cannot be added: {reason}");
                }
            }
            self.trigger
                .arm(session.schemas(), session.variables(), session.timeline());
        }
        for name in session.plots() {
            self.signals.add_requested(&name, session.variables());
        }
        self.read_values(session);
    }

    fn show(&mut self, ui: &mut egui::Ui, session: &WindowSession, style: &Style) {
        let past = session.recorded().and_then(Recorded::past);
        let seen = Input {
            snapshot: session.snapshot(),
            schemas: session.schemas(),
            timeline: past.as_ref().map_or(session.timeline(), |past| &past.timeline),
            end_s: past
                .as_ref()
                .map_or(session.now(), |past| past.end_s.max(session.now())),
            gaps: past.as_ref().map_or(&[], |past| &past.gaps),
            is_recording: session.is_recording(),
            accepts_requests: !session.is_over() && !session.is_recording(),
        };
        for request in self.draw(ui, &seen, session.variables(), style) {
            match request {
                Request::Act(action) => session.act(action),
                Request::Seek(time) => drop(session.seek_switch(time)),
                Request::Panel(schema) => session.open_window(super::WindowKind::Panel(schema)),
            }
        }
    }

    fn keep(&self) -> serde_json::Value {
        let saved = SavedState {
            span: self.axis.span(),
            share: self.share,
            filter: self.filter.clone(),
            folded: self.folded.clone(),
            traces: self.signals.list.iter().map(|chart| chart.name.clone()).collect(),
            trigger: self.trigger.saved.clone(),
            cursors: self.cursors,
        };
        serde_json::to_value(saved).unwrap_or_default()
    }
}
