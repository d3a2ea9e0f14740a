//! The robot and what it senses in space: a picture that is turned, moved and brought nearer by hand. It refuses to compute: all it
//! shows was told by the application.

mod bar;
mod cast;
mod figures;
mod gather;
mod gpu;
mod hand;
mod hit;
mod items;
mod orbit;
mod overlay;
mod seen;
mod show;
mod solids;
mod stage;
#[cfg(test)]
mod tests;
mod touch;

use eframe::egui::{self, Color32, Sense, Ui, pos2};
use glam::Vec3;
use jde_panel::{Gesture, Ink};
use serde::{Deserialize, Serialize};

use super::Window;
use crate::look::{Look, ink};
use crate::session::Session;
use gather::Gather;
use gpu::{Card, Ground};
use hand::{Pointed, Taken};
use items::Items;
use orbit::Orbit;
use seen::Seen;
use stage::Stage;
use touch::Touch;

pub(crate) use gpu::{Effort, offer};
#[cfg(test)]
pub(crate) use orbit::Eye;
#[cfg(test)]
pub(crate) use seen::frame;

/// The window.
pub(crate) struct Space {
    kept: Kept,
    /// Where the eye goes, if it is on its way.
    goal: Option<Orbit>,
    /// Where the robot that is followed was.
    robot: Option<Vec3>,
    pointed: Option<Pointed>,
    touch: Touch,
    /// What could not be shown, in words.
    troubles: Vec<String>,
    gather: Gather,
    seen: Seen,
    stage: Stage,
    card: Option<Result<Card, String>>,
}

/// What is kept from one start to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct Kept {
    orbit: Orbit,
    follow: bool,
    items: Items,
}

impl Default for Kept {
    fn default() -> Self {
        Self {
            orbit: Orbit::default(),
            follow: true,
            items: Items::default(),
        }
    }
}

impl Space {
    /// With what one kept before.
    pub(crate) fn open(kept: &serde_json::Value) -> Self {
        let mut kept: Kept = serde_json::from_value(kept.clone()).unwrap_or_default();
        if !kept.orbit.is_sound() {
            kept.orbit = Orbit::default();
        }
        Self {
            kept,
            goal: None,
            robot: None,
            pointed: None,
            touch: Touch::default(),
            troubles: Vec::new(),
            gather: Gather::default(),
            seen: Seen::default(),
            stage: Stage::default(),
            card: None,
        }
    }

    /// What is seen.
    #[cfg(test)]
    pub(crate) fn seen(&self) -> &Seen {
        &self.seen
    }

    /// From where.
    #[cfg(test)]
    pub(crate) fn orbit(&self) -> &Orbit {
        &self.kept.orbit
    }

    /// Changes what is wanted.
    #[cfg(test)]
    pub(crate) fn want(&mut self, change: impl FnOnce(&mut Items)) {
        change(&mut self.kept.items);
    }

    /// Follows no robot.
    #[cfg(test)]
    pub(crate) fn stay(&mut self) {
        self.kept.follow = false;
    }

    /// Draws what is seen; answers with what hands did to the scenes of panels, each with the schema that it is for.
    fn picture(&mut self, ui: &mut Ui, look: &Look) -> Vec<(String, Gesture)> {
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
        let eye = hand::eye(&self.kept.orbit, &response);
        let gestures = self.touch.gestures(ui, &response, &eye, &self.seen);
        let taken = Taken {
            drag: self.touch.drags(),
            keys: self.touch.types(&self.seen),
        };
        let (wish, away) = hand::steer(ui, &response, &mut self.kept.orbit, self.kept.follow, taken);
        if away {
            self.kept.follow = false;
            self.goal = None;
        }
        if let Some(wish) = wish {
            self.fulfil(wish);
        }
        self.follow();
        self.glide(ui);

        self.stage.clear();
        self.troubles = show::all(&mut self.stage, &self.seen, &self.kept.items, look);
        if let Some(pointed) = &self.pointed {
            mark(&mut self.stage, pointed, look);
        }
        let eye = hand::eye(&self.kept.orbit, &response);
        let ground = ground(&self.kept, look);
        let scale = ui.pixels_per_point();
        let pixels = [rect.width(), rect.height()].map(|points| (points * scale).round() as u32);
        let card = self.card.get_or_insert_with(|| Card::find(ui.ctx()));
        let drawn = match card {
            Ok(card) => {
                self.troubles
                    .extend(self.stage.leave_out_pictures(card.most_pixels()));
                card.draw(&self.stage, &eye, &ground, pixels)
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
            self.pointed = hand::point(&eye, &self.stage.things, glam::Vec2::new(at.x, at.y));
            ui.ctx().request_repaint();
        }
        if self.kept.items.grid {
            overlay::ticks(&painter, rect, &eye, ground.step, look);
        }
        overlay::labels(&painter, rect, &eye, &self.stage, look);
        if self.kept.items.axes {
            overlay::gizmo(&painter, rect, &eye, look);
        }
        if response.has_focus() {
            let stroke = ui.visuals().selection.stroke;
            painter.rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Inside);
        }
        self.bar(ui, rect);
        self.notes(&painter, rect, look);
        gestures
    }

    /// Where the robot that is followed is now.
    fn present(&self) -> Option<Vec3> {
        let place = self.seen.robots.iter().find_map(seen::Robot::place)?;
        Some(place.transform_point3(Vec3::Z * 0.2))
    }

    /// Takes the eye along with the robot.
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
                // The first time that it is seen.
                None => self.kept.orbit.target = now,
            }
        }
        self.robot = robot;
    }

    /// Goes a part of the way to where the eye is to be; asks for the next frame only while there is a way.
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
    fn show(&mut self, ui: &mut Ui, session: &Session, look: &Look) {
        self.gather.update(&mut self.seen, session, &self.kept.items);
        for (schema, gesture) in self.picture(ui, look) {
            if !session.is_gone() && !session.is_recording() {
                // What comes of it the schema draws, and what is refused is among the notices.
                session.touch(&schema, gesture);
            }
        }
    }

    fn keep(&self) -> serde_json::Value {
        serde_json::to_value(self.kept).unwrap_or_default()
    }
}

/// A cross where somebody pointed.
fn mark(stage: &mut Stage, pointed: &Pointed, look: &Look) {
    let color = ink(Ink::Plain, look);
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        stage.line(pointed.at - axis * 0.12, pointed.at + axis * 0.12, 1.5, color);
    }
    stage.dot(pointed.at, 6.0, color);
}

fn ground(kept: &Kept, look: &Look) -> Ground {
    let (floor, beyond, lines) = if look.dark {
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
    Ground {
        floor,
        beyond,
        lines,
        step: overlay::step(kept.orbit.distance),
        shown: kept.items.grid,
    }
}
