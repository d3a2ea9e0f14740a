//! The schema of adaptive Monte Carlo localization. The filter is `jde-mcl`; here are its map, its times, and what
//! happens when a scan or the odometry is missing or wrong.

use jde_grid::{Geometry, GeometryError, OccupancyGrid as Grid};
use jde_mcl::{Beams, Doubt, Field, Limits, Localizer, Model, MotionNoise, Sensor, Settings, State};
use jde_motion::{arc, is_jump, jumped};
use jde_schema::prelude::*;
use jde_schema::types::{Body, Start};

/// The most time between a scan and the odometry that the velocity bridges, s.
const BRIDGED: f64 = 0.5;

/// How likely a scan is at a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
enum SensorModel {
    /// By the distance from the end of each beam to the nearest obstacle.
    LikelihoodField,
    /// By the difference of the length of each beam from that of a ray through the map. Some thirty times slower.
    Beam,
}

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
    /// Where the robot is when the schema awakes first and whenever this is written, in the frame of the map:
    /// `[[3.55, 1.6, "90 deg"]]`. Without a pose it is searched.
    #[modulation(default = Start::NONE)]
    initial: Modulation<Start>,
    /// Standard deviation of x and y of that pose.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 10.0)]
    initial_deviation: Modulation<f64>,
    /// Standard deviation of the heading of that pose.
    #[modulation(default = 15_f64.to_radians(), unit = "rad", min = 0.0, max = 3.15)]
    initial_heading_deviation: Modulation<f64>,
    /// Where the laser is on the base, and which way its x points.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    pub(crate) mount: Modulation<Pose2D>,
    /// The most particles.
    #[modulation(default = 2000, min = 10, max = 100_000, fixed)]
    particles: Modulation<u32>,
    /// The fewest particles.
    #[modulation(default = 500, min = 2, max = 100_000)]
    least: Modulation<u32>,
    /// The error of KLD-sampling: a smaller one needs more particles.
    #[modulation(default = 0.05, min = 0.001, max = 1.0)]
    error: Modulation<f64>,
    /// The quantile of the standard normal distribution for the probability of that error: 2.326 for 99 %.
    #[modulation(default = 2.326, min = 0.0, max = 5.0)]
    quantile: Modulation<f64>,
    /// Standard deviation of the heading of the odometry for each radian of a turn.
    #[modulation(default = 0.1, unit = "rad/rad", min = 0.0, max = 10.0)]
    turn_by_turn: Modulation<f64>,
    /// Standard deviation of the heading of the odometry for each metre of way.
    #[modulation(default = 0.05, unit = "rad/m", min = 0.0, max = 10.0)]
    turn_by_way: Modulation<f64>,
    /// Standard deviation of the way of the odometry for each metre.
    #[modulation(default = 0.1, unit = "m/m", min = 0.0, max = 10.0)]
    way_by_way: Modulation<f64>,
    /// Standard deviation of the way of the odometry for each radian of a turn.
    #[modulation(default = 0.02, unit = "m/rad", min = 0.0, max = 10.0)]
    way_by_turn: Modulation<f64>,
    /// How likely a scan is at a pose: `likelihood-field` or `beam`.
    #[modulation(default = SensorModel::LikelihoodField)]
    model: Modulation<SensorModel>,
    /// How many beams of a scan count.
    #[modulation(default = 60, min = 8, max = 1088, fixed)]
    beams: Modulation<u32>,
    /// Standard deviation of the ends of beams from the obstacles of the map: that of the laser and of the map.
    #[modulation(default = 0.1, unit = "m", min = 0.01, max = 2.0)]
    deviation: Modulation<f64>,
    /// Likelihood of a beam that hits what the map does not have, where one that fits exactly has about 1.
    #[modulation(default = 0.1, min = 0.0001, max = 0.9)]
    outliers: Modulation<f64>,
    /// For how many independent measurements a scan counts, since neighbouring beams err alike.
    #[modulation(default = 20.0, min = 1.0, max = 1088.0)]
    independent: Modulation<f64>,
    /// Way after which the particles are weighed.
    #[modulation(default = 0.1, unit = "m", min = 0.0, max = 10.0)]
    update_way: Modulation<f64>,
    /// Turn after which the particles are weighed.
    #[modulation(default = 0.1, unit = "rad", min = 0.0, max = 3.15)]
    update_turn: Modulation<f64>,
    /// The most poses at which a lost robot is searched.
    #[modulation(default = 2_000_000, min = 1000, max = 100_000_000)]
    search: Modulation<u32>,
    /// At how many of them it is searched with each scan.
    #[modulation(default = 40_000, min = 1000, max = 10_000_000)]
    search_step: Modulation<u32>,
    /// Least share of the beams that agree with the map, as an average over scans, when the pose becomes sure.
    #[modulation(default = 0.7, min = 0.0, max = 1.0)]
    sure_agreement: Modulation<f64>,
    /// The same while the pose is sure. Below it a robot whose pose was sure is lost, and one whose pose was not sure yet
    /// below `sure_agreement`.
    #[modulation(default = 0.5, min = 0.0, max = 1.0)]
    agreement: Modulation<f64>,
    /// How far the end of a beam that agrees may be from an obstacle of the map.
    #[modulation(default = 0.25, unit = "m", min = 0.0, max = 1.0)]
    tolerance: Modulation<f64>,
    /// Least share of the particles' weights that is at one place when the pose is sure.
    #[modulation(default = 0.95, min = 0.5, max = 1.0)]
    share: Modulation<f64>,
    /// Greatest standard deviation of a position that is sure.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 10.0)]
    sure_deviation: Modulation<f64>,
    /// Greatest standard deviation of a heading that is sure.
    #[modulation(default = 0.2, unit = "rad", min = 0.0, max = 3.15)]
    sure_heading_deviation: Modulation<f64>,
    /// Way that a robot must go after a search until its pose is sure.
    #[modulation(default = 1.0, unit = "m", min = 0.0, max = 100.0)]
    confirm: Modulation<f64>,
    /// How long the pose is exported without a usable scan.
    #[modulation(default = 1.0, unit = "s", min = 0.0, max = 3600.0)]
    patience: Modulation<f64>,
    /// A step of the odometry from which on it is a jump, and no motion. So is a turn by more than 90 degrees.
    #[modulation(default = 1.0, unit = "m", min = 0.3)]
    jump: Modulation<f64>,
    /// The pose in the frame of the map with its covariance, and the velocity of the odometry.
    #[export]
    pose: Export<Odometry>,
    /// The pose of the odometry's frame in that of the map (REP-105), while the pose is sure.
    #[export]
    correction: Export<PoseStamped>,
    /// How sure the pose is, in words.
    #[export]
    state: Export<Text<160>>,
    /// The average share of the beams that agree with the map.
    #[export]
    agreeing: Export<f64>,
    pub(crate) localizer: Option<Localizer>,
    /// The numbers of the map, of the initial pose and of the last scan.
    map_number: u64,
    initial_number: Option<u64>,
    scan_number: u64,
    pub(crate) scan_beams: Beams,
    /// The last pose of the odometry.
    pub(crate) last: Option<Pose2D>,
    /// When the last usable scan was; none after it was missing for too long.
    seen: Option<Duration>,
    /// What is wrong with the last scan, after a colon.
    blind: String,
    pub(crate) known: Option<State>,
    /// The words of the last iteration.
    pub(crate) words: String,
    /// Where the robot was before a reload.
    pub(crate) restored: Option<Pose2D>,
}

