//! Images of cameras: turned into textures when a new one has come, and not before.

use std::collections::HashMap;

use eframe::egui::{self, ColorImage, TextureHandle, TextureOptions, Ui, Vec2};
use jde_abi::describe::{Field, Form, Type};
use jde_link::{Rate, Sample};

use super::reading::{Reading, sampled};
use crate::look::{self, Look};
use crate::session::Session;

/// So often at most.
const RATE: Rate = Rate::Hz(20);

/// The pictures of all cameras, as they were last.
#[derive(Default)]
pub(super) struct Pictures {
    shown: HashMap<String, Shown>,
}

struct Shown {
    sequence: u64,
    picture: Result<TextureHandle, String>,
}

impl Pictures {
    /// Shows the picture of a camera, as wide as there is room.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, camera: &str, look: &Look) {
        let variable = session
            .variables()
            .iter()
            .find(|variable| variable.name == camera);
        let reading = sampled(session, variable, RATE);
        let (sample, fresh) = match &reading {
            Reading::Here(sample, fresh) => (sample, fresh),
            Reading::None(name, why) => {
                self.shown.remove(camera);
                ui.weak(format!("{name}: {}", why.words()));
                super::table::play(ui, session, reading.sleeper());
                return;
            }
            Reading::Absent => return,
        };
        let shown = self
            .shown
            .get(camera)
            .filter(|shown| shown.sequence == sample.sequence);
        if shown.is_none() {
            let before = self.shown.remove(camera);
            let picture = color_image(sample).map(|image| match before {
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
                    super::table::age(ui, fresh, look);
                });
            }
            Err(reason) => {
                ui.colored_label(
                    look::ink(jde_panel::Ink::Warn, look),
                    format!("{camera}: {reason}"),
                );
            }
        }
    }

    /// Forgets those that nobody shows.
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

/// The picture of a sample, whose value is too large to be copied through a stack: its fields are read in place.
pub(super) fn color_image(sample: &Sample) -> Result<ColorImage, String> {
    let bytes = sample.bytes.as_deref().ok_or("there is none")?;
    let fields = Fields(&sample.value_type, bytes);
    let number = |name: &str| fields.number(name).ok_or("it is no picture");
    let (width, height, step) = (number("width")?, number("height")?, number("step")?);
    let encoding = fields.several("encoding").ok_or("it is no picture")?;
    let pixels = fields.several("data").ok_or("it is no picture")?;
    let (depth, order) = match encoding {
        b"rgb8" => (3, [0, 1, 2]),
        b"bgr8" => (3, [2, 1, 0]),
        b"mono8" => (1, [0, 0, 0]),
        other => {
            let other = String::from_utf8_lossy(other);
            return Err(format!("its pixels are `{other}`: expected rgb8, bgr8 or mono8"));
        }
    };
    let whole = height.saturating_sub(1) * step + depth * width;
    if width == 0 || height == 0 || step < depth * width || pixels.len() < whole {
        let length = pixels.len();
        return Err(format!(
            "its {length} bytes are no {width} × {height} pixels in rows of {step}"
        ));
    }
    let rows = pixels.chunks(step).take(height);
    let colors = rows
        .flat_map(|row| row[..depth * width].chunks_exact(depth))
        .map(|pixel| {
            let [red, green, blue] = order.map(|place| pixel[place]);
            egui::Color32::from_rgb(red, green, blue)
        });
    Ok(ColorImage::new([width, height], colors.collect()))
}

/// The fields of a value, where its description says that they are.
struct Fields<'a>(&'a Type, &'a [u8]);

impl<'a> Fields<'a> {
    fn of(&self, name: &str) -> Option<&'a Field> {
        self.0.fields.iter().find(|field| field.name == name)
    }

    fn word(&self, at: usize) -> Option<usize> {
        let word = self.1.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_ne_bytes(word) as usize)
    }

    fn number(&self, name: &str) -> Option<usize> {
        self.word(self.of(name)?.offset)
    }

    /// The bytes of a text or of a sequence of bytes.
    fn several(&self, name: &str) -> Option<&'a [u8]> {
        let field = self.of(name)?;
        let (Form::Text {
            capacity,
            length_offset,
        }
        | Form::Sequence {
            capacity,
            length_offset,
        }) = field.form
        else {
            return None;
        };
        let length = self.word(length_offset)?.min(capacity);
        self.1.get(field.offset..field.offset + length)
    }
}
