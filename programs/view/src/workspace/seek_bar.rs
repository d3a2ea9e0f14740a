//! The bar below the windows of a recording: its position, and its controls. It writes the modulations of the
//! schema `replay`, which controls the playback of each recording.

use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::Rate;
use jde_link::message::Action;
use jde_types::{Flag, Text};
use serde_json::json;

use super::marks;
use crate::recorded::Recorded;
use crate::session::{AFTER_SWITCH_S, OrderOutcome, STEERING, WindowSession};
use crate::tap::tap;

const PLAYBACK_SPEEDS: [f64; 7] = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 10.0];

/// How far from the place of a jump the first position after it is, s of the recording at normal speed.
const JUMP_TOLERANCE: f64 = 0.5;
/// How long the slider waits for such a position.
const JUMP_TIMEOUT: Duration = Duration::from_secs(2);

/// The state of the bar.
#[derive(Default)]
pub(super) struct SeekBar {
    /// The position that the user chose, until the recording reaches it.
    sought: Option<Seek>,
}

/// A jump that was ordered.
struct Seek {
    /// In s.
    place: f64,
    outcome: OrderOutcome,
    /// When the order was accepted.
    accepted: Option<Instant>,
}

impl Seek {
    /// Whether the recording has jumped or refused to. A position of before may come after the order was accepted,
    /// so only one as far from the place as is played between two positions ends the jump; or [`JUMP_TIMEOUT`], if the
    /// recording was told to jump elsewhere meanwhile.
    fn is_over(&mut self, position: f64, speed: f64, now: Instant) -> bool {
        match self.outcome.get() {
            None => false,
            Some(Err(_)) => true,
            Some(Ok(())) => {
                let accepted = *self.accepted.get_or_insert(now);
                (position - self.place).abs() <= JUMP_TOLERANCE * speed.max(1.0)
                    || now - accepted > JUMP_TIMEOUT
            }
        }
    }
}

impl SeekBar {
    fn seek(&mut self, session: &WindowSession, place: f64) {
        self.sought = Some(Seek {
            place,
            outcome: session.seek(place),
            accepted: None,
        });
    }

