//! The draw list of one frame: shapes in space, in a few large lists in the format of the graphics card. It
//! is cleared and filled each frame, so that it allocates no memory once it has grown.
//!
//! It knows no robots and no windows.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use eframe::egui::Color32;
use glam::{Affine3A, Mat3A, Quat, Vec3};

use crate::picture;

/// A mesh whose vertices are stored on the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Mesh {
    /// A cube with edges of length 1, centered.
    Box,
    /// A cylinder along z of diameter and height 1, centered.
    Cylinder,
    /// A sphere of diameter 1, centered.
    Sphere,
    /// A cone with its base of diameter 1 at z = 0, and its tip at z = 1.
    Cone,
}

/// The meshes, in the order of their numbers.
pub(crate) const FORMS: [Mesh; 4] = [Mesh::Box, Mesh::Cylinder, Mesh::Sphere, Mesh::Cone];

/// A mesh with its placement and color.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Instance {
    /// The rows of its affine matrix.
    pub(crate) rows: [[f32; 4]; 3],
    pub(crate) color: [u8; 4],
}

/// A vertex of a triangle.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Corner {
    pub(crate) at: [f32; 3],
    pub(crate) normal: [f32; 3],
    pub(crate) color: [u8; 4],
}

/// A straight line, or a dot if both ends are equal.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Stroke {
    pub(crate) from: [f32; 3],
    /// In points of the screen.
    pub(crate) width: f32,
    pub(crate) to: [f32; 3],
    pub(crate) color: [u8; 4],
}

/// An image. A different `stamp` means different pixels.
#[derive(Clone, Debug)]
pub(crate) struct Pixels {
    pub(crate) picture: picture::Picture,
    pub(crate) stamp: u64,
}

/// An image placed in space.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    /// Identifies its texture, which is kept from frame to frame.
    pub(crate) name: String,
    pub(crate) pixels: Arc<Pixels>,
    /// Upper left, upper right, lower right, lower left.
    pub(crate) corners: [Vec3; 4],
}

/// A text at a position.
#[derive(Clone, Debug)]
pub(crate) struct Label {
    pub(crate) at: Vec3,
    pub(crate) text: String,
    pub(crate) color: Color32,
}

/// A named object that can be clicked.
#[derive(Clone, Debug)]
pub(crate) struct Pickable {
    pub(crate) name: String,
    pub(crate) at: Vec3,
    pub(crate) radius: f32,
}

/// Everything to draw in a frame.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    /// Opaque instances, by mesh.
    pub(crate) opaque: [Vec<Instance>; FORMS.len()],
    /// Translucent instances, by mesh.
    pub(crate) translucent: [Vec<Instance>; FORMS.len()],
    pub(crate) opaque_corners: Vec<Corner>,
    pub(crate) translucent_corners: Vec<Corner>,
    pub(crate) strokes: Vec<Stroke>,
    pub(crate) dots: Vec<Stroke>,
    pub(crate) pictures: Vec<Picture>,
    pub(crate) labels: Vec<Label>,
    pub(crate) things: Vec<Pickable>,
}

/// The transform that rotates about x (roll), then y (pitch), then z (yaw), and then moves to `at`.
pub(crate) fn placed(at: Vec3, [roll, pitch, yaw]: [f32; 3]) -> Affine3A {
    let rotation = Quat::from_rotation_z(yaw) * Quat::from_rotation_y(pitch) * Quat::from_rotation_x(roll);
    Affine3A::from_rotation_translation(rotation, at)
}

impl DrawList {
    pub(crate) fn clear(&mut self) {
        self.opaque.iter_mut().for_each(Vec::clear);
        self.translucent.iter_mut().for_each(Vec::clear);
        self.opaque_corners.clear();
        self.translucent_corners.clear();
        self.strokes.clear();
        self.dots.clear();
        self.pictures.clear();
        self.labels.clear();
        self.things.clear();
    }

    /// Adds a mesh scaled to a size, with its origin at `pose`.
    pub(crate) fn form(&mut self, form: Mesh, pose: Affine3A, size: Vec3, color: Color32) {
        let Affine3A { matrix3, translation } = pose;
        let scaled = matrix3 * Mat3A::from_diagonal(size);
        let row = |row: usize| {
            let [x, y, z] = scaled.row(row).to_array();
            [x, y, z, translation[row]]
        };
        let instance = Instance {
            rows: [row(0), row(1), row(2)],
            color: straight(color),
        };
        let list = if instance.color[3] == 255 {
            &mut self.opaque
        } else {
            &mut self.translucent
        };
        list[form as usize].push(instance);
    }

