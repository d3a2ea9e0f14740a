//! Who waves: the person beside a colour that appears.

use core::time::Duration;

use jde_schema::prelude::*;
use jde_schema::types::{Person, normalize_angle};

/// Time without the colour after which it appears anew.
const LULL: Duration = Duration::from_millis(1500);
/// Time after a wave in which no other one counts: the robot turns, and the colour leaves the picture and returns.
const PAUSE: Duration = Duration::from_secs(8);
/// How far a person may be from where the one who is followed was last, to be the same, m.
const SAME_PERSON_DISTANCE: f64 = 1.0;

/// The colour by which people wave, over time.
#[derive(Debug, Default)]
pub(crate) struct Wave {
    seen_at: Option<Duration>,
    /// When a wave was taken.
    taken_at: Option<Duration>,
    /// Whether the colour that is seen was taken.
    is_taken: bool,
}

impl Wave {
    /// Takes whether the colour is seen. Returns whether it is a wave that was not taken yet.
    pub(crate) fn begins(&mut self, now: Duration, is_seen: bool) -> bool {
        if !is_seen {
            return false;
        }
        let before = self.seen_at.replace(now);
        if before.is_none_or(|before| now.saturating_sub(before) > LULL) {
            self.is_taken = false;
        }
        let pauses = self.taken_at.is_some_and(|at| now.saturating_sub(at) <= PAUSE);
        if pauses {
            self.is_taken = true;
        }
        !self.is_taken
    }

    /// Takes the wave: it begins no more until the colour appears anew.
    pub(crate) fn take(&mut self, now: Duration) {
        (self.taken_at, self.is_taken) = (Some(now), true);
    }
}

/// Returns the number of the person whose direction from a robot is nearest to `bearing`, and at most `beside` from it.
pub(crate) fn find(bearing: f64, beside: f64, robot: &Pose2D, persons: &[Person]) -> Option<u32> {
    let off = |person: &Person| {
        let place = robot.localize(&place(person));
        normalize_angle(libm::atan2(place.y, place.x) - bearing).abs()
    };
    least(persons, off, beside)
}

/// Returns the number of the person at `target`, where the one who is followed was last.
pub(crate) fn at(target: &Pose2D, persons: &[Person]) -> Option<u32> {
    least(
        persons,
        |person| place(person).distance_to(target),
        SAME_PERSON_DISTANCE,
    )
}

fn place(person: &Person) -> Pose2D {
    Pose2D::new(person.position.x, person.position.y, 0.0)
}

fn least(persons: &[Person], measure: impl Fn(&Person) -> f64, most: f64) -> Option<u32> {
    let measured = persons.iter().map(|person| (measure(person), person.id));
    measured
        .filter(|(value, _)| *value <= most)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, id)| id)
}
