// The shaders of the 3D view. Colors are in the screen's gamma space. Light is computed on their squares, which approximates linear light.

struct Frame {
    view_projection: mat4x4f,
    eye: vec3f,
    distance: f32,
    // The size of the picture in pixels, and the number of pixels per point of the screen.
    size: vec2f,
    scale: f32,
    spare: f32,
    sun: vec3f,
    ambient: f32,
    // The color of the floor in its middle, and that of the background beyond it.
    floor: vec4f,
    beyond: vec4f,
    lines: vec4f,
    middle: vec2f,
    reach: f32,
    // The distance between grid lines, in m.
    step: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

fn nearer(at: vec3f, part: f32) -> vec4f {
    return frame.view_projection * vec4f(at + (frame.eye - at) * part, 1.0);
}

// Meshes and triangles.

struct Lit {
    @builtin(position) position: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec4f,
}

@vertex
fn form(
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec4f,
    @location(3) x: vec4f,
    @location(4) y: vec4f,
    @location(5) z: vec4f,
    @location(6) tint: vec4f,
) -> Lit {
    let local = vec4f(at, 1.0);
    let place = vec3f(dot(x, local), dot(y, local), dot(z, local));
    // Under different scales along the axes, a normal is scaled by their inverses.
    let a = vec3f(x.x, y.x, z.x);
    let b = vec3f(x.y, y.y, z.y);
    let c = vec3f(x.z, y.z, z.z);
    let n = a * (normal.x / max(dot(a, a), 1e-12))
        + b * (normal.y / max(dot(b, b), 1e-12))
        + c * (normal.z / max(dot(c, c), 1e-12));
    return Lit(frame.view_projection * vec4f(place, 1.0), place, n, color * tint);
}

@vertex
fn corner(@location(0) at: vec3f, @location(1) normal: vec3f, @location(2) color: vec4f) -> Lit {
    return Lit(frame.view_projection * vec4f(at, 1.0), at, normal, color);
}

fn shade(lit: Lit) -> vec3f {
    let toward = normalize(frame.eye - lit.at);
    var n = normalize(lit.normal);
    if dot(n, toward) < 0.0 {
        n = -n;
    }
    let key = max(dot(n, frame.sun), 0.0);
    let sky = 0.5 + 0.5 * n.z;
    let lamp = max(dot(n, toward), 0.0);
    let glint = pow(max(dot(reflect(-frame.sun, n), toward), 0.0), 24.0);
    let light = frame.ambient * (0.45 + 0.55 * sky) + 0.58 * key + 0.22 * lamp;
    let color = lit.color.rgb * lit.color.rgb * light + vec3f(0.05 * glint);
    return sqrt(clamp(color, vec3f(0.0), vec3f(1.0)));
}

@fragment
fn lit(in: Lit) -> @location(0) vec4f {
    return vec4f(shade(in) * in.color.a, in.color.a);
}

// Lines and dots: their width is in points of the screen.

struct Flat {
    @builtin(position) position: vec4f,
    @location(0) color: vec4f,
    // The offset from the middle of a dot, and its radius, in pixels.
    @location(1) off: vec2f,
    @location(2) radius: f32,
}

@vertex
fn stroke(
    @builtin(vertex_index) index: u32,
    @location(0) from_: vec3f,
    @location(1) width: f32,
    @location(2) to_: vec3f,
    @location(3) color: vec4f,
) -> Flat {
    var a = nearer(from_, 0.004);
    var b = nearer(to_, 0.004);
    // The part behind the eye is cut off.
    let least = 0.02 * frame.distance;
    if a.w < least && b.w < least {
        return Flat(vec4f(0.0, 0.0, -2.0, 1.0), color, vec2f(0.0), 1.0);
    }
    if a.w < least {
        a = mix(b, a, (b.w - least) / (b.w - a.w));
    }
    if b.w < least {
        b = mix(a, b, (a.w - least) / (a.w - b.w));
    }
    let half_size = frame.size * 0.5;
    var along = b.xy / b.w * half_size - a.xy / a.w * half_size;
    let length_ = length(along);
    along = select(vec2f(1.0, 0.0), along / max(length_, 1e-6), length_ > 1e-6);
    let half_width = max(width * frame.scale, 1.0) * 0.5;
    let side = select(-1.0, 1.0, (index & 1u) == 1u);
    let end = select(-1.0, 1.0, (index & 2u) == 2u);
    var at = select(a, b, end > 0.0);
    let off = vec2f(-along.y, along.x) * side * half_width;
    at = vec4f(at.xy + off / half_size * at.w, at.zw);
    return Flat(at, color, vec2f(0.0), 1.0);
}

@fragment
fn plain(in: Flat) -> @location(0) vec4f {
    return vec4f(in.color.rgb * in.color.a, in.color.a);
}

@vertex
fn dot_(
    @builtin(vertex_index) index: u32,
    @location(0) from_: vec3f,
    @location(1) width: f32,
    @location(2) to_: vec3f,
    @location(3) color: vec4f,
) -> Flat {
    let at = nearer(from_, 0.006);
    let radius = max(width * frame.scale, 1.5) * 0.5;
    let corner_ = vec2f(select(-1.0, 1.0, (index & 1u) == 1u), select(-1.0, 1.0, (index & 2u) == 2u));
    let off = corner_ * (radius + 1.0);
    let place = vec4f(at.xy + off / (frame.size * 0.5) * at.w, at.zw);
    return Flat(place, color, off, radius);
}

@fragment
fn round(in: Flat) -> @location(0) vec4f {
    let cover = clamp(in.radius - length(in.off) + 0.5, 0.0, 1.0);
    if cover <= 0.01 {
        discard;
    }
    let alpha = in.color.a * cover;
    return vec4f(in.color.rgb * alpha, alpha);
}

// The floor, with a grid line at each step and a stronger one at every tenth.

struct Floor {
    @builtin(position) position: vec4f,
    @location(0) at: vec2f,
}

@vertex
fn floor_corner(@builtin(vertex_index) index: u32) -> Floor {
    let corner_ = vec2f(select(-1.0, 1.0, (index & 1u) == 1u), select(-1.0, 1.0, (index & 2u) == 2u));
    let at = frame.middle + corner_ * frame.reach;
    return Floor(frame.view_projection * vec4f(at, 0.0, 1.0), at);
}

fn lines(at: vec2f, step: f32, width: f32) -> f32 {
    let scaled = at / step;
    let change = max(fwidth(scaled), vec2f(1e-6));
    let near = abs(fract(scaled - 0.5) - 0.5) / change;
    let cover = clamp(vec2f(0.5 + 0.5 * width) - near, vec2f(0.0), vec2f(1.0));
    // Lines that would merge fade out.
    let fade = clamp(vec2f(1.2) - change * 4.0, vec2f(0.0), vec2f(1.0));
    return max(cover.x * fade.x, cover.y * fade.y);
}

@fragment
fn floor_(in: Floor) -> @location(0) vec4f {
    let away = length(in.at - frame.middle) / frame.reach;
    let fade = clamp(1.0 - away, 0.0, 1.0);
    let width = frame.scale;
    let fine = lines(in.at, frame.step, width) * 0.55;
    let coarse = lines(in.at, frame.step * 10.0, width * 1.4);
    var color = mix(frame.beyond.rgb, frame.floor.rgb, fade);
    color = mix(color, frame.lines.rgb, max(fine, coarse) * frame.lines.a * fade);
    return vec4f(color, 1.0);
}

// Images of cameras.

@group(1) @binding(0) var pixels: texture_2d<f32>;
@group(1) @binding(1) var sampler_: sampler;

struct Shown {
    @builtin(position) position: vec4f,
    @location(0) at: vec2f,
}

@vertex
fn picture(@location(0) at: vec3f, @location(1) uv: vec2f) -> Shown {
    return Shown(frame.view_projection * vec4f(at, 1.0), uv);
}

@fragment
fn shown(in: Shown) -> @location(0) vec4f {
    return textureSample(pixels, sampler_, in.at);
}
