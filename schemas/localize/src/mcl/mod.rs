//! The schema of adaptive Monte Carlo localization. The filter is `jde-mcl`; here are its map, its times, and what
//! happens when a scan or the odometry is missing or wrong.

mod ports;

use jde_grid::{Geometry, GeometryError, OccupancyGrid as Grid};
use jde_mcl::{
    Beams, Doubt, LikelihoodField, Limits, Localizer, Model, MotionNoise, Sensor, Settings, State,
};
use jde_motion::{OdometryHistory, is_jump, jumped};
use jde_schema::prelude::*;
use jde_schema::types::{Body, Start};

use crate::ports::{LocalizedPose, PoseLimits};
use ports::{Agreement, InitialPose, OdometryNoise, Particles, Search, SensorModel, SensorNoise, Updates};

/// Exports where the robot is on a map, by particles: adaptive Monte Carlo localization.
///
/// The pose is exported while it is sure, and retracted otherwise; `state` says why. It continues with the odometry
/// between two scans. A robot that is lost is searched on the whole map. Samples are drawn from the application's seed.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "40ms")]
pub struct Mcl {
    /// The map.
    #[import]
    map: Import<OccupancyGrid>,
    /// The scan of the laser.
    #[import]
    pub(crate) laser: Import<LaserScan>,
    /// The pose and velocity by the odometry.
    #[import]
    odometry: Import<Odometry>,
    /// The body of the robot. If it is bound, it states where the laser is, and `mount` does not count.
    #[import(optional)]
    body: Import<Body>,
    #[ports]
    initial: InitialPose,
    /// The pose of the laser on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed, mount)]
    pub(crate) mount: Modulation<Pose2D>,
    #[ports]
    particles: Particles,
    #[ports]
    noise: OdometryNoise,
    #[ports]
    sensor: SensorNoise,
    #[ports]
    updates: Updates,
    #[ports]
    search: Search,
    #[ports]
    fit: Agreement,
    #[ports]
    limits: PoseLimits,
    /// Time for which the pose is exported without a usable scan.
    #[modulation(default = 1.0, unit = "s", min = 0.0, max = 3600.0)]
    patience: Modulation<f64>,
    #[ports]
    place: LocalizedPose,
    /// The average share of the beams that agree with the map.
    #[export]
    agreeing: Export<f64>,
    pub(crate) localizer: Option<Localizer>,
    /// The numbers of the map, of the initial pose and of the last scan.
    map_number: u64,
    initial_number: Option<u64>,
    scan_number: u64,
    pub(crate) scan_beams: Beams,
    history: OdometryHistory,
    /// The last pose of the odometry.
    pub(crate) last: Option<Pose2D>,
    /// When the last usable scan was; none after it was missing for too long.
    seen: Option<Duration>,
    /// What is wrong with the last scan, after a colon.
    blind: String,
    pub(crate) known: Option<State>,
    /// The words of the last iteration.
    pub(crate) words: String,
    /// Where the robot was before a reload or on the last map; no pose if that was not known.
    pub(crate) restored: Option<Start>,
}

