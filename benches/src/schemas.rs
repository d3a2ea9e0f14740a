//! The schemas that are linked into the benches. They record when their periods begin and how long they take
//! to act.
//!
//! Each instance keeps its notes for itself until it sleeps, so that recording takes no lock.

use std::f32::consts::TAU;
use std::hint::black_box;
use std::sync::{Mutex, PoisonError};

use jde_abi::raw;
use jde_loader::{Plugins, SearchPath};
use jde_measure::pairs::{Effort, Rounds, consume, interleave};
use jde_paths::{BEAMS, Periods};
use jde_schema::prelude::*;

/// The notes of all instances that have slept, one list each.
static NOTES: Mutex<Vec<Vec<u64>>> = Mutex::new(Vec::new());

/// The greatest number of notes of one instance.
const MAX_NOTES: usize = 10_000;

/// Records the number in its name, and then the beginning of each period, ns of the application's time.
#[derive(Describe)]
#[schema(motor, period = "1ms")]
pub(crate) struct Beat {
    times: Vec<u64>,
}

/// Is always ready, and does nothing.
#[derive(Describe)]
#[schema(motor, period = "50ms")]
pub(crate) struct Leaf {}

/// A sensor and an actuator. Each value is the time of its publication, ns; it is positive if a reaction is
/// expected.
#[derive(Describe)]
#[schema(driver, period = "20ms")]
pub(crate) struct Robot {
    /// The sensor's value.
    #[export]
    seen: Export<f64>,
    /// Speeds.
    #[command(neutral = Twist::ZERO, validity = "1s")]
    velocity: Command<Twist>,
    negative: bool,
}

/// Acts on each positive value of the sensor, and records the delay, ns.
#[derive(Describe)]
#[schema(motor, period = "1s")]
pub(crate) struct Brake {
    /// The sensor's value.
    #[import(trigger)]
    seen: Import<f64>,
    /// Speeds.
    #[actuator]
    base: Actuator<Twist>,
    acted_on: f64,
    delays: Vec<u64>,
}

/// Acts while `Brake` does not.
#[derive(Describe)]
#[schema(motor, period = "20ms")]
pub(crate) struct Cruise {
    /// Speeds.
    #[actuator]
    base: Actuator<Twist>,
}

/// A value of 64 bytes.
#[derive(Clone, Copy, Value)]
#[repr(C)]
#[value(name = "bench_msgs/msg/Small")]
pub(crate) struct Small {
    /// When it was sent, by the system's monotonic clock, ns.
    sent: u64,
    /// Padding.
    rest: [u64; 7],
}

/// A value as large as a picture.
#[derive(Clone, Copy, Value)]
#[repr(C)]
#[value(name = "bench_msgs/msg/Large")]
pub(crate) struct Large {
    /// When it was sent, by the system's monotonic clock, ns.
    sent: u64,
    /// Padding.
    rest: [u8; 640 * 480 * 3],
}

/// Publishes a small and a large value in turn.
#[derive(Describe)]
#[schema(motor, period = "20ms")]
pub(crate) struct Source {
    /// 64 bytes.
    #[export]
    small: Export<Small>,
    /// As large as a picture.
    #[export]
    large: Export<Large>,
    turn: bool,
}

/// Times reads of other schemas' exports.
#[derive(Describe)]
#[schema(motor, period = "20ms")]
pub(crate) struct Reader {
    /// 8 bytes.
    #[import]
    seen: Import<f64>,
    /// 64 bytes.
    #[import]
    small: Import<Small>,
}

impl Schema for Beat {
    fn awake(&mut self, cx: &Context) -> Result {
        self.times = Vec::with_capacity(MAX_NOTES);
        let number = cx.name().trim_start_matches(char::is_alphabetic);
        self.times.push(number.parse()?);
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        if self.times.len() < MAX_NOTES {
            self.times.push(now(cx));
        }
        Ok(true.into())
    }

    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }

    fn sleep(&mut self, _: &Context) {
        note(std::mem::take(&mut self.times));
    }
}

impl Schema for Leaf {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Schema for Robot {
    fn iterate(&mut self, cx: &Context) -> Result {
        let _ = self.velocity.get(cx);
        self.negative = !self.negative;
        let sign = if self.negative { -1.0 } else { 1.0 };
        self.seen.write(cx, sign * now(cx) as f64);
        Ok(())
    }
}

impl Schema for Brake {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.seen.get(cx).is_some_and(|seen| *seen > 0.0).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let accepted = self.base.command(cx, Twist::ZERO).accepted();
        let seen = self.seen.get(cx).map_or(0.0, |seen| *seen);
        if accepted && seen > 0.0 && seen != self.acted_on && self.delays.len() < MAX_NOTES {
            self.acted_on = seen;
            self.delays.push(now(cx) - seen as u64);
        }
        Ok(())
    }

    fn sleep(&mut self, _: &Context) {
        note(std::mem::take(&mut self.delays));
    }
}

