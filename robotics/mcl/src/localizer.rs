//! When particles move, are weighed and are drawn anew, and whether their estimate is sure.

use jde_types::{Pose2D, normalize_angle};

use crate::beams::Beams;
use crate::field::LikelihoodField;
use crate::fit::Comparison;
use crate::particles::{Estimate, Particles, cells};
use crate::places::{NOISE, Places};
use crate::random::normals;
use crate::search::{PoseSearch, Region};
use crate::sensor::{Likelihoods, Sensor};
use crate::settings::{Limits, Settings};
use crate::state::{Doubt, State};

/// The share of the newest scan in the average agreement.
const NEWEST: f64 = 0.2;
/// How many scans an average needs before a robot counts as lost.
const SCANS: u32 = 10;
/// What is sure stays sure until it is so many times worse.
const DEVIATION_HYSTERESIS: f64 = 2.0;
/// By how much more a scan may speak for another place than for that of a sure estimate, since it is the best of many.
const LUCK: f32 = 0.15;
/// A search vouches for an estimate until the agreement falls by this, as it does when the robot is carried away.
const FALL: f64 = 0.15;
/// It is searched again after a third of that.
const SINKS: f64 = 0.05;
/// The robot was turned if the scan fits better by more than this, rad, away from the estimate.
const PUSHED_TURN: f64 = 0.1;
/// The deviations of the only place that a search found, m and rad: it was fitted to the scan.
const FOUND_DEVIATION: f64 = 0.1;
const FOUND_HEADING_DEVIATION: f64 = 0.05;

/// A particle filter on one map.
#[derive(Clone, Debug)]
pub struct Localizer {
    field: LikelihoodField,
    particles: Particles,
    likelihoods: Likelihoods,
    search: PoseSearch,
    is_searching: bool,
    /// The estimate at the scan of the search, in cells, and the agreement.
    searched_from: Option<([f32; 3], f64)>,
    /// What a search found, until the estimate is sure.
    places: Places,
    /// Whether the particles come from a search, and the estimate has not been sure since.
    is_found: bool,
    /// The agreement when a search found no better place than that of the estimate.
    vouched: Option<f64>,
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
    /// The agreement of the estimate that was sure before a doubt.
    before: Option<f64>,
}

impl Localizer {
    /// Returns a localizer with room for `most` particles, which does not know where the robot is. It allocates all
    /// that it will need.
    #[must_use]
    pub fn new(field: LikelihoodField, most: usize, seed: u64) -> Self {
        let cell = field.geometry().resolution();
        Self {
            particles: Particles::new(most, cell),
            likelihoods: Likelihoods::new(Sensor::default(), cell),
            search: PoseSearch::new(cell),
            is_searching: false,
            searched_from: None,
            places: Places::new(cell),
            is_found: false,
            vouched: None,
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
            before: None,
            field,
        }
    }

    /// Returns the map.
    #[must_use]
    pub const fn field(&self) -> &LikelihoodField {
        &self.field
    }

