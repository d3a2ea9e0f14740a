//! The bar above the windows: which application, how it stands, which windows there are, and how everything looks.

use std::time::Duration;

use eframe::egui;
use jde_core::Health;
use jde_link::message::{Action, Network};

use super::Desk;
use crate::look::{Angle, Length};
use crate::settings::Settings;
use crate::window::Kind;

/// How long what came of an order is shown.
const SHOWN: Duration = Duration::from_secs(8);
/// An application that says nothing for so long is said to be silent.
const SILENT: Duration = Duration::from_secs(1);

impl Desk {
    /// Draws it; answers whether the person wants to leave.
    pub(super) fn bar(&mut self, ui: &mut egui::Ui, settings: &mut Settings) -> bool {
        let mut leave = false;
        egui::MenuBar::new().ui(ui, |ui| {
            leave = ui
                .button("Applications")
                .on_hover_text("Back to what runs and what was recorded. The robot goes on.")
                .clicked();
            ui.separator();
            self.title(ui);
            ui.separator();
            ui.menu_button("Windows", |ui| self.windows_menu(ui));
            ui.menu_button("Panels", |ui| self.panels_menu(ui));
            ui.menu_button("Look", |ui| look_menu(ui, settings));
            ui.separator();
            self.notice(ui);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                self.stop_all(ui)
            });
        });
        leave
    }

    fn title(&self, ui: &mut egui::Ui) {
        let about = self.session.about();
        let name = if about.name == about.application {
            about.name.clone()
        } else {
            format!("{} ({})", about.name, about.application)
        };
        ui.strong(name).on_hover_text(format!(
            "{} on {}, process {}\n{}",
            about.user, about.host, about.pid, about.file
        ));
        if self.session.is_gone() {
            let text = egui::RichText::new("gone")
                .color(ui.visuals().error_fg_color)
                .strong();
            ui.label(text).on_hover_text(
                "It ended, was killed, or the network to it is cut. What is shown is how it was last.",
            );
            return;
        }
        ui.label(format!("{:.1} s", self.session.now()))
            .on_hover_text("Time of the application since its start.");
        let silent = self.session.silent();
        if silent > SILENT {
            let text = format!("no news for {} s", silent.as_secs());
            ui.colored_label(ui.visuals().error_fg_color, text).on_hover_text(
                "It hangs, was suspended, or the network to it is cut. What is shown is how it was then.",
            );
        }
        // Silence is no news, so nobody else has this drawn.
        ui.ctx().request_repaint_after(SILENT / 2);
        let troubled = self
            .session
            .snapshot()
            .schemas
            .iter()
            .filter(|schema| schema.health != Health::Ok);
        match troubled.count() {
            0 => {}
            1 => drop(ui.colored_label(ui.visuals().warn_fg_color, "1 schema in trouble")),
            count => {
                drop(ui.colored_label(ui.visuals().warn_fg_color, format!("{count} schemas in trouble")))
            }
        }
        if about.network == Network::Read {
            ui.weak("read only")
                .on_hover_text("Clients from the network may look here, and not operate.");
        }
    }

    fn windows_menu(&mut self, ui: &mut egui::Ui) {
        for kind in [Kind::Oscilloscope, Kind::Robot, Kind::Space, Kind::Values] {
            self.window_entry(ui, kind);
        }
        ui.separator();
        if ui.button("As they usually are").clicked() {
            self.tidy();
        }
    }

    fn panels_menu(&mut self, ui: &mut egui::Ui) {
        let panels: Vec<_> = self.session.panels().map(str::to_owned).collect();
        if panels.is_empty() {
            ui.weak("no schema of this application has a panel");
        }
        for schema in panels {
            self.window_entry(ui, Kind::Panel(schema));
        }
    }

    fn window_entry(&mut self, ui: &mut egui::Ui, kind: Kind) {
        let mut on = self.has(&kind);
        if ui.checkbox(&mut on, kind.title()).changed() {
            if on {
                self.show_window(kind)
            } else {
                self.hide_window(&kind)
            }
        }
    }

    /// Why the last order came to nothing, for a while.
    fn notice(&self, ui: &mut egui::Ui) {
        let notices = self.session.notices();
        let Some(notice) = notices.last() else { return };
        let left = SHOWN.saturating_sub(notice.at.elapsed());
        if left.is_zero() {
            return;
        }
        ui.ctx().request_repaint_after(left);
        let color = ui.visuals().error_fg_color;
        ui.add(egui::Label::new(egui::RichText::new(&notice.text).color(color)).truncate())
            .on_hover_text(&notice.text);
    }

    /// The one thing that must be found at once.
    fn stop_all(&self, ui: &mut egui::Ui) {
        if self.session.is_recording() || self.session.is_gone() {
            return;
        }
        // In text fields too, and whatever window has the focus.
        if ui.input_mut(|input| input.consume_key(egui::Modifiers::CTRL, egui::Key::Space)) {
            self.session.act(Action::StopAll);
        }
        let held = self.session.roots().all(|root| self.session.is_stopped(root));
        let stop = egui::RichText::new("Stop everything").strong();
        if held {
            let go = ui.button("Let it go on");
            if go
                .on_hover_text("Releases the roots: the hierarchy decides again.")
                .clicked()
            {
                self.session.act(Action::ReleaseAll);
            }
            ui.colored_label(ui.visuals().warn_fg_color, "stopped");
        } else if ui
            .add(
                egui::Button::new(stop.color(egui::Color32::WHITE))
                    .fill(egui::Color32::from_rgb(176, 32, 32)),
            )
            .on_hover_text(
                "Ctrl+Space. Puts every root to sleep, and with it all that acts; the actuators brake. Nothing is lost.",
            )
            .clicked()
        {
            self.session.act(Action::StopAll);
        }
    }
}

/// Theme, size and units.
pub(crate) fn look_menu(ui: &mut egui::Ui, settings: &mut Settings) {
    let before = settings.clone();
    ui.label("Theme");
    ui.horizontal(|ui| {
        use egui::ThemePreference::{Dark, Light, System};
        for (theme, name) in [(System, "As the desktop"), (Dark, "Dark"), (Light, "Light")] {
            ui.selectable_value(&mut settings.theme, theme, name);
        }
    });
    ui.label("Size");
    ui.horizontal(|ui| {
        for zoom in [0.8, 1.0, 1.25, 1.5, 2.0] {
            ui.selectable_value(&mut settings.zoom, zoom, format!("{:.0} %", zoom * 100.0));
        }
    });
    ui.label("Angles");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.units.angle, Angle::Degrees, "Degrees");
        ui.selectable_value(&mut settings.units.angle, Angle::Radians, "Radians");
    });
    ui.label("Lengths");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.units.length, Length::Metres, "Metres");
        ui.selectable_value(&mut settings.units.length, Length::Millimetres, "Millimetres");
    });
    if *settings != before {
        settings.apply(ui.ctx());
    }
}
