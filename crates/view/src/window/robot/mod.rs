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
use crate::session::Session;
use crate::style::Style;
use drive::Drive;
use picture::Pictures;
use plane::Plane;
use sensors::{Candidates, Choice, Sensors};

/// Below this width, in points, the column of numbers is shown below the plane instead of beside it.
const NARROW: f32 = 560.0;

/// The window.
pub(crate) struct RobotWindow {
    choice: Choice,
    plane: Plane,
    drive: Drive,
    senses: Sensors,
    pictures: Pictures,
}

/// The state saved for the next start.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct SavedState {
    choice: Choice,
    plane: Plane,
    /// In m/s.
    speed: Option<f64>,
}

impl RobotWindow {
    /// Opens the window with its saved state. Driving is off at first.
    pub(crate) fn open(kept: &serde_json::Value) -> Self {
        let kept = SavedState::deserialize(kept).unwrap_or_default();
        Self {
            choice: kept.choice,
            plane: kept.plane,
            drive: Drive::new(kept.speed),
            senses: Sensors::default(),
            pictures: Pictures::default(),
        }
    }

    fn column(&mut self, ui: &mut Ui, session: &Session, style: &Style) {
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
    fn show(&mut self, ui: &mut Ui, session: &Session, style: &Style) {
        let offer = self.senses.update(session, &self.choice);
        bar(ui, &mut self.choice, &mut self.plane, &self.senses, &offer);
        let room = ui.available_size();
        if room.x < NARROW {
            ScrollArea::vertical().show(ui, |ui| {
                let height = (0.5 * room.y).max(200.0);
                ui.allocate_ui([room.x, height].into(), |ui| {
                    self.plane.show(ui, &self.senses, style)
                });
                self.column(ui, session, style);
            });
            return;
        }
        Panel::right(ui.scope_id().with("numbers"))
            .default_size(330.0)
            .size_range(260.0..=0.6 * room.x)
            .show(ui, |ui| {
                ScrollArea::vertical().show(ui, |ui| self.column(ui, session, style));
            });
        egui::CentralPanel::no_frame().show(ui, |ui| self.plane.show(ui, &self.senses, style));
    }

    fn keep(&self) -> serde_json::Value {
        let kept = SavedState {
            choice: self.choice.clone(),
            plane: self.plane.clone(),
            speed: Some(self.drive.speed()),
        };
        serde_json::to_value(kept).unwrap_or_default()
    }
}

/// The bar of choices: the robot, the laser, and what the plane shows.
fn bar(ui: &mut Ui, choice: &mut Choice, plane: &mut Plane, senses: &Sensors, offer: &Candidates) {
    ui.horizontal_wrapped(|ui| {
        if senses.bodies.len() > 1 {
            one_of(ui, "Robot", &senses.body, &senses.bodies, &mut choice.body);
        }
        if offer.lasers.len() > 1 {
            let chosen = senses.laser.name().unwrap_or_default().to_owned();
            one_of(ui, "Laser", &chosen, &offer.lasers, &mut choice.laser);
        }
        let before = plane.ahead_up;
        ui.selectable_value(&mut plane.ahead_up, true, "Ahead is up")
            .on_hover_text("The robot stays in the middle, and looks up");
        ui.selectable_value(&mut plane.ahead_up, false, "Floor")
            .on_hover_text("The floor stays as it is, and the robot moves on it");
        if plane.ahead_up != before {
            plane.fit();
        }
        if !plane.ahead_up {
            ui.checkbox(&mut plane.follow, "Follow")
                .on_hover_text("Keep the robot in sight");
        }
        ui.separator();
        for (shown, name, hint) in [
            (&mut plane.laser, "Laser", "Points and rays of the laser"),
            (
                &mut plane.sonars,
                "Sonars",
                "Cones of the sonars that hear something",
            ),
            (&mut plane.path, "Path", "Where it has been, as its wheels tell"),
            (
                &mut plane.speeds,
                "Speeds",
                "Thick: as its wheels tell. Thin: as it is told",
            ),
        ] {
            ui.toggle_value(shown, name).on_hover_text(hint);
        }
    });
}

fn one_of(ui: &mut Ui, what: &str, chosen: &str, all: &[String], choice: &mut Option<String>) {
    let inner = egui::ComboBox::from_label(what)
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
        .on_hover_text(format!("{what}: which of {}", all.len()));
}
