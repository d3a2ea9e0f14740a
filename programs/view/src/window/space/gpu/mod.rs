//! Draws a draw list on the graphics card, into a texture that egui shows. An unchanged picture is not drawn
//! again: the texture stays while the draw list, the eye and the size stay.
//!
//! It knows no robots. An error of the card is returned as a message, never a panic.

mod meshes;
mod pipelines;
mod target;

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use eframe::egui;
use eframe::egui_wgpu::RenderState;
use glam::Vec2;
use wgpu::BufferUsages;

use super::draw_list::{DrawList, FORMS, Instance, Picture};
use super::orbit::Eye;
use pipelines::Pipelines;
use target::{GrowingBuffer, Shown, Target, checked};

/// The quality of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quality {
    /// All pixels of the screen, with several samples per pixel if the card supports that.
    Fine,
    /// Fewer pixels than the screen has, and one sample per pixel: keeps the picture fluid on software
    /// renderers.
    Quick,
}

impl Quality {
    /// The quality for a card.
    pub(crate) fn of(state: &RenderState) -> Self {
        match state.adapter.get_info().device_type {
            wgpu::DeviceType::Cpu => Self::Quick,
            _ => Self::Fine,
        }
    }

    fn samples(self) -> u32 {
        match self {
            Self::Fine => 4,
            Self::Quick => 1,
        }
    }

    /// The number of pixels to draw for a row of pixels of the screen.
    fn pixels(self, pixels: u32) -> u32 {
        match self {
            Self::Fine => pixels,
            Self::Quick => pixels.div_ceil(5) * 3,
        }
    }
}

/// The background: its colors and the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Background {
    pub(crate) floor: egui::Color32,
    pub(crate) beyond: egui::Color32,
    pub(crate) lines: egui::Color32,
    /// Distance of the grid's lines, in m.
    pub(crate) step: f32,
    pub(crate) shown: bool,
}

/// The graphics card, and the resources on it.
pub(crate) struct Card {
    state: RenderState,
    quality: Quality,
    samples: u32,
    pipelines: Pipelines,
    forms: (wgpu::Buffer, [Range<u32>; FORMS.len()]),
    frame: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    sampler: wgpu::Sampler,
    instances: GrowingBuffer,
    corners: GrowingBuffer,
    strokes: GrowingBuffer,
    dots: GrowingBuffer,
    picture_corners: GrowingBuffer,
    pictures: HashMap<String, Shown>,
    target: Option<Target>,
    drawn: Option<u64>,
    /// Number of pictures drawn.
    times: u64,
}

/// The uniforms of a frame. The layout must match the shaders.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Frame {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 3],
    distance: f32,
    size: [f32; 2],
    scale: f32,
    spare: f32,
    sun: [f32; 3],
    ambient: f32,
    floor: [f32; 4],
    beyond: [f32; 4],
    lines: [f32; 4],
    middle: [f32; 2],
    reach: f32,
    step: f32,
}

/// Stores the card and its quality in the context, where [`Card::find`] reads them.
pub(crate) fn offer(ctx: &egui::Context, state: &RenderState, quality: Quality) {
    ctx.data_mut(|data| data.insert_temp(egui::Id::NULL, (state.clone(), quality)));
}

impl Card {
    /// Prepares the card on which the windows are drawn.
    ///
    /// # Errors
    /// There is no card, or it lacks a required feature; a message for the user.
    pub(crate) fn find(ctx: &egui::Context) -> Result<Self, String> {
        let (state, quality): (RenderState, Quality) = ctx
            .data(|data| data.get_temp(egui::Id::NULL))
            .ok_or("these windows have neither a graphics card nor a software renderer")?;
        let device = state.device.clone();
        checked(&device, || Self::new(state, quality))
    }

