//! The true motion of a robot during a drive, and the ready-made measures of it. It reads nothing itself.

use jde_core::Nanos;
use jde_types::{Mission, Truth};

/// A ready-made measure of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionMeasure {
    /// The driven length, m.
    Distance,
    /// The least distance to an object, m.
    Clearance,
    /// The root mean square of the jerk along the robot's heading, m/s3.
    Smoothness,
    /// The energy from the battery, J.
    Energy,
    /// Success weighted by path length (Anderson et al., *On Evaluation of Embodied Navigation Agents*,
    /// 2018): 0 without success, else the direct length by the longer of the direct and the driven one.
    Spl,
    /// The metric of the BARN challenge: 0 without success, else the optimal time by the time, which counts
    /// as at least 2 and at most 8 optimal times. The time begins when the robot is [`START_DISTANCE`] away
    /// from its start. The optimal time is that of the length at the speed.
    Barn {
        /// m/s.
        speed: f64,
        /// m; if there is none, that of the world's reference path, or else the direct length.
        length: Option<f64>,
    },
}

/// The distance from the start at which the clock of the BARN challenge begins to count, m.
pub const START_DISTANCE: f64 = 0.1;

/// The motion of one robot.
#[derive(Clone, Debug, Default)]
pub struct RobotMotion {
    first: Option<MotionSample>,
    last: Option<MotionSample>,
    /// When the robot was [`START_DISTANCE`] away from its start first.
    left_start: Option<Nanos>,
    /// The length of the reference path of its world, m.
    reference_length: Option<f64>,
    /// The acceleration before the last sample, m/s2.
    acceleration: Option<f64>,
    distance: f64,
    min_clearance: Option<f64>,
    /// The integral of the squared jerk, and the time over which it was taken, s.
    jerk: (f64, f64),
    energy: Option<f64>,
    power: Option<(f64, Nanos)>,
    /// The target under way.
    target: Option<(u32, f64, f64)>,
    direct: f64,
}

#[derive(Clone, Copy, Debug)]
struct MotionSample {
    time: Nanos,
    position: [f64; 2],
    speed: f64,
}

impl MotionSample {
    fn distance_to(&self, other: &Self) -> f64 {
        let [x, y] = [0, 1].map(|axis| self.position[axis] - other.position[axis]);
        x.hypot(y)
    }
}

