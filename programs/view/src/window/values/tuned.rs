//! Modulations that differ from the application's file: their list, the way back, and the button that writes them to the
//! file. What differs, and what is written, is decided by the link's client, as for `jde tuned`.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use eframe::egui::{self, RichText, Ui};
use jde_board::value::Value;
use jde_link::message::VariableInfo;
use jde_link::tuned::{self, Tuned};
use jde_link::{Rate, Sample};
use jde_panel::Ink;

use super::cell;
use crate::session::WindowSession;
use crate::style::{self, Style};

/// What was written, in lines, or why nothing was.
type Saved = Result<Vec<String>, String>;

/// The modulations that differ.
#[derive(Default)]
pub(super) struct TunedList {
    /// Whether nothing else is shown.
    pub(super) is_only: bool,
    /// Each modulation as last compared, with the value that was compared.
    compared: HashMap<String, (Arc<Sample>, Option<Tuned>)>,
    /// What these windows have written to the file since the run began.
    written: HashMap<String, Value>,
    /// The writing under way, with what it writes.
    saving: Option<(Receiver<Saved>, Vec<Tuned>)>,
    saved: Option<Saved>,
}

impl TunedList {
    /// Whether a modulation differs, as last compared.
    pub(super) fn has(&self, name: &str) -> bool {
        self.compared.get(name).is_some_and(|(_, tuned)| tuned.is_some())
    }

    /// Compares a value with the file's.
    fn compare(&mut self, info: &VariableInfo, sample: &Arc<Sample>) -> Option<&Tuned> {
        let known = self.compared.get(&info.name);
        if known.is_none_or(|(known, _)| !Arc::ptr_eq(known, sample)) {
            let written = self.written.get(&info.name).map(jde_link::value::to_json);
            let stated = written.or_else(|| info.stated.clone());
            let tuned = Tuned::of(
                &VariableInfo {
                    stated,
                    ..info.clone()
                },
                sample,
            );
            self.compared
                .insert(info.name.clone(), (Arc::clone(sample), tuned));
        }
        self.compared.get(&info.name)?.1.as_ref()
    }

    /// Shows what can be done with all that differ, while only they are shown.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        self.poll();
        if !self.is_only {
            return;
        }
        for info in session.variables().iter().filter(|info| info.stated.is_some()) {
            if let Some(sample) = session.value(&info.name, Rate::Hz(1)) {
                self.compare(info, &sample);
            }
        }
        let all = self.compared.values().filter_map(|(_, tuned)| tuned.clone());
        let all: Vec<_> = all.collect();
        ui.horizontal_wrapped(|ui| {
            let can_act = !all.is_empty() && !session.is_over() && !session.is_recording();
            ui.add_enabled_ui(can_act && self.saving.is_none(), |ui| {
                if ui
                    .button("Save to the file")
                    .on_hover_text(&session.about().file)
                    .clicked()
                {
                    self.save(ui.ctx(), session, all.clone());
                }
            });
            ui.add_enabled_ui(can_act, |ui| {
                let back = ui.button("All back");
                if back.on_hover_text("Set all to the values of the file").clicked() {
                    all.iter().for_each(|tuned| session.act(tuned.back()));
                }
            });
            let (ink, text) = match &self.saved {
                None => return,
                Some(Ok(lines)) if lines.is_empty() => {
                    (Ink::Plain, "the file has these values already".to_owned())
                }
                Some(Ok(lines)) => (Ink::Good, format!("saved {}", lines.join(", "))),
                Some(Err(reason)) => (Ink::Bad, reason.clone()),
            };
            ui.label(RichText::new(text).color(style::color_of(ink, style)));
        });
        ui.add_space(2.0);
    }

    /// Shows the file's value of a modulation that differs, and a button that sets it back.
    pub(super) fn show_back(
        &mut self,
        ui: &mut Ui,
        session: &WindowSession,
        style: &Style,
        info: &VariableInfo,
        sample: &Arc<Sample>,
    ) {
        let Some(tuned) = self.compare(info, sample) else {
            return;
        };
        let number = tuned.file.as_number().filter(|number| *number >= 0.0);
        let number = number.map(|number| number as usize);
        let choice = number.and_then(|number| info.range.choices.get(number));
        let file = choice.cloned();
        let file = file.unwrap_or_else(|| cell::line(&tuned.file, &info.unit, style));
        // A narrow column cuts the text beside it.
        let hint = format!("Set it to the value of the file, {file}");
        let back = ui.small_button("Back").on_hover_text(hint);
        let name = format!("set back {}", info.name);
        back.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        if back.clicked() {
            session.act(tuned.back());
        }
        ui.weak(format!("file {file}"));
    }

    /// Begins to write values to the file, on a thread of its own, since it waits for the disk.
    fn save(&mut self, ctx: &egui::Context, session: &WindowSession, all: Vec<Tuned>) {
        let (done, saved) = channel();
        let (remote, schemas) = (session.remote().clone(), session.schemas().clone());
        let (repaint, tuned) = (ctx.clone(), all.clone());
        let worker = move || {
            // The receiver may be gone with the window.
            let _ =
                done.send(tuned::save(&remote, &schemas, &tuned, false).map_err(|reason| reason.to_string()));
            repaint.request_repaint();
        };
        match thread::Builder::new().name("view-save".to_owned()).spawn(worker) {
            Ok(_) => self.saving = Some((saved, all)),
            Err(error) => {
                self.saved = Some(Err(format!(
                    "nothing is saved, because there is no thread: {error}"
                )))
            }
        }
    }

    /// Notes the end of the writing.
    fn poll(&mut self) {
        let Some((saved, _)) = &self.saving else { return };
        let result = match saved.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => Err("nothing is saved".to_owned()),
        };
        let tuned = self.saving.take().map_or_else(Vec::new, |(_, tuned)| tuned);
        if result.is_ok() {
            for tuned in tuned {
                self.compared.remove(&tuned.info.name);
                self.written.insert(tuned.info.name, tuned.now);
            }
        }
        self.saved = Some(result);
    }
}
