// Triangles with vertex colors only, or multiplied by a texture. Each kind has its own entry point, because a software renderer executes all branches.

struct Corner {
    @builtin(position) place: vec4<f32>,
    @location(0) tint: vec4<f32>,
    @location(1) texel: vec2<f32>,
}

@group(0) @binding(0) var texels: texture_2d<f32>;
@group(0) @binding(1) var reading: sampler;

@vertex
fn corner(
    @location(0) place: vec2<f32>,
    @location(1) texel: vec2<f32>,
    @location(2) tint: vec4<f32>,
) -> Corner {
    return Corner(vec4<f32>(place, 0.0, 1.0), tint, texel);
}

@fragment
fn solid(@location(0) tint: vec4<f32>) -> @location(0) vec4<f32> {
    return tint;
}

@fragment
fn textured(@location(0) tint: vec4<f32>, @location(1) texel: vec2<f32>) -> @location(0) vec4<f32> {
    return tint * textureSample(texels, reading, texel);
}
