//! The distortion of a lens, by the models of ROS and OpenCV.
//!
//! A place is in the plane one unit before the camera: x to the right, y down. [`Distortion::apply`] says where the lens
//! puts it, and [`Distortion::undo`] inverts that by Newton's method. Formulas: OpenCV's modules calib3d ("plumb_bob" and
//! "rational_polynomial", with thin prisms) and fisheye ("equidistant", Kannala and Brandt 2006).

type Place = [f64; 2];
/// The derivatives of the distorted x and y by the undistorted x and y.
type Slopes = [[f64; 2]; 2];

/// Rounds of Newton's method. It needs about four; a place that takes more has no inverse nearby.
const MAX_ITERATIONS: usize = 30;
/// Difference of places at which they are the same: a millionth of a pixel of any camera.
const CONVERGED: f64 = 1e-10;

/// A model of distortion with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Distortion {
    /// A pinhole, or a rectified picture.
    None,
    /// k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4. Those that a camera has not are 0.
    Polynomial([f64; 12]),
    /// k1 to k4, of the angle from the optical axis.
    Equidistant([f64; 4]),
}

impl Distortion {
    /// Returns the model of ROS of this name with these coefficients.
    ///
    /// # Errors
    /// An unknown model, another number of coefficients than it has, or one that is not finite.
    pub(crate) fn named(name: &str, coefficients: &[f64]) -> Result<Self, String> {
        if !coefficients.iter().all(|number| number.is_finite()) {
            return Err("a distortion coefficient is not finite".to_owned());
        }
        let polynomial = |counts: &[usize]| {
            // The last two of 14 tilt the sensor.
            let (known, tilt) = coefficients.split_at(coefficients.len().min(12));
            if !counts.contains(&coefficients.len()) || tilt.iter().any(|angle| *angle != 0.0) {
                return Err(format!(
                    "the distortion model `{name}` has {counts:?} coefficients, and {} are stated{}",
                    coefficients.len(),
                    if tilt.is_empty() {
                        ""
                    } else {
                        "; a tilted sensor is not supported"
                    },
                ));
            }
            let mut all = [0.0; 12];
            all[..known.len()].copy_from_slice(known);
            Ok(Self::Polynomial(all))
        };
        let model = match (name, coefficients.len()) {
            // Uncalibrated or rectified cameras state no coefficients, and some of them no model.
            ("" | "none" | "plumb_bob" | "rational_polynomial", 0) => Self::None,
            ("plumb_bob" | "radtan", _) => polynomial(&[4, 5])?,
            ("rational_polynomial", _) => polynomial(&[8, 12, 14])?,
            ("equidistant" | "fisheye" | "kannala_brandt", 4) => {
                Self::Equidistant(core::array::from_fn(|index| coefficients[index]))
            }
            ("equidistant" | "fisheye" | "kannala_brandt", count) => {
                return Err(format!(
                    "the distortion model `{name}` has 4 coefficients, and {count} are stated"
                ));
            }
            _ => {
                return Err(format!(
                    "the distortion model `{name}` is unknown: expected `plumb_bob`, `rational_polynomial` or `equidistant`"
                ));
            }
        };
        Ok(match model {
            Self::Polynomial(all) if all == [0.0; 12] => Self::None,
            other => other,
        })
    }

    /// Returns where the lens puts a place, and the slopes there.
    pub(crate) fn apply(&self, place: Place) -> (Place, Slopes) {
        match self {
            Self::None => (place, [[1.0, 0.0], [0.0, 1.0]]),
            Self::Polynomial(coefficients) => polynomial(coefficients, place),
            Self::Equidistant(coefficients) => equidistant(coefficients, place),
        }
    }

