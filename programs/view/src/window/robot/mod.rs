//! Sensors and motors: the sensor data around the robot's outline, and driving it by hand.

mod drive;
#[cfg(test)]
pub(crate) mod fixture;
mod picture;
mod plane;
mod reading;
mod sensors;
mod table;

use eframe::egui::{self, Panel, ScrollArea, Ui};
use serde::{Deserialize, Serialize};

use super::Window;
use crate::session::WindowSession;
use crate::style::Style;
use drive::ManualDrive;
use picture::Pictures;
use plane::Plane;
use sensors::{Candidates, RobotChoice, Sensors};

/// Below this width, in points, the column of numbers is shown below the plane instead of beside it.
const NARROW_WIDTH: f32 = 560.0;

/// The window.
pub(crate) struct RobotWindow {
    choice: RobotChoice,
    plane: Plane,
    drive: ManualDrive,
    senses: Sensors,
    pictures: Pictures,
}

/// The state saved for the next start.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct SavedState {
    choice: RobotChoice,
    plane: Plane,
    /// In m/s.
    speed: Option<f64>,
}

impl RobotWindow {
    /// Opens the window with its saved state. Driving is off at first.
    pub(crate) fn open(saved: &serde_json::Value) -> Self {
        let saved = SavedState::deserialize(saved).unwrap_or_default();
        Self {
            choice: saved.choice,
            plane: saved.plane,
            drive: ManualDrive::new(saved.speed),
            senses: Sensors::default(),
            pictures: Pictures::default(),
        }
    }

    fn column(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        self.drive.show(ui, session, &self.senses, style);
        ui.separator();
        table::show(ui, &self.senses, Some(session), style);
        let cameras = self.senses.cameras.clone();
        self.pictures.keep(&cameras);
        for camera in &cameras {
            ui.separator();
            self.pictures.show(ui, session, camera, style);
        }
    }
}

impl Window for RobotWindow {
    fn show(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        let offer = self.senses.update(session, &self.choice);
        bar(ui, &mut self.choice, &mut self.plane, &self.senses, &offer);
        let size = ui.available_size();
        if size.x < NARROW_WIDTH {
            ScrollArea::vertical().show(ui, |ui| {
                let height = (0.5 * size.y).max(200.0);
                ui.allocate_ui([size.x, height].into(), |ui| {
                    self.plane.show(ui, &self.senses, style)
                });
                self.column(ui, session, style);
            });
            return;
        }
        Panel::right(ui.scope_id().with("numbers"))
            .default_size(330.0)
            .size_range(260.0..=0.6 * size.x)
            .show(ui, |ui| {
                ScrollArea::vertical().show(ui, |ui| self.column(ui, session, style));
            });
        egui::CentralPanel::no_frame().show(ui, |ui| self.plane.show(ui, &self.senses, style));
    }

    fn keep(&self) -> serde_json::Value {
        let saved = SavedState {
            choice: self.choice.clone(),
            plane: self.plane.clone(),
            speed: Some(self.drive.speed()),
        };
        serde_json::to_value(saved).unwrap_or_default()
    }
}

/// The bar of choices: the robot, the laser, and what the plane shows.
fn bar(ui: &mut Ui, choice: &mut RobotChoice, plane: &mut Plane, senses: &Sensors, offer: &Candidates) {
    ui.horizontal_wrapped(|ui| {
        if senses.bodies.len() > 1 {
            choice_box(ui, "Robot", &senses.body, &senses.bodies, &mut choice.body);
        }
        if offer.lasers.len() > 1 {
            let chosen = senses.laser.name().unwrap_or_default().to_owned();
            choice_box(ui, "Laser", &chosen, &offer.lasers, &mut choice.laser);
        }
        let before = plane.ahead_up;
        ui.selectable_value(&mut plane.ahead_up, true, "Ahead is up")
            .on_hover_text("The robot stays in the middle and faces up");
        ui.selectable_value(&mut plane.ahead_up, false, "Floor")
            .on_hover_text("The floor stays fixed, and the robot moves on it");
        if plane.ahead_up != before {
            plane.fit();
        }
        if !plane.ahead_up {
            ui.checkbox(&mut plane.follow, "Follow")
                .on_hover_text("Keep the robot in view");
        }
        ui.separator();
        for (shown, name, hint) in [
            (&mut plane.laser, "Laser", "Points and rays of the laser"),
            (
                &mut plane.sonars,
                "Sonars",
                "Cones of the sonars that receive an echo",
            ),
            (&mut plane.path, "Path", "The driven path, by the wheel odometry"),
            (
                &mut plane.speeds,
                "Speeds",
                "Thick: measured at the wheels. Thin: commanded",
            ),
        ] {
            ui.toggle_value(shown, name).on_hover_text(hint);
        }
    });
}

fn choice_box(ui: &mut Ui, label: &str, chosen: &str, all: &[String], choice: &mut Option<String>) {
    let inner = egui::ComboBox::from_label(label)
        .selected_text(chosen)
        .show_ui(ui, |ui| {
            for name in all {
                if ui.selectable_label(name == chosen, name).clicked() {
                    *choice = Some(name.clone());
                }
            }
        });
    inner
        .response
        .on_hover_text(format!("{label}: which of {}", all.len()));
}
