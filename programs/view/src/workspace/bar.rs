//! The bar above the windows: the application, its status, and who stopped everything.

use std::time::Duration;

use eframe::egui;
use jde_core::Health;
use jde_link::message::{Action, Network};
use jde_timeline::health_text;

use super::menu::appearance_menu;
use super::{Navigation, Workspace};
use crate::settings::WindowSettings;
use crate::start::Discovery;
use crate::stop::confirmed;
use crate::style::{self, Style, Units};

/// How long a notice is shown.
const NOTICE_SHOWN: Duration = Duration::from_secs(8);
/// After this time without a snapshot, the application is shown as silent.
const SNAPSHOT_TIMEOUT: Duration = Duration::from_secs(1);

impl Workspace {
    /// Draws the bar. Returns where the user navigates to, if so.
    pub(crate) fn bar(&mut self, ui: &mut egui::Ui, settings: &mut WindowSettings) -> Option<Navigation> {
        let away = ui
            .button("Applications")
            .on_hover_text("Back to the list of applications and recordings. The robot continues.");
        let navigation = away.clicked().then_some(Navigation::Away);
        ui.separator();
        self.title(ui);
        let navigation = self.reopen_button(ui).or(navigation);
        ui.separator();
        ui.menu_button("Windows", |ui| self.windows_menu(ui));
        ui.menu_button("Panels", |ui| self.panels_menu(ui));
        ui.menu_button("Appearance", |ui| appearance_menu(ui, settings));
        ui.separator();
        self.notice(ui);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if !self.session.is_recording() {
                self.recorder
                    .show(ui, self.session.about(), self.session.is_over());
            }
            self.pass_time(ui);
        });
        navigation
    }

    fn title(&self, ui: &mut egui::Ui) {
        let about = self.session.about();
        let file = std::path::Path::new(&about.file);
        if self.session.is_recording() {
            let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
            ui.strong(&about.application);
            ui.label(format!("recorded in {name}")).on_hover_text(&about.file);
        } else {
            let name = if about.name == about.application {
                about.name.clone()
            } else {
                format!("{} ({})", about.name, about.application)
            };
            ui.strong(name).on_hover_text(format!(
                "{} on {}, process {}\n{}",
                about.user, about.host, about.pid, about.file
            ));
        }
        ui.label(format!("{:.1} s", self.session.now()))
            .on_hover_text("Time of the application since its start.");
        if let Some(ending) = self.session.ending() {
            let color = style::severity(ending.severity());
            let style = Style::of(ui.ctx(), Units::default());
            let word = egui::RichText::new(ending.word()).color(style::color_of(color, &style));
            let shown = format!("{}. The windows show its last state.", ending.reason());
            ui.label(word.strong()).on_hover_text(shown);
            return;
        }
        let silent = self.session.silent();
        if silent > SNAPSHOT_TIMEOUT {
            let text = format!("no news for {} s", silent.as_secs());
            ui.colored_label(ui.visuals().error_fg_color, text).on_hover_text(
                "It hangs, was suspended, or its network connection is cut. The windows show its last state.",
            );
        }
        // During silence no snapshot triggers a repaint, so this one is scheduled.
        ui.ctx().request_repaint_after(SNAPSHOT_TIMEOUT / 2);
        self.trouble(ui);
        if about.network == Network::Read {
            ui.weak("read only")
                .on_hover_text("Clients from the network may observe this application, but not operate it.");
        }
    }

    /// How many schemas are in trouble, which leads to their events.
    fn trouble(&self, ui: &mut egui::Ui) {
        let schemas = self.session.snapshot().schemas.iter();
        let unhealthy: Vec<_> = schemas.filter(|schema| schema.health != Health::Ok).collect();
        let (text, schema) = match unhealthy.as_slice() {
            [] => return,
            [schema] => ("1 schema in trouble".to_owned(), Some(schema.name.clone())),
            all => (format!("{} schemas in trouble", all.len()), None),
        };
        let reasons = unhealthy
            .iter()
            .map(|schema| format!("{}: {}", schema.name, health_text(&schema.health)));
        let reasons: Vec<_> = reasons.collect();
        let link = ui.link(egui::RichText::new(text).color(ui.visuals().warn_fg_color));
        if link.on_hover_text(reasons.join("\n")).clicked() {
            self.session.show_events(schema);
        }
    }

    /// Offers to open the new run of an application that is gone. The last state of the old run stays visible
    /// until then.
    fn reopen_button(&mut self, ui: &mut egui::Ui) -> Option<Navigation> {
        if !self.session.is_gone() || self.session.is_recording() {
            return None;
        }
        let discovery = self
            .discovery
            .get_or_insert_with(|| Discovery::new(ui.ctx(), &self.reach, &[]));
        let gone = self.session.about();
        let seen = discovery.seen();
        let again = seen
            .running
            .iter()
            .find(|about| about.name == gone.name && about.id != gone.id)?;
        // Buttons of a menu bar have no background by default.
        let open = egui::Button::new("It runs again: open it").fill(ui.visuals().selection.bg_fill);
        let open = ui.add(open);
        open.on_hover_text("Opens windows on the new run, in the same layout.")
            .clicked()
            .then(|| Navigation::For(Box::new(again.clone())))
    }

    /// The newest notice, for [`NOTICE_SHOWN`] after it occurred.
    fn notice(&self, ui: &mut egui::Ui) {
        let notices = self.session.notices();
        let Some(notice) = notices.last() else { return };
        let remaining = NOTICE_SHOWN.saturating_sub(notice.at.elapsed());
        if remaining.is_zero() {
            return;
        }
        ui.ctx().request_repaint_after(remaining);
        let color = ui.visuals().error_fg_color;
        ui.add(egui::Label::new(egui::RichText::new(&notice.text).color(color)).truncate())
            .on_hover_text(&notice.text);
    }

    /// The buttons that let time pass again where it stands still.
    fn pass_time(&self, ui: &mut egui::Ui) {
        if self.session.is_recording() || self.session.is_gone() {
            return;
        }
        let Some(reason) = self.session.standstill() else {
            return;
        };
        if ui
            .button("Continue")
            .on_hover_text("Time passes again.")
            .clicked()
        {
            self.session.act(Action::Continue);
        }
        if ui
            .button("Step")
            .on_hover_text("Lets a little time pass.")
            .clicked()
        {
            self.session.act(Action::Step);
        }
        ui.colored_label(ui.visuals().warn_fg_color, format!("stands still: {reason}"));
    }

    /// Who stopped everything, and the button that lets it go on. Neither while a stop is under way.
    pub(super) fn stopped(&mut self, ui: &mut egui::Ui, stopping: bool) {
        let stopped = self.session.stopped_by().filter(|_| !stopping);
        self.asks &= stopped.is_some();
        let Some((by, others)) = stopped else { return };
        let mut text = format!("Stopped by {by}");
        if !others.is_empty() {
            text += &format!(", except {}", others.join(", "));
        }
        let silent = self.session.silent();
        if silent > SNAPSHOT_TIMEOUT || self.session.is_gone() {
            text += &format!(", as of {} s ago", silent.as_secs());
        }
        egui::Panel::top("stopped").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                if confirmed(ui, &mut self.asks, "Go on ...", "Let everything go on") {
                    self.session.act(Action::ReleaseAll);
                }
                let color = ui.visuals().warn_fg_color;
                ui.label(egui::RichText::new(text).color(color).strong())
                    .on_hover_text(
                        "Schemas that were stopped separately stay stopped when the rest goes on.",
                    );
            });
        });
    }
}