impl Schema for Mcl {
    fn awake(&mut self, cx: &Context) -> Result {
        let most = self.sensor.max_beams.get(cx) as usize;
        self.scan_beams = Beams::new(most);
        // What happened while it slept is not known; how far the odometry went meanwhile is no jump.
        (self.seen, self.known, self.last) = (None, None, None);
        if let Some(localizer) = &mut self.localizer {
            localizer.doubt();
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.place.pose.retract(cx);
        self.place.correction.retract(cx);
        self.place.state.retract(cx);
        self.agreeing.retract(cx);
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let words = match self.localize(cx) {
            Ok(words) => words,
            Err(words) => {
                self.place.pose.retract(cx);
                self.place.correction.retract(cx);
                words
            }
        };
        self.place.state.write(cx, Text::truncated(&words));
        self.words = words;
        Ok(())
    }
}

impl Mcl {
    /// Exports the pose.
    ///
    /// # Errors
    /// Why there is none.
    fn localize(&mut self, cx: &Context) -> Result<String, String> {
        let odometry = self.odometry.get(cx).ok_or("there is no odometry")?;
        let measured = odometry.pose2d();
        if let Some(last) = self.last.replace(measured)
            && is_jump(&last, &measured, self.limits.jump.get(cx))
        {
            warn!(cx, "{}", jumped(&last, &measured));
            if let Some(localizer) = &mut self.localizer {
                localizer.jump(&last, &measured);
            }
            self.known = None;
        }
        self.follow_map(cx, &measured)?;
        self.follow_initial(cx);
        self.look(cx, &odometry);
        let Some(localizer) = &self.localizer else {
            return Err("there is no map".into());
        };
        if self.seen.is_none() {
            return Err(format!("no scan that can be used{}", self.blind));
        }
        self.agreeing.write(cx, localizer.agreement());
        match self.known {
            Some(State::Sure) => {}
            Some(State::Unsure(doubt)) => return Err(format!("not sure: {doubt}")),
            Some(State::Searching(share)) => {
                return Err(format!("searched on the map: {:.0} % done", 100.0 * share));
            }
            None => return Err(format!("not sure: {}", Doubt::Unseen)),
        }
        let (Some(pose), Some(estimate)) = (localizer.pose(&measured), localizer.estimate()) else {
            return Err(format!("not sure: {}", Doubt::Nowhere));
        };
        let frame = self.map.get(cx).ok_or("there is no map")?.header.frame_id;
        let header = Header {
            stamp: odometry.header.stamp,
            frame_id: frame,
        };
        let exported = Odometry {
            header,
            pose: PoseWithCovariance::planar(pose, &estimate.covariance),
            ..*odometry
        };
        self.place.pose.write_at(cx, exported, odometry.time());
        let correction = pose.transform(&measured.localize(&Pose2D::ORIGIN));
        let correction = PoseStamped {
            header,
            pose: correction.into(),
        };
        self.place.correction.write_at(cx, correction, odometry.time());
        Ok(format!(
            "sure to {:.2} m and {:.1} degrees: {:.0} % of the beams agree with the map",
            estimate.deviation(),
            estimate.heading_deviation().to_degrees(),
            100.0 * localizer.agreement()
        ))
    }

    /// Returns what another localizer may know of the place: only what was sure, or said by a person.
    pub(crate) fn kept(&self, odometry: Option<Pose2D>) -> Option<Start> {
        let Some(localizer) = &self.localizer else {
            return self.restored;
        };
        let place = odometry.filter(|_| localizer.is_settled());
        let place = place.and_then(|odometry| localizer.pose(&odometry));
        Some(place.map_or(Start::NONE, Start::at))
    }

    /// Takes over a map that is new. On it, the robot is where it was on the last one, if that was known.
    fn follow_map(&mut self, cx: &Context, odometry: &Pose2D) -> Result<(), String> {
        let map = self.map.get(cx).ok_or("there is no map")?;
        if core::mem::replace(&mut self.map_number, map.sequence()) == map.sequence() {
            return if self.localizer.is_some() {
                Ok(())
            } else {
                Err("the map cannot be used".into())
            };
        }
        self.restored = self.kept(Some(*odometry));
        self.localizer = None;
        let field = field(&map).map_err(|error| error.to_string())?;
        if field.free_cells() == 0 {
            return Err("no cell of the map is free".into());
        }
        self.localizer = Some(Localizer::new(
            field,
            self.particles.max_particles.get(cx) as usize,
            cx.seed(),
        ));
        self.initial_number = None;
        self.known = None;
        Ok(())
    }

    /// Starts anew where a file or an operator says, if they say so now.
    fn follow_initial(&mut self, cx: &Context) {
        let Some(localizer) = &mut self.localizer else {
            return;
        };
        let initial = self.initial.initial_pose.sample(cx);
        let number = initial.sequence();
        let is_first = self.initial_number.is_none();
        if self.initial_number.replace(number) == Some(number) {
            return;
        }
        let restored = self.restored.take().filter(|_| is_first);
        let start = restored.map_or_else(|| initial.get(), |restored| restored.get());
        match start {
            Some(pose) => {
                let heading = self.initial.initial_heading_deviation.get(cx);
                localizer.start_at(&pose, self.initial.initial_deviation.get(cx), heading);
            }
            None => localizer.start_anywhere(),
        }
        self.known = None;
    }

