//! Turns of a rotating lidar: points one after another become scans with a constant number of beams. It knows no
//! protocol and no clock: the time comes with the points.
//!
//! The lidars rotate clockwise, as seen from above, and count their angles clockwise. Scans count counter-clockwise
//! (REP-103). A turn begins and ends behind, so that the motion of the robot during a turn is not seen ahead.

/// How far a point may be from a beam that it counts for, in beams. Points that are about as dense as the beams would
/// leave beams empty at 0.5.
const REACH: f64 = 0.6;
/// The greatest angle without a point in a turn, degrees.
const MAX_GAP: f64 = 90.0;
/// Least points of a turn. The slowest lidars measure about 200.
const MIN_POINTS: usize = 90;

/// What a lidar measured in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Clockwise from straight ahead, degrees.
    pub(crate) angle: f64,
    /// Distance, m, by REP-117.
    pub(crate) range: f32,
    /// In units of the lidar.
    pub(crate) intensity: f32,
    /// Time of the measurement by any clock that only advances, s.
    pub(crate) time: f64,
}

/// The beams of one turn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Turn {
    /// Distances, m; the first beam looks behind, and the others follow counter-clockwise.
    pub(crate) ranges: Vec<f32>,
    pub(crate) intensities: Vec<f32>,
    /// Time of its last point by the clock of the points, s.
    pub(crate) end: f64,
    /// Time from its first point to its last, s.
    pub(crate) duration: f64,
}

/// Collects points until a turn is complete.
#[derive(Debug)]
pub(crate) struct Turns {
    /// Whether the lidar hangs upside down, and rotates counter-clockwise as seen from above.
    inverted: bool,
    ranges: Vec<f32>,
    intensities: Vec<f32>,
    points: usize,
    /// Time of the first point of the turn; `None` before a turn has begun.
    start: Option<f64>,
    /// Angle from behind, degrees, and time of the last point.
    last: Option<(f64, f64)>,
}

impl Turns {
    /// Starts without points. The first turn begins when the lidar looks behind.
    pub(crate) fn new(beams: usize, inverted: bool) -> Self {
        Self {
            inverted,
            ranges: vec![f32::NAN; beams],
            intensities: vec![0.0; beams],
            points: 0,
            start: None,
            last: None,
        }
    }

    /// Discards the turn that has begun.
    pub(crate) fn clear(&mut self) {
        (self.start, self.last) = (None, None);
    }

    /// Adds a point. Returns the turn that ended before it.
    pub(crate) fn add(&mut self, point: &Point) -> Option<Turn> {
        let place = (point.angle + 180.0).rem_euclid(360.0);
        let mut turn = None;
        if let Some((last, _)) = self.last {
            let step = (place - last).rem_euclid(360.0);
            if step > 360.0 - MAX_GAP {
                // Lidars that correct the angle of each point do not measure exactly in order. A point of the turn that
                // has ended is too late.
                if place < last && self.start.is_some() {
                    self.mark(point);
                }
                return None;
            }
            if step > MAX_GAP {
                self.clear();
            } else if place < last {
                turn = self.finish();
                self.start = Some(point.time);
            }
        }
        self.last = Some((place, point.time));
        if self.start.is_some() {
            self.mark(point);
        }
        turn
    }

    /// Ends the turn, and empties the beams even if it was not whole.
    fn finish(&mut self) -> Option<Turn> {
        let beams = self.ranges.len();
        let ranges = core::mem::replace(&mut self.ranges, vec![f32::NAN; beams]);
        let intensities = core::mem::replace(&mut self.intensities, vec![0.0; beams]);
        let points = core::mem::take(&mut self.points);
        let (start, (_, end)) = (self.start?, self.last?);
        let turn = Turn {
            ranges,
            intensities,
            end,
            duration: end - start,
        };
        (points >= MIN_POINTS && turn.duration > 0.0).then_some(turn)
    }

