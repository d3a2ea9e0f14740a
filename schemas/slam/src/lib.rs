//! Makes a map while the robot drives, and says where the robot is on it. It drives nowhere.

mod file;
mod map;
mod memory;
mod panel;
mod ports;

use std::fs::File;
use std::sync::mpsc::TryRecvError;

use jde_motion::{OdometryHistory, is_jump, jumped};
use jde_schema::prelude::*;
use jde_schema::types::Body;
use jde_slam::{Anchor, Continuation, Scan, Settings, State};

use file::{Loading, Saving, begun, hold, load};
use map::Map;
use ports::{Drawing, Keyframes, LoopClosure, MapFile, OdometryNoise, ScanMatching, ScanReading};

/// How far from the base a laser may be mounted, m.
const MAX_MOUNT_DISTANCE: f64 = 10.0;
/// How many keyframes of a map that is continued are read in one iteration.
const KEYFRAMES_PER_ITERATION: usize = 8;

/// Exports a map from the scans of a laser, and the place of the robot on it: simultaneous localization and mapping.
///
/// The frame of the map is "map"; the robot is at `map_start_pose` in it when it takes its first scan. The pose
/// continues with the odometry between two scans, and is retracted while no scan fits; `state` gives the reason.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "40ms")]
pub struct Slam {
    /// The scan of the laser.
    #[import]
    pub(crate) laser: Import<LaserScan>,
    /// The pose and velocity by the odometry.
    #[import]
    odometry: Import<Odometry>,
    /// The body of the robot. If it is bound, it states where the laser is, and `mount` does not count.
    #[import(optional)]
    body: Import<Body>,
    /// Where the robot is in the frame of the map when it takes its first scan; on a map that is continued, to 0.3 m.
    #[modulation(default = Pose2D::ORIGIN, fixed, was = "initial")]
    map_start_pose: Modulation<Pose2D>,
    /// The pose of the laser on the base, within 10 m.
    #[modulation(default = Pose2D::ORIGIN, fixed, mount)]
    pub(crate) mount: Modulation<Pose2D>,
    #[ports]
    scans: ScanReading,
    #[ports]
    drawing: Drawing,
    #[ports]
    map_file: MapFile,
    #[ports]
    keyframes: Keyframes,
    #[ports]
    matching: ScanMatching,
    #[ports]
    noise: OdometryNoise,
    #[ports]
    loops: LoopClosure,
    /// Time for which the pose is exported without a scan that fits.
    #[modulation(default = 2.0, unit = "s", min = 0.0, max = 3600.0)]
    patience: Modulation<f64>,
    /// Least step of the odometry that is a jump and no motion. A turn by more than 90 degrees is a jump too.
    #[modulation(default = 1.0, unit = "m", min = 0.3)]
    jump: Modulation<f64>,
    /// The map.
    #[export(lasting)]
    map: Export<OccupancyGrid>,
    /// The pose in the frame of the map with its covariance, and the velocity of the odometry.
    #[export]
    pose: Export<Odometry>,
    /// The pose of the odometry's frame in that of the map (REP-105), while there is a pose.
    #[export]
    correction: Export<PoseStamped>,
    /// The present activity, or the reason why there is no pose, in words.
    #[export]
    state: Export<Text<160>>,
    pub(crate) slam: jde_slam::Slam,
    /// The file of the map that is continued after a reload, until it is read.
    loading: Option<Loading>,
    /// The map that is continued, until it is read.
    reading: Option<Continuation>,
    pub(crate) drawn: Map,
    saving: Saving,
    scan_number: u64,
    history: OdometryHistory,
    /// Why the time of the last scan says nothing.
    untimely: Option<String>,
    /// The last pose of the odometry.
    pub(crate) last: Option<Pose2D>,
    /// When the last scan that fits was.
    seen: Option<Duration>,
    /// Whether scans do not fit for longer than `patience`, which the log says.
    is_lost: bool,
    /// The words of the last iteration.
    pub(crate) words: String,
    /// Where the robot was before a reload or a sleep.
    restored: Option<Pose2D>,
}