    /// Returns the place that the lens puts there; `None` if there is none, as beyond the edge of what a lens shows.
    pub(crate) fn undo(&self, distorted: Place) -> Option<Place> {
        let start = match self {
            Self::None => return Some(distorted),
            Self::Polynomial(_) => distorted,
            // The angle is nearly the distance from the middle.
            Self::Equidistant(_) => {
                let angle = libm::hypot(distorted[0], distorted[1]);
                let scale = if angle > 1e-9 {
                    libm::tan(angle.min(1.5)) / angle
                } else {
                    1.0
                };
                distorted.map(|axis| scale * axis)
            }
        };
        let mut place = start;
        for _ in 0..MAX_ITERATIONS {
            let (at, [[xx, xy], [yx, yy]]) = self.apply(place);
            let error = [at[0] - distorted[0], at[1] - distorted[1]];
            let determinant = xx * yy - xy * yx;
            // Where the slopes vanish or turn around, the lens shows two places at one.
            if determinant.is_nan() || determinant <= 0.0 {
                return None;
            }
            if libm::hypot(error[0], error[1]) < CONVERGED {
                return Some(place);
            }
            place[0] -= (yy * error[0] - xy * error[1]) / determinant;
            place[1] -= (xx * error[1] - yx * error[0]) / determinant;
        }
        None
    }
}

fn polynomial(coefficients: &[f64; 12], [x, y]: Place) -> (Place, Slopes) {
    let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4] = *coefficients;
    let r2 = x * x + y * y;
    let (above, below) = (
        1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)),
        1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)),
    );
    let radial = above / below;
    // The derivative of the radial factor by the squared radius.
    let slope =
        ((k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3)) - radial * (k4 + r2 * (2.0 * k5 + 3.0 * r2 * k6))) / below;
    let place = [
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + r2 * s2),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + r2 * s4),
    ];
    // The derivatives of the prisms by the squared radius.
    let prism = [s1 + 2.0 * r2 * s2, s3 + 2.0 * r2 * s4];
    let mixed = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    let slopes = [
        [
            radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x + 2.0 * x * prism[0],
            mixed + 2.0 * y * prism[0],
        ],
        [
            mixed + 2.0 * x * prism[1],
            radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x + 2.0 * y * prism[1],
        ],
    ];
    (place, slopes)
}

