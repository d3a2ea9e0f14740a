//! Shapes in space, seen from above: what a robot meets of them between the floor and [`OVERHEAD`].

use std::array;
use std::f64::consts::TAU;

use super::super::OVERHEAD;
use super::pose3::Pose3;

/// The least height of a thing, m: less is a mark on the floor.
const FLAT: f64 = 0.005;
/// The greatest sine of a tilt that counts as none: the rounding of saved states.
const UPRIGHT: f64 = 1e-3;
/// The least width of a thing, m, and the least distance of two points of an outline: the resolution of what is written.
const MIN_WIDTH: f64 = 1e-5;
/// The greatest coordinate and size, m: a tenth of what a world file may have.
pub(super) const FAR: f64 = 1e4;
/// The corners for which a circle stands that is not seen from its end.
const CORNERS: usize = 32;

/// A shape with its sizes, m. The axis of a round one is z, and the middle of its length is the origin.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Primitive {
    Box([f64; 3]),
    Cylinder {
        radius: f64,
        length: f64,
    },
    Capsule {
        radius: f64,
        length: f64,
    },
    Cone {
        radius: f64,
        length: f64,
    },
    Sphere(f64),
    /// Its radii.
    Ellipsoid([f64; 3]),
    /// An outline that rises from the origin.
    Prism {
        points: Vec<[f64; 2]>,
        height: f64,
    },
}

/// What a robot meets.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Plan {
    Box {
        center: [f64; 2],
        size: [f64; 2],
        angle: f64,
    },
    Circle {
        center: [f64; 2],
        radius: f64,
    },
    /// It is neither, or tilted.
    Outline(Vec<[f64; 2]>),
}

impl Primitive {
    /// Returns what a robot meets and its height above the floor, or why it meets nothing.
    pub(super) fn seen(&self, pose: Pose3) -> Result<(Plan, f64), String> {
        let numbers = self.sizes();
        if !numbers.iter().all(|size| *size >= MIN_WIDTH) {
            return Err("its size is not above 0".to_owned());
        }
        let corners = if let Self::Prism { points, .. } = self {
            points.as_slice()
        } else {
            &[]
        };
        let coordinates = pose.at.iter().chain(corners.iter().flatten()).chain(&numbers);
        // What is not a number is not near either.
        if !coordinates.into_iter().all(|part| part.abs() < FAR) {
            return Err("it is beyond 10 km".to_owned());
        }
        let [bottom, top] = self.heights(pose);
        if bottom > OVERHEAD {
            return Err(format!("it is {bottom:.2} m above the floor"));
        }
        if top <= FLAT {
            return Err("it does not rise above the floor".to_owned());
        }
        let nothing = || "it does not rise above the floor".to_owned();
        self.plan(pose).map(|plan| (plan, top)).ok_or_else(nothing)
    }

    fn sizes(&self) -> Vec<f64> {
        match self {
            Self::Box(sizes) | Self::Ellipsoid(sizes) => sizes.to_vec(),
            Self::Cylinder { radius, length } | Self::Cone { radius, length } => vec![*radius, *length],
            // One without a length is a sphere.
            Self::Capsule { radius, length } => vec![*radius, length.max(MIN_WIDTH)],
            Self::Sphere(radius) => vec![*radius],
            Self::Prism { height, .. } => vec![*height],
        }
    }