impl RobotMotion {
    /// The ready-made measures that need no number of their own, by their names.
    pub const READY: [(&'static str, MotionMeasure); 5] = [
        ("distance", MotionMeasure::Distance),
        ("clearance", MotionMeasure::Clearance),
        ("smoothness", MotionMeasure::Smoothness),
        ("energy", MotionMeasure::Energy),
        ("spl", MotionMeasure::Spl),
    ];

    /// Takes a new true state.
    pub fn observe(&mut self, now: Nanos, truth: &Truth) {
        let sample = MotionSample {
            time: now,
            position: [truth.pose.x, truth.pose.y],
            speed: truth.twist.linear.x,
        };
        self.min_clearance = Some(truth.min_clearance);
        let first = self.first.get_or_insert(sample);
        if sample.distance_to(first) >= START_DISTANCE {
            self.left_start.get_or_insert(now);
        }
        let Some(last) = self.last.replace(sample) else {
            return;
        };
        self.distance += sample.distance_to(&last);
        let passed = now.saturating_sub(last.time) as f64 / 1e9;
        if passed <= 0.0 {
            return;
        }
        let acceleration = (sample.speed - last.speed) / passed;
        if let Some(before) = self.acceleration.replace(acceleration) {
            let jerk = (acceleration - before) / passed;
            self.jerk.0 += jerk * jerk * passed;
            self.jerk.1 += passed;
        }
    }

    /// Takes the length of the reference path of the robot's world, m.
    pub fn set_reference_length(&mut self, length: Option<f64>) {
        self.reference_length = length;
    }

    /// Takes the battery's present power, W.
    pub fn observe_power(&mut self, now: Nanos, power: f64) {
        self.advance_energy(now);
        self.power = Some((power.abs(), now));
    }

    /// Takes the mission's progress. The direct length to a target is its distance when it becomes the
    /// target.
    pub fn observe_mission(&mut self, mission: &Mission) {
        let target = (mission.reached, mission.target.x, mission.target.y);
        if mission.state == Mission::RUNNING && self.target != Some(target) && mission.distance > 0.0 {
            self.target = Some(target);
            self.direct += mission.distance;
        }
    }

    /// Returns a measure at the end of the drive; `None` without the values that it needs.
    #[must_use]
    pub fn measure(&self, measure: MotionMeasure, now: Nanos, is_success: bool) -> Option<f64> {
        self.last?;
        match measure {
            MotionMeasure::Distance => Some(self.distance),
            MotionMeasure::Clearance => self.min_clearance,
            MotionMeasure::Smoothness => (self.jerk.1 > 0.0).then(|| (self.jerk.0 / self.jerk.1).sqrt()),
            MotionMeasure::Energy => {
                let mut ended = self.clone();
                ended.advance_energy(now);
                ended.energy
            }
            MotionMeasure::Spl | MotionMeasure::Barn { .. } if !is_success => Some(0.0),
            MotionMeasure::Spl => (self.direct > 0.0).then(|| self.direct / self.direct.max(self.distance)),
            MotionMeasure::Barn { speed, length } => {
                let optimal = length.or(self.reference_length).unwrap_or(self.direct) / speed;
                let time = now.saturating_sub(self.left_start.unwrap_or_default()) as f64 / 1e9;
                (optimal > 0.0).then(|| optimal / time.clamp(2.0 * optimal, 8.0 * optimal))
            }
        }
    }

    fn advance_energy(&mut self, now: Nanos) {
        if let Some((power, since)) = &mut self.power {
            *self.energy.get_or_insert(0.0) += *power * now.saturating_sub(*since) as f64 / 1e9;
            *since = now;
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{Pose2D, Twist};

    use super::*;

    const SECOND: Nanos = 1_000_000_000;

    /// A robot that drives 1 m/s for four seconds towards a target 4 m ahead.
    fn straight() -> RobotMotion {
        let mut motion = RobotMotion::default();
        motion.observe_mission(&Mission {
            target: Pose2D::new(4.0, 0.0, 0.0),
            distance: 4.0,
            total: 1,
            ..Mission::default()
        });
        for second in 0..=4 {
            motion.observe(
                second * SECOND,
                &Truth {
                    pose: Pose2D::new(second as f64, 0.0, 0.0),
                    twist: Twist::planar(1.0, 0.0),
                    clearance: 1.0,
                    min_clearance: 0.5,
                    collisions: 0,
                },
            );
        }
        motion.observe_power(0, 24.0);
        motion
    }

    #[test]
    fn a_straight_drive_is_as_long_as_direct_and_smooth() {
        let motion = straight();
        let measured = |measure| motion.measure(measure, 4 * SECOND, true);
        assert_eq!(measured(MotionMeasure::Distance), Some(4.0));
        assert_eq!(measured(MotionMeasure::Clearance), Some(0.5));
        assert_eq!(measured(MotionMeasure::Smoothness), Some(0.0));
        assert_eq!(measured(MotionMeasure::Energy), Some(96.0));
        assert_eq!(measured(MotionMeasure::Spl), Some(1.0));
    }

    #[test]
    fn the_metric_of_barn_is_bounded_by_twice_and_eight_times_the_optimal_time() {
        let motion = straight();
        let barn = |length, seconds: u64| {
            let measure = MotionMeasure::Barn { speed: 2.0, length };
            motion.measure(measure, seconds * SECOND, true)
        };
        assert_eq!(
            barn(None, 1),
            Some(0.5),
            "no drive is better than twice the optimal time"
        );
        // The clock begins at the first sample away from the start, after a second.
        assert_eq!(barn(None, 9), Some(0.25));
        assert_eq!(barn(None, 100), Some(0.125));
        assert_eq!(barn(Some(8.0), 17), Some(0.25));
    }

    #[test]
    fn the_reference_path_of_the_world_is_the_optimal_one_unless_a_length_is_stated() {
        let mut motion = straight();
        motion.set_reference_length(Some(8.0));
        let barn = |length| motion.measure(MotionMeasure::Barn { speed: 2.0, length }, 17 * SECOND, true);
        assert_eq!(barn(None), Some(0.25));
        assert_eq!(barn(Some(4.0)), Some(0.125));
    }

    #[test]
    fn without_success_there_is_no_credit_and_without_a_robot_no_value() {
        let barn = MotionMeasure::Barn {
            speed: 2.0,
            length: None,
        };
        for measure in [MotionMeasure::Spl, barn] {
            assert_eq!(straight().measure(measure, SECOND, false), Some(0.0));
            assert_eq!(RobotMotion::default().measure(measure, SECOND, false), None);
        }
    }

    #[test]
    fn jerk_is_the_change_of_acceleration() {
        let mut motion = RobotMotion::default();
        for (second, speed) in [0.0, 1.0, 1.0, 1.0].into_iter().enumerate() {
            let twist = Twist::planar(speed, 0.0);
            motion.observe(
                second as Nanos * SECOND,
                &Truth {
                    twist,
                    ..Truth::default()
                },
            );
        }
        // Accelerations 1, 0, 0: jerks -1 and 0.
        let smoothness = motion.measure(MotionMeasure::Smoothness, 3 * SECOND, true);
        assert_eq!(smoothness, Some(0.5_f64.sqrt()));
    }
}
