//! The search for a robot whose place is not known: poses all over the free cells, or around a place, by how well one
//! scan fits there. It looks at so many poses a call, so that no iteration waits for its end.

use core::f32::consts::TAU;

use jde_types::Pose2D;

use crate::beams::Beams;
use crate::field::LikelihoodField;
use crate::random::around_zero;
use crate::sensor::{Model, Sensor};

/// The headings at each place: every 5 degrees.
const TURNS: usize = 72;
/// The beams that a pose is judged by.
pub(crate) const BEAMS: usize = 30;
/// The distance of the places, m, unless there would be too many.
const SPACING: f64 = 0.2;
/// The standard deviation of the ends of beams, m: poses lie this far from the true one.
const DEVIATION: f64 = 0.2;
/// The beams of a scan that are kept for what is done with the places.
const KEPT_BEAMS: usize = 60;

/// How many poses are kept. Many are of one place.
const KEPT: usize = 4000;

/// A pose in cells, and how well the scan fits.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    pose: [f32; 3],
    score: f32,
}

/// Where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Region {
    /// At all free cells.
    Everywhere,
    /// In a disc: its middle and radius in cells.
    Disc((f32, f32), f32),
}

/// A search under way, or the memory for one.
#[derive(Clone, Debug)]
pub(crate) struct PoseSearch {
    region: Region,
    /// The pose of the odometry at the scan.
    odometry: Pose2D,
    /// The ends of the beams in cells, for each heading.
    ends: Vec<[(f32, f32); BEAMS]>,
    beams: Beams,
    /// More beams of the same scan.
    scan: Beams,
    scores: [f32; 256],
    place: u32,
    places: u32,
    spacing: f32,
    /// Whether the places are as near to each other as they should.
    is_dense: bool,
    /// The best so far, and others.
    candidates: Vec<Candidate>,
    /// Whether others were left out.
    is_cut: bool,
}

impl PoseSearch {
    /// Returns room for a search on a map with cells of `cell` m.
    pub(crate) fn new(cell: f64) -> Self {
        let mut scores = [0.0; 256];
        let sensor = Sensor {
            model: Model::LikelihoodField,
            deviation: DEVIATION,
            outliers: 0.05,
            independent: 1.0,
        };
        for (score, distance) in scores.iter_mut().zip(LikelihoodField::distances()) {
            *score = sensor.logarithm(f64::from(distance) * cell);
        }
        Self {
            region: Region::Everywhere,
            odometry: Pose2D::ORIGIN,
            ends: vec![[(0.0, 0.0); BEAMS]; TURNS],
            beams: Beams::new(BEAMS),
            scan: Beams::new(KEPT_BEAMS),
            scores,
            place: 0,
            places: 0,
            spacing: 0.0,
            is_dense: false,
            candidates: Vec::with_capacity(2 * KEPT),
            is_cut: false,
        }
    }

    /// Begins anew with a scan, which was taken at this pose of the odometry. It looks at no more than `most` poses.
    pub(crate) fn begin(
        &mut self,
        field: &LikelihoodField,
        region: Region,
        beams: &Beams,
        odometry: Pose2D,
        most: usize,
    ) {
        let cell = field.geometry().resolution();
        self.beams.thin(beams);
        self.scan.thin(beams);
        for (turn, ends) in self.ends.iter_mut().enumerate() {
            let (sin, cos) = libm::sincosf(turn as f32 * TAU / TURNS as f32);
            let scale = 1.0 / cell as f32;
            for (end, beam) in ends.iter_mut().zip(self.beams.as_slice()) {
                let (ahead, left) = (beam.end.0 * scale, beam.end.1 * scale);
                *end = (cos * ahead - sin * left, sin * ahead + cos * left);
            }
        }
        let area = match region {
            Region::Everywhere => f64::from(field.free_cells()),
            Region::Disc(_, radius) => core::f64::consts::PI * f64::from(radius) * f64::from(radius),
        };
        let spacing = SPACING / cell;
        let places = (area / (spacing * spacing))
            .ceil()
            .min((most / TURNS) as f64)
            .max(1.0);
        (self.place, self.places) = (0, places as u32);
        self.spacing = libm::sqrt(area / places) as f32;
        self.is_dense = self.spacing <= spacing as f32;
        self.candidates.clear();
        self.is_cut = false;
        (self.region, self.odometry) = (region, odometry);
    }

    /// How far it is, from 0 to 1.
    pub(crate) fn done(&self) -> f64 {
        f64::from(self.place) / f64::from(self.places.max(1))
    }

    /// Where it looks.
    pub(crate) const fn region(&self) -> Region {
        self.region
    }

    /// Whether it looked everywhere, as closely as it should: what it did not find is not there.
    pub(crate) fn is_of_all(&self) -> bool {
        self.is_dense && self.region == Region::Everywhere
    }

    /// Whether it left out poses that are worse than those that it kept.
    pub(crate) const fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Its scan.
    pub(crate) const fn scan(&self) -> &Beams {
        &self.scan
    }

    /// The distance of the places, in cells.
    pub(crate) const fn spacing(&self) -> f32 {
        self.spacing
    }

    /// The pose of the odometry at its scan.
    pub(crate) fn odometry(&mut self) -> &mut Pose2D {
        &mut self.odometry
    }

