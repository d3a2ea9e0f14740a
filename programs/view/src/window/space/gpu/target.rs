//! Resources that stay on the card from frame to frame: the target texture, buffers that grow, and textures
//! of images.

use std::sync::Arc;
use std::task::{Context, Poll, Waker};

use eframe::egui;
use eframe::egui::mutex::RwLock;
use eframe::egui_wgpu::{RenderState, Renderer};
use wgpu::{Buffer, BufferUsages, Device, ErrorFilter, Queue};

use super::super::draw_list::Pixels;
use super::pipelines::{COLOR, DEPTH};

/// Runs `work` with the card. Returns the first error of the card as a message.
pub(super) fn checked<T>(device: &Device, work: impl FnOnce() -> T) -> Result<T, String> {
    let scopes = [
        ErrorFilter::Internal,
        ErrorFilter::OutOfMemory,
        ErrorFilter::Validation,
    ]
    .map(|filter| device.push_error_scope(filter));
    let result = work();
    let mut error = None;
    for scope in scopes.into_iter().rev() {
        let mut popped = std::pin::pin!(scope.pop());
        // The result is available at once on all platforms except the web.
        if let Poll::Ready(Some(popped_error)) = popped.as_mut().poll(&mut Context::from_waker(Waker::noop()))
        {
            error.get_or_insert(popped_error.to_string());
        }
    }
    match error {
        None => Ok(result),
        Some(reason) => Err(format!("the graphics card refused: {reason}")),
    }
}

/// A buffer that grows as needed.
pub(super) struct GrowingBuffer {
    label: &'static str,
    usage: BufferUsages,
    buffer: Option<Buffer>,
}

impl GrowingBuffer {
    pub(super) fn new(label: &'static str, usage: BufferUsages) -> Self {
        Self {
            label,
            usage: usage | BufferUsages::COPY_DST,
            buffer: None,
        }
    }

    /// Writes lists into the buffer, one after the other.
    pub(super) fn put(&mut self, device: &Device, queue: &Queue, lists: &[&[u8]]) {
        let bytes: usize = lists.iter().map(|list| list.len()).sum();
        if self
            .buffer
            .as_ref()
            .is_none_or(|buffer| buffer.size() < bytes as u64)
        {
            self.buffer = Some(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size: bytes.next_power_of_two().max(256) as u64,
                usage: self.usage,
                mapped_at_creation: false,
            }));
        }
        if let Some(buffer) = &self.buffer {
            let mut at = 0;
            for list in lists {
                if !list.is_empty() {
                    queue.write_buffer(buffer, at, list);
                    at += list.len() as u64;
                }
            }
        }
    }

    pub(super) fn slice(&self) -> wgpu::BufferSlice<'_> {
        self.slice_from(0)
    }

    pub(super) fn slice_from(&self, from: u64) -> wgpu::BufferSlice<'_> {
        self.buffer
            .as_ref()
            .expect("the buffer was written before")
            .slice(from..)
    }

    pub(super) fn into_buffer(self) -> Buffer {
        self.buffer.expect("the buffer was written before")
    }
}

/// The target texture. It is registered with egui until dropped.
pub(super) struct Target {
    pixels: [u32; 2],
    /// The multisampled texture, which is resolved into the shown texture.
    multisampled: Option<wgpu::TextureView>,
    resolved: wgpu::TextureView,
    depth: wgpu::TextureView,
    shown: Registered,
}

struct Registered {
    id: egui::TextureId,
    renderer: Arc<RwLock<Renderer>>,
}

impl Drop for Registered {
    fn drop(&mut self) {
        self.renderer.write().free_texture(&self.id);
    }
}

impl Target {
    /// Creates a target. It takes over the texture id of `previous`, so that egui continues to use it.
    pub(super) fn new(state: &RenderState, pixels: [u32; 2], samples: u32, previous: Option<Self>) -> Self {
        let texture = |format, samples, usage| {
            let texture = state.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("space"),
                size: wgpu::Extent3d {
                    width: pixels[0],
                    height: pixels[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let resolved = texture(COLOR, 1, wgpu::TextureUsages::TEXTURE_BINDING);
        let none = wgpu::TextureUsages::empty();
        let mut renderer = state.renderer.write();
        // With one sample per pixel, the picture is smoothed when it is scaled up to the screen.
        let filter = if samples > 1 {
            wgpu::FilterMode::Nearest
        } else {
            wgpu::FilterMode::Linear
        };
        let shown = match previous {
            Some(previous) => {
                let id = previous.shown.id;
                renderer.update_egui_texture_from_wgpu_texture(&state.device, &resolved, filter, id);
                previous.shown
            }
            None => Registered {
                id: renderer.register_native_texture(&state.device, &resolved, filter),
                renderer: Arc::clone(&state.renderer),
            },
        };
        drop(renderer);
        Self {
            pixels,
            multisampled: (samples > 1).then(|| texture(COLOR, samples, none)),
            depth: texture(DEPTH, samples, none),
            resolved,
            shown,
        }
    }

    pub(super) fn id(&self) -> egui::TextureId {
        self.shown.id
    }

    pub(super) fn pixels(&self) -> [u32; 2] {
        self.pixels
    }

    /// Begins a render pass that clears to a color.
    pub(super) fn pass<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        color: &[f32; 4],
    ) -> wgpu::RenderPass<'a> {
        let [r, g, b, _] = color.map(f64::from);
        let (view, resolve_target) = match &self.multisampled {
            Some(multisampled) => (multisampled, Some(&self.resolved)),
            None => (&self.resolved, None),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("space"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                resolve_target,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: if self.multisampled.is_some() {
                        wgpu::StoreOp::Discard
                    } else {
                        wgpu::StoreOp::Store
                    },
                },
                depth_slice: None,
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}

/// The texture of an image.
pub(super) struct Shown {
    texture: wgpu::Texture,
    stamp: u64,
    pub(super) group: wgpu::BindGroup,
}

impl Shown {
    /// Uploads pixels, into the texture of `previous` if the size is the same. Unchanged pixels are not
    /// uploaded again.
    pub(super) fn with(
        previous: Option<Self>,
        device: &Device,
        queue: &Queue,
        (layout, sampler): (&wgpu::BindGroupLayout, &wgpu::Sampler),
        pixels: &Pixels,
    ) -> Self {
        let [width, height] = pixels.picture.size.map(|side| side as u32);
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let mut shown = previous
            .filter(|shown| shown.texture.size() == size)
            .unwrap_or_else(|| {
                let texture = device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("space picture"),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: COLOR,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                });
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("space picture"),
                    layout,
                    entries: &[
                        wgpu::BindGroupEntry {
                            binding: 0,
                            resource: wgpu::BindingResource::TextureView(&view),
                        },
                        wgpu::BindGroupEntry {
                            binding: 1,
                            resource: wgpu::BindingResource::Sampler(sampler),
                        },
                    ],
                });
                Self {
                    texture,
                    stamp: !pixels.stamp,
                    group,
                }
            });
        if shown.stamp != pixels.stamp {
            queue.write_texture(
                shown.texture.as_image_copy(),
                &pixels.picture.rgba,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * width),
                    rows_per_image: None,
                },
                size,
            );
            shown.stamp = pixels.stamp;
        }
        shown
    }
}
