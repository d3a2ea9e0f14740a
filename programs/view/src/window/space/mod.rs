//! The 3D view: the robot and its sensor data in space, with a view that the user turns, moves and zooms. It
//! refuses to compute: it shows only data of the application.

mod bar;
mod compose;
mod draw_list;
mod entities;
mod gestures;
mod gpu;
mod hit;
mod items;
mod models;
mod orbit;
mod overlay;
mod pointer;
mod sampler;
mod scene_data;
mod solids;
#[cfg(test)]
mod tests;

use eframe::egui::{self, Color32, Sense, Ui, pos2};
use glam::Vec3;
use jde_panel::{Gesture, Ink};
use serde::{Deserialize, Serialize};

use super::Window;
use crate::session::WindowSession;
use crate::style::{Style, color_of};
use draw_list::DrawList;
use gestures::SceneGestures;
use gpu::{Background, Card};
use items::Items;
use orbit::Orbit;
use pointer::{Pointed, PointerInput};
use sampler::Sampler;
use scene_data::SceneData;

pub(crate) use gpu::{Quality, offer};
#[cfg(test)]
pub(crate) use orbit::Eye;
#[cfg(test)]
pub(crate) use scene_data::frame;

/// The window.
#[derive(Default)]
pub(crate) struct Space {
    kept: SavedState,
    /// The view towards which the eye moves, if it is moving.
    goal: Option<Orbit>,
    /// The last position of the followed robot.
    robot: Option<Vec3>,
    pointed: Option<Pointed>,
    touch: SceneGestures,
    /// What cannot be shown, as messages.
    troubles: Vec<String>,
    sampler: Sampler,
    seen: SceneData,
    draw_list: DrawList,
    card: Option<Result<Card, String>>,
}

/// The state saved for the next start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct SavedState {
    orbit: Orbit,
    follow: bool,
    items: Items,
}

impl Default for SavedState {
    fn default() -> Self {
        Self {
            orbit: Orbit::default(),
            follow: true,
            items: Items::default(),
        }
    }
}

impl Space {
    /// Opens the window with its saved state.
    pub(crate) fn open(kept: &serde_json::Value) -> Self {
        let mut kept: SavedState = serde_json::from_value(kept.clone()).unwrap_or_default();
        if !kept.orbit.is_valid() {
            kept.orbit = Orbit::default();
        }
        Self {
            kept,
            ..Self::default()
        }
    }

    /// The data of the scene.
    #[cfg(test)]
    pub(crate) fn seen(&self) -> &SceneData {
        &self.seen
    }

    /// The current view.
    #[cfg(test)]
    pub(crate) fn orbit(&self) -> &Orbit {
        &self.kept.orbit
    }

    /// Changes the items to show.
    #[cfg(test)]
    pub(crate) fn want(&mut self, change: impl FnOnce(&mut Items)) {
        change(&mut self.kept.items);
    }

    /// Stops following the robot.
    #[cfg(test)]
    pub(crate) fn stay(&mut self) {
        self.kept.follow = false;
    }

