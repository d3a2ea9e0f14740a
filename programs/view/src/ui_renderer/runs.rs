//! Splits the triangles of a mesh by the pipeline that they need, without changing their order.

use std::ops::Range;

use eframe::egui::TextureId;
use eframe::egui::epaint::{Mesh, Vertex, WHITE_UV};

/// The pipeline that a triangle needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TriangleKind {
    /// Plain colors without blending: the triangle is opaque and large.
    Solid,
    /// A texture, blended with the background.
    Textured,
}

/// Minimum area in square points for which changing the pipeline is worth it.
const PIPELINE_CHANGE_AREA: f32 = 2048.0;

/// The triangles of a mesh in their order, as runs with the same pipeline. The ranges are of indices.
pub(super) fn runs(mesh: &Mesh) -> Vec<(TriangleKind, Range<usize>)> {
    let mut runs: Vec<(TriangleKind, Range<usize>)> = Vec::new();
    for (number, corners) in mesh.indices.as_chunks::<3>().0.iter().enumerate() {
        let kind = triangle_kind(mesh, corners.map(|corner| &mesh.vertices[corner as usize]));
        let indices = 3 * number..3 * number + 3;
        match runs.last_mut() {
            Some((before, run)) if *before == kind => run.end = indices.end,
            _ => runs.push((kind, indices)),
        }
    }
    runs
}

fn triangle_kind(mesh: &Mesh, corners: [&Vertex; 3]) -> TriangleKind {
    let [a, b, c] = corners.map(|corner| corner.pos);
    let area = ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)).abs() / 2.0;
    let plain = |corner: &Vertex| corner.uv == WHITE_UV && corner.color.is_opaque();
    // That texture coordinate is white only in the font texture.
    if area >= PIPELINE_CHANGE_AREA
        && mesh.texture_id == TextureId::default()
        && corners.into_iter().all(plain)
    {
        TriangleKind::Solid
    } else {
        TriangleKind::Textured
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Color32, Rect, pos2, vec2};

    use super::*;

    fn rect(side: f32) -> Rect {
        Rect::from_min_size(pos2(3.0, 4.0), vec2(side, side))
    }

    #[test]
    fn large_opaque_triangles_are_solid_and_the_order_is_kept() {
        let mut mesh = Mesh::default();
        mesh.add_colored_rect(rect(100.0), Color32::RED);
        mesh.add_colored_rect(rect(10.0), Color32::RED);
        mesh.add_colored_rect(rect(100.0), Color32::from_black_alpha(9));
        mesh.add_rect_with_uv(rect(100.0), rect(0.5), Color32::RED);
        mesh.add_colored_rect(rect(100.0), Color32::GREEN);
        let expected = [
            (TriangleKind::Solid, 0..6),
            (TriangleKind::Textured, 6..24),
            (TriangleKind::Solid, 24..30),
        ];
        assert_eq!(runs(&mesh), expected);
    }

    #[test]
    fn triangles_of_another_texture_are_never_solid() {
        let mut mesh = Mesh::with_texture(TextureId::User(1));
        let corner = Rect::from_min_max(WHITE_UV, WHITE_UV);
        mesh.add_rect_with_uv(rect(100.0), corner, Color32::RED);
        assert_eq!(runs(&mesh), [(TriangleKind::Textured, 0..6)]);
    }
}
