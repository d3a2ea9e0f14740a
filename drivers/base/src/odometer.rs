//! The motion between lines of a board's state: from counts that wrap and the wheels' geometry, or from speeds. It keeps
//! no pose.

use core::time::Duration;
use std::collections::VecDeque;

use jde_motion::arc;
use jde_schema::prelude::{Pose2D, Twist};

use crate::hello::{Hello, Kind};
use crate::report::Motion;
use crate::session::SILENCE;

/// Time over which speeds are measured: a tick in one period of a board is a coarse number.
const WINDOW: Duration = Duration::from_millis(60);
/// How much faster than its limits a base may seem to move: it overshoots, and is pushed.
const MARGIN: f64 = 3.0;
/// What a base may seem to move beyond that, m at each wheel: some ticks of a coarse encoder.
const SLACK: f64 = 0.05;
/// What an omnidirectional base may seem to turn beyond that, rad.
const TURN_SLACK: f64 = 0.25;

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
    /// The greatest speed that a wheel can seem to have, m/s; of an omnidirectional base, its own.
    fastest: f64,
    /// The greatest turn rate that the base can seem to have, rad/s.
    fastest_turn: f64,
    /// The last count of each wheel, and the board's time of it.
    last: Option<(Duration, [u32; 2])>,
    /// The ways of the wheels in the window, m, and the times of their ends.
    ways: VecDeque<(Duration, [f64; 2])>,
}

impl Odometer {
    /// # Errors
    /// The counts of the board wrap too soon, in words.
    pub(crate) fn new(hello: &Hello) -> Result<Self, String> {
        let Twist { linear, angular } = hello.limits;
        let fastest = match hello.kind {
            Kind::Differential { track, .. } => linear.x + angular.z * track / 2.0,
            Kind::Omnidirectional => libm::hypot(linear.x, linear.y),
        };
        let odometer = Self {
            kind: hello.kind,
            fastest: MARGIN * fastest,
            fastest_turn: MARGIN * angular.z,
            last: None,
            ways: VecDeque::new(),
        };
        if let Kind::Differential {
            ticks_per_metre,
            bits,
            ..
        } = hello.kind
        {
            let (half, longest) = (half_a_wrap(ticks_per_metre, bits), odometer.longest(SILENCE));
            if half < longest {
                return Err(format!(
                    "`bits` are too few: its counts wrap after {:.2} m, and must not within {:.2} m",
                    2.0 * half,
                    2.0 * longest
                ));
            }
        }
        Ok(odometer)
    }

    /// The longest way that is a motion in this time, m.
    fn longest(&self, time: Duration) -> f64 {
        SLACK + self.fastest * time.as_secs_f64()
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
                let gap = time.saturating_sub(then);
                let longest = self.longest(gap);
                let problem = if longest >= half_a_wrap(ticks_per_metre, bits) {
                    Some(format!(
                        "no line came for {:.1} s, and its counts may have wrapped",
                        gap.as_secs_f64()
                    ))
                } else {
                    let leap = ways.into_iter().find(|way| way.abs() > longest);
                    leap.map(|way| format!("its counts leapt by {way:.2} m, which is no motion"))
                };
                if let Some(problem) = problem {
                    self.ways.clear();
                    self.ways.push_back((time, [0.0; 2]));
                    return Err(problem);
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
                let Some((then, _)) = last else {
                    return Ok(Step::default());
                };
                let gap = time.saturating_sub(then);
                let passed = gap.as_secs_f64();
                if gap > SILENCE {
                    return Err(format!(
                        "no line came for {passed:.1} s, and how it moved is unknown"
                    ));
                }
                let turned = turn.abs() * passed;
                if libm::hypot(ahead, left) * passed > self.longest(gap)
                    || turned > TURN_SLACK + self.fastest_turn * passed
                {
                    return Err(format!(
                        "its speeds {ahead:.2} m/s, {left:.2} m/s and {turn:.2} rad/s are no motion"
                    ));
                }
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

/// The longest way that counts can tell from its opposite, m.
fn half_a_wrap(ticks_per_metre: f64, bits: u32) -> f64 {
    libm::exp2(f64::from(bits - 1)) / ticks_per_metre
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
            fastest_turn: 6.0,
            last: None,
            ways: VecDeque::new(),
        }
    }

    #[test]
    fn counts_that_wrap_before_a_board_is_lost_are_refused() {
        let made = |bits: u32| {
            let text = format!(
                "1 kind=differential firmware=f serial=s watchdog=300 period=20 speed=500 turn=2000 track=200000 \
                 ticks=1000000 bits={bits}"
            );
            let (_, hello) = Hello::read(text.split(' ')).expect("it is complete");
            Odometer::new(&hello).map(drop)
        };
        // It may seem to make 1.1 m in 0.5 s.
        assert_eq!(made(12), Ok(()));
        assert!(made(11).is_err_and(|reason| reason.contains("wrap after 2.05 m")));
    }

    #[test]
    fn narrow_counts_that_may_have_wrapped_in_a_gap_are_no_motion() {
        let mut odometer = odometer(10);
        let mut step = |ms, count: u32| odometer.step(Duration::from_millis(ms), Motion::Counts([count; 2]));
        assert!(step(0, 100).is_ok() && step(20, 110).is_ok());
        let reason = step(320, 120).expect_err("512 ticks are 0.51 m, and it may have made 0.95 m");
        assert!(reason.contains("may have wrapped"), "{reason}");
    }

    #[test]
    fn speeds_that_no_base_has_and_those_after_a_gap_are_no_motion() {
        let mut odometer = Odometer {
            kind: Kind::Omnidirectional,
            ..odometer(32)
        };
        let mut step = |ms, speeds| odometer.step(Duration::from_millis(ms), Motion::Speeds(speeds));
        assert_eq!(step(0, [0.1, 0.0, 0.0]), Ok(Step::default()));
        assert!(step(100, [0.4, -0.3, 1.0]).is_ok_and(|step| step.twist.linear.y == -0.3));
        for (ms, speeds) in [(200, [9.0, 0.0, 0.0]), (300, [0.0, 0.0, 20.0])] {
            assert!(step(ms, speeds).is_err_and(|reason| reason.contains("no motion")));
        }
        assert!(step(1000, [0.1, 0.0, 0.0]).is_err_and(|reason| reason.contains("for 0.7 s")));
        assert!(step(1100, [0.1, 0.0, 0.0]).is_ok());
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