impl Schema for Slam {
    fn awake(&mut self, cx: &Context) -> Result {
        check_mount(&self.mount.get(cx))?;
        if self.slam.scans().is_empty() && !self.is_loading() {
            self.begin(cx, self.restored.unwrap_or(self.map_start_pose.get(cx)))?;
        }
        self.restored = self.place();
        // What happened while it slept is not known; how far the odometry went meanwhile is no jump.
        (self.seen, self.last) = (None, None);
        self.slam.doubt();
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.pose.retract(cx);
        self.correction.retract(cx);
        self.state.retract(cx);
        self.follow_saving(cx);
        if self.is_worth_saving(cx) {
            // A new build that is to take its place waits for it.
            self.save_held(cx, hold(self.map_file.map_file_name.get(cx).as_str()));
        }
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.follow_loading()?;
        let words = match self.localize(cx) {
            Ok(words) => words,
            Err(words) => {
                self.pose.retract(cx);
                self.correction.retract(cx);
                words
            }
        };
        self.slam.advance(&self.settings(cx));
        self.state.write(cx, Text::truncated(&words));
        self.words = words;
        self.draw_map(cx)
    }
}

impl Inspect for Slam {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.mount, check_mount(&self.mount.get(cx)));
        problems.expect(
            &self.map_file.map_file_name,
            begun(
                self.map_file.map_file_name.get(cx).as_str(),
                &self.map_start_pose.get(cx),
                self.keyframes.keyframes.get(cx),
            ),
        );
    }
}

impl Slam {
    /// Begins with the map of the file, or a new one, on which the robot is at `start`.
    fn begin(&mut self, cx: &Context, start: Pose2D) -> Result {
        self.reading = begun(
            self.map_file.map_file_name.get(cx).as_str(),
            &start,
            self.keyframes.keyframes.get(cx),
        )?;
        self.slam = jde_slam::Slam::new(start);
        Ok(())
    }

    /// Begins after a reload, with what the previous build writes to the file as it sleeps.
    fn resume(&mut self, cx: &Context, place: Pose2D) -> Result {
        let file = self.map_file.map_file_name.get(cx);
        let begins = |file| load(file, place, self.keyframes.keyframes.get(cx));
        self.loading = (!file.is_empty()).then(|| begins(file.as_str())).transpose()?;
        (self.slam, self.reading) = (jde_slam::Slam::new(place), None);
        Ok(())
    }

    /// Whether the map that is continued is not read yet.
    const fn is_loading(&self) -> bool {
        self.loading.is_some() || self.reading.is_some()
    }

    /// Notes what has become of the file that was read after a reload.
    fn follow_loading(&mut self) -> Result {
        let Some(loading) = &self.loading else {
            return Ok(());
        };
        match loading.try_recv() {
            Err(TryRecvError::Empty) => return Ok(()),
            Err(TryRecvError::Disconnected) => return Err("the thread that read the map failed".into()),
            Ok(begun) => self.reading = begun?,
        }
        self.loading = None;
        Ok(())
    }

    /// Reads a part of the map that is continued.
    ///
    /// # Errors
    /// That it is not read yet.
    fn read(&mut self) -> Result<(), String> {
        if self.loading.is_some() {
            return Err("no pose: waits for the file of the map".into());
        }
        let Some(reading) = &mut self.reading else {
            return Ok(());
        };
        let Some(mut slam) = reading.advance(KEYFRAMES_PER_ITERATION) else {
            let (read, all) = (reading.read(), reading.keyframes());
            return Err(format!("no pose: reads the map, {read} of {all} keyframes"));
        };
        // The robot may have moved meanwhile.
        if let Some(odometry) = self.slam.odometry() {
            slam.start_at(&odometry);
        }
        (self.slam, self.reading) = (slam, None);
        Ok(())
    }

