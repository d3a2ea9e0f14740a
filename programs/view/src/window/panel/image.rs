//! An image of a panel: as large as there is space. Its pixels stay on the graphics card until a new list
//! replaces them.

use eframe::egui::{self, ColorImage, Pos2, Rect, Sense, TextureOptions, Ui, WidgetInfo, vec2};
use jde_panel::{Ink, Item, Wants};

use super::layout::{ListLayout, hint};
use super::state::Texture;
use crate::{picture, style};

/// Shows the image, and records the gestures on it.
pub(super) fn show(layout: &mut ListLayout<'_>, ui: &mut Ui, item: &Item) {
    let Item::Image {
        id,
        width,
        height,
        channels,
        pixels,
        wants,
    } = item
    else {
        return;
    };
    let limit = ui.input(|input| input.max_texture_side);
    if let Err(reason) = picture::fits([*width, *height].map(|side| side as usize), limit) {
        ui.colored_label(
            style::color_of(Ink::Warn, layout.style),
            format!("{id}: {reason}"),
        );
        return;
    }
    let size = vec2(*width as f32, *height as f32);
    let space = vec2(ui.available_width(), layout.height());
    let scale = (space.x / size.x).min(space.y / size.y);
    let (rect, response) = ui.allocate_exact_size(size * scale, sense(*wants));
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, id));
    let serial = layout.kept.serial;
    let picture = || image(*width, *height, *channels, pixels);
    let options = if scale > 3.0 {
        TextureOptions::NEAREST
    } else {
        TextureOptions::LINEAR
    };
    match layout.kept.textures.get_mut(id) {
        Some(texture) if texture.serial == serial => {}
        Some(texture) => {
            texture.handle.set(picture(), options);
            texture.serial = serial;
        }
        None => {
            let handle = ui.ctx().load_texture(id, picture(), options);
            layout
                .kept
                .textures
                .insert(id.clone(), Texture { handle, serial });
        }
    }
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    if let Some(texture) = layout.kept.textures.get(id) {
        ui.painter()
            .image(texture.handle.id(), rect, whole, egui::Color32::WHITE);
    }
    if response.has_focus() {
        let edge = ui.visuals().selection.stroke;
        ui.painter()
            .rect_stroke(rect, 0.0, edge, egui::StrokeKind::Inside);
    }
    let pixel = |at: Pos2| {
        let at = (rect.clamp(at) - rect.min) / scale;
        [f64::from(at.x), f64::from(at.y), 0.0]
    };
    let mut gestures = layout.kept.gestures.remove(id).unwrap_or_default();
    for touch in gestures.touches(ui, &response, *wants, pixel) {
        layout.record_gesture(id, touch);
    }
    layout.kept.gestures.insert(id.clone(), gestures);
    if let Some(hint) = hint(*wants) {
        response.on_hover_text_at_pointer(hint);
    }
}

fn sense(wants: Wants) -> Sense {
    let mut sense = Sense::hover();
    if wants.clicks || wants.keys {
        sense |= Sense::click();
    }
    if wants.drags {
        sense |= Sense::drag();
    }
    sense
}

fn image(width: u32, height: u32, channels: u8, pixels: &[u8]) -> ColorImage {
    let size = [width as usize, height as usize];
    match channels {
        1 => ColorImage::from_gray(size, pixels),
        3 => ColorImage::from_rgb(size, pixels),
        _ => ColorImage::from_rgba_unmultiplied(size, pixels),
    }
}