    /// Returns the lower and the upper edge.
    fn heights(&self, pose: Pose3) -> [f64; 2] {
        let z = pose.at[2];
        let [x_up, y_up, z_up] = pose.axes().map(|axis| axis[2]);
        let disc = |radius: f64| radius * (1.0 - z_up * z_up).max(0.0).sqrt();
        let half = match self {
            Self::Box([a, b, c]) => ((a * x_up).abs() + (b * y_up).abs() + (c * z_up).abs()) / 2.0,
            Self::Cylinder { radius, length } => length / 2.0 * z_up.abs() + disc(*radius),
            Self::Capsule { radius, length } => length / 2.0 * z_up.abs() + radius,
            Self::Sphere(radius) => *radius,
            Self::Ellipsoid([a, b, c]) => libm::hypot(libm::hypot(a * x_up, b * y_up), c * z_up),
            Self::Cone { radius, length } => {
                let (tip, base) = (length / 2.0 * z_up, -length / 2.0 * z_up);
                return [
                    z + tip.min(base - disc(*radius)),
                    z + tip.max(base + disc(*radius)),
                ];
            }
            Self::Prism { points, height } => {
                let ends = points.iter().flat_map(|&[x, y]| [[x, y, 0.0], [x, y, *height]]);
                return ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
                    let z = pose.point(point)[2];
                    [low.min(z), high.max(z)]
                });
            }
        };
        [z - half, z + half]
    }

    fn plan(&self, pose: Pose3) -> Option<Plan> {
        let center = [pose.at[0], pose.at[1]];
        let axes = pose.axes();
        let [_, _, up] = axes;
        let is_upright = libm::hypot(up[0], up[1]) <= UPRIGHT;
        let circle = |radius: f64| (radius >= MIN_WIDTH).then_some(Plan::Circle { center, radius });
        match self {
            Self::Box(sizes) => {
                // The axis that is upright, whichever it is.
                let is_upright = |axis: &usize| libm::hypot(axes[*axis][0], axes[*axis][1]) <= UPRIGHT;
                if let Some(upright) = [2, 0, 1].into_iter().find(is_upright) {
                    let (along, across) = ((upright + 1) % 3, (upright + 2) % 3);
                    return Some(Plan::Box {
                        center,
                        size: [sizes[along], sizes[across]],
                        angle: libm::atan2(axes[along][1], axes[along][0]),
                    });
                }
                let [a, b, c] = sizes.map(|size| size / 2.0);
                let corners = [-a, a]
                    .into_iter()
                    .flat_map(|x| [-b, b].into_iter().flat_map(move |y| [-c, c].map(|z| [x, y, z])));
                outline(pose, corners.collect())
            }
            Self::Cylinder { radius, .. } if is_upright => circle(*radius),
            Self::Cylinder { radius, length } => {
                if up[2].abs() <= UPRIGHT {
                    let width = 2.0 * chord(*radius, pose.at[2], 0.0);
                    return (width >= MIN_WIDTH).then(|| Plan::Box {
                        center,
                        size: [*length, width],
                        angle: libm::atan2(up[1], up[0]),
                    });
                }
                let half = length / 2.0;
                outline(pose, [ring(*radius, -half), ring(*radius, half)].concat())
            }
            Self::Capsule { radius, length } if is_upright => {
                circle(chord(*radius, pose.at[2], length / 2.0))
            }
            Self::Capsule { radius, length } => {
                let half = length / 2.0;
                let ends = [-half, half].map(|z| ball([*radius; 3], z));
                outline(pose, ends.concat())
            }
            Self::Sphere(radius) => circle(chord(*radius, pose.at[2], 0.0)),
            Self::Cone { radius, length } => {
                let half = length / 2.0;
                if is_upright && up[2] > 0.0 {
                    // The widest part above the floor.
                    let below = (half - pose.at[2]).max(0.0);
                    return circle(radius * (1.0 - below / length));
                }
                let mut points = ring(*radius, -half);
                points.push([0.0, 0.0, half]);
                outline(pose, points)
            }
            Self::Ellipsoid(radii) => outline(pose, ball(*radii, 0.0)),
            Self::Prism { points, height } => {
                if is_upright && up[2] > 0.0 {
                    let seen = points.iter().map(|&[x, y]| pose.point([x, y, 0.0]));
                    return closed(seen.map(|[x, y, _]| [x, y]).collect());
                }
                let ends = points.iter().flat_map(|&[x, y]| [[x, y, 0.0], [x, y, *height]]);
                outline(pose, ends.collect())
            }
        }
    }
}