    /// Adds a mesh with the middle of its base at `at` in the frame `pose`.
    pub(crate) fn upright(&mut self, form: Mesh, pose: Affine3A, at: Vec3, size: Vec3, color: Color32) {
        let middle = at + Vec3::Z * size.z / 2.0;
        self.form(form, pose * Affine3A::from_translation(middle), size, color);
    }

    /// Adds a triangle that is lit on both sides.
    pub(crate) fn triangle(&mut self, corners: [Vec3; 3], color: Color32) {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero().to_array();
        let color = straight(color);
        let list = if color[3] == 255 {
            &mut self.opaque_corners
        } else {
            &mut self.translucent_corners
        };
        list.extend(corners.map(|at| Corner {
            at: at.to_array(),
            normal,
            color,
        }));
    }

    /// Adds a line between two points. Its width is in points of the screen.
    pub(crate) fn line(&mut self, from: Vec3, to: Vec3, width: f32, color: Color32) {
        self.strokes.push(Stroke {
            from: from.to_array(),
            width,
            to: to.to_array(),
            color: straight(color),
        });
    }

    /// Adds lines through points in turn.
    pub(crate) fn lines(&mut self, points: impl IntoIterator<Item = Vec3>, width: f32, color: Color32) {
        let mut points = points.into_iter();
        let Some(mut before) = points.next() else { return };
        for point in points {
            self.line(before, point, width, color);
            before = point;
        }
    }

    /// Adds a round dot of a diameter in points of the screen.
    pub(crate) fn dot(&mut self, at: Vec3, width: f32, color: Color32) {
        self.dots.push(Stroke {
            from: at.to_array(),
            width,
            to: at.to_array(),
            color: straight(color),
        });
    }

    /// Adds an arrow with a shaft of this diameter.
    pub(crate) fn arrow(&mut self, from: Vec3, to: Vec3, diameter: f32, color: Color32) {
        let direction = to - from;
        let length = direction.length();
        if length < 1e-6 {
            return;
        }
        let rotation = Quat::from_rotation_arc(Vec3::Z, direction / length);
        let pose = Affine3A::from_rotation_translation(rotation, from);
        let head = (4.5 * diameter).min(length / 2.0);
        let shaft = length - head;
        self.upright(
            Mesh::Cylinder,
            pose,
            Vec3::ZERO,
            Vec3::new(diameter, diameter, shaft),
            color,
        );
        let tip = pose * Affine3A::from_translation(Vec3::Z * shaft);
        let wide = 0.6 * head;
        self.form(Mesh::Cone, tip, Vec3::new(wide, wide, head), color);
    }

    /// Adds a circle parallel to the floor.
    pub(crate) fn ring(&mut self, middle: Vec3, radius: f32, width: f32, color: Color32) {
        const PARTS: usize = 40;
        let point = |part: usize| {
            let (sin, cos) = (part as f32 / PARTS as f32 * std::f32::consts::TAU).sin_cos();
            middle + Vec3::new(cos, sin, 0.0) * radius
        };
        self.lines((0..=PARTS).map(point), width, color);
    }

    pub(crate) fn label(&mut self, at: Vec3, text: impl Into<String>, color: Color32) {
        self.labels.push(Label {
            at,
            text: text.into(),
            color,
        });
    }

    pub(crate) fn thing(&mut self, name: impl Into<String>, at: Vec3, radius: f32) {
        self.things.push(Pickable {
            name: name.into(),
            at,
            radius,
        });
    }

    /// Removes the images that exceed a card's limit. Returns the reasons as messages.
    pub(crate) fn remove_oversized_pictures(&mut self, limit: usize) -> Vec<String> {
        let mut reasons = Vec::new();
        self.pictures
            .retain(|shown| match picture::fits(shown.pixels.picture.size, limit) {
                Ok(()) => true,
                Err(reason) => {
                    reasons.push(format!("{}: {reason}", shown.name));
                    false
                }
            });
        reasons
    }

    /// A hash of everything that the card draws. Collisions are improbable.
    pub(crate) fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for list in self.opaque.iter().chain(&self.translucent) {
            bytemuck::cast_slice::<_, u8>(list).hash(&mut hasher);
        }
        for list in [&self.opaque_corners, &self.translucent_corners] {
            bytemuck::cast_slice::<_, u8>(list).hash(&mut hasher);
        }
        for list in [&self.strokes, &self.dots] {
            bytemuck::cast_slice::<_, u8>(list).hash(&mut hasher);
        }
        for picture in &self.pictures {
            (&picture.name, picture.pixels.stamp).hash(&mut hasher);
            bytemuck::bytes_of(&picture.corners.map(|corner| corner.to_array())).hash(&mut hasher);
        }
        hasher.finish()
    }
}

/// The color for the shaders: not premultiplied by its alpha.
pub(crate) fn straight(color: Color32) -> [u8; 4] {
    color.to_srgba_unmultiplied()
}
