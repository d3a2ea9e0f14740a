//! Intersections of rays with the shapes of a panel's scene. It neither draws nor reports gestures.

use glam::{Affine3A, Vec2, Vec3};
use jde_panel::Solid;

use super::orbit::{Eye, Ray};
use super::solids::{at, vector};

/// Distance within which thin shapes are hit, in points of the screen.
const HIT_DISTANCE: f32 = 6.0;

/// Intersects the ray through a point of the screen with a shape given in `frame`. Returns the distance from
/// the eye and the position, in m.
pub(crate) fn intersect(eye: &Eye, screen: Vec2, frame: Affine3A, solid: &Solid) -> Option<(f32, Vec3)> {
    let ray = eye.ray(screen);
    let point = |point: &[f64; 3]| frame.transform_point3(vector(*point));
    let distance = match solid {
        Solid::Box { place, size, .. } => slabs(&ray, frame * at(place), vector(*size) / 2.0),
        Solid::Cylinder {
            place,
            radius,
            height,
            ..
        } => cylinder(&ray, frame * at(place), *radius as f32, *height as f32 / 2.0),
        Solid::Sphere { center, radius, .. } => ray.ball(point(center), *radius as f32),
        Solid::Mesh { corners, .. } => corners
            .chunks_exact(3)
            .filter_map(|corners| triangle(&ray, [&corners[0], &corners[1], &corners[2]].map(point)))
            .min_by(f32::total_cmp),
        Solid::Line { points, .. } => points
            .windows(2)
            .filter_map(|pair| thin(eye, screen, [point(&pair[0]), point(&pair[1])]))
            .min_by(f32::total_cmp),
        Solid::Points { points, .. } => points
            .iter()
            .filter_map(|at| thin(eye, screen, [point(at), point(at)]))
            .min_by(f32::total_cmp),
        Solid::Arrow { from, to, .. } => thin(eye, screen, [point(from), point(to)]),
        // A text is not an object.
        Solid::Label { .. } => None,
    }?;
    (distance.is_finite() && distance > 0.0).then(|| (distance, ray.from + ray.along * distance))
}

/// Distance along a ray to a box with these half sizes.
fn slabs(ray: &Ray, place: Affine3A, half: Vec3) -> Option<f32> {
    let (from, along) = inside(ray, place);
    let (a, b) = ((-half - from) / along, (half - from) / along);
    let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
    (near <= far && far > 0.0).then_some(near)
}

/// Distance along a ray to a cylinder along z with this half height.
fn cylinder(ray: &Ray, place: Affine3A, radius: f32, half: f32) -> Option<f32> {
    let (from, along) = inside(ray, place);
    let (flat, direction) = (from.truncate(), along.truncate());
    let (a, b, c) = (
        direction.length_squared(),
        flat.dot(direction),
        flat.length_squared() - radius * radius,
    );
    // If the ray misses, the root is NaN, and the comparisons below are false.
    let side = (-b - (b * b - a * c).sqrt()) / a;
    let side = (side > 0.0 && (from.z + along.z * side).abs() <= half).then_some(side);
    let lids = [-half, half].map(|lid| (lid - from.z) / along.z);
    let lids = lids
        .into_iter()
        .filter(|distance| *distance > 0.0 && (flat + direction * distance).length() <= radius);
    side.into_iter().chain(lids).min_by(f32::total_cmp)
}

/// A ray in the frame of a shape. Lengths along it are preserved.
fn inside(ray: &Ray, place: Affine3A) -> (Vec3, Vec3) {
    let back = place.inverse();
    (back.transform_point3(ray.from), back.transform_vector3(ray.along))
}

/// Distance along a ray to a triangle, from either side (Möller and Trumbore).
fn triangle(ray: &Ray, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let across = ray.along.cross(ac);
    let size = ab.dot(across);
    if size.abs() < f32::EPSILON {
        return None;
    }
    let offset = ray.from - a;
    let u = offset.dot(across) / size;
    let over = offset.cross(ab);
    let v = ray.along.dot(over) / size;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ac.dot(over) / size)
}

/// Distance from the eye to a line segment that is near a point of the screen.
fn thin(eye: &Eye, screen: Vec2, [from, to]: [Vec3; 2]) -> Option<f32> {
    let (begin, end) = (eye.project(from)?, eye.project(to)?);
    let along = end - begin;
    let share = if along == Vec2::ZERO {
        0.0
    } else {
        ((screen - begin).dot(along) / along.length_squared()).clamp(0.0, 1.0)
    };
    let near = (begin + along * share).distance(screen) <= HIT_DISTANCE;
    near.then(|| from.lerp(to, share).distance(eye.place))
}

#[cfg(test)]
mod tests {
    use jde_panel::{Color, Ink, Place};

    use super::super::orbit::Orbit;
    use super::*;

    const SIZE: Vec2 = Vec2::new(640.0, 400.0);

    fn hit_position(solid: &Solid, toward: Vec3) -> Option<Vec3> {
        let eye = Orbit::default().eye(SIZE);
        let screen = eye.project(toward).expect("the point is in front of the eye");
        intersect(&eye, screen, Affine3A::from_translation(Vec3::X), solid).map(|(_, at)| at)
    }

    #[test]
    fn each_solid_is_hit_on_its_surface_and_missed_beside_it() {
        let color = Color::Ink(Ink::Plain);
        let place = Place {
            at: [0.0, 0.0, 0.5],
            turned: [0.0, 0.0, 0.7],
        };
        let middle = Vec3::new(1.0, 0.0, 0.5);
        /// Distance of a position from the surface. The position is relative to the middle of the shape.
        type Off = fn(Vec3) -> f32;
        let forms: [(Solid, Off); 4] = [
            (
                Solid::Sphere {
                    center: [0.0, 0.0, 0.5],
                    radius: 0.3,
                    color,
                },
                |off| off.length() - 0.3,
            ),
            (
                Solid::Box {
                    place,
                    size: [0.6; 3],
                    color,
                },
                |off| {
                    let turned = glam::Quat::from_rotation_z(-0.7) * off;
                    turned.abs().max_element() - 0.3
                },
            ),
            (
                Solid::Cylinder {
                    place,
                    radius: 0.3,
                    height: 0.6,
                    color,
                },
                |off| (off.truncate().length() - 0.3).max(off.z.abs() - 0.3),
            ),
            (
                Solid::Mesh {
                    corners: vec![[0.0, -2.0, 0.5], [0.0, 2.0, 0.5], [-2.0, 0.0, 0.5]],
                    color,
                },
                |off| off.z,
            ),
        ];
        for (form, outside) in &forms {
            let toward = middle - Vec3::new(0.05, 0.02, 0.0);
            let at = hit_position(form, toward).unwrap_or_else(|| panic!("{form:?}"));
            assert!(outside(at - middle).abs() < 2e-3, "{form:?} at {at}");
            assert_eq!(hit_position(form, Vec3::new(1.0, 3.0, 0.5)), None, "{form:?}");
        }
    }

    #[test]
    fn a_thin_shape_is_hit_near_it() {
        let color = Color::Ink(Ink::Plain);
        let line = Solid::Line {
            points: vec![[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
            color,
            width: 1.0,
        };
        let at = hit_position(&line, Vec3::new(1.0, 0.5, 0.0)).expect("the line is hit");
        assert!(at.distance(Vec3::new(1.0, 0.5, 0.0)) < 0.05, "{at}");
        assert_eq!(hit_position(&line, Vec3::new(1.0, 1.5, 0.0)), None);
    }
}