/// Returns half of the width, between the floor and [`OVERHEAD`], of a sphere whose middle is `half` around a height.
fn chord(radius: f64, z: f64, half: f64) -> f64 {
    let away = (z - half - OVERHEAD).max(-(z + half)).max(0.0);
    (radius * radius - away * away).max(0.0).sqrt()
}

/// Returns the corners of a circle about the axis z.
fn ring(radius: f64, z: f64) -> Vec<[f64; 3]> {
    let corner = |index: usize| {
        let (sin, cos) = libm::sincos(TAU * index as f64 / CORNERS as f64);
        [radius * cos, radius * sin, z]
    };
    (0..CORNERS).map(corner).collect()
}

/// Returns points of an ellipsoid whose middle is at a place of the axis z.
fn ball([a, b, c]: [f64; 3], z: f64) -> Vec<[f64; 3]> {
    let rings = CORNERS / 4;
    let level = |index: usize| {
        let (sin, cos) = libm::sincos(TAU / 2.0 * index as f64 / rings as f64);
        ring(sin, 0.0)
            .into_iter()
            .map(move |[x, y, _]| [a * x, b * y, z + c * cos])
    };
    (0..=rings).flat_map(level).collect()
}

/// Returns the outline of the part between the floor and [`OVERHEAD`] of what is between points.
fn outline(pose: Pose3, points: Vec<[f64; 3]>) -> Option<Plan> {
    let points: Vec<_> = points.into_iter().map(|point| pose.point(point)).collect();
    let is_met = |point: &&[f64; 3]| (0.0..=OVERHEAD).contains(&point[2]);
    let mut seen: Vec<_> = points.iter().filter(is_met).map(|&[x, y, _]| [x, y]).collect();
    for height in [0.0, OVERHEAD] {
        let (below, above): (Vec<&[f64; 3]>, Vec<_>) = points.iter().partition(|point| point[2] < height);
        for low in &below {
            for high in &above {
                let part = (height - low[2]) / (high[2] - low[2]);
                seen.push(array::from_fn(|axis| low[axis] + part * (high[axis] - low[axis])));
            }
        }
    }
    closed(hull(seen))
}

/// Returns the convex hull (Andrew's monotone chain), counter-clockwise.
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
                    <= MIN_WIDTH * MIN_WIDTH
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let lower = chain(&mut points.iter().copied());
    let upper = chain(&mut points.iter().rev().copied());
    [lower, upper].concat()
}