    /// Returns the odometry. If it has jumped, the robot has not.
    ///
    /// # Errors
    /// That it cannot be used.
    fn measure<'cx>(&mut self, cx: &'cx Context) -> Result<Sample<'cx, Odometry>, String> {
        let odometry = self.odometry.get(cx).ok_or("there is no odometry")?;
        let measured = odometry.pose2d();
        if let Some(last) = self.last.replace(measured)
            && is_jump(&last, &measured, self.jump.get(cx))
        {
            warn!(cx, "{}", jumped(&last, &measured));
            self.slam.jump(&last, &measured);
        }
        if self.is_loading() {
            self.slam.start_at(&measured);
        }
        Ok(odometry)
    }

    /// Exports the pose.
    ///
    /// # Errors
    /// Why there is none.
    fn localize(&mut self, cx: &Context) -> Result<String, String> {
        let (odometry, is_read) = (self.measure(cx), self.read());
        is_read?;
        let odometry = odometry?;
        let measured = odometry.pose2d();
        self.look(cx, &odometry);
        let patience = Duration::try_from_secs_f64(self.patience.get(cx)).unwrap_or(Duration::MAX);
        let is_lost = |seen| cx.now().saturating_sub(seen) > patience;
        let full = if self.slam.scans().len() >= self.keyframes.keyframes.get(cx) as usize {
            "; it has as many `keyframes` as it may, none of them close to another, and keeps no more"
        } else {
            ""
        };
        if self.seen.is_none_or(is_lost) {
            if let Some(untimely) = &self.untimely {
                return Err(format!("no pose: {untimely}"));
            }
            return Err(match self.slam.state() {
                state @ (State::New(_) | State::Differs(_) | State::Blind) => {
                    if !core::mem::replace(&mut self.is_lost, true) {
                        warn!(cx, "no pose: {state}{full}");
                    }
                    format!("no pose: {state}{full}")
                }
                State::Empty | State::Fits(_) => "no scan that can be used".into(),
            });
        }
        let anchor = self.slam.anchor(&measured).ok_or("no scan yet")?;
        self.export_pose(cx, &odometry, &anchor);
        self.is_lost = false;
        let graph = self.slam.graph();
        Ok(format!(
            "{} keyframes, {} loops: {}{full}",
            graph.poses().len(),
            graph.loops().count(),
            self.slam.state()
        ))
    }

    fn export_pose(&mut self, cx: &Context, odometry: &Sample<'_, Odometry>, anchor: &Anchor) {
        let (pose, measured) = (self.slam.place(anchor), odometry.pose2d());
        let header = Header::new(odometry.time(), "map");
        let covariance = self.slam.covariance(&self.settings(cx), &measured);
        let exported = Odometry {
            header,
            pose: PoseWithCovariance::planar(pose, &covariance),
            ..**odometry
        };
        self.pose.write_at(cx, exported, odometry.time());
        let correction = PoseStamped {
            header,
            pose: pose.transform(&measured.localize(&Pose2D::ORIGIN)).into(),
        };
        self.correction.write_at(cx, correction, odometry.time());
    }

    /// Returns where the laser of a scan is on the base.
    pub(crate) fn mounted(&self, cx: &Context, laser: &LaserScan) -> Pose2D {
        let body = self.body.get(cx);
        body.map_or_else(
            || self.mount.get(cx),
            |body| body.laser(laser.header.frame_id.as_str()),
        )
    }

    /// Takes a scan that is new.
    fn look(&mut self, cx: &Context, odometry: &Sample<'_, Odometry>) {
        self.history.add(odometry.time(), odometry);
        let Some(laser) = self.laser.get(cx) else { return };
        if core::mem::replace(&mut self.scan_number, laser.sequence()) == laser.sequence() {
            return;
        }
        let (beams, reach) = (
            self.scans.max_beams.get(cx) as usize,
            self.scans.max_laser_range.get(cx),
        );
        let sweep = match self.history.sweep(&laser, laser.time(), cx.now()) {
            Ok(sweep) => sweep,
            Err(words) => return self.untimely = Some(words),
        };
        self.untimely = None;
        let then = sweep.first();
        let mount = self.mounted(cx, &laser);
        let scan = Scan::new(&laser, sweep.seen_from(&then, &mount), beams, reach);
        let state = self.slam.step(&self.settings(cx), &then, &scan);
        if matches!(state, State::Fits(_)) {
            self.seen = Some(cx.now());
        }
    }

    /// Draws a part of the map, exports it when it is time, and has it saved.
    ///
    /// # Errors
    /// That the map is too large for any cells: a file that keeps a part of it would be taken for the whole.
    fn draw_map(&mut self, cx: &Context) -> Result {
        let coarser = self.drawn.advance(
            &self.slam,
            self.drawing.resolution.get(cx),
            self.drawing.margin.get(cx),
        )?;
        if let Some(side) = coarser {
            warn!(
                cx,
                "the map has more than 4096 × 4096 cells: from now on, it is drawn with cells of {side} m"
            );
        }
        if self.drawn.is_new() && is_due(cx, self.drawn.exported, self.drawing.map_update_interval.get(cx)) {
            let mut map = self.map.loan(cx);
            map.header = Header::new(cx.now(), "map");
            self.drawn.write(&mut map);
            map.publish();
            self.drawn.exported = Some(cx.now());
        }
        self.follow_saving(cx);
        let is_free = !self.saving.is_busy();
        if is_free
            && self.is_worth_saving(cx)
            && is_due(cx, self.saving.last, self.map_file.save_every.get(cx))
        {
            self.save(cx);
        }
        Ok(())
    }

    /// Whether the map shows what its file does not.
    fn is_worth_saving(&self, cx: &Context) -> bool {
        let is_other = self.slam.scans().len() > self.slam.given() || self.slam.revision() > 0;
        !self.map_file.map_file_name.get(cx).is_empty() && is_other && self.drawn.is_unsaved()
    }

    /// Has the map saved as it is now.
    pub(crate) fn save(&mut self, cx: &Context) {
        self.save_held(cx, None);
    }

    fn save_held(&mut self, cx: &Context, held: Option<File>) {
        self.saving.last = Some(cx.now());
        let file = self.map_file.map_file_name.get(cx);
        if let Err(error) = self.saving.begin(file.as_str(), &self.drawn, held) {
            warn!(cx, "cannot save the map: {error}");
        }
    }

    /// Notes what has become of the map that was written.
    fn follow_saving(&mut self, cx: &Context) {
        match self.saving.end() {
            Some(Ok(changes)) => self.drawn.set_saved(changes),
            Some(Err(error)) => warn!(cx, "cannot save the map: {error}"),
            None => {}
        }
    }

    fn settings(&self, cx: &Context) -> Settings {
        Settings {
            update: (
                self.matching.minimum_travel_distance.get(cx),
                self.matching.minimum_travel_heading.get(cx),
            ),
            keyframe: (
                self.keyframes.keyframe_way.get(cx),
                self.keyframes.keyframe_turn.get(cx),
            ),
            most: self.keyframes.keyframes.get(cx) as usize,
            way_by_way: self.noise.translation_noise_from_translation.get(cx),
            turn_by_turn: self.noise.rotation_noise_from_rotation.get(cx),
            turn_by_way: self.noise.rotation_noise_from_translation.get(cx),
            share: self.matching.match_minimum_response.get(cx),
            drift: self.loops.drift.get(cx),
            loop_share: self.loops.loop_match_minimum_response.get(cx),
            loop_matches: self.loops.loop_matches.get(cx) as usize,
        }
    }
}

/// Checks that the laser is near the base.
fn check_mount(mount: &Pose2D) -> Result<(), String> {
    if libm::hypot(mount.x, mount.y) <= MAX_MOUNT_DISTANCE {
        return Ok(());
    }
    Err(format!(
        "the laser is more than {MAX_MOUNT_DISTANCE} m from the base: state `mount` in metres"
    ))
}

fn is_due(cx: &Context, last: Option<Duration>, every: f64) -> bool {
    let every = Duration::try_from_secs_f64(every).unwrap_or(Duration::MAX);
    last.is_none_or(|last| cx.now().saturating_sub(last) >= every)
}

jde_schema::export!(
    "slam",
    "Makes a map while the robot drives, and says where the robot is on it.",
    [Slam]
);

#[cfg(test)]
mod tests;
