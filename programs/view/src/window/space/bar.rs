//! What lies over the picture: buttons, the point of the last click, and messages.

use eframe::egui::{self, Align2, Ui, vec2};
use jde_panel::Ink;

use super::orbit::Orbit;
use super::pointer::ViewAction;
use super::{Space, overlay};
use crate::style::{Style, color_of};

impl Space {
    /// Performs an action of the user other than moving the eye directly.
    pub(super) fn perform(&mut self, action: ViewAction) {
        let now = self.kept.orbit;
        match action {
            ViewAction::Follow => {
                self.kept.follow = !self.kept.follow;
                if self.kept.follow
                    && let Some(robot) = self.present()
                {
                    self.goal = Some(Orbit { target: robot, ..now });
                }
            }
            ViewAction::Top => self.goal = Some(self.goal.unwrap_or(now).above()),
            ViewAction::Reset => {
                let target = self.present().unwrap_or(Orbit::default().target);
                self.kept.follow = true;
                self.goal = Some(Orbit {
                    target,
                    ..Orbit::default()
                });
            }
        }
    }

    /// Shows the buttons over the picture.
    pub(super) fn bar(&mut self, ui: &mut Ui, rect: egui::Rect) {
        let area = egui::Rect::from_min_size(rect.min + vec2(8.0, 8.0), vec2(rect.width() - 16.0, 24.0));
        let builder = egui::UiBuilder::new()
            .max_rect(area)
            .layout(egui::Layout::left_to_right(egui::Align::Center));
        let mut bar = ui.new_child(builder);
        let mut action = None;
        egui::containers::menu::MenuButton::new("Show")
            .config(
                egui::containers::menu::MenuConfig::new()
                    .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside),
            )
            .ui(&mut bar, |ui| {
                for (on, name, about) in self.kept.items.each() {
                    ui.checkbox(on, name).on_hover_text(about);
                }
            })
            .0
            .on_hover_text("The items to show");
        let follow = bar
            .selectable_label(self.kept.follow, "Follow")
            .on_hover_text("The view follows the robot (F)");
        if follow.clicked() {
            action = Some(ViewAction::Follow);
        }
        if bar
            .button("Top")
            .on_hover_text("View from above, as on a map (T)")
            .clicked()
        {
            action = Some(ViewAction::Top);
        }
        let reset = bar.button("Reset").on_hover_text(
            "Restore the initial view (R)\n\nDrag to turn, Shift-drag or middle button to pan, wheel to zoom.\n\
             Keys: arrows, Shift-arrows, + and -. A click shows the name and position of a thing.",
        );
        if reset.clicked() {
            action = Some(ViewAction::Reset);
        }
        if let Some(action) = action {
            self.perform(action);
            ui.ctx().request_repaint();
        }
    }

    /// Shows the messages and the point of the last click.
    pub(super) fn notes(&self, painter: &egui::Painter, rect: egui::Rect, style: &Style) {
        let plain = color_of(Ink::Plain, style);
        if self.seen.is_empty() {
            let text = if self.seen.robots.is_empty() {
                "no odometry in this application: the pose of the robot is not known"
            } else {
                "no odometry yet: its driver may be asleep"
            };
            overlay::plate(painter, rect.center(), Align2::CENTER_CENTER, text, plain, style);
        }
        let mut at = rect.left_bottom() + vec2(8.0, -8.0);
        if let Some(pointed) = &self.pointed {
            let number = |number: f32| {
                style
                    .units
                    .show(f64::from((number * 1000.0).round() / 1000.0), "m")
            };
            let (x, y) = (number(pointed.at.x), number(pointed.at.y));
            let text = match &pointed.name {
                Some(name) => format!("{name}: x {x}, y {y}"),
                None => format!("x {x}, y {y}"),
            };
            overlay::plate(painter, at, Align2::LEFT_BOTTOM, &text, plain, style);
            at.y -= 22.0;
        }
        for trouble in &self.troubles {
            overlay::plate(
                painter,
                at,
                Align2::LEFT_BOTTOM,
                trouble,
                color_of(Ink::Warn, style),
                style,
            );
            at.y -= 22.0;
        }
    }

    /// Shows why there is no picture, and a button that tries again.
    pub(super) fn refused(&mut self, ui: &mut Ui, rect: egui::Rect, reason: &str) {
        let mut area = ui.new_child(egui::UiBuilder::new().max_rect(rect.shrink(16.0)));
        area.vertical_centered(|ui| {
            ui.add_space(rect.height() / 3.0);
            ui.label("There is no 3D picture on this screen. The other windows are not affected.");
            ui.weak(reason);
            if ui.button("Try again").clicked() {
                self.card = None;
            }
        });
    }
}
