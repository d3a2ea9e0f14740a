//! The pipelines of the 3D view, which turn the draw list into pixels. Created once per card.

use std::mem::size_of;

use wgpu::{
    BlendState, CompareFunction, DepthStencilState, Device, PrimitiveTopology, RenderPipeline, ShaderModule,
    TextureFormat, VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::super::draw_list::{Corner, Instance, Stroke};

/// The format in which egui takes textures.
pub(super) const COLOR: TextureFormat = TextureFormat::Rgba8Unorm;
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Size of an image's vertex, in bytes: its position and texture coordinate.
pub(super) const PICTURE_CORNER: usize = 5 * size_of::<f32>();

pub(super) struct Pipelines {
    pub(super) floor: RenderPipeline,
    pub(super) opaque_forms: RenderPipeline,
    pub(super) translucent_forms: RenderPipeline,
    pub(super) opaque_corners: RenderPipeline,
    pub(super) translucent_corners: RenderPipeline,
    pub(super) strokes: RenderPipeline,
    pub(super) dots: RenderPipeline,
    pub(super) pictures: RenderPipeline,
    pub(super) frame: wgpu::BindGroupLayout,
    pub(super) picture: wgpu::BindGroupLayout,
}

/// The properties in which the pipelines differ.
struct PipelineKind<'a> {
    vertex: &'a str,
    fragment: &'a str,
    buffers: &'a [Option<VertexBufferLayout<'a>>],
    topology: PrimitiveTopology,
    /// Whether it writes depth, which hides what is drawn later behind it.
    writes_depth: bool,
    pictures: bool,
}

impl Pipelines {
    pub(super) fn new(device: &Device, samples: u32) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("space.wgsl"));
        let frame = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("space frame"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let picture = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("space picture"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                    count: None,
                },
                wgpu::BindGroupLayoutEntry {
                    binding: 1,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                    count: None,
                },
            ],
        });
        let corner = VertexBufferLayout {
            array_stride: size_of::<Corner>() as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4],
        };
        let instance = VertexBufferLayout {
            array_stride: size_of::<Instance>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 6 => Unorm8x4],
        };
        let stroke = VertexBufferLayout {
            array_stride: size_of::<Stroke>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Unorm8x4],
        };
        let shown = VertexBufferLayout {
            array_stride: PICTURE_CORNER as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex_attr_array![0 => Float32x3, 1 => Float32x2],
        };
        let make = |kind: PipelineKind<'_>| {
            let layouts: &[_] = if kind.pictures {
                &[Some(&frame), Some(&picture)]
            } else {
                &[Some(&frame)]
            };
            pipeline(device, &module, layouts, samples, kind)
        };
        let forms = [Some(corner.clone()), Some(instance)];
        let corners = [Some(corner)];
        let strokes = [Some(stroke)];
        let form = |writes_depth| PipelineKind {
            vertex: "form",
            fragment: "lit",
            buffers: &forms,
            topology: PrimitiveTopology::TriangleList,
            writes_depth,
            pictures: false,
        };
        let triangle = |writes_depth| PipelineKind {
            vertex: "corner",
            fragment: "lit",
            buffers: &corners,
            topology: PrimitiveTopology::TriangleList,
            writes_depth,
            pictures: false,
        };
        let quad = |vertex, fragment, buffers, writes_depth| PipelineKind {
            vertex,
            fragment,
            buffers,
            topology: PrimitiveTopology::TriangleStrip,
            writes_depth,
            pictures: false,
        };
        Self {
            floor: make(quad("floor_corner", "floor_", &[], false)),
            opaque_forms: make(form(true)),
            translucent_forms: make(form(false)),
            opaque_corners: make(triangle(true)),
            translucent_corners: make(triangle(false)),
            strokes: make(quad("stroke", "plain", &strokes, false)),
            dots: make(quad("dot_", "round", &strokes, true)),
            pictures: make(PipelineKind {
                vertex: "picture",
                fragment: "shown",
                buffers: &[Some(shown)],
                topology: PrimitiveTopology::TriangleStrip,
                writes_depth: true,
                pictures: true,
            }),
            frame,
            picture,
        }
    }
}

fn pipeline(
    device: &Device,
    module: &ShaderModule,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    samples: u32,
    kind: PipelineKind<'_>,
) -> RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(kind.vertex),
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(kind.vertex),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(kind.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: kind.buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: kind.topology,
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(kind.writes_depth),
            depth_compare: Some(CompareFunction::LessEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: samples,
            ..wgpu::MultisampleState::default()
        },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(kind.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOR,
                blend: Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
