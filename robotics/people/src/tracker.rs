//! Persons from scan to scan: which legs belong to whom, who appears and who is gone.

use jde_types::{Echo, LaserScan, Pose2D, Unmeasured};

use crate::assignment::Assignment;
use crate::detector::{Detector, DetectorSettings, Leg};
use crate::track::{DEVIATIONS, DOUBLE, TENTATIVE, Track, between, distance};

/// The most persons.
pub const MOST_PERSONS: usize = 32;
/// The most tracks: of persons, and of what has not been confirmed to be one.
const MOST_TRACKS: usize = 64;
/// The most tracks that begin with a leg that is not confident enough for a person.
const MOST_DOUBTFUL: usize = 40;

/// The square of the Mahalanobis distance that 99 of 100 legs of a person stay below.
const GATE: f64 = 9.2;
/// What it costs if a track has no leg and no second leg: as much as twice the logarithm of the odds.
const MISSING: [f64; 2] = [14.0, 10.0];
/// How far a leg may be from where a person is expected, m; how much farther for each second without one, m/s; and at
/// most, m.
const REACH: [f64; 3] = [0.7, 1.0, 2.0];
/// How long after the patience with a hidden person a new track may take the person's number, s: it must move before.
const REMEMBERED: f64 = 3.0;
/// The least distance of a person who appears from those who are known, m.
const APART: f64 = 0.5;
/// How often the places of legs are noted, s; from which age to which they count, s; and how near to one the same thing
/// stands, m.
const NOTED: f64 = 0.25;
const AGES: [f64; 2] = [1.5, 4.0];
const STANDING_SPEED: f64 = 0.15;
/// From which distance of the nearest person to which the places of everything are noted, m: what is nearer may be a part
/// of the person.
const AROUND: [f64; 2] = [0.5, 2.0];
/// The least speed of a person who walks, m/s: no leg of this person is where something has stood.
const WALKS: f64 = 0.25;
/// How much of the acceleration of people what is not confirmed has: most of it is furniture.
const CALM: f64 = 0.25;
/// The distance from a wall within which nobody passes, m, and how near both ends of a way it does not count, m.
const WALL: [f64; 2] = [0.08, 0.2];
/// How much farther the laser must see for a place to be empty, and half of the place's width, m.
const EMPTY: [f64; 2] = [0.4, 0.15];

/// How persons are tracked. All may change from scan to scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerSettings {
    /// What is a leg.
    pub detector: DetectorSettings,
    /// The power of the acceleration of people, m²/s³.
    pub acceleration: f64,
    /// The least confidence of the leg of a person who appears.
    pub appears: f64,
    /// How long a person must move to be confirmed, s.
    pub confirm: f64,
    /// How far both legs of a person must move within 2 s to be confirmed, m. With 0, furniture that looks like legs is a
    /// person.
    pub moved: f64,
    /// The least average confidence of a person's legs.
    pub confidence: f64,
    /// How long a person is kept who is hidden, s.
    pub patience: f64,
    /// How long a person is kept who is not where the laser sees an empty place, s.
    pub absence: f64,
}

impl Default for TrackerSettings {
    fn default() -> Self {
        Self {
            detector: DetectorSettings::default(),
            acceleration: 0.02,
            appears: 0.5,
            confirm: 0.5,
            moved: 0.3,
            confidence: 0.25,
            patience: 3.0,
            absence: 1.0,
        }
    }
}

/// A person who is confirmed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Person {
    /// The number of the person, from 1; one who was lost and appears again keeps it.
    pub id: u32,
    /// The position, m.
    pub position: [f64; 2],
    /// The velocity, m/s.
    pub velocity: [f64; 2],
    /// The standard deviation of the position along each axis, m.
    pub deviation: f64,
    /// The average probability that what was seen were legs, from 0 to 1.
    pub confidence: f64,
    /// How long no leg of the person has been seen, s.
    pub unseen: f64,
}

