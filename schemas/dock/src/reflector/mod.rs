//! The schema that finds a reflector in the scans of a laser. It knows neither where the laser is on the base nor where the
//! reflector is in the world.

mod panel;
mod shape;

use jde_schema::prelude::*;
use jde_schema::types::PoseStamped;

use shape::{Bright, ReflectorShape};

/// Most things that may be strips. More are noise, and would cost more than its budget.
const MAX_CANDIDATES: usize = 64;

/// Strips of a reflector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/ReflectorStrips")]
pub struct ReflectorStrips {
    /// The middle of each strip, from that of the reflector to the right for a person who faces it, ascending.
    #[value(unit = "m")]
    pub offsets: Seq<f64, 8>,
}

/// Finds a reflector by the intensities of a laser: upright bright strips at stated places in a plane.
///
/// All strips must be in sight, and nothing else that is bright between them. If two reflectors of the shape are in
/// sight, none is exported; `state` says why.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "10ms")]
pub struct Reflector {
    /// The scans, with intensities.
    #[import]
    laser: Import<LaserScan>,
    /// The strips: `{ offsets = [-0.2, 0.08, 0.2] }`. With uneven distances a mirror shows another shape.
    #[modulation(default = ReflectorStrips { offsets: Seq::new() })]
    strips: Modulation<ReflectorStrips>,
    /// Width of a strip.
    #[modulation(default = 0.05, unit = "m", min = 0.01, max = 1.0)]
    width: Modulation<f64>,
    /// The least intensity of a strip, in units of the laser: above all else that is near the reflector.
    #[modulation(default = 0.0, min = 0.0)]
    bright: Modulation<f64>,
    /// How far a strip may be from its place, besides the distance from one beam to the next.
    #[modulation(default = 0.03, unit = "m", min = 0.001, max = 0.5)]
    tolerance: Modulation<f64>,
    /// How far away strips are searched.
    #[modulation(default = 4.0, unit = "m", min = 0.1)]
    range: Modulation<f64>,
    /// The middle of the reflector in the frame of the laser; its yaw is the direction in which the reflector faces.
    /// Retracted while the scan does not show exactly one.
    #[export]
    reflector: Export<PoseStamped>,
    /// The place of the reflector, or the reason why there is none, in words.
    #[export]
    state: Export<Text<160>>,
    /// Sequence number of the last scan; `None` after it awoke.
    last: Option<u64>,
    /// What is bright in the last scan.
    seen: Vec<Bright>,
    /// The reflector in the last scan.
    found: Option<Pose2D>,
    /// The words of the last scan.
    words: String,
}

impl Schema for Reflector {
    fn awake(&mut self, _: &Context) -> Result {
        self.last = None;
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.reflector.retract(cx);
        self.state.retract(cx);
        (self.found, self.seen) = (None, Vec::new());
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(scan) = self.laser.get(cx) else {
            self.seen.clear();
            self.last = None;
            self.publish(cx, Err("there is no scan".into()), Header::default(), cx.now());
            return Ok(());
        };
        if self.last.replace(scan.sequence()) != Some(scan.sequence()) {
            let found = self.find(cx, &scan);
            self.publish(cx, found, scan.header, scan.time());
        }
        Ok(())
    }
}

impl Inspect for Reflector {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let (strips, width) = (self.strips.get(cx), self.width.get(cx));
        if strips.offsets.len() < 2 {
            problems.wrong(
                &self.strips,
                "states fewer than two strips: expected { offsets = [-0.2, 0.08, 0.2] }",
            );
        }
        if let Some(pair) = strips
            .offsets
            .windows(2)
            .find(|pair| pair[1] - pair[0] < 2.0 * width)
        {
            problems.wrong(
                &self.strips,
                format!(
                    "has {} m after {} m: expected them to ascend by two widths or more",
                    pair[1], pair[0]
                ),
            );
        }
        if self.bright.get(cx) == 0.0 {
            problems.wrong(
                &self.bright,
                "is 0: state an intensity between that of the strips and that of what is beside them",
            );
        }
    }
}

impl Reflector {
    /// Returns the reflector in a scan.
    ///
    /// # Errors
    /// Why there is none.
    fn find(&mut self, cx: &Context, scan: &LaserScan) -> Result<Pose2D, String> {
        self.seen.clear();
        let (intensities, ranges) = (scan.intensities.len(), scan.ranges.len());
        if intensities == 0 {
            return Err("the laser measures no intensities".into());
        }
        if intensities != ranges {
            return Err(format!(
                "the scan has {intensities} intensities for {ranges} ranges"
            ));
        }
        let strips = self.strips.get(cx);
        let shape = ReflectorShape {
            offsets: &strips.offsets,
            width: self.width.get(cx),
            tolerance: self.tolerance.get(cx),
        };
        self.seen = shape::bright(scan, self.bright.get(cx), self.range.get(cx));
        let seen = &self.seen;
        let narrow = seen.iter().filter(|thing| shape.is_strip(thing)).count();
        if narrow > MAX_CANDIDATES {
            return Err(format!(
                "{narrow} things are as bright and narrow as strips: raise `bright`"
            ));
        }
        match shape.find(seen)[..] {
            [pose] => Ok(pose),
            [] => Err(format!(
                "no reflector of {} strips among {narrow} bright ones and {} other things",
                strips.offsets.len(),
                seen.len() - narrow
            )),
            [first, second, ..] => Err(format!(
                "two reflectors of this shape, {:.2} m apart",
                first.distance_to(&second)
            )),
        }
    }

    fn publish(&mut self, cx: &Context, found: Result<Pose2D, String>, header: Header, time: Duration) {
        self.found = found.as_ref().ok().copied();
        match found {
            Ok(pose) => {
                let stamped = PoseStamped {
                    header,
                    pose: pose.into(),
                };
                self.reflector.write_at(cx, stamped, time);
                self.words = format!("a reflector, {:.2} m away", libm::hypot(pose.x, pose.y));
            }
            Err(why) => {
                self.reflector.retract(cx);
                self.words = why;
            }
        }
        self.state.write(cx, Text::truncated(&self.words));
    }
}

#[cfg(test)]
mod tests;
