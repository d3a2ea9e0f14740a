//! The vertices of the meshes that are drawn many times.

use std::f32::consts::TAU;
use std::ops::Range;

use glam::Vec3;

use super::super::draw_list::{Corner, FORMS, Mesh};

/// Sides of round meshes: smooth at the size of a robot on a screen.
const ROUND_SIDES: usize = 28;
/// Rings of a sphere from pole to pole.
const SPHERE_RINGS: usize = 14;

/// The vertices of all meshes, and the range of each.
pub(super) fn corners() -> (Vec<Corner>, [Range<u32>; FORMS.len()]) {
    let mut all = Vec::new();
    let ranges = FORMS.map(|form| {
        let from = all.len() as u32;
        match form {
            Mesh::Box => cube(&mut all),
            Mesh::Cylinder => surface_around_z(&mut all, |side| {
                let (out, low, high) = (unit_at(side), -0.5, 0.5);
                [(out * 0.5).with_z(low), (out * 0.5).with_z(high)]
            }),
            Mesh::Sphere => sphere(&mut all),
            Mesh::Cone => surface_around_z(&mut all, |side| [unit_at(side) * 0.5, Vec3::Z]),
        }
        from..all.len() as u32
    });
    (all, ranges)
}

fn cube(all: &mut Vec<Corner>) {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut normal = Vec3::ZERO;
            normal[axis] = sign;
            let (u, v) = (Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3] * sign);
            let corner = |a: f32, b: f32| (normal + u * a + v * b) * 0.5;
            let [a, b, c, d] = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ];
            for at in [a, b, c, a, c, d] {
                push(all, at, normal);
            }
        }
    }
}

/// Adds a surface around z, from the lower to the upper end of each side, closed by discs.
fn surface_around_z(all: &mut Vec<Corner>, ends: impl Fn(usize) -> [Vec3; 2]) {
    for side in 0..ROUND_SIDES {
        let [low, high] = ends(side);
        let [next_low, next_high] = ends(side + 1);
        let normal = |side: usize| {
            let [low, high] = ends(side);
            let along = high - low;
            let out = unit_at(side);
            (out - along * (out.dot(along) / along.length_squared())).normalize()
        };
        let (current, next) = (normal(side), normal(side + 1));
        for (at, normal) in [
            (low, current),
            (next_low, next),
            (next_high, next),
            (low, current),
            (next_high, next),
            (high, current),
        ] {
            push(all, at, normal);
        }
        for (a, b, normal) in [(next_low, low, Vec3::NEG_Z), (high, next_high, Vec3::Z)] {
            for at in [Vec3::Z * a.z, a, b] {
                push(all, at, normal);
            }
        }
    }
}

fn sphere(all: &mut Vec<Corner>) {
    let point = |side: usize, ring: usize| {
        let (sin, cos) = (ring as f32 / SPHERE_RINGS as f32 * TAU / 2.0).sin_cos();
        (unit_at(side) * sin).with_z(cos)
    };
    for side in 0..ROUND_SIDES {
        for ring in 0..SPHERE_RINGS {
            let (a, b) = (point(side, ring), point(side + 1, ring));
            let (c, d) = (point(side + 1, ring + 1), point(side, ring + 1));
            for normal in [a, d, c, a, c, b] {
                push(all, normal * 0.5, normal);
            }
        }
    }
}

fn unit_at(side: usize) -> Vec3 {
    let (sin, cos) = (side as f32 / ROUND_SIDES as f32 * TAU).sin_cos();
    Vec3::new(cos, sin, 0.0)
}

fn push(all: &mut Vec<Corner>, at: Vec3, normal: Vec3) {
    all.push(Corner {
        at: at.to_array(),
        normal: normal.to_array(),
        color: [255; 4],
    });
}
