//! The motion between lines of a board's state: from counts that wrap and the wheels' geometry, or from speeds. It keeps
//! no pose.

use core::time::Duration;
use std::collections::VecDeque;

use jde_motion::arc;
use jde_schema::prelude::{Pose2D, Twist};

use crate::hello::{Hello, Kind};
use crate::report::Motion;

/// Time over which speeds are measured: a tick in one period of a board is a coarse number.
const WINDOW: Duration = Duration::from_millis(60);
/// How much faster than its limits a base may seem to move: it overshoots, and is pushed.
const MARGIN: f64 = 3.0;
/// What a base may seem to move beyond that, m at each wheel: some ticks of a coarse encoder.
const SLACK: f64 = 0.05;

/// What a base did since the line before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Step {
    /// Its motion, in its frame before.
    pub(crate) motion: Pose2D,
    /// Its speeds now.
    pub(crate) twist: Twist,
    /// The ticks of its wheels.
    pub(crate) ticks: [i64; 2],
}

/// Measures the steps of one board.
#[derive(Debug)]
pub(crate) struct Odometer {
    kind: Kind,
    /// The greatest speed that a wheel can seem to have, m/s.
    fastest: f64,
    /// The last count of each wheel, and the board's time of it.
    last: Option<(Duration, [u32; 2])>,
    /// The ways of the wheels in the window, m, and the times of their ends.
    ways: VecDeque<(Duration, [f64; 2])>,
}

impl Odometer {
    pub(crate) fn new(hello: &Hello) -> Self {
        let track = match hello.kind {
            Kind::Differential { track, .. } => track,
            Kind::Omnidirectional => 0.0,
        };
        Self {
            kind: hello.kind,
            fastest: MARGIN * (hello.limits.linear.x + hello.limits.angular.z * track / 2.0),
            last: None,
            ways: VecDeque::new(),
        }
    }

    /// Takes what was measured at `time` of the board's clock.
    ///
    /// # Errors
    /// A step that no wheel can have made, in words. It is no motion: the counts go on from there.
    pub(crate) fn step(&mut self, time: Duration, motion: Motion) -> Result<Step, String> {
        match (self.kind, motion) {
            (
                Kind::Differential {
                    track,
                    ticks_per_metre,
                    bits,
                },
                Motion::Counts(counts),
            ) => {
                let last = self.last.replace((time, counts));
                let Some((then, before)) = last else {
                    self.ways.push_back((time, [0.0; 2]));
                    return Ok(Step::default());
                };
                let ticks: [i64; 2] =
                    core::array::from_fn(|wheel| difference(before[wheel], counts[wheel], bits));
                let ways = ticks.map(|ticks| ticks as f64 / ticks_per_metre);
                let longest = SLACK + self.fastest * time.saturating_sub(then).as_secs_f64();
                if let Some(way) = ways.into_iter().find(|way| way.abs() > longest) {
                    self.ways.clear();
                    self.ways.push_back((time, [0.0; 2]));
                    return Err(format!("its counts leapt by {way:.2} m, which is no motion"));
                }
                self.ways.push_back((time, ways));
                Ok(Step {
                    motion: arc(&differential(ways, track), 1.0),
                    twist: self.twist(time, track),
                    ticks,
                })
            }
            (Kind::Omnidirectional, Motion::Speeds([ahead, left, turn])) => {
                let mut twist = Twist::planar(ahead, turn);
                twist.linear.y = left;
                let last = self.last.replace((time, [0; 2]));
                let passed = last.map_or(0.0, |(then, _)| time.saturating_sub(then).as_secs_f64());
                Ok(Step {
                    motion: arc(&twist, passed),
                    twist,
                    ticks: [0; 2],
                })
            }
            (Kind::Differential { .. }, Motion::Speeds(_)) | (Kind::Omnidirectional, Motion::Counts(_)) => {
                Err("it measures something else than its kind does".to_owned())
            }
        }
    }

    /// The speeds over the window that ends at `time`.
    fn twist(&mut self, time: Duration, track: f64) -> Twist {
        // The first entry is where the window begins: its own way was made before.
        while let Some((next, _)) = self.ways.get(1)
            && time.saturating_sub(*next) >= WINDOW
        {
            self.ways.pop_front();
        }
        let from = self.ways.front().map_or(time, |(from, _)| *from);
        let passed = time.saturating_sub(from).as_secs_f64();
        let way = |wheel: usize| -> f64 { self.ways.iter().skip(1).map(|(_, ways)| ways[wheel]).sum() };
        if passed > 0.0 {
            differential([way(0) / passed, way(1) / passed], track)
        } else {
            Twist::ZERO
        }
    }
}

/// The speeds of a base whose wheels have these.
fn differential([left, right]: [f64; 2], track: f64) -> Twist {
    Twist::planar(f64::midpoint(left, right), (right - left) / track)
}

/// The shorter way between two counts that wrap after `bits` bits.
fn difference(from: u32, to: u32, bits: u32) -> i64 {
    let spare = 32 - bits.clamp(1, 32);
    // Shifted up, the counts wrap as a number of 32 bits does.
    i64::from(((to.wrapping_sub(from) << spare) as i32) >> spare)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    fn odometer(bits: u32) -> Odometer {
        Odometer {
            kind: Kind::Differential {
                track: 0.2,
                ticks_per_metre: 1000.0,
                bits,
            },
            fastest: 3.0,
            last: None,
            ways: VecDeque::new(),
        }
    }

    #[test]
    fn a_turn_on_the_spot_and_a_straight_way_are_measured_by_the_wheels() {
        let mut odometer = odometer(32);
        let mut step = |ms, left: i32, right: i32| {
            odometer
                .step(
                    Duration::from_millis(ms),
                    Motion::Counts([left as u32, right as u32]),
                )
                .expect("it is a motion")
        };
        assert_eq!(
            step(0, 500, -500),
            Step::default(),
            "the first counts are no motion"
        );
        let turned = step(200, 500 - 157, -500 + 157);
        assert!(
            (turned.motion.theta - PI / 2.0).abs() < 1e-3 && turned.motion.x.abs() < 1e-9,
            "{turned:?}"
        );
        let ahead = step(300, 500 - 157 + 50, -500 + 157 + 50);
        assert!((ahead.motion.x - 0.05).abs() < 1e-9 && (ahead.twist.linear.x - 0.5).abs() < 1e-9);
        assert_eq!(ahead.ticks, [50, 50]);
    }

    #[test]
    fn counts_that_leap_are_no_motion_and_go_on_from_there() {
        let mut odometer = odometer(32);
        let mut step = |ms, count: u32| {
            odometer
                .step(Duration::from_millis(ms), Motion::Counts([count; 2]))
                .map(|step| (step.motion.x * 1000.0).round())
        };
        assert_eq!(step(0, 100), Ok(0.0));
        assert!(step(20, 3100).is_err_and(|reason| reason.contains("3.00 m")));
        assert_eq!(step(40, 3110), Ok(10.0));
    }

    proptest! {
        #[test]
        fn counts_of_any_size_wrap(from in any::<u32>(), way in -100_i32..100, bits in 8_u32..=32) {
            prop_assert_eq!(difference(from, from.wrapping_add_signed(way), bits), i64::from(way));
        }
    }
}
