//! Draws egui's output faster on software renderers. egui's own shader contains two ways of reading a
//! texture. A graphics card executes one of them, but a processor executes both for every pixel. Here each
//! way has its own pipeline, and large opaque triangles are not blended.
//!
//! It owns no textures: egui's renderer keeps these, and the render pass. It is not used with a graphics
//! card.

mod pipelines;
mod runs;

use std::ops::Range;

use eframe::egui::epaint::{ClippedPrimitive, ClippedShape, Mesh, PaintCallbackInfo, Primitive, Vertex};
use eframe::egui::{self, FullOutput, Pos2, Rect, Shape, Vec2};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState};
use wgpu::util::DeviceExt;
use wgpu::{BufferUsages, IndexFormat, RenderPass};

use crate::window::space::Quality;
use pipelines::Pipelines;
use runs::{TriangleKind, runs};

/// Installs the renderer where it is faster: at [`Quality::Quick`]. The target's format must not be sRGB,
/// because egui blends in gamma space.
pub(crate) fn take_over(ctx: &egui::Context, card: &RenderState, effort: Quality) {
    if effort == Quality::Quick && !card.target_format.is_srgb() {
        ctx.add_plugin(UiRenderer::new(card.clone()));
    }
}

/// Replaces egui's shapes at the end of each frame with one paint callback.
pub(crate) struct UiRenderer {
    card: RenderState,
    pipelines: Pipelines,
}

impl UiRenderer {
    pub(crate) fn new(card: RenderState) -> Self {
        Self {
            pipelines: Pipelines::new(&card.device, card.target_format),
            card,
        }
    }

    /// Updates the textures of this frame in egui's renderer.
    fn put_textures(&self, output: &mut FullOutput) {
        let mut renderer = self.card.renderer.write();
        for (id, changes) in output.textures_delta.set.drain() {
            for change in changes {
                renderer.update_texture(&self.card.device, &self.card.queue, id, &change);
            }
        }
    }

    fn ui_frame(&self, primitives: &[ClippedPrimitive], size: Vec2) -> UiFrame {
        let renderer = self.card.renderer.read();
        let (mut corners, mut indices, mut draw_calls) = (Vec::new(), Vec::new(), Vec::new());
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            // The windows use no other paint callbacks.
            let Primitive::Mesh(mesh) = primitive else {
                continue;
            };
            let Some(texture) = renderer.texture(&mesh.texture_id) else {
                tracing::warn!("no texture {:?}", mesh.texture_id);
                continue;
            };
            let (first, base) = (indices.len(), corners.len());
            append(mesh, size, &mut corners, &mut indices);
            for (way, run) in runs(mesh) {
                let group = (way == TriangleKind::Textured).then(|| texture.bind_group.clone());
                let indices = (first + run.start) as u32..(first + run.end) as u32;
                draw_calls.push(DrawCall {
                    clip: *clip_rect,
                    group,
                    indices,
                    base: base as i32,
                });
            }
        }
        let device = &self.card.device;
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("ui renderer"),
                contents,
                usage,
            })
        };
        UiFrame {
            pipelines: self.pipelines.clone(),
            corners: buffer(bytemuck::cast_slice(&corners), BufferUsages::VERTEX),
            indices: buffer(bytemuck::cast_slice(&indices), BufferUsages::INDEX),
            draw_calls,
            size,
        }
    }
}

/// Appends a mesh for the card: its vertices in coordinates from -1 to 1 across a screen of `size` points.
fn append(mesh: &Mesh, size: Vec2, corners: &mut Vec<Vertex>, indices: &mut Vec<u32>) {
    let scale = egui::vec2(2.0, -2.0) / size;
    corners.extend(mesh.vertices.iter().map(|corner| Vertex {
        pos: Pos2::new(-1.0, 1.0) + corner.pos.to_vec2() * scale,
        ..*corner
    }));
    indices.extend_from_slice(&mesh.indices);
}

impl egui::Plugin for UiRenderer {
    fn debug_name(&self) -> &'static str {
        "ui renderer"
    }

    fn output_hook(&mut self, ctx: &egui::Context, output: &mut FullOutput) {
        self.put_textures(output);
        let size = ctx.viewport_rect().size();
        let primitives = ctx.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let screen_rect = Rect::from_min_size(Pos2::ZERO, size);
        let frame = self.ui_frame(&primitives, size);
        let picture = Shape::Callback(Callback::new_paint_callback(screen_rect, frame));
        output.shapes = vec![ClippedShape::new(screen_rect, picture)];
    }
}

/// One frame, ready to draw.
struct UiFrame {
    pipelines: Pipelines,
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    draw_calls: Vec<DrawCall>,
    /// Size of the screen, in points.
    size: Vec2,
}

/// A run of triangles with the same state.
struct DrawCall {
    clip: Rect,
    /// The texture. `None` for solid triangles.
    group: Option<wgpu::BindGroup>,
    indices: Range<u32>,
    base: i32,
}