/// Tracks persons in a frame that stands still, as that of the odometry.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    detector: Detector,
    tracks: Vec<Track>,
    /// The legs and all other hits of the present scan.
    legs: Vec<([f64; 2], Leg)>,
    obstacles: Vec<[f64; 2]>,
    /// The cost of each leg for each track.
    costs: Vec<f64>,
    assignment: Assignment,
    is_taken: Vec<bool>,
    /// When and where legs were that are those of no confirmed person.
    stood: Vec<(f64, [f64; 2])>,
    /// When and where everything else was around persons.
    surroundings: Vec<(f64, [f64; 2])>,
    /// Persons who are hidden, or ended while they were.
    lost: Vec<Lost>,
    /// The time of the last scan, s.
    last: Option<f64>,
    confirmed: u32,
}

/// A person who is hidden or ended: the number, and where and when the legs were last seen, m and s.
#[derive(Clone, Copy, Debug)]
struct Lost {
    id: u32,
    place: [f64; 2],
    time: f64,
}

impl Tracker {
    /// Takes a scan of a laser that was at `sensor` at the time `now`, s. A time before the last one forgets everybody.
    ///
    /// # Errors
    /// As [`LaserScan::measured`], or if the time or the pose is not finite. Then nothing changes.
    pub fn step(
        &mut self,
        settings: &TrackerSettings,
        now: f64,
        sensor: &Pose2D,
        scan: &LaserScan,
    ) -> Result<(), Unmeasured> {
        if !now.is_finite() || !sensor.is_finite() {
            return Err(Unmeasured::NotFinite);
        }
        self.detector.detect(&settings.detector, scan)?;
        let time = now - self.last.replace(now).unwrap_or(now);
        if time < 0.0 {
            self.tracks.clear();
            self.lost.clear();
            self.stood.clear();
            self.surroundings.clear();
        }
        let time = time.max(0.0);
        self.place(sensor);
        self.predict(settings, time);
        self.associate(settings, now);
        for track in &mut self.tracks {
            track.update(&self.legs, time);
            if track.unseen > 0.0 && is_empty(scan, sensor, track.filter.position) {
                track.absent += time;
            }
        }
        self.compare(time);
        self.end(settings, now);
        self.confirm(settings, now, time);
        self.appear(settings, now);
        self.note(now);
        Ok(())
    }

