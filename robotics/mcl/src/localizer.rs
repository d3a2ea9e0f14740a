//! When particles move, are weighed and are drawn anew, and whether their estimate is sure.

use core::fmt;

use jde_types::Pose2D;

use crate::beams::Beams;
use crate::field::Field;
use crate::motion::MotionNoise;
use crate::particles::{Estimate, Particles, cells};
use crate::random::normals;
use crate::search::{Region, Search};
use crate::sensor::{Likelihoods, Sensor, agreement};

/// The share of the newest scan in the average agreement.
const NEWEST: f64 = 0.2;
/// How many scans an average needs before a robot counts as lost.
const SCANS: u32 = 10;
/// What is sure stays sure until it is so many times worse.
const LENIENT: f64 = 2.0;

/// What makes an estimate sure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The least share of the beams that agree with the map at the estimate, as an average over scans, when the estimate
    /// becomes sure. Below it a robot whose estimate was not sure yet is lost.
    pub sure_agreement: f64,
    /// The same while the estimate is sure. Below it a robot whose estimate was sure is lost.
    pub agreement: f64,
    /// How far the end of a beam may be from an obstacle of the map, m.
    pub tolerance: f64,
    /// The least share of the weights that the heaviest cluster has.
    pub share: f64,
    /// The greatest standard deviation of the position, m.
    pub deviation: f64,
    /// The greatest standard deviation of the heading, rad.
    pub heading_deviation: f64,
    /// The way that the robot must go after a search before its estimate is sure, m.
    pub confirm: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            sure_agreement: 0.7,
            agreement: 0.5,
            tolerance: 0.25,
            share: 0.95,
            deviation: 0.3,
            heading_deviation: 0.2,
            confirm: 1.0,
        }
    }
}

impl Limits {
    /// The share of the beams that must agree with an estimate that `is_sure` or not.
    const fn needed(&self, is_sure: bool) -> f64 {
        if is_sure {
            self.agreement
        } else {
            self.sure_agreement.max(self.agreement)
        }
    }
}

/// How it localizes. All may change from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The fewest particles.
    pub least: usize,
    /// The error of KLD-sampling.
    pub error: f64,
    /// The quantile of the standard normal distribution for the probability of that error.
    pub quantile: f64,
    /// The errors of the odometry.
    pub motion: MotionNoise,
    /// The model of the laser.
    pub sensor: Sensor,
    /// The way after which the particles are weighed, m.
    pub update_way: f64,
    /// The turn after which the particles are weighed, rad.
    pub update_turn: f64,
    /// The most poses that a search looks at.
    pub search: usize,
    /// The poses that a search looks at in one step.
    pub search_step: usize,
    /// What makes an estimate sure.
    pub limits: Limits,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            least: 500,
            error: 0.05,
            quantile: 2.326,
            motion: MotionNoise::default(),
            sensor: Sensor::default(),
            update_way: 0.1,
            update_turn: 0.1,
            search: 2_000_000,
            search_step: 40_000,
            limits: Limits::default(),
        }
    }
}

/// Why an estimate is not sure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// There is no estimate, because nobody has said where the robot is, and it was not searched.
    Nowhere,
    /// No scan has been compared with the map since the start.
    Unseen,
    /// This share of the beams agrees with the map.
    Disagrees(f64),
    /// Clusters of particles are at several places; this share is in the heaviest.
    Ambiguous(usize, f64),
    /// The standard deviation of the position, m, and of the heading, rad, is too large.
    Wide(f64, f64),
    /// The robot must go this way before the result of a search is sure, m.
    Unconfirmed(f64),
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Nowhere => f.write_str("nothing says where the robot is"),
            Self::Unseen => f.write_str("the scan has not been compared with the map"),
            Self::Disagrees(share) => {
                write!(f, "only {:.0} % of the beams agree with the map", 100.0 * share)
            }
            Self::Ambiguous(clusters, share) => write!(
                f,
                "it may be at {clusters} places, at one of them with {:.0} %",
                100.0 * share
            ),
            Self::Wide(way, turn) => write!(
                f,
                "the place is known to {way:.2} m and {:.0} degrees only",
                turn.to_degrees()
            ),
            Self::Unconfirmed(way) => write!(f, "the robot must move by another {way:.1} m to be sure"),
        }
    }
}

/// What is known of the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// The estimate is sure.
    Sure,
    /// There may be an estimate, but it is not sure.
    Unsure(Doubt),
    /// The robot is searched, and there is no estimate. The number is the share that is done.
    Searching(f64),
}

/// A particle filter on one map.
#[derive(Clone, Debug)]
pub struct Localizer {
    field: Field,
    particles: Particles,
    likelihoods: Likelihoods,
    search: Search,
    is_searching: bool,
    /// The region that is searched with the next scan.
    requested: Option<Region>,
    random: fastrand::Rng,
    /// The pose of the odometry at which the particles are.
    reference: Option<Pose2D>,
    estimate: Option<Estimate>,
    /// Whether the particles are weighed with the next scan in any case.
    is_due: bool,
    /// The way that is left until the estimate is confirmed, m.
    unconfirmed: f64,
    /// The average share of beams that agree, and over how many scans.
    agreement: f64,
    scans: u32,
    is_sure: bool,
    /// Whether the estimate has been sure since it was doubted.
    was_sure: bool,
}

