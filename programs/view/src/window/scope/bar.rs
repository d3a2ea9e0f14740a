//! The controls at the upper edge: run and pause, time per division, the trigger, cursors, traces, and the
//! filter.

use eframe::egui::{ComboBox, Key, Popup, PopupCloseBehavior, RichText, Slider, TextEdit, Ui};
use jde_link::message::VariableInfo;
use jde_panel::Ink;

use super::axis::{self, Scale};
use super::input::Input;
use super::trigger::{Mode, TriggerPhase};
use super::{Scope, trigger::Trigger};
use crate::style::{self, Style, time};

/// Example conditions, each with its meaning.
const CONDITIONS: [(&str, &str); 7] = [
    ("conflict", "two or more members of a group are ready"),
    ("absence", "a member of a group is awake and none wins"),
    ("chatter>5", "more than five switches of a group within a second"),
    ("overrun", "a schema misses its deadline or exceeds its budget"),
    ("fault", "a schema panics, fails, hangs or dies"),
    ("refused", "a command or a wake is refused"),
    ("operator", "an operator acts"),
];

impl Scope {
    pub(super) fn bar(
        &mut self,
        ui: &mut Ui,
        seen: &Input<'_>,
        variables: &[VariableInfo],
        scale: &Scale,
        style: &Style,
    ) {
        ui.horizontal_wrapped(|ui| {
            self.time(ui, seen);
            ui.separator();
            self.trigger(ui, seen, variables, style);
            ui.separator();
            let shown = self.cursors.at.is_some();
            let tip =
                "Two lines that can be dragged. They show the time between them and all values at them.";
            if ui.selectable_label(shown, "Cursors").on_hover_text(tip).clicked() {
                self.cursors.toggle(scale);
            }
            self.signals.pick(ui, variables, scale, style);
            ui.separator();
            self.filter(ui);
        });
        if let Some(text) = self.cursors.text() {
            ui.label(
                RichText::new(text)
                    .color(style::color_of(Ink::Seen, style))
                    .monospace(),
            );
        }
        if let Some(trouble) = &self.trigger.trouble {
            ui.label(RichText::new(trouble).color(style::color_of(Ink::Bad, style)));
        }
    }

    fn time(&mut self, ui: &mut Ui, seen: &Input<'_>) {
        let now = seen.now();
        let (text, tip) = if self.axis.is_paused() {
            ("Run", "Show the present again (space).")
        } else {
            ("Pause", "Pause the picture; the application continues (space).")
        };
        if ui.button(text).on_hover_text(tip).clicked() {
            self.run_or_pause(seen);
        }
        let division = self.axis.division();
        if ui
            .button("−")
            .on_hover_text("Show less time, in more detail.")
            .accessible_name("Less time per division")
            .clicked()
        {
            self.axis.set_division(axis::step(division, false), now);
        }
        ui.label(format!("{}/div", time::setting(division)))
            .on_hover_text("Time between two lines of the grid. The wheel zooms at the pointer, a drag moves, a double click follows the present.");
        if ui
            .button("+")
            .on_hover_text("Show more time.")
            .accessible_name("More time per division")
            .clicked()
        {
            self.axis.set_division(axis::step(division, true), now);
        }
        let live = self.axis.is_live();
        if ui
            .selectable_label(live, "Live")
            .on_hover_text("Follow the present (double click).")
            .clicked()
        {
            self.axis.follow();
        }
    }

    fn trigger(&mut self, ui: &mut Ui, seen: &Input<'_>, variables: &[VariableInfo], style: &Style) {
        let label = ui.label("Trigger");
        let field = TextEdit::singleline(&mut self.trigger.saved.text)
            .hint_text("conflict, fault, a.b.c > 0.3 …")
            .desired_width(150.0);
        let response = ui.add(field).labelled_by(label.id);
        let mut arm = response.lost_focus();
        let choose = ui
            .button("…")
            .on_hover_text("Example conditions.")
            .accessible_name("Conditions");
        Popup::menu(&choose).show(|ui| {
            for (condition, meaning) in CONDITIONS {
                let text = format!("{condition} — {meaning}");
                if ui
                    .selectable_label(self.trigger.saved.text == condition, text)
                    .clicked()
                {
                    condition.clone_into(&mut self.trigger.saved.text);
                    arm = true;
                }
            }
            ui.weak("or an expression over variables and signals: vff.won and clearance < 0.2");
            if ui.selectable_label(false, "no trigger").clicked() {
                self.trigger.saved.text.clear();
                arm = true;
            }
        });
        if arm {
            self.trigger.arm(seen.schemas, variables, seen.timeline);
            if self.trigger.phase() == &TriggerPhase::Off {
                self.axis.follow();
            }
        }
        let (mode, mode_hint) = self.trigger.saved.mode.label_and_hint();
        let modes = ComboBox::from_id_salt("mode").selected_text(mode).width(64.0);
        let shown = modes.show_ui(ui, |ui| {
            for mode in Mode::ALL {
                let (label, tip) = mode.label_and_hint();
                ui.selectable_value(&mut self.trigger.saved.mode, mode, label)
                    .on_hover_text(tip);
            }
        });
        shown
            .response
            .on_hover_text(mode_hint)
            .accessible_name("Mode of the trigger");
        let place = ui
            .button("place")
            .on_hover_text("The position of the firing in the window. Its causes are to its left.");
        Popup::menu(&place)
            .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
            .show(|ui| {
                let mut percent = self.trigger.saved.share * 100.0;
                let slider = Slider::new(&mut percent, 20.0..=80.0)
                    .suffix(" %")
                    .text("before the firing");
                if ui.add(slider).changed() {
                    self.trigger.saved.share = percent / 100.0;
                }
            });
        status(ui, &self.trigger, style);
    }

    fn filter(&mut self, ui: &mut Ui) {
        let field = TextEdit::singleline(&mut self.filter.text)
            .hint_text("name, type, kind, state")
            .desired_width(150.0);
        let response = ui.add(field).accessible_name("Filter");
        if response.has_focus() && ui.input(|input| input.key_pressed(Key::Escape)) {
            self.filter.text.clear();
        }
        ui.toggle_value(&mut self.filter.awake, "awake")
            .on_hover_text("Only schemas that are not SLEPT.");
        ui.toggle_value(&mut self.filter.troubled, "troubled")
            .on_hover_text(
                "Only schemas with overruns, faults or refusals, and those that an operator holds.",
            );
        if !self.filter.is_empty() {
            ui.weak(format!("{} left out", self.left_out));
            if ui
                .small_button("all")
                .on_hover_text("Show all schemas again.")
                .clicked()
            {
                self.filter = Default::default();
            }
        }
    }
}

/// Shows the phase of the trigger.
fn status(ui: &mut Ui, trigger: &Trigger, style: &Style) {
    let (text, color) = match trigger.phase() {
        TriggerPhase::Off => ("off".to_owned(), Ink::Faint),
        TriggerPhase::Armed => ("armed".to_owned(), Ink::Warn),
        TriggerPhase::Fired { at } | TriggerPhase::Done { at } => {
            (format!("triggered at {at:.3} s"), Ink::Good)
        }
    };
    let response = ui.label(RichText::new(text).color(style::color_of(color, style)));
    if let Some((at, text)) = trigger.last() {
        response.on_hover_text(format!("{at:.3} s: {text}"));
    }
}