impl CallbackTrait for UiFrame {
    fn paint(&self, info: PaintCallbackInfo, pass: &mut RenderPass<'static>, _: &CallbackResources) {
        if self.indices.size() == 0 {
            return;
        }
        let pixels = self.size * info.pixels_per_point;
        pass.set_viewport(0.0, 0.0, pixels.x, pixels.y, 0.0, 1.0);
        pass.set_vertex_buffer(0, self.corners.slice(..));
        pass.set_index_buffer(self.indices.slice(..), IndexFormat::Uint32);
        for draw_call in &self.draw_calls {
            let Some([x, y, width, height]) = scissors(draw_call.clip, &info) else {
                continue;
            };
            pass.set_scissor_rect(x, y, width, height);
            match &draw_call.group {
                None => pass.set_pipeline(&self.pipelines.solid),
                Some(group) => {
                    pass.set_pipeline(&self.pipelines.textured);
                    pass.set_bind_group(0, group, &[]);
                }
            }
            pass.draw_indexed(draw_call.indices.clone(), draw_call.base, 0..1);
        }
    }
}

/// The pixels of a rectangle, clipped to the screen. `None` if it is empty.
fn scissors(clip: Rect, info: &PaintCallbackInfo) -> Option<[u32; 4]> {
    let [width, height] = info.screen_size_px;
    let pixel = |at: f32, limit: u32| (at * info.pixels_per_point).round().clamp(0.0, limit as f32) as u32;
    let (left, right) = (pixel(clip.min.x, width), pixel(clip.max.x, width));
    let (top, bottom) = (pixel(clip.min.y, height), pixel(clip.max.y, height));
    (left < right && top < bottom).then(|| [left, top, right - left, bottom - top])
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use eframe::egui::{Color32, ColorImage, TextureOptions, pos2, vec2};
    use eframe::egui_wgpu::RendererOptions;
    use egui_kittest::Harness;
    use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};

    use super::*;

    /// Renders a frame with each kind of content, with this renderer or without.
    fn drawn(renderer: bool, scale: f32) -> ([u32; 2], Vec<u8>) {
        let card = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
        let own = own_texture(&card);
        let plugin = renderer.then(|| UiRenderer::new(card.clone()));
        let mut harness = Harness::builder()
            .with_size(vec2(300.0, 200.0))
            .with_pixels_per_point(scale)
            .with_context_setup(move |ctx| {
                if let Some(renderer) = plugin {
                    ctx.add_plugin(renderer);
                }
            })
            .renderer(WgpuTestRenderer::from_render_state(card))
            .build_ui(move |ui| contents(ui, own));
        harness.run();
        let picture = harness.render().expect("the window renders");
        (picture.dimensions().into(), picture.into_raw())
    }

    fn contents(ui: &mut egui::Ui, own: egui::TextureId) {
        let place = |x, y, width, height| Rect::from_min_size(pos2(x, y), vec2(width, height));
        let painter = ui.painter().clone();
        painter.rect_filled(place(0.0, 0.0, 300.0, 200.0), 0.0, Color32::from_rgb(40, 60, 80));
        painter.rect_filled(
            place(20.0, 20.0, 180.0, 120.0),
            12.0,
            Color32::from_rgb(200, 60, 80),
        );
        painter.rect_filled(
            place(60.0, 60.0, 200.0, 120.0),
            0.0,
            Color32::from_black_alpha(90),
        );
        let cut = painter.with_clip_rect(place(150.0, 0.0, 75.0, 75.0));
        cut.circle_filled(pos2(150.0, 40.0), 50.0, Color32::YELLOW);
        let all = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        painter.image(own, place(10.0, 150.0, 90.0, 40.0), all, Color32::WHITE);
        let managed = ui.data_mut(|data| data.get_temp::<egui::TextureHandle>(egui::Id::NULL));
        let managed = managed.unwrap_or_else(|| {
            let stripes = [Color32::RED, Color32::BLUE, Color32::GREEN, Color32::WHITE];
            let image = ColorImage::new([2, 2], stripes.to_vec());
            ui.ctx().load_texture("stripes", image, TextureOptions::NEAREST)
        });
        painter.image(managed.id(), place(210.0, 110.0, 80.0, 80.0), all, Color32::WHITE);
        ui.data_mut(|data| data.insert_temp(egui::Id::NULL, managed));
        ui.heading("hidden by nothing");
        ui.label("0.25 m/s");
    }

    /// A texture registered in egui's renderer, as the 3D picture is.
    fn own_texture(card: &RenderState) -> egui::TextureId {
        let size = wgpu::Extent3d {
            width: 2,
            height: 1,
            depth_or_array_layers: 1,
        };
        let texture = card.device.create_texture_with_data(
            &card.queue,
            &wgpu::TextureDescriptor {
                label: None,
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            &[255, 128, 0, 255, 0, 0, 128, 255],
        );
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut renderer = card.renderer.write();
        renderer.register_native_texture(&card.device, &view, wgpu::FilterMode::Linear)
    }

    #[test]
    fn the_output_equals_that_of_egui() {
        for scale in [1.0, 1.5] {
            let ((size, ours), (expected, theirs)) = (drawn(true, scale), drawn(false, scale));
            assert_eq!(size, expected);
            let colors: HashSet<&[u8]> = theirs.chunks(4).collect();
            assert!(colors.len() > 50, "the picture has many colors");
            let different = ours
                .iter()
                .zip(&theirs)
                .filter(|(ours, theirs)| ours.abs_diff(**theirs) > 3);
            assert_eq!(different.count(), 0, "at {scale} pixels per point");
        }
    }
}