    /// Enters a point at the beams that it is near to. Of several points at a beam, the nearest counts.
    fn mark(&mut self, point: &Point) {
        self.points += 1;
        let angle = if self.inverted { point.angle } else { -point.angle };
        let beams = self.ranges.len() as f64;
        let place = (angle + 180.0).rem_euclid(360.0) / 360.0 * beams;
        for beam in (place - REACH).ceil() as i64..=(place + REACH).floor() as i64 {
            let beam = beam.rem_euclid(beams as i64) as usize;
            if self.ranges[beam].is_nan() || point.range < self.ranges[beam] {
                (self.ranges[beam], self.intensities[beam]) = (point.range, point.intensity);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Adds points at these angles, a millisecond apart. The distance is the angle.
    fn turns(turns: &mut Turns, angles: impl IntoIterator<Item = f64>) -> Vec<Turn> {
        let point = |(index, angle): (usize, f64)| Point {
            angle: angle.rem_euclid(360.0),
            range: angle.rem_euclid(360.0) as f32,
            intensity: 7.0,
            time: index as f64 / 1000.0,
        };
        let points = angles.into_iter().enumerate().map(point);
        points.filter_map(|point| turns.add(&point)).collect()
    }

    fn degrees(from: u32, to: u32) -> impl Iterator<Item = f64> {
        (from..to).map(f64::from)
    }

    #[test]
    fn a_turn_begins_behind_wherever_the_points_begin() {
        for first in [0, 1, 179, 180, 181, 352, 359] {
            let found = turns(&mut Turns::new(360, false), degrees(first, first + 1081));
            assert_eq!(found.len(), 2, "from {first}");
            for turn in found {
                assert!((turn.duration - 0.359).abs() < 1e-9);
                // Clockwise 90 degrees is to the right, a quarter of a turn after behind.
                assert_eq!((turn.ranges[90], turn.ranges[270]), (90.0, 270.0));
                assert_eq!((turn.ranges[180], turn.ranges[179]), (0.0, 1.0));
            }
        }
    }

    #[test]
    fn a_lidar_that_hangs_upside_down_is_seen_from_above() {
        let found = turns(&mut Turns::new(360, true), degrees(0, 720));
        assert_eq!((found[0].ranges[270], found[0].ranges[90]), (90.0, 270.0));
    }

    #[test]
    fn beams_without_a_point_have_no_measurement() {
        let found = turns(
            &mut Turns::new(360, false),
            degrees(0, 700).filter(|angle| !(380.0..400.0).contains(angle)),
        );
        let empty = found[0].ranges.iter().filter(|range| range.is_nan()).count();
        assert_eq!((found.len(), empty), (1, 20));
    }

    #[test]
    fn a_turn_with_a_great_gap_or_few_points_is_discarded() {
        let gap = degrees(0, 300).chain(degrees(420, 541));
        assert_eq!(turns(&mut Turns::new(360, false), gap), []);
        let few = degrees(0, 120).map(|step| step * 7.0);
        assert_eq!(turns(&mut Turns::new(360, false), few), []);
    }

    #[test]
    fn a_discarded_turn_leaves_nothing_in_the_next_one() {
        // A turn begins behind, and a gap of 120 degrees ends it. The next one has no points at 200 to 240 degrees.
        let next = degrees(540, 901).filter(|angle| !(560.0..600.0).contains(angle));
        let angles = degrees(170, 360).chain(degrees(480, 540)).chain(next);
        let found = turns(&mut Turns::new(360, false), angles);
        assert_eq!(found.len(), 1);
        let at = |clockwise: usize| found[0].ranges[(540 - clockwise) % 360];
        assert!((200..240).all(|clockwise| at(clockwise).is_nan()));
        assert_eq!((at(199), at(240)), (199.0, 240.0));
    }

    #[test]
    fn a_point_that_comes_after_its_turn_begins_no_other() {
        let angles = degrees(0, 181).chain([179.0]).chain(degrees(181, 541));
        assert_eq!(turns(&mut Turns::new(360, false), angles).len(), 1);
    }

    #[test]
    fn of_several_points_at_a_beam_the_nearest_counts_and_any_precedes_none() {
        let mut turns = Turns::new(90, false);
        let mut found = Vec::new();
        for step in 0..1100_u32 {
            let range = [f32::NAN, 3.0, 2.0, f32::INFINITY][step as usize % 4];
            found.extend(turns.add(&Point {
                angle: f64::from(step) % 360.0,
                range,
                intensity: range,
                time: f64::from(step),
            }));
        }
        assert_eq!(found[0].ranges, [2.0; 90]);
        assert_eq!(found[0].intensities, [2.0; 90]);
    }

    proptest! {
        #[test]
        fn evenly_spaced_points_leave_no_beam_empty(points in 375_u32..700, shift in 0.0..1.0) {
            let spacing = 360.0 / f64::from(points);
            let angles = (0..points * 3).map(|point| (f64::from(point) + shift) * spacing);
            let found = turns(&mut Turns::new(450, false), angles);
            prop_assert!(!found.is_empty());
            for turn in found {
                prop_assert!(turn.ranges.iter().all(|range| !range.is_nan()));
                for (beam, range) in turn.ranges.iter().enumerate() {
                    let error = f64::from(*range) - (180.0 - beam as f64 * 0.8);
                    let error = (error + 180.0).rem_euclid(360.0) - 180.0;
                    prop_assert!(error.abs() <= 0.8 * REACH + 1e-4);
                }
            }
        }

        #[test]
        fn any_points_give_turns_of_the_same_size(angles in prop::collection::vec(0.0_f64..360.0, 0..2000)) {
            for turn in turns(&mut Turns::new(360, false), angles) {
                prop_assert_eq!((turn.ranges.len(), turn.intensities.len()), (360, 360));
                prop_assert!(turn.duration > 0.0);
            }
        }
    }
}