impl Schema for Cruise {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::planar(0.4, 0.0));
        Ok(())
    }
}

impl Schema for Source {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.turn = !self.turn;
        if self.turn {
            let mut small = self.small.loan(cx);
            small.sent = crate::bare::now();
            small.publish();
        } else {
            let mut large = self.large.loan(cx);
            large.sent = crate::bare::now();
            large.publish();
        }
        Ok(())
    }
}

impl Schema for Reader {
    /// Times the reads once, as soon as both values exist. Is never ready.
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        if let (Some(seen), Some(small)) = (self.seen.get(cx), self.small.get(cx)) {
            let effort = EFFORT.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(effort) = effort {
                let reads = [
                    timed(effort, || *self.seen.get(cx).expect("the value persists"), *seen),
                    timed(
                        effort,
                        || *self.small.get(cx).expect("the value persists"),
                        *small,
                    ),
                ];
                READS.lock().unwrap_or_else(PoisonError::into_inner).extend(reads);
            }
        }
        Ok(false.into())
    }

    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

/// The times of a schema's repeated reads of one value.
pub(crate) struct ReadTimes {
    pub(crate) bytes: usize,
    /// Reads through the import.
    pub(crate) imported: Rounds,
    /// Reads of the same value in a mutex, by the same code.
    pub(crate) locked: Rounds,
}

/// The effort for the next `Reader` that has both values.
static EFFORT: Mutex<Option<Effort>> = Mutex::new(None);
/// The results of `Reader`.
static READS: Mutex<Vec<ReadTimes>> = Mutex::new(Vec::new());

/// Times a schema's reads of values of 8 and 64 bytes, in an application in lockstep.
pub(crate) fn reads(effort: Effort) -> anyhow::Result<Vec<ReadTimes>> {
    const APPLICATION: &str = r#"
        roots = ["source", "reader"]
        [schemas.robot]
        type = "pace/robot"
        [schemas.source]
        type = "pace/source"
        [schemas.reader]
        type = "pace/reader"
        imports = { seen = "robot.seen", small = "source.small" }
    "#;
    EFFORT
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .replace(effort);
    Periods::of(APPLICATION, &plugins()?)?.pass(200);
    let reads = std::mem::take(&mut *READS.lock().unwrap_or_else(PoisonError::into_inner));
    anyhow::ensure!(!reads.is_empty(), "the schema read nothing");
    Ok(reads)
}

fn timed<T: Copy>(effort: Effort, read: impl Fn() -> T, value: T) -> ReadTimes {
    let mutex = Mutex::new(value);
    let lock = || *black_box(&mutex).lock().unwrap_or_else(PoisonError::into_inner);
    let [imported, locked] = interleave(
        effort,
        [
            &mut |times| (0..times).for_each(|_| consume(read())),
            &mut |times| (0..times).for_each(|_| consume(lock())),
        ],
    );
    ReadTimes {
        bytes: size_of::<T>(),
        imported,
        locked,
    }
}

/// A base in a corridor, among the beams of a TurtleBot 4's laser, with a path ahead.
#[derive(Describe)]
#[schema(driver, period = "100ms")]
pub(crate) struct Corridor {
    /// The scan of the laser.
    #[export]
    laser: Export<LaserScan>,
    /// The pose and velocity of the base.
    #[export]
    pose: Export<Odometry>,
    /// The path.
    #[export]
    path: Export<Path>,
    /// The commanded speed.
    #[export]
    speed: Export<f64>,
    /// Speeds of the base.
    #[command(neutral = Twist::ZERO, validity = "1s")]
    velocity: Command<Twist>,
}

impl Schema for Corridor {
    fn iterate(&mut self, cx: &Context) -> Result {
        let step = TAU / BEAMS as f32;
        let range = |beam: u32| (1.0 / (step * beam as f32).sin().abs()).min(11.0);
        let scan = LaserScan {
            angle_max: step * (BEAMS - 1) as f32,
            angle_increment: step,
            range_max: 12.0,
            ranges: (0..BEAMS).map(range).collect(),
            ..LaserScan::default()
        };
        let ahead = |at: u32| PoseStamped {
            pose: Pose::from(Pose2D::new(0.1 * f64::from(at), 0.0, 0.0)),
            ..PoseStamped::default()
        };
        let path = Path {
            poses: (0..50).map(ahead).collect(),
            ..Path::default()
        };
        self.laser.write(cx, scan);
        let twist = Twist::planar(0.3, 0.0);
        self.pose
            .write(cx, Odometry::planar(cx.now(), Pose2D::ORIGIN, twist));
        self.path.write(cx, path);
        self.speed.write(cx, self.velocity.get(cx).linear.x);
        Ok(())
    }
}