impl Localizer {
    /// Returns a localizer with room for `most` particles, which does not know where the robot is. It allocates all
    /// that it will need.
    #[must_use]
    pub fn new(field: Field, most: usize, seed: u64) -> Self {
        let cell = field.geometry().resolution();
        Self {
            particles: Particles::new(most, cell),
            likelihoods: Likelihoods::new(Sensor::default(), cell),
            search: Search::new(most, cell),
            is_searching: false,
            requested: None,
            random: fastrand::Rng::with_seed(seed),
            reference: None,
            estimate: None,
            is_due: false,
            unconfirmed: 0.0,
            agreement: 0.0,
            scans: 0,
            is_sure: false,
            was_sure: false,
            field,
        }
    }

    /// Returns the map.
    #[must_use]
    pub const fn field(&self) -> &Field {
        &self.field
    }

    /// The robot is here, with these standard deviations of x and y in metres and of the heading in radians.
    pub fn start_at(&mut self, pose: &Pose2D, deviation: f64, heading_deviation: f64) {
        self.forget();
        let [x, y, heading] = cells(self.field.geometry(), pose);
        let deviation = (deviation / self.field.geometry().resolution()) as f32;
        for _ in 0..self.particles.most() {
            let ([dx, dy], [turn, _]) = (normals(&mut self.random), normals(&mut self.random));
            self.particles.push([
                x + deviation * dx,
                y + deviation * dy,
                heading + heading_deviation as f32 * turn,
            ]);
        }
        self.particles.level();
        self.estimate = self.particles.estimate(self.field.geometry());
        self.is_due = true;
    }

    /// The robot is within `radius` m of this place, with any heading. Its pose is searched there with the next scan.
    pub fn start_around(&mut self, (x, y): (f64, f64), radius: f64) {
        self.forget();
        let geometry = self.field.geometry();
        let (column, row) = geometry.to_grid((x, y));
        let radius = radius / geometry.resolution();
        self.requested = Some(Region::Disc((column as f32, row as f32), radius as f32));
    }

    /// The robot is anywhere. It is searched on the whole map with the next scan.
    pub fn start_anywhere(&mut self) {
        self.forget();
        self.requested = Some(Region::Everywhere);
    }

    /// The odometry jumped from one pose to another without a motion of the robot.
    pub fn jump(&mut self, from: &Pose2D, to: &Pose2D) {
        let moved = |pose: &Pose2D| to.transform(&from.localize(pose));
        self.reference = self.reference.as_ref().map(moved);
        let searched = self.search.odometry();
        *searched = moved(searched);
        self.doubt();
    }

    /// The robot may have been moved meanwhile: its pose is not sure until a scan agrees.
    pub fn doubt(&mut self) {
        (self.agreement, self.scans) = (0.0, 0);
        (self.is_sure, self.was_sure) = (false, false);
        self.is_due = true;
    }

    /// Takes a scan, and the pose of the odometry at its time. Returns what is known of the pose.
    ///
    /// Takes time by the number of particles times that of beams, if the robot moved; and that of poses of a search.
    pub fn step(&mut self, settings: &Settings, odometry: &Pose2D, beams: &Beams) -> State {
        if !self.likelihoods.is_of(&settings.sensor) {
            self.likelihoods = Likelihoods::new(settings.sensor, self.field.geometry().resolution());
        }
        if let Some(region) = self.requested.take() {
            self.begin_search(settings, region, odometry, beams);
        }
        if self.is_searching
            && self
                .search
                .advance(&self.field, settings.search_step, &mut self.random)
        {
            self.end_search(settings, odometry);
        }
        self.filter(settings, odometry, beams);
        self.compare(settings, odometry, beams);
        let state = self.judge(&settings.limits);
        self.is_sure = state == State::Sure;
        self.was_sure |= self.is_sure;
        // The best poses of a search would make a sure estimate doubtful.
        self.is_searching &= !self.is_sure;
        let is_lost = self.scans >= SCANS && self.agreement < settings.limits.needed(self.was_sure);
        if is_lost && !self.is_searching {
            self.begin_search(settings, Region::Everywhere, odometry, beams);
        }
        state
    }

    /// Returns the estimate of the pose at this pose of the odometry, whether it is sure or not.
    #[must_use]
    pub fn pose(&self, odometry: &Pose2D) -> Option<Pose2D> {
        let reference = self.reference.as_ref().unwrap_or(odometry);
        let estimate = self.estimate.as_ref()?;
        Some(estimate.pose.transform(&reference.localize(odometry)))
    }

    /// Returns the estimate at the last update of the particles.
    #[must_use]
    pub const fn estimate(&self) -> Option<&Estimate> {
        self.estimate.as_ref()
    }