    pub(super) fn show(&mut self, ui: &mut egui::Ui, session: &WindowSession) {
        let number = |name: &str| {
            session
                .read::<f64>(&variable_name(name), Rate::Hz(20))
                .map(|(number, _)| number)
        };
        let flag = |name: &str| {
            session
                .read::<Flag>(&variable_name(name), Rate::Hz(20))
                .map(|(flag, _)| flag.get())
        };
        let position = number("position").unwrap_or_default();
        let paused = flag("paused").unwrap_or_default();
        let looping = flag("loop").unwrap_or_default();
        let speed = number("speed").unwrap_or(1.0);
        let range = session
            .variables()
            .iter()
            .find(|variable| variable.name == variable_name("position"))
            .and_then(|variable| variable.range.least.zip(variable.range.greatest));
        ui.horizontal(|ui| {
            let play = if paused { "Play" } else { "Pause" };
            let pressed = ui.button(play).on_hover_text("Space").clicked();
            if pressed || space(ui) {
                set(session, "paused", json!(!paused));
            }
            let past = session.recorded().and_then(Recorded::past);
            if ui
                .add_enabled(past.is_some(), egui::Button::new("Previous takeover"))
                .on_hover_text("Goes to the change of winner before, and pauses there.")
                .clicked()
                && let Some(past) = &past
                && let Some(takeover) = past.takeover_before(position - 2.0 * AFTER_SWITCH_S)
            {
                set(session, "paused", json!(true));
                self.seek(session, takeover.time_s + AFTER_SWITCH_S);
            }
            let step = ui.button("Next takeover");
            if step
                .on_hover_text("Goes to the next change of winner, and pauses there.")
                .clicked()
            {
                match past.as_ref().map(|past| past.takeover_after(position)) {
                    Some(Some(takeover)) => {
                        set(session, "paused", json!(true));
                        self.seek(session, takeover.time_s + AFTER_SWITCH_S);
                    }
                    Some(None) => {}
                    None => set(session, "step", json!(true)),
                }
            }
            egui::ComboBox::from_id_salt("speed")
                .selected_text(format!("{speed} x"))
                .width(64.0)
                .show_ui(ui, |ui| {
                    for choice in PLAYBACK_SPEEDS {
                        if ui
                            .selectable_label(speed == choice, format!("{choice} x"))
                            .clicked()
                        {
                            set(session, "speed", json!(choice));
                        }
                    }
                })
                .response
                .on_hover_text("Seconds of the recording per second.");
            let mut again = looping;
            if ui.checkbox(&mut again, "Loop").changed() {
                set(session, "loop", json!(again));
            }
            ui.label(format!("{position:.2} s"));
            // Always a widget: one that appears while the slider is dragged would take the drag from it, whose number it has.
            let damage = session.read::<Text<256>>(&variable_name("damage"), Rate::Hz(1));
            let damage = damage.map(|(text, _)| text).filter(|text| !text.is_empty());
            let mark = if damage.is_some() { "cut off" } else { "" };
            let mark = ui.colored_label(ui.visuals().warn_fg_color, mark);
            if let Some(damage) = damage {
                mark.on_hover_text(format!("{}; the part before is played", damage.as_str()));
            }
            let left_out = session.read::<Text<1020>>(&variable_name("left_out"), Rate::Hz(1));
            let left_out = left_out.map(|(text, _)| text).filter(|text| !text.is_empty());
            let mark = if left_out.is_some() {
                "a part is not played"
            } else {
                ""
            };
            let mark = ui.colored_label(ui.visuals().warn_fg_color, mark);
            if let Some(left_out) = left_out {
                mark.on_hover_text(left_out.as_str());
            }
            let Some((begin, end)) = range else { return };
            ui.spacing_mut().slider_width = (ui.available_width() - 70.0).max(60.0);
            let mut place = self.sought.as_ref().map_or(position, |sought| sought.place);
            let slider = egui::Slider::new(&mut place, begin..=end).show_value(false);
            let slider = ui.add(slider);
            let marked = past.as_ref().and_then(|past| {
                marks::draw(ui, slider.rect, &past.moments, (begin, end));
                marks::at(&slider, &past.moments, (begin, end))
            });
            let tip = "The current position in the recording. Marks: takeovers, contacts, faults, failures.";
            let slider = slider.on_hover_text(marked.as_deref().unwrap_or(tip));
            slider.widget_info(|| egui::WidgetInfo::slider(true, place, "Position in the recording"));
            let tapped = tap(ui, &slider).filter(|_| !slider.changed());
            if let Some(at) = tapped {
                let (left, right) = (slider.rect.left(), slider.rect.right());
                place = egui::remap_clamp(f64::from(at.x), f64::from(left)..=f64::from(right), begin..=end);
            }
            if slider.changed() || tapped.is_some() {
                self.seek(session, place);
            } else if !slider.dragged() {
                let now = Instant::now();
                self.sought.take_if(|sought| sought.is_over(position, speed, now));
            }
            ui.label(format!("{end:.1} s"));
        });
    }
}

/// Consumes the space key, which plays and pauses, unless a widget has the keyboard focus.
fn space(ui: &egui::Ui) -> bool {
    ui.memory(|memory| memory.focused().is_none())
        && ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Space))
}

fn variable_name(name: &str) -> String {
    format!("{STEERING}.{name}")
}

fn set(session: &WindowSession, name: &str, value: serde_json::Value) {
    session.act(order(name, value));
}

fn order(name: &str, value: serde_json::Value) -> Action {
    Action::Modulate {
        schema: STEERING.to_owned(),
        variable: name.to_owned(),
        value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_of_before_the_jump_does_not_move_the_slider_back() {
        let outcome = OrderOutcome::default();
        let mut seek = Seek {
            place: 95.0,
            outcome: outcome.clone(),
            accepted: None,
        };
        let now = Instant::now();
        assert!(!seek.is_over(95.0, 1.0, now), "not accepted");
        outcome.set(Ok(()));
        assert!(!seek.is_over(10.0, 1.0, now));
        assert!(!seek.is_over(52.0, 1.0, now), "of a jump before this one");
        assert!(seek.is_over(95.1, 1.0, now));
        assert!(
            seek.is_over(98.0, 10.0, now),
            "it is played at ten times the speed"
        );
        assert!(
            seek.is_over(52.0, 1.0, now + JUMP_TIMEOUT * 2),
            "it was told to jump elsewhere"
        );
        let refused = OrderOutcome::default();
        refused.set(Err("it is at an end".to_owned()));
        assert!(
            Seek {
                outcome: refused,
                ..seek
            }
            .is_over(10.0, 1.0, now)
        );
    }
}