/// Returns an outline without points that are at one place; `None` if nothing is left.
fn closed(mut points: Vec<[f64; 2]>) -> Option<Plan> {
    let is_same = |a: &[f64; 2], b: &[f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]) < MIN_WIDTH;
    points.dedup_by(|b, a| is_same(a, b));
    while points.len() > 1 && is_same(&points[0], &points[points.len() - 1]) {
        points.pop();
    }
    (points.len() > 2).then_some(Plan::Outline(points))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn seen(shape: Primitive, at: [f64; 3], angles: [f64; 3]) -> Result<(Plan, f64), String> {
        shape.seen(Pose3::euler(at, angles))
    }

    fn assert_near(found: &[f64], right: &[f64]) {
        let near = found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(
            near && found.len() == right.len(),
            "{found:?} instead of {right:?}"
        );
    }

    #[test]
    fn boxes_that_lie_on_any_side_are_boxes() {
        let (plan, top) = seen(
            Primitive::Box([1.0, 2.0, 3.0]),
            [5.0, 6.0, 0.5],
            [FRAC_PI_2, 0.0, 0.25],
        )
        .unwrap();
        // The roll puts the length along z across the floor.
        let Plan::Box { center, size, angle } = plan else {
            panic!("{plan:?}")
        };
        assert_near(&[center[0], center[1], top], &[5.0, 6.0, 1.5]);
        assert_near(&[size[0], size[1]], &[3.0, 1.0]);
        assert_near(&[libm::cos(2.0 * (angle - 0.25))], &[-1.0]);
    }

    #[test]
    fn what_is_tilted_is_the_outline_of_its_part_between_floor_and_overhead() {
        // A plank of 4 m that rises by 45 degrees from the floor at x = 0.
        let at = 2.0 * FRAC_PI_2.sin() / 2.0_f64.sqrt();
        let (plan, _) = seen(
            Primitive::Box([4.0, 1.0, 0.01]),
            [at, 0.0, at],
            [0.0, -FRAC_PI_2 / 2.0, 0.0],
        )
        .unwrap();
        let Plan::Outline(points) = plan else {
            panic!("{plan:?}")
        };
        let most = points.iter().map(|point| point[0]).fold(f64::MIN, f64::max);
        let least = points.iter().map(|point| point[0]).fold(f64::MAX, f64::min);
        assert!((most - 0.507).abs() < 1e-3 && least.abs() < 1e-2, "{points:?}");
        assert_eq!(points.len(), 4);
    }

    #[test]
    fn round_things_are_met_at_their_widest_part_below_overhead() {
        let radius = |shape, z| match seen(shape, [0.0, 0.0, z], [0.0; 3]) {
            Ok((Plan::Circle { radius, .. }, _)) => radius,
            other => panic!("{other:?}"),
        };
        assert_near(&[radius(Primitive::Sphere(0.5), 0.5)], &[0.5]);
        assert_near(
            &[radius(Primitive::Sphere(5.0), 5.0)],
            &[(25.0f64 - 20.25).sqrt()],
        );
        assert_near(&[radius(Primitive::Sphere(1.0), -0.6)], &[0.8]);
        let cone = Primitive::Cone {
            radius: 1.0,
            length: 2.0,
        };
        assert_near(&[radius(cone.clone(), 1.0), radius(cone, 0.0)], &[1.0, 0.5]);
        let capsule = Primitive::Capsule {
            radius: 0.3,
            length: 1.0,
        };
        assert_near(&[radius(capsule, 0.8)], &[0.3]);
        let cylinder = Primitive::Cylinder {
            radius: 0.2,
            length: 2.0,
        };
        let (plan, top) = seen(cylinder, [1.0, 2.0, 0.2], [0.0, FRAC_PI_2, FRAC_PI_2]).unwrap();
        let Plan::Box { size, angle, .. } = plan else {
            panic!("{plan:?}")
        };
        assert_near(&[size[0], size[1], angle, top], &[2.0, 0.4, FRAC_PI_2, 0.4]);
        let Ok((Plan::Outline(points), _)) =
            seen(Primitive::Ellipsoid([1.0, 0.5, 0.4]), [0.0, 0.0, 0.4], [0.0; 3])
        else {
            panic!("an ellipsoid is an outline")
        };
        let most = [0, 1].map(|axis| points.iter().map(|point| point[axis]).fold(f64::MIN, f64::max));
        assert_near(&most, &[1.0, 0.5]);
    }

    #[test]
    fn what_nobody_meets_says_why() {
        let reason = |shape, z| seen(shape, [0.0, 0.0, z], [0.0; 3]).unwrap_err();
        assert_eq!(
            reason(Primitive::Sphere(0.1), 2.0),
            "it is 1.90 m above the floor"
        );
        assert_eq!(
            reason(Primitive::Box([1.0; 3]), -0.5),
            "it does not rise above the floor"
        );
        assert_eq!(
            reason(Primitive::Box([1.0, -1.0, 1.0]), 0.5),
            "its size is not above 0"
        );
        assert_eq!(
            reason(Primitive::Sphere(f64::NAN), 0.5),
            "its size is not above 0"
        );
        assert_eq!(reason(Primitive::Sphere(1e9), 0.5), "it is beyond 10 km");
    }
}
