//! People around a robot by the scans of its laser. The tracker is `jde-people`; this plugin has its frame and times,
//! and what happens when a scan or the odometry is missing or wrong.

mod panel;

use jde_motion::{OdometryHistory, is_jump};
use jde_people::{DetectorSettings, Tracker, TrackerSettings};
use jde_schema::prelude::*;
use jde_schema::types::{Person, Persons, Point2D};

/// After this time without a usable scan the persons are not exported.
const SILENCE_TIME: Duration = Duration::from_millis(500);

/// Exports the persons whose legs a laser sees: their places, their velocities, and a number for each.
///
/// The laser must be between the ankles and the knees, and the frame is that of the odometry. Somebody is a person
/// once the legs have moved, remains a person while standing, and keeps the number while hidden for `patience`. The
/// persons are retracted while there is no usable scan or odometry.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "20ms")]
pub struct People {
    /// The scan of the laser.
    #[import]
    laser: Import<LaserScan>,
    /// The pose and velocity by the odometry.
    #[import]
    odometry: Import<Odometry>,
    /// The pose of the laser on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed, mount)]
    mount: Modulation<Pose2D>,
    /// How far away persons are searched.
    #[modulation(default = 10.0, unit = "m", min = 0.5, max = 30.0)]
    range: Modulation<f64>,
    /// The fewest beams that end at a leg.
    #[modulation(default = 2, min = 2, max = 100)]
    hits: Modulation<u32>,
    /// Least probability that a segment of the scan is the leg of a new person.
    #[modulation(default = 0.5, min = 0.0, max = 1.0)]
    appears: Modulation<f64>,
    /// Least average probability that the segments of a person are legs.
    #[modulation(default = 0.25, min = 0.0, max = 1.0)]
    confidence: Modulation<f64>,
    /// Time for which somebody must move to be a person.
    #[modulation(default = 0.5, unit = "s", min = 0.0, max = 60.0)]
    confirm: Modulation<f64>,
    /// How far both legs must move within 2 s for somebody to be a person. With 0, people who have never moved are persons,
    /// and so is furniture that looks like legs.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 10.0)]
    moved: Modulation<f64>,
    /// Time for which a hidden person keeps the number, as do all persons without a usable scan.
    #[modulation(default = 3.0, unit = "s", min = 0.0, max = 60.0)]
    patience: Modulation<f64>,
    /// Time for which a person is kept where the laser sees an empty place.
    #[modulation(default = 1.0, unit = "s", min = 0.0, max = 60.0)]
    absence: Modulation<f64>,
    /// The growth of the variance of a person's velocity: larger for people who change it readily.
    #[modulation(default = 0.02, unit = "m2/s3", min = 0.0001, max = 10.0)]
    acceleration: Modulation<f64>,
    /// Least step of the odometry that is a jump and no motion. A turn by more than 90 degrees is a jump too.
    #[modulation(default = 1.0, unit = "m", min = 0.1)]
    jump: Modulation<f64>,
    /// The persons, in the frame of the odometry.
    #[export(validity = "1s")]
    persons: Export<Persons>,
    tracker: Tracker,
    history: OdometryHistory,
    /// Sequence number of the last scan.
    scan_number: u64,
    /// When the last usable scan was.
    seen: Option<Duration>,
    /// The last pose of the odometry.
    last: Option<Pose2D>,
    /// Why there are no persons.
    trouble: Option<String>,
}

impl Schema for People {
    fn awake(&mut self, _: &Context) -> Result {
        // What was seen before a sleep is out of date, but no number is used again.
        self.tracker.forget();
        (self.seen, self.last) = (None, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.persons.retract(cx);
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.trouble = self.track(cx).err();
        if self.trouble.is_some() {
            self.persons.retract(cx);
        }
        Ok(())
    }
}

impl People {
    /// Exports the persons in a scan that is new.
    ///
    /// # Errors
    /// Why there are none.
    fn track(&mut self, cx: &Context) -> Result<(), String> {
        let odometry = self.odometry.get(cx).ok_or("there is no odometry")?;
        let measured = odometry.pose2d();
        if let Some(last) = self.last.replace(measured)
            && is_jump(&last, &measured, self.jump.get(cx))
        {
            let way = last.distance_to(&measured);
            warn!(cx, "the odometry jumped by {way:.2} m: all persons are new");
            self.tracker.forget();
            self.persons.retract(cx);
        }
        self.history.add(odometry.time(), &odometry);
        let laser = self.laser.get(cx);
        if let Some(laser) = &laser
            && core::mem::replace(&mut self.scan_number, laser.sequence()) != laser.sequence()
        {
            let base = self.history.base("scans", laser.time(), cx.now())?;
            let sensor = base.transform(&self.mount.get(cx));
            let (settings, time) = (self.settings(cx), laser.time().as_secs_f64());
            if self.tracker.step(&settings, time, &sensor, laser).is_ok() {
                self.seen = Some(cx.now());
                let persons = Persons {
                    header: Header {
                        stamp: laser.header.stamp,
                        frame_id: odometry.header.frame_id,
                    },
                    persons: self.tracker.persons().map(person).collect(),
                };
                self.persons.write_at(cx, persons, laser.time());
            }
        }
        let patience = Duration::from_secs_f64(self.patience.get(cx));
        let silent = self
            .seen
            .map_or(Duration::MAX, |seen| cx.now().saturating_sub(seen));
        if silent > patience {
            self.tracker.forget();
        }
        if laser.is_none() || silent > SILENCE_TIME.min(patience) {
            return Err("no scan that can be used".into());
        }
        Ok(())
    }

    fn settings(&self, cx: &Context) -> TrackerSettings {
        TrackerSettings {
            detector: DetectorSettings {
                range: self.range.get(cx),
                hits: self.hits.get(cx) as usize,
                ..DetectorSettings::default()
            },
            acceleration: self.acceleration.get(cx),
            appears: self.appears.get(cx),
            confirm: self.confirm.get(cx),
            moved: self.moved.get(cx),
            confidence: self.confidence.get(cx),
            patience: self.patience.get(cx),
            absence: self.absence.get(cx),
        }
    }
}

fn person(person: jde_people::Person) -> Person {
    let [x, y] = person.position;
    Person {
        id: person.id,
        position: Point2D { x, y },
        velocity: person.velocity,
        deviation: person.deviation,
        confidence: person.confidence,
        unseen: person.unseen,
        ..Person::default()
    }
}

/// Saves how many persons there have been, so that no number is used again.
impl Memory for People {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.tracker.last_number());
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.tracker.count_from(saved.take()?);
        Ok(())
    }
}

jde_schema::export!(
    "people",
    "Tracks the people around a robot by its laser.",
    [People]
);

#[cfg(test)]
mod tests;
