//! An extended Kalman filter of a pose in the plane: the odometry moves it, and the range, the bearing and the direction
//! of things whose poses are known correct it (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, chapter 7).

use jde_schema::prelude::*;
use jde_schema::types::normalize_angle;

/// A pose with its covariance of x, y and heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) pose: Pose2D,
    pub(super) covariance: [[f64; 3]; 3],
}

/// Where something is, as the base sees it, with standard deviations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// In the frame of the base.
    pub(super) pose: Pose2D,
    /// Of the range, m, the bearing, rad, and the direction in which it faces, rad.
    pub(super) deviations: [f64; 3],
}

/// The squared Mahalanobis distance of three numbers that 99 of 100 sightings stay below.
const GATE: f64 = 11.34;

impl Seen {
    pub(super) fn is_finite(&self) -> bool {
        let Pose2D { x, y, theta } = self.pose;
        let mut numbers = [x, y, theta].into_iter().chain(self.deviations);
        numbers.all(f64::is_finite)
    }
}

impl Estimate {
    /// Returns the pose of a base that sees something whose pose is known.
    pub(super) fn from(place: &Pose2D, seen: &Seen) -> Self {
        let [range, bearing, facing] = seen.deviations;
        let across = seen.pose.x.hypot(seen.pose.y) * facing.hypot(bearing);
        let position = across.hypot(range);
        let deviations = [position, position, facing];
        let mut covariance = [[0.0; 3]; 3];
        for (index, deviation) in deviations.into_iter().enumerate() {
            covariance[index][index] = deviation * deviation;
        }
        let pose = place.transform(&seen.pose.localize(&Pose2D::ORIGIN));
        Self { pose, covariance }
    }

    /// Moves the base by a step in its own frame, whose way and turn have standard deviations.
    pub(super) fn advance(&mut self, step: &Pose2D, [way, turn]: [f64; 2]) {
        let (sin, cos) = self.pose.theta.sin_cos();
        let (dx, dy) = (cos * step.x - sin * step.y, sin * step.x + cos * step.y);
        let moves = [[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]];
        let product = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
            [0, 1, 2]
                .map(|row| [0, 1, 2].map(|column| (0..3).map(|index| a[row][index] * b[index][column]).sum()))
        };
        let turned = [0, 1, 2].map(|row| [0, 1, 2].map(|column| moves[column][row]));
        self.covariance = product(product(moves, self.covariance), turned);
        for axis in 0..2 {
            self.covariance[axis][axis] += way * way;
        }
        self.covariance[2][2] += turn * turn;
        self.pose = self.pose.transform(step);
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
        let bearing = |pose: &Pose2D| pose.y.atan2(pose.x);
        let differences = [
            seen.pose.x.hypot(seen.pose.y) - range,
            normalize_angle(bearing(&seen.pose) - bearing(&expected)),
            normalize_angle(seen.pose.theta - expected.theta),
        ];
        let slopes = [
            [-dx / range, -dy / range, 0.0],
            [dy / square, -dx / square, -1.0],
            [0.0, 0.0, -1.0],
        ];
        // One number after another: their errors are independent. What the ones before changed is taken off.
        let mut distance = 0.0;
        let mut change = [0.0; 3];
        for ((difference, slope), deviation) in differences.into_iter().zip(slopes).zip(seen.deviations) {
            let spread = next
                .covariance
                .map(|row| (0..3).map(|index| row[index] * slope[index]).sum::<f64>());
            let variance =
                deviation * deviation + (0..3).map(|index| slope[index] * spread[index]).sum::<f64>();
            let rest = difference - (0..3).map(|index| slope[index] * change[index]).sum::<f64>();
            distance += rest * rest / variance;
            for row in 0..3 {
                change[row] += spread[row] / variance * rest;
                for column in 0..3 {
                    next.covariance[row][column] -= spread[row] * spread[column] / variance;
                }
            }
        }
        if distance.is_nan() || distance > GATE {
            return false;
        }
        let Pose2D { x, y, theta } = next.pose;
        next.pose = Pose2D::new(x + change[0], y + change[1], normalize_angle(theta + change[2]));
        *self = next;
        true
    }

    /// Returns the standard deviations of the position, in its worst direction, m, and of the heading, rad.
    pub(super) fn deviations(&self) -> [f64; 2] {
        let [[xx, xy, _], [_, yy, _], [_, _, heading]] = self.covariance;
        let greatest = f64::midpoint(xx, yy) + (((xx - yy) / 2.0).powi(2) + xy * xy).sqrt();
        [greatest, heading].map(|variance| variance.clamp(0.0, f64::INFINITY).sqrt())
    }
}
