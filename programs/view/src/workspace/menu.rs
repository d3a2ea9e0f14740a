//! The menus of the bar: the windows and panels, and the style.

use eframe::egui;

use super::Workspace;
use crate::settings::WindowSettings;
use crate::style::{Angle, Length};
use crate::window::WindowKind;

impl Workspace {
    pub(super) fn windows_menu(&mut self, ui: &mut egui::Ui) {
        for kind in [
            WindowKind::Oscilloscope,
            WindowKind::Robot,
            WindowKind::Space,
            WindowKind::Values,
            WindowKind::Events,
        ] {
            self.window_entry(ui, kind);
        }
        ui.separator();
        if ui.button("Default layout").clicked() {
            self.restore_default_layout();
        }
    }

    pub(super) fn panels_menu(&mut self, ui: &mut egui::Ui) {
        let panels: Vec<_> = self.session.panels().map(str::to_owned).collect();
        if panels.is_empty() {
            ui.weak("no schema of this application has a panel");
        }
        for schema in panels {
            self.window_entry(ui, WindowKind::Panel(schema));
        }
    }

    fn window_entry(&mut self, ui: &mut egui::Ui, kind: WindowKind) {
        let mut on = self.has(&kind);
        if ui.checkbox(&mut on, kind.title()).changed() {
            if on {
                self.show_window(kind)
            } else {
                self.hide_window(&kind)
            }
        }
    }
}

/// The menu of theme, size and units.
pub(crate) fn appearance_menu(ui: &mut egui::Ui, settings: &mut WindowSettings) {
    let before = settings.clone();
    ui.label("Theme");
    ui.horizontal(|ui| {
        use egui::ThemePreference::{Dark, Light, System};
        for (theme, name) in [(System, "System"), (Dark, "Dark"), (Light, "Light")] {
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
