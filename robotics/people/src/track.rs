//! A track: of a person, or of what has not been confirmed to be one.

use crate::detector::Leg;
use crate::kalman::Filter;
use crate::tracker::TrackerSettings;

/// The greatest distance between both legs of a person, m.
const STRIDE: f64 = 0.8;
/// The standard deviation of a person's middle from one leg, from both, and from two that look like one, m.
pub(crate) const DEVIATIONS: [f64; 3] = [0.15, 0.06, 0.08];
/// The width from which on a leg is two, m.
const TWO: f64 = 0.25;
/// The standard deviation of the speed of a person who appears, m/s.
const SPEED: f64 = 0.8;
/// The time by which an average confidence follows, s.
const MEMORY: f64 = 1.0;
/// How long a person who is not confirmed is kept without a leg, s.
pub(crate) const TENTATIVE: f64 = 0.5;
/// How far back the places of the legs count as those from which a person moves, s, and how many of them are kept.
const WINDOW: f64 = 2.0;
const TIMES: usize = 8;
/// How far a leg may go from one scan to the next, m, and how much farther for each second between them, m/s. What is
/// farther away is another thing.
const LEAP: [f64; 2] = [0.1, 1.5];
/// Two tracks with one leg each that are nearer than this, m, for so long, s, are one.
pub(crate) const DOUBLE: (f64, f64) = (0.45, 1.0);

#[derive(Clone, Copy, Debug)]
pub(crate) struct Track {
    /// 0 until it is confirmed.
    pub(crate) id: u32,
    pub(crate) filter: Filter,
    pub(crate) confidence: f64,
    /// Where and when it began, m and s.
    pub(crate) origin: ([f64; 2], f64),
    /// Where its legs were in the last scan in which it was seen, m; twice the same for one leg.
    pub(crate) places: [[f64; 2]; 2],
    /// The same at some times before, from the newest to the oldest, and how long ago the newest was, s.
    past: [[[f64; 2]; 2]; TIMES],
    since: f64,
    /// How long it has been seen, in all, s, and for how long it has moved, until it is confirmed.
    seen: f64,
    pub(crate) moving: f64,
    /// How long it has not, s.
    pub(crate) unseen: f64,
    /// For how much of that the laser saw that it is not there, s.
    pub(crate) absent: f64,
    /// For how long another track has had what may be its second leg, s.
    pub(crate) doubled: f64,
    /// Its legs in the present scan.
    pub(crate) legs: [Option<usize>; 2],
}

impl Track {
    /// Begins with its first leg, which is as confident as this, and the second one if there is any, at the time `now`.
    pub(crate) fn new(places: [[f64; 2]; 2], legs: [Option<usize>; 2], confidence: f64, now: f64) -> Self {
        let place = between(places[0], places[1]);
        Self {
            id: 0,
            filter: Filter::new(place, DEVIATIONS[0], SPEED),
            confidence,
            origin: (place, now),
            places,
            past: [places; TIMES],
            since: 0.0,
            seen: 0.0,
            moving: 0.0,
            unseen: 0.0,
            absent: 0.0,
            doubled: 0.0,
            legs,
        }
    }

    /// Drops the second leg if it is too far from the first.
    pub(crate) fn check_stride(&mut self, legs: &[([f64; 2], Leg)]) {
        if self.legs[0].is_none() {
            self.legs.swap(0, 1);
        }
        if let [Some(first), Some(second)] = self.legs
            && distance(legs[first].0, legs[second].0) > STRIDE
        {
            let far = |leg: usize| distance(legs[leg].0, self.filter.position);
            self.legs = [Some(if far(first) < far(second) { first } else { second }), None];
        }
    }

    /// Takes its legs.
    pub(crate) fn update(&mut self, legs: &[([f64; 2], Leg)], time: f64) {
        let [Some(first), second] = self.legs else {
            self.unseen += time;
            return;
        };
        let (position, leg) = legs[first];
        let (measured, deviation, confidence) = match second.map(|second| legs[second]) {
            Some((other, second)) => (
                between(position, other),
                DEVIATIONS[1],
                leg.confidence.max(second.confidence),
            ),
            None if leg.width > TWO => (position, DEVIATIONS[2], leg.confidence),
            None => (position, DEVIATIONS[0], leg.confidence),
        };
        self.remember([position, second.map_or(position, |second| legs[second].0)], time);
        self.filter.update(measured, deviation);
        self.confidence += (1.0 - libm::exp(-time / MEMORY)) * (confidence - self.confidence);
        self.seen += time;
        (self.unseen, self.absent) = (0.0, 0.0);
    }

    /// Remembers where its legs are. What is suddenly elsewhere is another thing, and the past does not count.
    fn remember(&mut self, places: [[f64; 2]; 2], time: f64) {
        self.since += time;
        if apart(self.places, places) > LEAP[0] + LEAP[1] * time {
            self.past = [places; TIMES];
        } else if self.since >= WINDOW / TIMES as f64 {
            self.past.rotate_right(1);
            (self.past[0], self.since) = (places, 0.0);
        }
        self.places = places;
    }

    pub(crate) fn is_kept(&self, settings: &TrackerSettings) -> bool {
        if self.doubled > DOUBLE.1 {
            false
        } else if self.id > 0 {
            self.unseen <= settings.patience
                && self.absent <= settings.absence
                && self.confidence >= settings.confidence
        } else {
            // What has stood there for long is only hidden.
            let patience = self.seen.clamp(TENTATIVE, settings.patience.max(TENTATIVE));
            self.unseen <= patience && self.absent <= TENTATIVE
        }
    }

    /// Takes the number away, as another track has it now.
    pub(crate) fn replace(&mut self) {
        (self.id, self.unseen) = (0, f64::INFINITY);
    }

    pub(crate) fn is_replaced(&self) -> bool {
        self.unseen.is_infinite()
    }

    /// Returns whether all its legs are so far from where they were.
    pub(crate) fn has_moved(&self, way: f64) -> bool {
        self.past.iter().any(|&then| apart(then, self.places) >= way)
    }
}

/// Returns the least distance from one of some legs to one of others: if only one of two is in sight, that is no motion.
fn apart(from: [[f64; 2]; 2], to: [[f64; 2]; 2]) -> f64 {
    let distances = from.iter().flat_map(|&a| to.iter().map(move |&b| distance(a, b)));
    distances.fold(f64::INFINITY, f64::min)
}

pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

pub(crate) fn between(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])]
}