    /// Returns the average share of the beams that agree with the map at the estimate, from 0 to 1.
    #[must_use]
    pub const fn agreement(&self) -> f64 {
        self.agreement
    }

    /// Returns the number of particles.
    #[must_use]
    pub const fn particles(&self) -> usize {
        self.particles.len()
    }

    /// Returns the places of every so many particles that they are at most `most`, in the frame of the map, m.
    pub fn places(&self, most: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        let step = self.particles.len().div_ceil(most.max(1)).max(1);
        (0..self.particles.len()).step_by(step).map(|index| {
            let [x, y, _] = self.particles.pose(index);
            self.field.geometry().to_world((x.into(), y.into()))
        })
    }

    fn forget(&mut self) {
        self.particles.clear();
        self.estimate = None;
        self.reference = None;
        self.is_searching = false;
        self.requested = None;
        self.unconfirmed = 0.0;
        self.doubt();
    }

    fn begin_search(&mut self, settings: &Settings, region: Region, odometry: &Pose2D, beams: &Beams) {
        if self.field.free_cells() > 0 {
            self.search
                .begin(&self.field, region, beams, *odometry, settings.search);
            self.is_searching = true;
        }
    }

    /// Adds the best poses to the particles; beside those that there were, at most as many.
    fn end_search(&mut self, settings: &Settings, odometry: &Pose2D) {
        self.is_searching = false;
        self.particles.make_room();
        let reference = *self.reference.get_or_insert(*odometry);
        let first = self.particles.len();
        let room = self.particles.most() - first;
        let particles = &mut self.particles;
        self.search
            .best(room, &mut self.random, |pose| particles.push(pose));
        if self.particles.len() == 0 {
            // No free cell is where it was said to be.
            self.requested = Some(Region::Everywhere);
            return;
        }
        let since = self.search.odometry().localize(&reference);
        let motion = settings.motion.motion(&since, self.field.geometry().resolution());
        self.particles.predict(first, &motion, &mut self.random);
        self.particles.level();
        self.unconfirmed = settings.limits.confirm;
        self.doubt();
    }

    /// Moves and weighs the particles if the robot has moved or it is due.
    fn filter(&mut self, settings: &Settings, odometry: &Pose2D, beams: &Beams) {
        if self.particles.len() == 0 {
            return;
        }
        let reference = *self.reference.get_or_insert(*odometry);
        let delta = reference.localize(odometry);
        let way = libm::hypot(delta.x, delta.y);
        if way < settings.update_way && delta.theta.abs() < settings.update_turn && !self.is_due {
            return;
        }
        let geometry = *self.field.geometry();
        let motion = settings.motion.motion(&delta, geometry.resolution());
        self.particles.predict(0, &motion, &mut self.random);
        self.reference = Some(*odometry);
        self.particles.weigh(&self.field, &self.likelihoods, beams);
        self.estimate = self.particles.estimate(&geometry);
        self.unconfirmed = (self.unconfirmed - way).max(0.0);
        if self.particles.effective() < 0.5 * self.particles.len() as f64 {
            let kld = (settings.error, settings.quantile);
            self.particles.resample(settings.least, kld, &mut self.random);
        }
        self.is_due = false;
    }

    /// Compares the scan with the map at the estimate.
    fn compare(&mut self, settings: &Settings, odometry: &Pose2D, beams: &Beams) {
        let Some(pose) = self.pose(odometry) else { return };
        let geometry = self.field.geometry();
        let cell = geometry.resolution() as f32;
        let tolerance = settings.limits.tolerance as f32 / cell;
        let share = agreement(&self.field, beams, cells(geometry, &pose), (tolerance, cell));
        self.scans = self.scans.saturating_add(1);
        // At first the mean of all.
        let newest = NEWEST.max(1.0 / f64::from(self.scans));
        self.agreement += newest * (f64::from(share) - self.agreement);
    }

    fn judge(&self, limits: &Limits) -> State {
        let Some(estimate) = &self.estimate else {
            return if self.is_searching {
                State::Searching(self.search.done())
            } else {
                State::Unsure(Doubt::Nowhere)
            };
        };
        let lenient = if self.is_sure { LENIENT } else { 1.0 };
        let (deviation, turn) = (estimate.deviation(), estimate.heading_deviation());
        let doubt = if self.scans == 0 {
            Doubt::Unseen
        } else if self.agreement < limits.needed(self.is_sure) {
            Doubt::Disagrees(self.agreement)
        } else if 1.0 - estimate.share > lenient * (1.0 - limits.share) {
            Doubt::Ambiguous(estimate.clusters, estimate.share)
        } else if deviation > lenient * limits.deviation || turn > lenient * limits.heading_deviation {
            Doubt::Wide(deviation, turn)
        } else if self.unconfirmed > 0.0 {
            Doubt::Unconfirmed(self.unconfirmed)
        } else {
            return State::Sure;
        };
        State::Unsure(doubt)
    }
}