    /// Looks at about `poses` more poses. Returns whether that was the end.
    pub(crate) fn advance(
        &mut self,
        field: &LikelihoodField,
        poses: usize,
        random: &mut fastrand::Rng,
    ) -> bool {
        for _ in 0..(poses / TURNS).max(1) {
            if self.place >= self.places {
                break;
            }
            if let Some(place) = self.draw(field, random) {
                self.judge(field, place);
            }
            self.place += 1;
        }
        self.place >= self.places
    }

    /// The next place: a random one of the next free cells, or of the disc.
    fn draw(&self, field: &LikelihoodField, random: &mut fastrand::Rng) -> Option<(f32, f32)> {
        match self.region {
            Region::Everywhere => {
                let share = (f64::from(self.place) + random.f64()) / f64::from(self.places);
                let number = (share * f64::from(field.free_cells())) as u32;
                let (x, y) = field.free_cell(number);
                Some((x + random.f32(), y + random.f32()))
            }
            Region::Disc((x, y), radius) => {
                let away = radius * libm::sqrtf(random.f32());
                let (sin, cos) = libm::sincosf(TAU * random.f32());
                Some((x + away * cos, y + away * sin))
            }
        }
        .filter(|&(x, y)| field.is_free(x, y))
    }

    fn judge(&mut self, field: &LikelihoodField, (x, y): (f32, f32)) {
        let count = self.beams.as_slice().len();
        for turn in 0..TURNS {
            let scores = self.ends[turn][..count].iter().map(|end| {
                let parts = field.parts(x + end.0, y + end.1);
                self.scores[parts as usize]
            });
            let candidate = Candidate {
                pose: [x, y, turn as f32 * TAU / TURNS as f32],
                score: scores.sum(),
            };
            if self.candidates.len() == self.candidates.capacity() {
                self.keep_best();
            }
            self.candidates.push(candidate);
        }
    }

    fn keep_best(&mut self) {
        if self.candidates.len() > KEPT {
            let better = |a: &Candidate, b: &Candidate| b.score.total_cmp(&a.score);
            self.candidates.select_nth_unstable_by(KEPT, better);
            self.candidates.truncate(KEPT);
            self.is_cut = true;
        }
    }

    /// Sorts the best poses, the best first.
    pub(crate) fn sort(&mut self) {
        self.keep_best();
        let better = |a: &Candidate, b: &Candidate| b.score.total_cmp(&a.score);
        self.candidates.sort_unstable_by(better);
    }

    /// The poses in cells.
    pub(crate) fn candidates(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        self.candidates.iter().map(|candidate| candidate.pose)
    }

    /// Calls `take` for the poses, each moved at random by the distance between two; at most `most`.
    pub(crate) fn best(&self, most: usize, random: &mut fastrand::Rng, mut take: impl FnMut([f32; 3])) {
        for [x, y, heading] in self.candidates().take(most) {
            let half = self.spacing / 2.0;
            let turn = TAU / TURNS as f32 / 2.0;
            take([
                x + half * around_zero(random),
                y + half * around_zero(random),
                heading + turn * around_zero(random),
            ]);
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_types::LaserScan;

    use super::*;
    use crate::field::tests::map;

    /// The pose of the scan is among the best, and calls in parts find the same.
    #[test]
    fn the_pose_of_a_scan_is_found_in_parts() {
        let field = LikelihoodField::new(&map(&[
            "#######################",
            "#.........#...........#",
            "#.........#...........#",
            "#.....................#",
            "#.........#....####...#",
            "#.........#....####...#",
            "#######################",
        ]));
        let truth = [15.0, 4.5, 1.0];
        let mut scan = LaserScan {
            angle_increment: TAU / 60.0,
            range_max: 80.0,
            ..LaserScan::default()
        };
        for beam in 0..60 {
            let (sin, cos) = libm::sincosf(truth[2] + scan.angle(beam) as f32);
            let way = field.cast((truth[0], truth[1]), (cos, sin), 60.0);
            scan.ranges.push(way).expect("few beams");
        }
        scan.state_last_angle();
        let mut beams = Beams::new(60);
        beams.update(&scan, |_| Pose2D::ORIGIN).expect("all hit");
        let find = |region, step| {
            let mut random = fastrand::Rng::with_seed(3);
            // Cells of 1 m.
            let mut search = PoseSearch::new(1.0);
            search.begin(&field, region, &beams, Pose2D::ORIGIN, 200_000);
            let mut calls = 1;
            while !search.advance(&field, step, &mut random) {
                assert!(search.done() < 1.0);
                calls += 1;
            }
            let mut best = Vec::new();
            search.sort();
            search.best(20, &mut random, |pose| best.push(pose));
            (best, calls)
        };
        let (best, calls) = find(Region::Everywhere, usize::MAX);
        let near = |pose: &&[f32; 3]| {
            (pose[0] - truth[0]).hypot(pose[1] - truth[1]) < 1.0 && (pose[2] - 1.0).abs() < 0.2
        };
        assert!(best.iter().filter(near).count() >= 15, "{best:?}");
        assert_eq!((best, 1), (find(Region::Everywhere, 10_000).0, calls));
        let (best, _) = find(Region::Disc((5.0, 3.0), 2.0), 1000);
        assert!(best.iter().all(|pose| (pose[0] - 5.0).hypot(pose[1] - 3.0) < 2.2));
        assert!(
            find(Region::Disc((-50.0, 3.0), 2.0), 1000).0.is_empty(),
            "off the map"
        );
    }
}
