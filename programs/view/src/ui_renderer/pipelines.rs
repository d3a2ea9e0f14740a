//! The render pipelines, created once: for triangles with a texture and for solid ones.

use std::num::NonZeroU64;

use wgpu::{
    BindingType, BlendComponent, BlendFactor, BlendOperation, BlendState, Device, ShaderStages, TextureFormat,
};

/// Size of the uniform with which egui describes a texture to its shader, in bytes.
const TEXTURE_FLAGS: u64 = 16;

/// The pipelines of all kinds of triangles.
#[derive(Clone)]
pub(super) struct Pipelines {
    pub(super) solid: wgpu::RenderPipeline,
    pub(super) textured: wgpu::RenderPipeline,
}

impl Pipelines {
    pub(super) fn new(device: &Device, format: TextureFormat) -> Self {
        let texture = texture_layout(device);
        let shader = device.create_shader_module(wgpu::include_wgsl!("ui.wgsl"));
        let pipe = |entry: &str, groups: &[Option<&wgpu::BindGroupLayout>], blend| {
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("ui renderer"),
                bind_group_layouts: groups,
                immediate_size: 0,
            });
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("ui renderer"),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &shader,
                    entry_point: Some("corner"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    // The layout of egui's vertices.
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: size_of::<eframe::egui::epaint::Vertex>() as u64,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4],
                    })],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &shader,
                    entry_point: Some(entry),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format,
                        blend,
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            solid: pipe("solid", &[], None),
            textured: pipe("textured", &[Some(&texture)], Some(OVER)),
        }
    }
}

/// Blends premultiplied colors over the background, in egui's gamma space.
const OVER: BlendState = BlendState {
    color: BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor: BlendFactor::OneMinusSrcAlpha,
        operation: BlendOperation::Add,
    },
    alpha: BlendComponent {
        src_factor: BlendFactor::OneMinusDstAlpha,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    },
};

/// The layout of the textures in egui's renderer. It must match exactly, so that those bind groups can be
/// used here.
fn texture_layout(device: &Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("ui renderer texture"),
        entries: &[
            entry(
                0,
                BindingType::Texture {
                    multisampled: false,
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2,
                },
            ),
            entry(1, BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            entry(
                2,
                BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: NonZeroU64::new(TEXTURE_FLAGS),
                },
            ),
        ],
    })
}
