//! Camera images. An image is converted to a texture only when a new one arrives.

use std::collections::HashMap;

use eframe::egui::{self, TextureHandle, TextureOptions, Ui, Vec2};
use jde_link::Rate;

use super::reading::{VariableState, sampled};
use crate::picture::{self, Picture};
use crate::session::WindowSession;
use crate::style::{self, Style};

/// Maximum rate of images.
const RATE: Rate = Rate::Hz(20);

/// The newest image of each camera.
#[derive(Default)]
pub(super) struct Pictures {
    shown: HashMap<String, Shown>,
}

struct Shown {
    sequence: u64,
    picture: Result<TextureHandle, String>,
}

impl Pictures {
    /// Shows the image of a camera, as wide as the space allows.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &WindowSession, camera: &str, style: &Style) {
        let variable = session
            .variables()
            .iter()
            .find(|variable| variable.name == camera);
        let reading = sampled(session, variable, RATE);
        let (sample, fresh) = match &reading {
            VariableState::Present(sample, fresh) => (sample, fresh),
            VariableState::None(name, reason) => {
                self.shown.remove(camera);
                ui.weak(format!("{name}: {}", reason.message()));
                super::table::play(ui, session, reading.sleeper());
                return;
            }
            VariableState::Absent => return,
        };
        let shown = self
            .shown
            .get(camera)
            .filter(|shown| shown.sequence == sample.sequence);
        if shown.is_none() {
            let previous = self.shown.remove(camera);
            let limit = ui.input(|input| input.max_texture_side);
            let image = Picture::read(sample).and_then(|picture| {
                picture::fits(picture.size, limit)?;
                Ok(picture.image())
            });
            let picture = image.map(|image| match previous {
                Some(Shown {
                    picture: Ok(mut texture),
                    ..
                }) => {
                    texture.set(image, TextureOptions::LINEAR);
                    texture
                }
                _ => ui.ctx().load_texture(camera, image, TextureOptions::LINEAR),
            });
            let sequence = sample.sequence;
            self.shown.insert(camera.to_owned(), Shown { sequence, picture });
        }
        let Some(shown) = self.shown.get(camera) else {
            return;
        };
        match &shown.picture {
            Ok(texture) => {
                frame(ui, texture, camera, fresh.stale);
                let [width, height] = texture.size();
                let text = format!("{camera}  {width} × {height}");
                ui.horizontal(|ui| {
                    ui.label(text);
                    super::table::age(ui, fresh, style);
                });
            }
            Err(reason) => {
                ui.colored_label(
                    style::color_of(jde_panel::Ink::Warn, style),
                    format!("{camera}: {reason}"),
                );
            }
        }
    }

    /// Frees the images of all other cameras.
    pub(super) fn keep(&mut self, cameras: &[String]) {
        self.shown.retain(|camera, _| cameras.contains(camera));
    }
}

fn frame(ui: &mut Ui, texture: &TextureHandle, camera: &str, stale: bool) {
    let size = texture.size_vec2();
    let width = ui.available_width().min(size.x.max(320.0));
    let size = Vec2::new(width, width * size.y / size.x);
    let image = egui::Image::new((texture.id(), size))
        .corner_radius(3.0)
        .alt_text(format!("picture of {camera}"));
    let image = if stale {
        image.tint(egui::Color32::from_gray(110))
    } else {
        image
    };
    ui.add(image);
}
