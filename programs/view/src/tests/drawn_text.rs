//! The texts of a frame as they are drawn: what is left of each where it is cut, its color, and the ground behind it.

use eframe::egui::epaint::{ClippedShape, Mesh, PathShape, TextShape};
use eframe::egui::{Color32, Pos2, Rect, Shape};

/// A text as drawn.
#[derive(Debug)]
pub(crate) struct DrawnText {
    pub(crate) text: String,
    /// Where it is.
    pub(crate) rect: Rect,
    /// Its color on its ground, and that ground: both opaque.
    pub(crate) color: Color32,
    pub(crate) ground: Color32,
}

/// Returns the texts of a frame whose middle is inside the part of the window in which they are drawn.
pub(crate) fn of(shapes: &[ClippedShape], window: Color32) -> Vec<DrawnText> {
    let mut flat = Vec::new();
    shapes
        .iter()
        .for_each(|clipped| flatten(&clipped.shape, clipped.clip_rect, &mut flat));
    let mut texts = Vec::new();
    for (place, (shape, clip)) in flat.iter().enumerate() {
        let Shape::Text(text) = shape else { continue };
        let rect = text.visual_bounding_rect();
        if text.galley.text().trim().is_empty() || !clip.contains(rect.center()) {
            continue;
        }
        let ground = flat[..place]
            .iter()
            .filter(|(_, clip)| clip.contains(rect.center()))
            .filter_map(|(shape, _)| fill(shape, rect.center()))
            .fold(window, over);
        texts.extend(colors(text).map(|color| DrawnText {
            text: shown(text),
            rect,
            color: over(ground, color),
            ground,
        }));
    }
    texts
}

fn flatten<'s>(shape: &'s Shape, clip: Rect, into: &mut Vec<(&'s Shape, Rect)>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| flatten(shape, clip, into)),
        shape => into.push((shape, clip)),
    }
}

/// The letters of a text that are drawn: without those that were cut.
fn shown(text: &TextShape) -> String {
    let rows = text.galley.rows.iter();
    rows.map(|row| row.glyphs.iter().map(|glyph| glyph.chr).collect::<String>())
        .collect::<Vec<_>>()
        .join(" ")
}

fn colors(text: &TextShape) -> impl Iterator<Item = Color32> + '_ {
    text.galley.job.sections.iter().map(|section| {
        let color = match text.override_text_color {
            Some(color) => color,
            None if section.format.color == Color32::PLACEHOLDER => text.fallback_color,
            None => section.format.color,
        };
        color.gamma_multiply(text.opacity_factor)
    })
}

/// The color with which a shape fills a point. Pictures are unknown, and fill nothing.
fn fill(shape: &Shape, at: Pos2) -> Option<Color32> {
    match shape {
        Shape::Rect(rect) => {
            (rect.brush.is_none() && rect.blur_width == 0.0 && rect.rect.contains(at)).then_some(rect.fill)
        }
        Shape::Circle(circle) => (circle.center.distance(at) <= circle.radius).then_some(circle.fill),
        Shape::Path(path) => is_inside(path, at).then_some(path.fill),
        Shape::Mesh(mesh) => mesh_color(mesh, at),
        Shape::Noop
        | Shape::Vec(_)
        | Shape::Ellipse(_)
        | Shape::LineSegment { .. }
        | Shape::Band(_)
        | Shape::Text(_)
        | Shape::QuadraticBezier(_)
        | Shape::CubicBezier(_)
        | Shape::Callback(_) => None,
    }
}

fn is_inside(path: &PathShape, at: Pos2) -> bool {
    let ends = path.points.iter().zip(path.points.iter().cycle().skip(1));
    let crossings = ends.filter(|(one, next)| {
        (one.y > at.y) != (next.y > at.y)
            && at.x < one.x + (at.y - one.y) / (next.y - one.y) * (next.x - one.x)
    });
    path.closed && crossings.count() % 2 == 1
}

fn mesh_color(mesh: &Mesh, at: Pos2) -> Option<Color32> {
    if mesh.texture_id != eframe::egui::TextureId::default() {
        return None;
    }
    let side = |a: Pos2, b: Pos2| (b - a).rot90().dot(at - a);
    let mut triangles = mesh.indices.chunks_exact(3);
    let found = triangles.find(|corners| {
        let [a, b, c] = [0, 1, 2].map(|corner| mesh.vertices[corners[corner] as usize].pos);
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
    })?;
    Some(mesh.vertices[found[0] as usize].color)
}

/// Lays a color over an opaque one.
fn over(ground: Color32, color: Color32) -> Color32 {
    let rest = 255 - u16::from(color.a());
    let part = |ground: u8, color: u8| (u16::from(color) + u16::from(ground) * rest / 255).min(255) as u8;
    Color32::from_rgb(
        part(ground.r(), color.r()),
        part(ground.g(), color.g()),
        part(ground.b(), color.b()),
    )
}