    /// Returns where the laser of a scan is on the base.
    pub(crate) fn mounted(&self, cx: &Context, laser: &LaserScan) -> Pose2D {
        let body = self.body.get(cx);
        body.map_or_else(
            || self.mount.get(cx),
            |body| body.laser(laser.header.frame_id.as_str()),
        )
    }

    /// Takes a scan that is new, and notices when there has been none for too long.
    fn look(&mut self, cx: &Context, odometry: &Sample<'_, Odometry>) {
        let settings = self.settings(cx);
        self.history.add(odometry.time(), odometry);
        let laser = self.laser.get(cx);
        let mount = (laser.as_ref()).map_or(Pose2D::ORIGIN, |laser| self.mounted(cx, laser));
        let Some(localizer) = &mut self.localizer else {
            return;
        };
        let laser = laser
            .filter(|laser| core::mem::replace(&mut self.scan_number, laser.sequence()) != laser.sequence());
        let then = laser.map(|laser| {
            let sweep = self.history.sweep(&laser, laser.time(), cx.now())?;
            let then = sweep.first();
            (self.scan_beams.update(&laser, sweep.seen_from(&then, &mount)))
                .map_err(|blind| blind.to_string())?;
            Ok::<_, String>(then)
        });
        if let Some(then) = &then {
            self.blind = (then.as_ref()).map_or_else(|words| format!(": {words}"), |_| String::new());
        }
        if let Some(Ok(then)) = then {
            self.known = Some(localizer.step(&settings, &then, &self.scan_beams));
            self.seen = Some(cx.now());
        }
        // A search goes on without a new scan.
        if self.known.is_some()
            && let Some(state) = localizer.search(&settings)
        {
            self.known = Some(state);
        }
        let patience = Duration::from_secs_f64(self.patience.get(cx));
        if self
            .seen
            .is_some_and(|seen| cx.now().saturating_sub(seen) > patience)
        {
            // Meanwhile the robot may be elsewhere.
            localizer.doubt();
            (self.seen, self.known) = (None, None);
        }
    }

    fn settings(&self, cx: &Context) -> Settings {
        Settings {
            least: self.particles.min_particles.get(cx) as usize,
            error: self.particles.kld_err.get(cx),
            quantile: self.particles.kld_z.get(cx),
            motion: MotionNoise {
                turn_by_turn: self.noise.rotation_noise_from_rotation.get(cx),
                turn_by_way: self.noise.rotation_noise_from_translation.get(cx),
                way_by_way: self.noise.translation_noise_from_translation.get(cx),
                way_by_turn: self.noise.translation_noise_from_rotation.get(cx),
            },
            sensor: Sensor {
                model: match self.sensor.laser_model_type.get(cx) {
                    SensorModel::LikelihoodField => Model::LikelihoodField,
                    SensorModel::Beam => Model::Beam,
                },
                deviation: self.sensor.sigma_hit.get(cx),
                outliers: self.sensor.z_rand.get(cx),
                independent: self.sensor.independent.get(cx),
            },
            update_way: self.updates.update_min_d.get(cx),
            update_turn: self.updates.update_min_a.get(cx),
            search: self.search.search.get(cx) as usize,
            search_step: self.search.search_step.get(cx) as usize,
            limits: Limits {
                sure_agreement: self.fit.sure_agreement.get(cx),
                agreement: self.fit.agreement.get(cx),
                changed_agreement: self.fit.changed_agreement.get(cx),
                tolerance: self.fit.tolerance.get(cx),
                share: self.fit.share.get(cx),
                deviation: self.limits.sure_deviation.get(cx),
                heading_deviation: self.limits.sure_heading_deviation.get(cx),
                confirm: self.search.confirm.get(cx),
            },
        }
    }
}

/// Prepares the map of a message.
fn field(map: &OccupancyGrid) -> Result<LikelihoodField, GeometryError> {
    let (info, origin) = (&map.info, Pose2D::from(map.info.origin));
    let origin = (origin.x, origin.y, origin.theta);
    let geometry = Geometry::new(info.width, info.height, info.resolution.into(), origin)?;
    Ok(LikelihoodField::new(&Grid::from_ros(geometry, &map.data)?))
}