    /// Returns the confirmed persons.
    pub fn persons(&self) -> impl Iterator<Item = Person> + '_ {
        let confirmed = self.tracks.iter().filter(|track| track.id > 0);
        confirmed.map(|track| Person {
            id: track.id,
            position: track.filter.position,
            velocity: track.filter.velocity,
            deviation: track.filter.variance.sqrt(),
            confidence: track.confidence,
            unseen: track.unseen,
        })
    }

    /// Returns where the legs of the last scan are, and how probable each is.
    pub fn legs(&self) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        self.legs
            .iter()
            .map(|(position, leg)| (*position, leg.confidence))
    }

    /// Returns the number of the last person who was confirmed; 0 before the first one.
    #[must_use]
    pub fn last_number(&self) -> u32 {
        self.confirmed
    }

    /// Goes on to count from a number, as that of another tracker.
    pub fn count_from(&mut self, last: u32) {
        self.confirmed = last;
    }

    /// Forgets everybody. Numbers are not used again.
    pub fn forget(&mut self) {
        self.tracks.clear();
        self.lost.clear();
        self.legs.clear();
        self.stood.clear();
        self.surroundings.clear();
        self.last = None;
    }

    /// Transforms what the laser sees.
    fn place(&mut self, sensor: &Pose2D) {
        let (sin, cos) = libm::sincos(sensor.theta);
        let place = |x: f64, y: f64| [sensor.x + cos * x - sin * y, sensor.y + sin * x + cos * y];
        self.legs.clear();
        let legs = self.detector.legs().iter();
        self.legs.extend(legs.map(|leg| (place(leg.x, leg.y), *leg)));
        self.obstacles.clear();
        let obstacles = self.detector.obstacles().iter();
        self.obstacles.extend(obstacles.map(|&(x, y)| place(x, y)));
    }

    /// Moves the persons on; nobody whom the laser does not see goes through a wall that it sees.
    fn predict(&mut self, settings: &TrackerSettings, time: f64) {
        for track in &mut self.tracks {
            let before = track.filter.position;
            let share = if track.id > 0 { 1.0 } else { CALM };
            track.filter.predict(time, share * settings.acceleration);
            if track.unseen > 0.0
                && is_blocked(&self.obstacles, before, track.filter.position, [WALL[0], 0.0])
            {
                track.filter.stop(before);
            }
        }
    }

    /// Gives each person the legs with the least sum of costs: a row for each of two legs of each person, and columns for
    /// the legs and for the lack of one in each row.
    fn associate(&mut self, settings: &TrackerSettings, now: f64) {
        let count = self.legs.len();
        self.costs.clear();
        for track in &self.tracks {
            let reach = reach(track.unseen);
            let walks = track.id > 0 && distance(track.filter.velocity, [0.0; 2]) > WALKS;
            let costs = self.legs.iter().map(|(position, leg)| {
                let (distance, square) = track.filter.distance(*position, DEVIATIONS[0]);
                // Who was hidden appears again as clearly as somebody new.
                let is_doubtful = track.unseen > TENTATIVE && leg.confidence < settings.appears;
                let is_far = square > GATE || distance > reach || is_doubtful;
                let is_other = || walks && has_stood(&self.surroundings, now, &[*position]);
                if is_far || is_other() || is_blocked(&self.obstacles, track.filter.position, *position, WALL)
                {
                    f64::INFINITY
                } else {
                    square + track.filter.spread(DEVIATIONS[0]) - 2.0 * libm::log(leg.confidence)
                }
            });
            self.costs.extend(costs);
        }
        for track in &mut self.tracks {
            track.legs = [None; 2];
        }
        let (tracks, costs) = (&mut self.tracks, &self.costs);
        let rows = 2 * tracks.len();
        let cost = |row: usize, column: usize| {
            if column < count {
                // A leg out of reach costs more than any lack.
                costs[row / 2 * count + column].min(1e3)
            } else {
                MISSING[row % 2]
            }
        };
        self.assignment.solve((rows, count + rows), cost, |row, column| {
            if column < count && costs[row / 2 * count + column].is_finite() {
                tracks[row / 2].legs[row % 2] = Some(column);
            }
        });
        self.is_taken.clear();
        self.is_taken.resize(count, false);
        for track in &mut self.tracks {
            track.check_stride(&self.legs);
            for leg in track.legs.into_iter().flatten() {
                self.is_taken[leg] = true;
            }
        }
    }

    /// Ends tracks, and remembers the persons who are hidden.
    fn end(&mut self, settings: &TrackerSettings, now: f64) {
        let (tracks, longest) = (&self.tracks, settings.patience + REMEMBERED);
        let is_tracked = |lost: &Lost| tracks.iter().any(|track| track.id == lost.id);
        self.lost
            .retain(|lost| now - lost.time <= longest && !is_tracked(lost));
        let hidden = tracks.iter().filter(|track| track.id > 0 && track.unseen > 0.0);
        self.lost.extend(hidden.map(|track| Lost {
            id: track.id,
            place: between(track.places[0], track.places[1]),
            time: now - track.unseen,
        }));
        self.tracks.retain(|track| track.is_kept(settings));
    }

    /// Returns the number of the nearest lost person who may have become a track. It began when the person was lost, at most
    /// [`TENTATIVE`] before or `patience` later, within reach, and with no wall between.
    fn lost_before(&self, settings: &TrackerSettings, track: &Track) -> Option<u32> {
        let (place, begin) = track.origin;
        let reachable = self.lost.iter().filter(|lost| {
            let gap = begin - lost.time;
            (-TENTATIVE..=settings.patience).contains(&gap)
                && distance(lost.place, place) < reach(gap.max(0.0))
                && !is_blocked(&self.obstacles, lost.place, place, WALL)
        });
        let away = |lost: &Lost| distance(lost.place, place);
        let nearest = reachable.min_by(|a, b| away(a).total_cmp(&away(b)));
        nearest.map(|lost| lost.id)
    }

    /// Makes persons of tracks, unless they may be the legs of one who is known. Who was lost keeps the number.
    fn confirm(&mut self, settings: &TrackerSettings, now: f64, time: f64) {
        let mut persons = self.persons().count();
        for index in 0..self.tracks.len() {
            let track = &self.tracks[index];
            if track.id > 0 || track.unseen > 0.0 {
                continue;
            }
            let moves = settings.moved <= 0.0
                || track.has_moved(settings.moved) && !has_stood(&self.stood, now, &track.places);
            let moving = if moves { track.moving + time } else { 0.0 };
            let is_walking = moves && moving >= settings.confirm && track.confidence >= settings.appears;
            if is_walking && persons < MOST_PERSONS {
                let lost = self.lost_before(settings, track);
                let is_near = |other: &Track| {
                    let is_other = other.id > 0 && Some(other.id) != lost;
                    is_other && distance(other.filter.position, track.filter.position) < APART
                };
                if !self.tracks.iter().any(is_near) {
                    persons += 1;
                    self.number(index, lost);
                }
            }
            self.tracks[index].moving = moving;
        }
        self.tracks.retain(|track| !track.is_replaced());
    }

    /// Gives a track the number of a person who was lost, or the next one.
    fn number(&mut self, index: usize, lost: Option<u32>) {
        let id = lost.unwrap_or(self.confirmed + 1);
        self.confirmed = self.confirmed.max(id);
        self.lost.retain(|lost| lost.id != id);
        for track in &mut self.tracks {
            if track.id == id {
                track.replace();
            }
        }
        self.tracks[index].id = id;
    }

    /// Notes where legs are that are those of no confirmed person, and what else is around persons, now and then.
    fn note(&mut self, now: f64) {
        let is_new = |past: &[(f64, [f64; 2])]| past.last().is_some_and(|(then, _)| now - then < NOTED);
        if is_new(&self.stood) || is_new(&self.surroundings) {
            return;
        }
        for past in [&mut self.stood, &mut self.surroundings] {
            past.retain(|(then, _)| now - then <= AGES[1]);
        }
        let own = |index: usize| {
            self.tracks
                .iter()
                .any(|track| track.id > 0 && track.legs.contains(&Some(index)))
        };
        let legs = self.legs.iter().enumerate().filter(|(index, _)| !own(*index));
        self.stood.extend(legs.map(|(_, (place, _))| (now, *place)));
        let persons = || self.tracks.iter().filter(|track| track.id > 0);
        let nearest = |place: &[f64; 2]| {
            let away = persons().map(|track| distance(track.filter.position, *place));
            away.fold(f64::INFINITY, f64::min)
        };
        let others = self.obstacles.iter().copied();
        let others = others.filter(|place| (AROUND[0]..AROUND[1]).contains(&nearest(place)));
        self.surroundings.extend(others.map(|place| (now, place)));
    }

    /// Notices tracks that have one leg each of one person. The younger one ends.
    fn compare(&mut self, time: f64) {
        for index in 0..self.tracks.len() {
            let (older, rest) = self.tracks.split_at_mut(index);
            let Some(track) = rest.first_mut() else { return };
            let is_double = older.iter().any(|other| {
                let is_near = distance(other.filter.position, track.filter.position) < DOUBLE.0;
                is_near && track.legs[1].is_none() && other.legs[1].is_none()
            });
            track.doubled = if is_double { track.doubled + time } else { 0.0 };
        }
    }

    /// Begins a track for each leg that belongs to nobody, with the nearest other one. What looks little like a leg has
    /// a track, too, so that no person who is hidden takes it.
    fn appear(&mut self, settings: &TrackerSettings, now: f64) {
        for first in 0..self.legs.len() {
            let (position, leg) = self.legs[first];
            let is_doubtful = leg.confidence < settings.appears;
            let most = if is_doubtful { MOST_DOUBTFUL } else { MOST_TRACKS };
            if self.is_taken[first] || self.tracks.len() >= most {
                continue;
            }
            let others = (0..self.legs.len()).filter(|&other| other != first && !self.is_taken[other]);
            let near = others
                .map(|other| (other, distance(position, self.legs[other].0)))
                .filter(|&(other, apart)| {
                    apart < APART && !is_blocked(&self.obstacles, position, self.legs[other].0, WALL)
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let middle = near.map_or(position, |(other, _)| between(position, self.legs[other].0));
            let is_known = |track: &Track| distance(track.filter.position, middle) < APART;
            if self.tracks.iter().any(is_known) {
                continue;
            }
            self.is_taken[first] = true;
            if let Some((other, _)) = near {
                self.is_taken[other] = true;
            }
            let places = [position, near.map_or(position, |(other, _)| self.legs[other].0)];
            let legs = [Some(first), near.map(|(other, _)| other)];
            self.tracks.push(Track::new(places, legs, leg.confidence, now));
        }
    }
}

/// Returns how far from where a person is expected a leg may be that was not seen for some time, m.
fn reach(unseen: f64) -> f64 {
    (REACH[0] + REACH[1] * unseen).min(REACH[2])
}

/// Returns whether something has stood at one of these places for long.
fn has_stood(stood: &[(f64, [f64; 2])], now: f64, places: &[[f64; 2]]) -> bool {
    // Most places are far away, which one difference shows.
    let is_near =
        |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < STANDING_SPEED && distance(a, b) < STANDING_SPEED;
    let past = stood.iter().take_while(|(then, _)| now - then >= AGES[0]);
    let mut past = past.map(|(_, place)| *place);
    past.any(|place| places.iter().any(|&own| is_near(own, place)))
}

/// Returns whether an obstacle is within `near` m of the way between two places; what is within `ends` m of either does
/// not count.
fn is_blocked(obstacles: &[[f64; 2]], from: [f64; 2], to: [f64; 2], [near, ends]: [f64; 2]) -> bool {
    let length = distance(from, to);
    if length <= 2.0 * ends {
        return false;
    }
    let (ahead, left) = ((to[0] - from[0]) / length, (to[1] - from[1]) / length);
    obstacles.iter().any(|[x, y]| {
        let (x, y) = (x - from[0], y - from[1]);
        let (along, aside) = (x * ahead + y * left, y * ahead - x * left);
        (ends..=length - ends).contains(&along) && aside.abs() < near
    })
}

/// Returns whether the laser sees beyond a place.
fn is_empty(scan: &LaserScan, sensor: &Pose2D, place: [f64; 2]) -> bool {
    let local = sensor.localize(&Pose2D::new(place[0], place[1], 0.0));
    let range = libm::hypot(local.x, local.y);
    let half = libm::atan2(EMPTY[1], range);
    let bearing = libm::atan2(local.y, local.x);
    let mut beams = 0;
    for (beam, echo) in scan.echoes() {
        let angle = jde_types::normalize_angle(scan.angle(beam) - bearing);
        if angle.abs() <= half && echo != Echo::Nothing {
            beams += 1;
            let free = echo.distance(0.0).unwrap_or(f64::from(scan.range_max));
            if free < range + EMPTY[0] {
                return false;
            }
        }
    }
    beams > 0
}