    /// Draws the scene. Returns the gestures on the scenes of panels, each with its schema.
    fn picture(&mut self, ui: &mut Ui, style: &Style) -> Vec<(String, Gesture)> {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(
                egui::Role::Canvas,
                true,
                "Space: the robot and what it senses, in 3D",
            )
        });
        if rect.width() < 8.0 || rect.height() < 8.0 {
            return Vec::new();
        }
        let eye = pointer::eye(&self.kept.orbit, &response);
        let gestures = self.touch.gestures(ui, &response, &eye, &self.seen);
        let taken = PointerInput {
            drag: self.touch.drags(),
            keys: self.touch.types(&self.seen),
        };
        let (action, away) = pointer::steer(ui, &response, &mut self.kept.orbit, self.kept.follow, taken);
        if away {
            self.kept.follow = false;
            self.goal = None;
        }
        if let Some(action) = action {
            self.perform(action);
        }
        self.follow();
        self.glide(ui);

        self.draw_list.clear();
        self.troubles = compose::all(&mut self.draw_list, &self.seen, &self.kept.items, style);
        if let Some(pointed) = &self.pointed {
            mark(&mut self.draw_list, pointed, style);
        }
        let eye = pointer::eye(&self.kept.orbit, &response);
        let background = background(&self.kept, style);
        let scale = ui.pixels_per_point();
        let pixels = [rect.width(), rect.height()].map(|points| (points * scale).round() as u32);
        let card = self.card.get_or_insert_with(|| Card::find(ui.ctx()));
        let drawn = match card {
            Ok(card) => {
                self.troubles
                    .extend(self.draw_list.remove_oversized_pictures(card.max_picture_side()));
                card.draw(&self.draw_list, &eye, &background, pixels)
            }
            Err(reason) => Err(reason.clone()),
        };
        let painter = ui.painter_at(rect);
        match drawn {
            Ok(texture) => {
                let whole = egui::Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                painter.image(texture, rect, whole, Color32::WHITE);
            }
            Err(reason) => {
                self.card = Some(Err(reason.clone()));
                self.refused(ui, rect, &reason);
                return gestures;
            }
        }
        if response.clicked()
            && let Some(at) = response.interact_pointer_pos()
        {
            let at = at - rect.min;
            self.pointed = pointer::point(&eye, &self.draw_list.things, glam::Vec2::new(at.x, at.y));
            ui.ctx().request_repaint();
        }
        if self.kept.items.grid {
            overlay::ticks(&painter, rect, &eye, background.step, style);
        }
        overlay::labels(&painter, rect, &eye, &self.draw_list, style);
        if self.kept.items.axes {
            overlay::gizmo(&painter, rect, &eye, style);
        }
        if response.has_focus() {
            let stroke = ui.visuals().selection.stroke;
            painter.rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Inside);
        }
        self.bar(ui, rect);
        self.notes(&painter, rect, style);
        gestures
    }

    /// The current position of the followed robot.
    fn present(&self) -> Option<Vec3> {
        let place = self.seen.robots.iter().find_map(scene_data::RobotData::place)?;
        Some(place.transform_point3(Vec3::Z * 0.2))
    }

    /// Moves the view along with the robot.
    fn follow(&mut self) {
        let robot = self.present();
        if self.kept.follow
            && let Some(now) = robot
        {
            match self.robot {
                Some(before) => {
                    self.kept.orbit.target += now - before;
                    if let Some(goal) = &mut self.goal {
                        goal.target += now - before;
                    }
                }
                // The robot's first position centers the view.
                None => self.kept.orbit.target = now,
            }
        }
        self.robot = robot;
    }

    /// Moves the eye a step towards its goal. Requests a repaint only while it moves.
    fn glide(&mut self, ui: &Ui) {
        let Some(goal) = self.goal else { return };
        let time = ui.style().animation_time;
        let part = if time > 0.0 {
            1.0 - (-3.0 * ui.input(|input| input.stable_dt) / time).exp()
        } else {
            1.0
        };
        let orbit = self.kept.orbit.toward(&goal, part);
        if orbit.is_at(&goal) {
            (self.kept.orbit, self.goal) = (goal, None);
        } else {
            self.kept.orbit = orbit;
            ui.ctx().request_repaint();
        }
    }
}

impl Window for Space {
    fn show(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        self.sampler.update(&mut self.seen, session, &self.kept.items);
        for (schema, gesture) in self.picture(ui, style) {
            if !session.is_over() && !session.is_recording() {
                // The schema draws the effect. A refusal is added to the notices.
                session.touch(&schema, gesture);
            }
        }
    }

    fn keep(&self) -> serde_json::Value {
        serde_json::to_value(self.kept).unwrap_or_default()
    }
}

/// Draws a cross at the point that the user clicked.
fn mark(draw_list: &mut DrawList, pointed: &Pointed, style: &Style) {
    let color = color_of(Ink::Plain, style);
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        draw_list.line(pointed.at - axis * 0.12, pointed.at + axis * 0.12, 1.5, color);
    }
    draw_list.dot(pointed.at, 6.0, color);
}

fn background(kept: &SavedState, style: &Style) -> Background {
    let (floor, beyond, lines) = if style.dark {
        (
            Color32::from_rgb(47, 50, 56),
            Color32::from_rgb(25, 27, 31),
            Color32::from_rgba_unmultiplied(150, 158, 172, 150),
        )
    } else {
        (
            Color32::from_rgb(238, 239, 241),
            Color32::from_rgb(214, 219, 226),
            Color32::from_rgba_unmultiplied(92, 102, 118, 150),
        )
    };
    Background {
        floor,
        beyond,
        lines,
        step: overlay::step(kept.orbit.distance),
        shown: kept.items.grid,
    }
}