fn equidistant(coefficients: &[f64; 4], [x, y]: Place) -> (Place, Slopes) {
    let [k1, k2, k3, k4] = *coefficients;
    let r = libm::hypot(x, y);
    if r < 1e-9 {
        return ([x, y], [[1.0, 0.0], [0.0, 1.0]]);
    }
    let angle = libm::atan(r);
    let a2 = angle * angle;
    let bent = angle * (1.0 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))));
    let by_angle = 1.0 + a2 * (3.0 * k1 + a2 * (5.0 * k2 + a2 * (7.0 * k3 + a2 * 9.0 * k4)));
    let scale = bent / r;
    // The derivative of the scale by the radius, over the radius.
    let slope = (by_angle / (1.0 + r * r) - scale) / (r * r);
    let slopes = [
        [scale + x * x * slope, x * y * slope],
        [x * y * slope, scale + y * y * slope],
    ];
    ([x * scale, y * scale], slopes)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The matrix K of the camera for which OpenCV 4 computed the places.
    const FOCAL: Place = [600.0, 610.0];
    const MIDDLE: Place = [320.0, 240.0];
    const PLACES: [Place; 3] = [[0.4, -0.3], [-0.55, 0.25], [0.1, 0.42]];
    const RATIONAL: [f64; 12] = [
        -0.35, 0.15, 0.001, -0.002, 0.02, 0.05, -0.04, 0.01, 0.003, -0.002, 0.0015, 0.001,
    ];

    fn check(model: &str, coefficients: &[f64], expected: [Place; 3]) {
        let distortion = Distortion::named(model, coefficients).unwrap();
        for (place, expected) in PLACES.into_iter().zip(expected) {
            let (seen, _) = distortion.apply(place);
            for axis in 0..2 {
                let pixel = MIDDLE[axis] + FOCAL[axis] * seen[axis];
                assert!(
                    (pixel - expected[axis]).abs() < 1e-5,
                    "{model}: {pixel} {expected:?}"
                );
            }
        }
    }

    #[test]
    fn places_are_where_opencv_puts_them() {
        check(
            "plumb_bob",
            &[-0.28, 0.09, 0.0007, -0.0013, -0.01],
            [
                [543.9671, 69.183149],
                [19.057587, 379.096162],
                [376.926505, 483.776593],
            ],
        );
        check(
            "rational_polynomial",
            &RATIONAL[..8],
            [
                [538.271768, 73.491527],
                [27.812542, 375.046263],
                [375.761409, 479.170032],
            ],
        );
        check(
            "rational_polynomial",
            &RATIONAL,
            [
                [538.646768, 73.758402],
                [28.309672, 375.461506],
                [376.055235, 479.361783],
            ],
        );
        check(
            "equidistant",
            &[-0.02, 0.01, -0.004, 0.001],
            [
                [541.688498, 70.962521],
                [24.6704, 376.478073],
                [376.466877, 481.113563],
            ],
        );
    }

    #[test]
    fn what_is_no_model_is_refused_in_words() {
        let message = |name, coefficients: &[f64]| Distortion::named(name, coefficients).unwrap_err();
        assert!(message("fov", &[0.9]).contains("`fov` is unknown"));
        assert!(message("plumb_bob", &[0.1; 7]).contains("7 are stated"));
        assert!(message("equidistant", &[0.1; 5]).contains("has 4 coefficients"));
        assert!(message("plumb_bob", &[f64::NAN; 5]).contains("not finite"));
        assert!(message("rational_polynomial", &[0.1; 14]).contains("tilted"));
        assert_eq!(Distortion::named("plumb_bob", &[0.0; 5]), Ok(Distortion::None));
        assert_eq!(Distortion::named("", &[]), Ok(Distortion::None));
    }

    #[test]
    fn where_the_lens_turns_around_nothing_is_shown() {
        let barrel = Distortion::named("plumb_bob", &[-0.3, 0.0, 0.0, 0.0, 0.0]).unwrap();
        // The distorted radius r - 0.3 r³ is 0.70 at most.
        assert!(barrel.undo([0.69, 0.0]).is_some());
        assert_eq!(barrel.undo([0.72, 0.0]), None);
        assert_eq!(barrel.undo([f64::NAN, 0.0]), None);
    }

    proptest! {
        #[test]
        fn every_place_that_is_shown_is_found_again(
            place in [-0.9..0.9, -0.9..0.9],
            (k1, k2, k3) in (-0.4..0.4, -0.2..0.2, -0.05..0.05),
            (p1, p2) in (-0.005..0.005, -0.005..0.005),
            model in 0..3,
        ) {
            let distortion = match model {
                0 => Distortion::named("plumb_bob", &[k1, k2, p1, p2, k3]),
                1 => Distortion::named("rational_polynomial", &[k1, k2, p1, p2, k3, k1 / 3.0, k2 / 2.0, k3]),
                _ => Distortion::named("equidistant", &[k1 / 5.0, k2 / 5.0, k3, p1]),
            }.unwrap();
            let (seen, slopes) = distortion.apply(place);
            // The slopes are the derivatives.
            let step = 1e-6;
            for axis in 0..2 {
                let mut near = place;
                near[axis] += step;
                let (there, _) = distortion.apply(near);
                for part in 0..2 {
                    let slope = (there[part] - seen[part]) / step;
                    let expected = slopes[part][axis];
                    prop_assert!((slope - expected).abs() < 1e-3 * (1.0 + expected.abs()), "{slope} {slopes:?}");
                }
            }
            // What is found again shows at the same place, and it is the place itself where the lens is mild.
            if let Some(found) = distortion.undo(seen) {
                let (again, _) = distortion.apply(found);
                prop_assert!((again[0] - seen[0]).hypot(again[1] - seen[1]) < 1e-9);
            }
            if place[0].hypot(place[1]) < 0.5 {
                let found = distortion.undo(seen).unwrap();
                prop_assert!((found[0] - place[0]).hypot(found[1] - place[1]) < 1e-7, "{found:?} {place:?}");
            }
        }
    }
}
