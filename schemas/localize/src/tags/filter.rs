//! An extended Kalman filter of a pose in the plane: the odometry moves it, and the range, the bearing and the direction
//! of things whose poses are known correct it (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, chapter 7). With
//! the pose it estimates the systematic errors of the odometry: wheels that are larger or smaller than they should be.

use jde_schema::prelude::*;
use jde_schema::types::normalize_angle;

/// x, y, heading, and the errors of the odometry.
const STATES: usize = 5;

/// A pose with the errors of the odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) pose: Pose2D,
    errors: [f64; 2],
    /// The standard deviations of the errors before any sighting.
    prior: [f64; 2],
    pub(super) covariance: [[f64; STATES]; STATES],
}

/// The errors of the odometry: the share by which ways and turns are longer than it says, and the turn to the left that
/// it misses for each metre ahead, rad/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    values: [f64; 2],
    prior: [f64; 2],
    covariance: [[f64; 2]; 2],
}

/// Where something is, as the base sees it, with standard deviations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// In the frame of the base.
    pub(super) pose: Pose2D,
    /// Of the range, m, the bearing, rad, and the direction in which it faces, rad.
    pub(super) deviations: [f64; 3],
}

/// Standard deviations of the changes of both errors after 1 m, as shares of those before any sighting; they grow with
/// the root. So the errors are constants that are never known exactly: the floor and the load change them.
const CHANGES: [f64; 2] = [0.1, 0.06];
/// An error of so many of its standard deviations is none of the wheels: the sightings are wrong.
const MOST_DEVIATIONS: f64 = 4.0;
/// The squared Mahalanobis distance of three numbers that 99 of 100 sightings stay below.
const GATE: f64 = 11.34;

impl Seen {
    pub(super) fn is_finite(&self) -> bool {
        self.pose.is_finite() && self.deviations.into_iter().all(f64::is_finite)
    }
}

impl Errors {
    /// Returns errors of which nothing but the standard deviations is known.
    pub(super) fn new([scale, drift]: [f64; 2]) -> Self {
        Self {
            values: [0.0; 2],
            prior: [scale, drift],
            covariance: [[scale * scale, 0.0], [0.0, drift * drift]],
        }
    }
}

impl Estimate {
    /// Returns the pose of a base that sees something whose pose is known, with these errors of its odometry.
    pub(super) fn from(place: &Pose2D, seen: &Seen, errors: &Errors) -> Self {
        let [range, bearing, facing] = seen.deviations;
        let across = libm::hypot(seen.pose.x, seen.pose.y) * libm::hypot(facing, bearing);
        let position = libm::hypot(across, range);
        let mut covariance = [[0.0; STATES]; STATES];
        for (index, deviation) in [position, position, facing].into_iter().enumerate() {
            covariance[index][index] = deviation * deviation;
        }
        covariance[3][3..].copy_from_slice(&errors.covariance[0]);
        covariance[4][3..].copy_from_slice(&errors.covariance[1]);
        Self {
            pose: place.transform(&seen.pose.localize(&Pose2D::ORIGIN)),
            errors: errors.values,
            prior: errors.prior,
            covariance,
        }
    }

    /// Returns what is known of the errors, wherever the base is.
    pub(super) fn errors(&self) -> Errors {
        let [.., [_, _, _, a, b], [_, _, _, c, d]] = self.covariance;
        Errors {
            values: self.errors,
            prior: self.prior,
            covariance: [[a, b], [c, d]],
        }
    }