/// A base among walls that are far away, and every other time before an obstacle, which stays until the base stands.
/// It records the time from the scan that shows the obstacle until the base stands, ns.
#[derive(Describe)]
#[schema(driver, period = "25ms")]
pub(crate) struct Base {
    /// The scan of the laser.
    #[export]
    laser: Export<LaserScan>,
    /// The pose and velocity of the base.
    #[export]
    pose: Export<Odometry>,
    /// Speeds of the base.
    #[command(neutral = Twist::ZERO, validity = "1s", trigger)]
    velocity: Command<Twist>,
    scans: u32,
    next_scan: u64,
    is_free: bool,
    /// When the obstacle was shown to a base that drove.
    shown_at: Option<u64>,
    delays: Vec<u64>,
}

impl Base {
    fn scan(&mut self, cx: &Context, is_free: bool) {
        self.scans += 1;
        let step = TAU / 360.0;
        // No scan equals the one before.
        let nearest = if is_free { 3.5 } else { 0.35 } + 1e-4 * (self.scans % 16) as f32;
        let is_ahead = |beam: u32| beam.min(360 - beam) < 20;
        let scan = LaserScan {
            angle_max: step * 359.0,
            angle_increment: step,
            range_max: 12.0,
            ranges: (0..360)
                .map(|beam| if is_ahead(beam) { nearest } else { 3.5 })
                .collect(),
            ..LaserScan::default()
        };
        let pose = Pose2D::new(1e-6 * f64::from(self.scans), 0.0, 0.0);
        let odometry = Odometry::planar(cx.now(), pose, Twist::planar(0.4, 0.0));
        self.pose.write(cx, odometry);
        self.laser.write(cx, scan);
    }
}

impl Schema for Base {
    fn awake(&mut self, cx: &Context) -> Result {
        (self.next_scan, self.is_free) = (now(cx), false);
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let drives = self.velocity.get(cx).linear.x > 0.0;
        if let Some(shown_at) = self.shown_at.take_if(|_| !drives) {
            self.delays.push(now(cx) - shown_at);
        }
        // A turn because of a command comes between two scans.
        if now(cx) >= self.next_scan {
            while now(cx) >= self.next_scan {
                self.next_scan += 25_000_000;
            }
            self.is_free = self.shown_at.is_none() && (!self.is_free || !drives);
            if !self.is_free && self.shown_at.is_none() {
                self.shown_at = Some(now(cx));
            }
            self.scan(cx, self.is_free);
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        let unanswered = self.shown_at.take().map(|shown_at| now(cx) - shown_at);
        self.delays.extend(unanswered);
        note(std::mem::take(&mut self.delays));
    }
}

/// Defines a father with many children.
macro_rules! parent {
    ($($child:ident)+) => {
        /// Wakes all its children once.
        #[derive(Describe)]
        #[schema(motor, period = "50ms")]
        pub(crate) struct Parent {
            $(
                /// One of many children.
                #[child(group = "all", optional)]
                $child: Child,
            )+
            woken: bool,
        }

        impl Schema for Parent {
            fn awake(&mut self, _: &Context) -> Result {
                self.woken = false;
                Ok(())
            }

            fn iterate(&mut self, cx: &Context) -> Result {
                if !self.woken {
                    self.woken = true;
                    $(self.$child.wake(cx);)+
                }
                Ok(())
            }
        }

        /// The roles of its children.
        pub(crate) const ROLES: &[&str] = &[$(stringify!($child)),+];
    };
}
parent! {
    c00 c01 c02 c03 c04 c05 c06 c07 c08 c09 c10 c11 c12 c13 c14 c15 c16 c17 c18 c19
    c20 c21 c22 c23 c24 c25 c26 c27 c28 c29 c30 c31 c32 c33 c34 c35 c36 c37 c38 c39
    c40 c41 c42 c43 c44 c45 c46 c47 c48 c49 c50 c51 c52 c53 c54 c55 c56 c57 c58 c59
    c60 c61 c62 c63 c64 c65 c66 c67 c68 c69 c70 c71 c72 c73 c74 c75 c76 c77 c78 c79
    c80 c81 c82 c83 c84 c85 c86 c87 c88 c89 c90 c91 c92 c93 c94 c95 c96 c97 c98 c99
}

/// The plugin of these schemas.
pub(crate) static PLUGIN: raw::Plugin = jde_schema::plugin!(
    "pace",
    "Schemas of the benches.",
    [
        Beat, Leaf, Robot, Brake, Cruise, Source, Reader, Corridor, Base, Parent
    ]
);

/// Returns a catalogue with the plugin of these schemas.
pub(crate) fn plugins() -> anyhow::Result<Plugins> {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN)?;
    Ok(plugins)
}

/// Takes the notes that were stored since the last call.
pub(crate) fn notes() -> Vec<Vec<u64>> {
    std::mem::take(&mut *NOTES.lock().unwrap_or_else(PoisonError::into_inner))
}

fn note(notes: Vec<u64>) {
    NOTES.lock().unwrap_or_else(PoisonError::into_inner).push(notes);
}

fn now(cx: &Context) -> u64 {
    cx.now().as_nanos() as u64
}