impl Schema for Mcl {
    fn awake(&mut self, cx: &Context) -> Result {
        let most = self.beams.get(cx) as usize;
        self.scan_beams = Beams::new(most);
        // What happened while it slept is not known; how far the odometry went meanwhile is no jump.
        (self.seen, self.known, self.last) = (None, None, None);
        if let Some(localizer) = &mut self.localizer {
            localizer.doubt();
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.pose.retract(cx);
        self.correction.retract(cx);
        self.state.retract(cx);
        self.agreeing.retract(cx);
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let words = match self.localize(cx) {
            Ok(words) => words,
            Err(words) => {
                self.pose.retract(cx);
                self.correction.retract(cx);
                words
            }
        };
        self.state.write(cx, Text::truncated(&words));
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
            && is_jump(&last, &measured, self.jump.get(cx))
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
        self.pose.write_at(cx, exported, odometry.time());
        let correction = pose.transform(&measured.localize(&Pose2D::ORIGIN));
        let correction = PoseStamped {
            header,
            pose: correction.into(),
        };
        self.correction.write_at(cx, correction, odometry.time());
        Ok(format!(
            "sure to {:.2} m and {:.1} degrees: {:.0} % of the beams agree with the map",
            estimate.deviation(),
            estimate.heading_deviation().to_degrees(),
            100.0 * localizer.agreement()
        ))
    }

    /// Takes over a map that is new. On it, the robot is where it was on the last one.
    fn follow_map(&mut self, cx: &Context, odometry: &Pose2D) -> Result<(), String> {
        let map = self.map.get(cx).ok_or("there is no map")?;
        if core::mem::replace(&mut self.map_number, map.sequence()) == map.sequence() {
            return if self.localizer.is_some() {
                Ok(())
            } else {
                Err("the map cannot be used".into())
            };
        }
        let last = self.localizer.take();
        let place = last.and_then(|localizer| localizer.pose(odometry));
        self.restored = place.or(self.restored);
        let field = field(&map).map_err(|error| error.to_string())?;
        if field.free_cells() == 0 {
            return Err("no cell of the map is free".into());
        }
        self.localizer = Some(Localizer::new(field, self.particles.get(cx) as usize, cx.seed()));
        self.initial_number = None;
        self.known = None;
        Ok(())
    }

    /// Starts anew where a file or an operator says, if they say so now.
    fn follow_initial(&mut self, cx: &Context) {
        let Some(localizer) = &mut self.localizer else {
            return;
        };
        let initial = self.initial.sample(cx);
        let number = initial.sequence();
        let is_first = self.initial_number.is_none();
        if self.initial_number.replace(number) == Some(number) {
            return;
        }
        let restored = self.restored.take().filter(|_| is_first);
        match restored.or(initial.get()) {
            Some(pose) => {
                let heading = self.initial_heading_deviation.get(cx);
                localizer.start_at(&pose, self.initial_deviation.get(cx), heading);
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
        let (settings, measured) = (self.settings(cx), odometry.pose2d());
        let laser = self.laser.get(cx);
        let mount = (laser.as_ref()).map_or(Pose2D::ORIGIN, |laser| self.mounted(cx, laser));
        let Some(localizer) = &mut self.localizer else {
            return;
        };
        let laser = laser
            .filter(|laser| core::mem::replace(&mut self.scan_number, laser.sequence()) != laser.sequence());
        let laser = laser.filter(|laser| {
            self.blind = match self.scan_beams.update(laser, &mount) {
                Ok(()) => String::new(),
                Err(blind) => format!(": {blind}"),
            };
            self.blind.is_empty()
        });
        if let Some(laser) = laser {
            // Where the base was at the time of the scan.
            let since = laser.time().as_secs_f64() - odometry.time().as_secs_f64();
            let motion = arc(&odometry.twist.twist, since.clamp(-BRIDGED, BRIDGED));
            let then = measured.transform(&motion);
            self.known = Some(localizer.step(&settings, &then, &self.scan_beams));
            self.seen = Some(cx.now());
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
            least: self.least.get(cx) as usize,
            error: self.error.get(cx),
            quantile: self.quantile.get(cx),
            motion: MotionNoise {
                turn_by_turn: self.turn_by_turn.get(cx),
                turn_by_way: self.turn_by_way.get(cx),
                way_by_way: self.way_by_way.get(cx),
                way_by_turn: self.way_by_turn.get(cx),
            },
            sensor: Sensor {
                model: match self.model.get(cx) {
                    SensorModel::LikelihoodField => Model::LikelihoodField,
                    SensorModel::Beam => Model::Beam,
                },
                deviation: self.deviation.get(cx),
                outliers: self.outliers.get(cx),
                independent: self.independent.get(cx),
            },
            update_way: self.update_way.get(cx),
            update_turn: self.update_turn.get(cx),
            search: self.search.get(cx) as usize,
            search_step: self.search_step.get(cx) as usize,
            limits: Limits {
                sure_agreement: self.sure_agreement.get(cx),
                agreement: self.agreement.get(cx),
                tolerance: self.tolerance.get(cx),
                share: self.share.get(cx),
                deviation: self.sure_deviation.get(cx),
                heading_deviation: self.sure_heading_deviation.get(cx),
                confirm: self.confirm.get(cx),
            },
        }
    }
}

/// Prepares the map of a message.
fn field(map: &OccupancyGrid) -> Result<Field, GeometryError> {
    let (info, origin) = (&map.info, Pose2D::from(map.info.origin));
    let origin = (origin.x, origin.y, origin.theta);
    let geometry = Geometry::new(info.width, info.height, info.resolution.into(), origin)?;
    Ok(Field::new(&Grid::from_ros(geometry, &map.data)?))
}