    /// The robot is here, with these standard deviations of x and y in metres and of the heading in radians.
    pub fn start_at(&mut self, pose: &Pose2D, deviation: f64, heading_deviation: f64) {
        self.forget();
        self.spread(cells(self.field.geometry(), pose), deviation, heading_deviation);
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

    /// The robot may have been moved meanwhile: its pose is not sure until a scan agrees, and a search begins anew.
    pub fn doubt(&mut self) {
        if self.is_sure {
            self.before = Some(self.agreement);
        }
        if core::mem::take(&mut self.is_searching) && self.particles.len() == 0 {
            self.requested = Some(self.search.region());
        }
        self.searched_from = None;
        (self.agreement, self.scans) = (0.0, 0);
        (self.is_sure, self.was_sure) = (false, false);
        self.vouched = None;
        self.is_due = true;
    }

    /// Takes a scan, and the pose of the odometry at its time. Returns what is known of the pose.
    ///
    /// Takes time by the number of particles times that of beams, if the robot moved; after a search, also by that of the
    /// places that it found.
    pub fn step(&mut self, settings: &Settings, odometry: &Pose2D, beams: &Beams) -> State {
        if !self.likelihoods.is_of(&settings.sensor) {
            self.likelihoods = Likelihoods::new(settings.sensor, self.field.geometry().resolution());
        }
        if let Some(region) = self.requested.take() {
            self.begin_search(settings, region, odometry, beams);
        }
        self.filter(settings, odometry, beams);
        self.compare(settings, odometry, beams);
        let state = self.conclude(settings);
        if self.needs_search(&settings.limits) && !self.is_searching {
            self.begin_search(settings, Region::Everywhere, odometry, beams);
        }
        state
    }

    /// Goes on with a search, if there is one, and returns what is known of the pose then. It needs no new scan.
    ///
    /// Takes time by the number of poses of a call; the last call fits the scan at some tens of places.
    pub fn search(&mut self, settings: &Settings) -> Option<State> {
        if !self.is_searching {
            return None;
        }
        if (self.search).advance(&self.field, settings.search_step, &mut self.random) {
            self.is_searching = false;
            self.end_search(settings);
        }
        Some(self.conclude(settings))
    }

    /// Returns the estimate of the pose at this pose of the odometry, whether it is sure or not.
    #[must_use]
    pub fn pose(&self, odometry: &Pose2D) -> Option<Pose2D> {
        let reference = self.reference.as_ref().unwrap_or(odometry);
        let estimate = self.estimate.as_ref()?;
        Some(estimate.pose.transform(&reference.localize(odometry)))
    }

    /// Whether the estimate was sure or said by a person, and no search has replaced it since.
    #[must_use]
    pub const fn is_settled(&self) -> bool {
        self.estimate.is_some() && !self.is_found
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

    /// Returns the places of an even selection of particles, at most `most`, in the frame of the map, m.
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
        self.places.clear();
        self.is_found = false;
        self.unconfirmed = 0.0;
        self.doubt();
        (self.requested, self.before) = (None, None);
    }

    /// Adds as many particles as there is room for around a pose in cells, with these deviations in m and rad.
    fn spread(&mut self, [x, y, heading]: [f32; 3], deviation: f64, heading_deviation: f64) {
        let deviation = (deviation / self.field.geometry().resolution()) as f32;
        for _ in self.particles.len()..self.particles.most() {
            let ([dx, dy], [turn, _]) = (normals(&mut self.random), normals(&mut self.random));
            self.particles.push([
                x + deviation * dx,
                y + deviation * dy,
                heading + heading_deviation as f32 * turn,
            ]);
        }
    }

    fn begin_search(&mut self, settings: &Settings, region: Region, odometry: &Pose2D, beams: &Beams) {
        if self.field.free_cells() > 0 {
            self.search
                .begin(&self.field, region, beams, *odometry, settings.search);
            let geometry = self.field.geometry();
            let estimate = self.pose(odometry).map(|pose| cells(geometry, &pose));
            self.searched_from = estimate.map(|pose| (pose, self.agreement));
            self.is_searching = true;
        }
    }

    /// Compares the best places with that of the estimate. If one is better, or the estimate is worth nothing without a
    /// search, it takes them over.
    fn end_search(&mut self, settings: &Settings) {
        self.search.sort();
        let tolerance = tolerance(settings, &self.field);
        let scan = Comparison {
            field: &self.field,
            likelihoods: &self.likelihoods,
            beams: self.search.scan(),
            tolerance,
        };
        let reach = self.search.spacing() / 2.0;
        let Some((pose, agreement)) = self.searched_from else {
            self.places.find(&self.search, &scan, reach);
            self.take_places(settings, None);
            return;
        };
        if self.agreement < agreement - FALL {
            // The scan is of another place, or of before: the next one is searched.
            return;
        }
        self.places.find(&self.search, &scan, reach);
        let (own, climbed) = (scan.fit(pose).support, scan.climb(pose, reach));
        let (near, near_by) = (self.places.best_of(pose).into_iter())
            .chain([(climbed, scan.fit(climbed).support)])
            .fold(
                (pose, own),
                |best, other| if other.1 > best.1 { other } else { best },
            );
        let lead = near_by - self.places.best_beside(near).unwrap_or(-1.0);
        // What is sure has its past for it, and what a person said has the person. What was found has nothing: the best
        // of all poses of a wrong map has some luck too.
        let is_best = if self.is_sure {
            lead > -LUCK
        } else {
            lead > -NOISE && !self.is_found
        };
        // A pose that the scan knows better is that of a robot that was pushed or turned.
        let is_apart = libm::hypotf(near[0] - pose[0], near[1] - pose[1]) > tolerance
            || normalize_angle((near[2] - pose[2]).into()).abs() > PUSHED_TURN;
        if is_best && is_apart && near_by > own + NOISE {
            self.take_places(settings, Some(near));
        } else if is_best {
            self.vouched = Some(agreement);
        } else {
            self.take_places(settings, None);
        }
    }

    /// Adds what a search found to the particles, beside those that there were: the surroundings of `near`, or those of
    /// the only place, or the best poses.
    fn take_places(&mut self, settings: &Settings, near: Option<[f32; 3]>) {
        self.particles.make_room();
        let reference = *self.reference.get_or_insert(*self.search.odometry());
        let first = self.particles.len();
        let room = self.particles.most() - first;
        let only = match self.places.as_slice() {
            &[place] if !self.places.is_cut() => Some(place.pose),
            _ => None,
        };
        if let Some(pose) = near.or(only) {
            self.spread(pose, FOUND_DEVIATION, FOUND_HEADING_DEVIATION);
        } else {
            let particles = &mut self.particles;
            self.search
                .best(room, &mut self.random, |pose| particles.push(pose));
        }
        if self.particles.len() == 0 {
            // No free cell is where it was said to be.
            self.requested = Some(Region::Everywhere);
            return;
        }
        let since = self.search.odometry().localize(&reference);
        let motion = settings.motion.motion(&since, self.field.geometry().resolution());
        self.particles.predict(first, &motion, &mut self.random);
        self.particles.level();
        self.places.shift(&since);
        self.doubt();
        if near.is_none() {
            (self.is_found, self.before) = (true, None);
            let is_unique = only.is_some() && self.search.is_of_all();
            self.unconfirmed = if is_unique { 0.0 } else { settings.limits.confirm };
        }
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
        if self.is_found {
            let scan = Comparison {
                field: &self.field,
                likelihoods: &self.likelihoods,
                beams,
                tolerance: tolerance(settings, &self.field),
            };
            self.places.follow(&delta, &scan);
        }
        if self.particles.effective() < 0.5 * self.particles.len() as f64 {
            let kld = (settings.error, settings.quantile);
            self.particles.resample(settings.least, kld, &mut self.random);
        }
        self.is_due = false;
    }

    /// Compares the scan with the map at the estimate.
    fn compare(&mut self, settings: &Settings, odometry: &Pose2D, beams: &Beams) {
        let Some(pose) = self.pose(odometry) else { return };
        let scan = Comparison {
            field: &self.field,
            likelihoods: &self.likelihoods,
            beams,
            tolerance: tolerance(settings, &self.field),
        };
        let share = scan.fit(cells(self.field.geometry(), &pose)).agreeing;
        self.scans = self.scans.saturating_add(1);
        // At first the mean of all.
        let newest = NEWEST.max(1.0 / f64::from(self.scans));
        self.agreement += newest * (f64::from(share) - self.agreement);
    }

    /// Judges, and remembers what follows from it.
    fn conclude(&mut self, settings: &Settings) -> State {
        let state = self.judge(&settings.limits);
        self.is_sure = state == State::Sure;
        self.was_sure |= self.is_sure;
        self.is_found &= !self.is_sure;
        // Its scan was of another moment, if it began because few beams agreed.
        let sure_agreement = settings.limits.sure_agreement();
        let was_low = self
            .searched_from
            .is_some_and(|(_, agreement)| agreement < sure_agreement);
        self.is_searching &= !((self.is_sure || was_low) && self.agreement >= sure_agreement);
        state
    }

    /// The share of the beams that must agree.
    fn needed(&self, limits: &Limits) -> f64 {
        let needed = if self.is_sure {
            limits.agreement
        } else {
            limits.sure_agreement()
        };
        let changed = limits.changed_agreement;
        // What was never sure must agree with the map, whatever a search says. What was doubted must agree as it did.
        let least = if self.was_sure {
            self.vouched.map(|vouched| vouched - FALL)
        } else {
            self.before
                .filter(|_| self.vouched.is_some())
                .map(|before| before - SINKS)
        };
        least.map_or(needed, |least| needed.min(least.max(changed)))
    }

    /// Whether another place may explain the scans better.
    fn needs_search(&mut self, limits: &Limits) -> bool {
        if self.scans < SCANS {
            return false;
        }
        let is_low = self.agreement < limits.sure_agreement();
        if !is_low {
            self.vouched = None;
        }
        let may_rest = |vouched| self.agreement >= limits.agreement.max(vouched - SINKS);
        let is_open = self.places.is_cut() || self.rivals().is_none();
        let is_elsewhere = self.is_found && self.unconfirmed == 0.0 && is_open;
        is_elsewhere || is_low && !self.vouched.is_some_and(may_rest)
    }

    /// How many other places explain the scans about as well as the estimate; `None` if its place was not found.
    fn rivals(&self) -> Option<usize> {
        let pose = &self.estimate.as_ref()?.pose;
        self.places.rivals(cells(self.field.geometry(), pose))
    }

    fn judge(&self, limits: &Limits) -> State {
        let Some(estimate) = &self.estimate else {
            return if self.is_searching {
                State::Searching(self.search.done())
            } else if self.particles.len() > 0 {
                State::Unsure(Doubt::Unseen)
            } else {
                State::Unsure(Doubt::Nowhere)
            };
        };
        let lenient = if self.is_sure { DEVIATION_HYSTERESIS } else { 1.0 };
        let (deviation, turn) = (estimate.deviation(), estimate.heading_deviation());
        let rivals = || self.rivals().unwrap_or(self.places.as_slice().len());
        let doubt = if self.scans == 0 {
            Doubt::Unseen
        } else if self.agreement < self.needed(limits) {
            Doubt::Disagrees(self.agreement)
        } else if self.unconfirmed > 0.0 {
            Doubt::Unconfirmed(self.unconfirmed)
        } else if 1.0 - estimate.share > lenient * (1.0 - limits.share) {
            Doubt::Ambiguous(estimate.clusters, estimate.share)
        } else if deviation > lenient * limits.deviation || turn > lenient * limits.heading_deviation {
            Doubt::Wide(deviation, turn)
        } else if self.is_found && (rivals() > 0 || self.places.is_cut()) {
            Doubt::Rivalled(rivals())
        } else {
            return State::Sure;
        };
        State::Unsure(doubt)
    }
}

/// How far the end of a beam that agrees may be from an obstacle, in cells.
fn tolerance(settings: &Settings, field: &LikelihoodField) -> f32 {
    (settings.limits.tolerance / field.geometry().resolution()) as f32
}