    /// Moves the base by a step of the odometry in its own frame, whose way and turn have standard deviations.
    pub(super) fn advance(&mut self, step: &Pose2D, [way, turn]: [f64; 2]) {
        let (sin, cos) = libm::sincos(self.pose.theta);
        let (dx, dy) = (cos * step.x - sin * step.y, sin * step.x + cos * step.y);
        let moves: [[f64; STATES]; STATES] = [
            [1.0, 0.0, -dy, dx, 0.0],
            [0.0, 1.0, dx, dy, 0.0],
            [0.0, 0.0, 1.0, step.theta, step.x],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0],
        ];
        let moved = moves.map(|row| self.times(&row));
        let length = libm::hypot(step.x, step.y);
        let [scale, drift] = [0, 1].map(|error| (CHANGES[error] * self.prior[error]).powi(2) * length);
        let noise = [way * way, way * way, turn * turn, scale, drift];
        for row in 0..STATES {
            self.covariance[row] = moves.map(|column| scalar(&moved[row], &column));
            self.covariance[row][row] += noise[row];
        }
        let [scale, drift] = self.errors;
        self.pose = self.pose.transform(&Pose2D::new(
            step.x * (1.0 + scale),
            step.y * (1.0 + scale),
            step.theta * (1.0 + scale) + step.x * drift,
        ));
    }

    /// Returns the product of a row and the covariance, which is symmetric.
    fn times(&self, row: &[f64; STATES]) -> [f64; STATES] {
        self.covariance.map(|other| scalar(row, &other))
    }

    /// Corrects the pose by a sighting of something whose pose is known. Returns whether the sighting fits.
    pub(super) fn correct(&mut self, place: &Pose2D, seen: &Seen) -> bool {
        let mut next = *self;
        let expected = self.pose.localize(place);
        let square = expected.x * expected.x + expected.y * expected.y;
        if square < 1e-4 {
            return false;
        }
        let range = square.sqrt();
        // In the frame of the world, from the base to the thing.
        let (dx, dy) = (place.x - self.pose.x, place.y - self.pose.y);
        let bearing = |pose: &Pose2D| libm::atan2(pose.y, pose.x);
        let differences = [
            libm::hypot(seen.pose.x, seen.pose.y) - range,
            normalize_angle(bearing(&seen.pose) - bearing(&expected)),
            normalize_angle(seen.pose.theta - expected.theta),
        ];
        let slopes: [[f64; STATES]; 3] = [
            [-dx / range, -dy / range, 0.0, 0.0, 0.0],
            [dy / square, -dx / square, -1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0, 0.0, 0.0],
        ];
        // One number after another: their errors are independent. What the ones before changed is taken off.
        let mut distance = 0.0;
        let mut change = [0.0; STATES];
        for ((difference, slope), deviation) in differences.into_iter().zip(slopes).zip(seen.deviations) {
            let spread = next.times(&slope);
            let variance = deviation * deviation + scalar(&slope, &spread);
            let rest = difference - scalar(&slope, &change);
            distance += rest * rest / variance;
            for row in 0..STATES {
                change[row] += spread[row] / variance * rest;
                for column in 0..STATES {
                    next.covariance[row][column] -= spread[row] * spread[column] / variance;
                }
            }
        }
        if distance.is_nan() || distance > GATE {
            return false;
        }
        let (Pose2D { x, y, theta }, [dx, dy, turn, scale, drift]) = (next.pose, change);
        next.pose = Pose2D::new(x + dx, y + dy, normalize_angle(theta + turn));
        next.errors = [next.errors[0] + scale, next.errors[1] + drift];
        let errors = next.errors.into_iter().zip(next.prior);
        if errors
            .into_iter()
            .any(|(error, prior)| error.abs() > MOST_DEVIATIONS * prior)
        {
            return false;
        }
        *self = next;
        true
    }

    /// Returns the standard deviations of the position, in its worst direction, m, and of the heading, rad.
    pub(super) fn deviations(&self) -> [f64; 2] {
        let [[xx, xy, ..], [_, yy, ..], [_, _, heading, ..], ..] = self.covariance;
        let greatest = f64::midpoint(xx, yy) + (((xx - yy) / 2.0).powi(2) + xy * xy).sqrt();
        [greatest, heading].map(|variance| variance.clamp(0.0, f64::INFINITY).sqrt())
    }
}

fn scalar(a: &[f64; STATES], b: &[f64; STATES]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