    fn new(state: RenderState, quality: Quality) -> Self {
        let device = &state.device;
        let supported = |format| {
            let features = state.adapter.get_texture_format_features(format);
            features.flags.sample_count_supported(quality.samples())
        };
        let samples = if supported(pipelines::COLOR) && supported(pipelines::DEPTH) {
            quality.samples()
        } else {
            1
        };
        let pipelines = Pipelines::new(device, samples);
        let (corners, ranges) = meshes::corners();
        let mut forms = GrowingBuffer::new("space forms", BufferUsages::VERTEX);
        forms.put(device, &state.queue, &[bytemuck::cast_slice(&corners)]);
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("space frame"),
            size: size_of::<Frame>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("space frame"),
            layout: &pipelines.frame,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: frame.as_entire_binding(),
            }],
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("space pictures"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        Self {
            quality,
            samples,
            forms: (forms.into_buffer(), ranges),
            frame,
            frame_group,
            sampler,
            instances: GrowingBuffer::new("space instances", BufferUsages::VERTEX),
            corners: GrowingBuffer::new("space corners", BufferUsages::VERTEX),
            strokes: GrowingBuffer::new("space strokes", BufferUsages::VERTEX),
            dots: GrowingBuffer::new("space dots", BufferUsages::VERTEX),
            picture_corners: GrowingBuffer::new("space picture corners", BufferUsages::VERTEX),
            pictures: HashMap::new(),
            target: None,
            drawn: None,
            times: 0,
            pipelines,
            state,
        }
    }

    /// Draws into a texture for a picture of `pixels` on the screen, and returns it. Does nothing if the
    /// picture is unchanged.
    ///
    /// # Errors
    /// The error of the card, as a message for the user.
    pub(crate) fn draw(
        &mut self,
        draw_list: &DrawList,
        eye: &Eye,
        background: &Background,
        pixels: [u32; 2],
    ) -> Result<egui::TextureId, String> {
        let limit = self.state.device.limits().max_texture_dimension_2d;
        let pixels = pixels.map(|pixels| self.quality.pixels(pixels).clamp(1, limit));
        let frame = frame(eye, background, pixels);
        let mut hasher = DefaultHasher::new();
        (draw_list.fingerprint(), pixels, background.shown).hash(&mut hasher);
        bytemuck::bytes_of(&frame).hash(&mut hasher);
        let fingerprint = hasher.finish();
        if let (Some(target), Some(drawn)) = (&self.target, self.drawn)
            && drawn == fingerprint
        {
            return Ok(target.id());
        }
        self.drawn = None;
        let device = self.state.device.clone();
        let id = checked(&device, || self.paint(draw_list, &frame, background, pixels))?;
        self.drawn = Some(fingerprint);
        self.times += 1;
        Ok(id)
    }

    /// Maximum width and height of an image, in pixels.
    pub(crate) fn max_picture_side(&self) -> usize {
        self.state.device.limits().max_texture_dimension_2d as usize
    }

    #[cfg(test)]
    pub(crate) fn pictures_drawn(&self) -> u64 {
        self.times
    }

    fn paint(
        &mut self,
        draw_list: &DrawList,
        frame: &Frame,
        background: &Background,
        pixels: [u32; 2],
    ) -> egui::TextureId {
        let (device, queue) = (self.state.device.clone(), self.state.queue.clone());
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
        let forms: Vec<&[u8]> = (draw_list.opaque.iter().chain(&draw_list.translucent))
            .map(|list| bytemuck::cast_slice(list.as_slice()))
            .collect();
        self.instances.put(&device, &queue, &forms);
        let corners = [&draw_list.opaque_corners, &draw_list.translucent_corners]
            .map(|list| bytemuck::cast_slice(list));
        self.corners.put(&device, &queue, &corners);
        self.strokes
            .put(&device, &queue, &[bytemuck::cast_slice(&draw_list.strokes)]);
        self.dots
            .put(&device, &queue, &[bytemuck::cast_slice(&draw_list.dots)]);
        self.put_pictures(&draw_list.pictures);

        if self
            .target
            .as_ref()
            .is_none_or(|target| target.pixels() != pixels)
        {
            let before = self.target.take();
            self.target = Some(Target::new(&self.state, pixels, self.samples, before));
        }
        let target = self
            .target
            .as_ref()
            .expect("the target exists or was just created");
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = target.pass(&mut encoder, &frame.beyond);
            pass.set_bind_group(0, &self.frame_group, &[]);
            self.draw_opaque(&mut pass, draw_list);
            if background.shown {
                pass.set_pipeline(&self.pipelines.floor);
                pass.draw(0..4, 0..1);
            }
            self.draw_flat(&mut pass, draw_list);
            self.draw_translucent(&mut pass, draw_list);
        }
        queue.submit([encoder.finish()]);
        target.id()
    }

    fn draw_opaque(&self, pass: &mut wgpu::RenderPass<'_>, draw_list: &DrawList) {
        self.draw_forms(pass, &self.pipelines.opaque_forms, &draw_list.opaque, 0);
        if !draw_list.opaque_corners.is_empty() {
            pass.set_pipeline(&self.pipelines.opaque_corners);
            pass.set_vertex_buffer(0, self.corners.slice());
            pass.draw(0..draw_list.opaque_corners.len() as u32, 0..1);
        }
        pass.set_pipeline(&self.pipelines.pictures);
        for (number, picture) in draw_list.pictures.iter().enumerate() {
            let Some(shown) = self.pictures.get(&picture.name) else {
                continue;
            };
            pass.set_bind_group(1, &shown.group, &[]);
            pass.set_vertex_buffer(0, self.picture_corners.slice());
            let first = 4 * number as u32;
            pass.draw(first..first + 4, 0..1);
        }
    }

    fn draw_flat(&self, pass: &mut wgpu::RenderPass<'_>, draw_list: &DrawList) {
        for (pipeline, buffer, count) in [
            (&self.pipelines.strokes, &self.strokes, draw_list.strokes.len()),
            (&self.pipelines.dots, &self.dots, draw_list.dots.len()),
        ] {
            if count > 0 {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, buffer.slice());
                pass.draw(0..4, 0..count as u32);
            }
        }
    }

    fn draw_translucent(&self, pass: &mut wgpu::RenderPass<'_>, draw_list: &DrawList) {
        if !draw_list.translucent_corners.is_empty() {
            let first = draw_list.opaque_corners.len() as u32;
            pass.set_pipeline(&self.pipelines.translucent_corners);
            pass.set_vertex_buffer(0, self.corners.slice());
            pass.draw(first..first + draw_list.translucent_corners.len() as u32, 0..1);
        }
        let opaque: usize = draw_list.opaque.iter().map(Vec::len).sum();
        self.draw_forms(
            pass,
            &self.pipelines.translucent_forms,
            &draw_list.translucent,
            opaque,
        );
    }

    /// Draws the instances of `lists`, which begin at the instance `first` in the buffer.
    fn draw_forms(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        lists: &[Vec<Instance>; FORMS.len()],
        mut first: usize,
    ) {
        pass.set_pipeline(pipeline);
        for (list, corners) in lists.iter().zip(&self.forms.1) {
            if !list.is_empty() {
                pass.set_vertex_buffer(0, self.forms.0.slice(..));
                // Some cards cannot start at a first instance, so the buffer is bound with an offset instead.
                let from = (first * size_of::<Instance>()) as u64;
                pass.set_vertex_buffer(1, self.instances.slice_from(from));
                pass.draw(corners.clone(), 0..list.len() as u32);
                first += list.len();
            }
        }
    }

    fn put_pictures(&mut self, pictures: &[Picture]) {
        let (device, queue) = (&self.state.device, &self.state.queue);
        self.pictures
            .retain(|name, _| pictures.iter().any(|picture| picture.name == *name));
        let mut corners: Vec<[f32; 5]> = Vec::new();
        for picture in pictures {
            let [upper_left, upper_right, lower_right, lower_left] = picture.corners;
            // The order of a triangle strip.
            for (at, [u, v]) in [
                (upper_left, [0.0, 0.0]),
                (upper_right, [1.0, 0.0]),
                (lower_left, [0.0, 1.0]),
                (lower_right, [1.0, 1.0]),
            ] {
                corners.push([at.x, at.y, at.z, u, v]);
            }
            let known = self.pictures.remove(&picture.name);
            let shown = Shown::with(
                known,
                device,
                queue,
                (&self.pipelines.picture, &self.sampler),
                &picture.pixels,
            );
            self.pictures.insert(picture.name.clone(), shown);
        }
        self.picture_corners
            .put(device, queue, &[bytemuck::cast_slice(&corners)]);
    }
}

fn frame(eye: &Eye, background: &Background, pixels: [u32; 2]) -> Frame {
    let color = |color: egui::Color32| color.to_srgba_unmultiplied().map(|part| f32::from(part) / 255.0);
    let size = Vec2::new(pixels[0] as f32, pixels[1] as f32);
    let middle = eye.target;
    Frame {
        view_projection: eye.view_projection.to_cols_array_2d(),
        eye: eye.place.to_array(),
        distance: eye.distance,
        size: size.to_array(),
        scale: size.y / eye.size.y,
        spare: 0.0,
        sun: glam::Vec3::new(-0.35, -0.45, 0.82).normalize().to_array(),
        ambient: 0.34,
        floor: color(background.floor),
        beyond: color(background.beyond),
        lines: color(background.lines),
        middle: [middle.x, middle.y],
        reach: 6.0 * eye.distance,
        step: background.step,
    }
}
