//! A complete log, which is read once: where the robot was, what its laser saw, and when. What cannot be read is named and
//! left out; what its clock does not tell is spread evenly.

mod beams;
mod clock;
mod poses;
mod record;

use core::time::Duration;
use std::io;

use jde_files::{Budget, Exceeded, LeftOut};
use jde_schema::types::{Pose2D, normalize_angle};

pub(crate) use beams::Scan;
use beams::{Stated, no_return};
use clock::{Clock, Fault};
use poses::Poses;
use record::{Line, Reading, Source, Sweep};

/// Most kinds of lines that are named.
const MAX_NAMED: usize = 20;
/// Between poses that are farther apart, the odometry is interpolated: just below what readers take for a jump, m and rad.
const INTERPOLATION_STEP: (f64, f64) = (0.8, 1.2);
/// How fast a robot goes whose clock does not tell it, m/s and rad/s, and how long it is on its way at most, s.
const SPEED: (f64, f64) = (2.0, 2.0);
const MAX_WAY_TIME: f64 = 10.0;
/// What is farther, or faster by the clock of the log, is a jump indeed: m, m/s and rad/s.
const JUMP: f64 = 10.0;
const JUMP_SPEED: (f64, f64) = (5.0, 6.3);

/// The records of a log, in order.
#[derive(Debug)]
pub(crate) struct LogFile {
    records: Vec<Record>,
    scans: usize,
    mount: Pose2D,
    no_return: Option<f32>,
    /// Whether the clock of the log tells its time.
    is_timed: bool,
    notes: Vec<String>,
}

/// A record of the log.
#[derive(Debug)]
pub(crate) struct Record {
    /// Time since the first record.
    pub(crate) time: Duration,
    /// The pose of the robot.
    pub(crate) pose: Pose2D,
    pub(crate) scan: Option<Scan>,
}

/// The reason why a file is not a usable log.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LogError {
    #[error("cannot read the log {path}: {error}")]
    Io { path: String, error: io::Error },
    #[error("cannot read the log {path}: {0}; play a part of it", path = .1)]
    Budget(Exceeded, String),
    #[error("{path} has no scan: not one of its {lines} lines is a FLASER or ROBOTLASER1 line that can be read{}", first.as_ref().map(|first| format!("; {first}")).unwrap_or_default())]
    NoScan {
        path: String,
        lines: usize,
        first: Option<String>,
    },
    #[error("{path} does not say where its robot was: its scans have no poses, and it has no ODOM line")]
    NoPose { path: String },
    #[error("nothing in {path} can be used: no beam of its {scans} scans ends at an object")]
    NoEcho { path: String, scans: usize },
}

/// A line with a pose or a scan.
struct Entry {
    line: usize,
    reading: Reading,
    sweep: Option<(Source, Sweep)>,
}

impl LogFile {
    /// Reads the bytes of the log `path`, up to where they are damaged. If its clock does not tell when its scans were, they are
    /// `interval` apart.
    pub(crate) fn of(
        bytes: &[u8],
        damage: Option<io::Error>,
        path: &str,
        interval: Duration,
    ) -> Result<Self, LogError> {
        let mut log = Lines::default();
        log.read(bytes)
            .map_err(|exceeded| LogError::Budget(exceeded, path.to_owned()))?;
        if let Some(error) = damage {
            // It explains the missing scans best.
            if log.entries.iter().all(|entry| entry.sweep.is_none()) {
                let path = path.to_owned();
                return Err(LogError::Io { path, error });
            }
            log.notes.push(format!(
                "the file is cut short after line {}: {error}; only the part before is played",
                log.count
            ));
        }
        log.finish(path, interval.as_secs_f64())
    }

    pub(crate) fn records(&self) -> &[Record] {
        &self.records
    }

    pub(crate) fn scans(&self) -> usize {
        self.scans
    }

    /// Where the laser is on the robot.
    pub(crate) fn mount(&self) -> Pose2D {
        self.mount
    }

    /// From which range on the laser of this log had no return, if its greatest range says so, m.
    pub(crate) fn no_return(&self) -> Option<f32> {
        self.no_return
    }

    pub(crate) fn duration(&self) -> Duration {
        self.records.last().map_or(Duration::ZERO, |record| record.time)
    }

    /// Warnings from reading it, for the operator.
    pub(crate) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the pose at a time before the record `next`, where the record before it is so far away that the way there
    /// would look like a jump.
    pub(crate) fn pose_between(&self, next: usize, now: Duration) -> Option<Pose2D> {
        let (last, next) = (self.records.get(next.checked_sub(1)?)?, self.records.get(next)?);
        let (way, turn) = (last.pose.distance_to(&next.pose), turn(&last.pose, &next.pose));
        let seconds = next.time.saturating_sub(last.time).as_secs_f64();
        let is_far = way > INTERPOLATION_STEP.0 || turn.abs() > INTERPOLATION_STEP.1;
        let is_motion = way <= JUMP_SPEED.0 * seconds && turn.abs() <= JUMP_SPEED.1 * seconds;
        if !is_far || way > JUMP || (self.is_timed && !is_motion) || seconds <= 0.0 {
            return None;
        }
        let share = now.saturating_sub(last.time).as_secs_f64() / seconds;
        Some(interpolate(&last.pose, &next.pose, share.min(1.0)))
    }
}

fn turn(from: &Pose2D, to: &Pose2D) -> f64 {
    normalize_angle(to.theta - from.theta)
}

fn interpolate(from: &Pose2D, to: &Pose2D, share: f64) -> Pose2D {
    Pose2D::new(
        from.x + share * (to.x - from.x),
        from.y + share * (to.y - from.y),
        normalize_angle(from.theta + share * turn(from, to)),
    )
}

/// The lines read so far.
#[derive(Default)]
struct Lines {
    entries: Vec<Entry>,
    count: usize,
    left_out: LeftOut,
    notes: Vec<String>,
    stated: Stated,
    /// The offsets of the lasers in front and in the rear.
    offsets: [Option<f64>; 2],
}

impl Lines {
    fn read(&mut self, bytes: &[u8]) -> Result<(), Exceeded> {
        let mut budget = Budget::default();
        for line in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.count += 1;
            budget.work(1)?;
            let number = self.count;
            let text = String::from_utf8_lossy(line);
            let (reading, sweep) = match record::parse(&text) {
                Ok(Line::Empty) => continue,
                Ok(Line::Param(name, value)) => {
                    self.param(name, value);
                    continue;
                }
                Ok(Line::Other(name)) => {
                    self.leave_out(name, number, "it has neither a scan nor the pose of the robot");
                    continue;
                }
                Err(error) => {
                    let name = text.split_ascii_whitespace().next().unwrap_or_default();
                    self.leave_out(format_args!("a {name} line"), number, error);
                    continue;
                }
                Ok(Line::Odometry(reading)) => (reading, None),
                Ok(Line::Scan(source, sweep, reading)) => (reading, Some((source, sweep))),
            };
            let ranges = sweep
                .as_ref()
                .map_or(0, |(_, sweep)| size_of_val(sweep.ranges.as_slice()));
            // A list that grows has room for twice its length.
            budget.hold(2 * size_of::<Entry>() + ranges)?;
            self.entries.push(Entry {
                line: number,
                reading,
                sweep,
            });
        }
        Ok(())
    }

    fn leave_out(&mut self, what: impl core::fmt::Display, line: usize, why: impl core::fmt::Display) {
        self.left_out.add(what, Some(&format_args!("line {line}")), why);
    }

    /// Takes a parameter. The first of its name counts, as for GMapping.
    fn param(&mut self, name: &str, value: &str) {
        let Some(value) = value.parse().ok().filter(|value: &f64| value.is_finite()) else {
            return;
        };
        match name {
            "robot_frontlaser_offset" => self.offsets[0] = self.offsets[0].or(Some(value)),
            "robot_rearlaser_offset" => self.offsets[1] = self.offsets[1].or(Some(value)),
            "laser_front_laser_resolution" => self.stated.resolution(value),
            "laser_front_laser_fov" => self.stated.field_of_view(value),
            _ => {}
        }
    }

    fn finish(mut self, path: &str, interval: f64) -> Result<LogFile, LogError> {
        let path = || path.to_owned();
        let Some(source) = self.choose() else {
            return Err(LogError::NoScan {
                path: path(),
                lines: self.count,
                first: self.left_out.lines().next(),
            });
        };
        let stated = if source.is_rear() {
            Stated::default()
        } else {
            self.stated
        };
        let offset = self.offsets[usize::from(source.is_rear())];
        let poses = Poses::of(&mut self.entries, source, offset);
        self.notes.extend(poses.notes);
        if poses.contradicts {
            self.keep(
                |entry| entry.sweep.is_some(),
                |_| "ODOM".to_owned(),
                "its poses contradict those of the scans",
            );
        }
        let (clock, times) = self.times(interval);
        let mut records = Vec::with_capacity(self.entries.len());
        let mut greatest = 0.0_f32;
        for (entry, time) in core::mem::take(&mut self.entries).into_iter().zip(times) {
            let scan = entry.sweep.map(|(_, sweep)| {
                let finite = sweep.ranges.iter().copied().filter(|range| range.is_finite());
                greatest = finite.fold(greatest, f32::max);
                Scan::new(sweep, &stated)
            });
            records.push((time, entry.reading.robot, scan));
        }
        let scans: Vec<&Scan> = records.iter().filter_map(|(_, _, scan)| scan.as_ref()).collect();
        if !scans.iter().any(|scan| scan.hits()) {
            let scans = scans.len();
            return Err(LogError::NoEcho { path: path(), scans });
        }
        let scans = scans.len();
        let named = self.left_out.lines().count();
        self.notes.extend(self.left_out.lines().take(MAX_NAMED));
        if named > MAX_NAMED {
            self.notes
                .push(format!("{} more kinds of lines are left out", named - MAX_NAMED));
        }
        Ok(LogFile {
            records: with_poses(records).ok_or_else(|| LogError::NoPose { path: path() })?,
            scans,
            mount: poses.mount,
            no_return: no_return(greatest),
            is_timed: clock.is_usable(),
            notes: self.notes,
        })
    }

    /// Chooses the scans that are played, and leaves out all others: the first source of those that have about as many
    /// scans as any.
    fn choose(&mut self) -> Option<Source> {
        let mut counts = std::collections::BTreeMap::new();
        for (source, _) in self.entries.iter().filter_map(|entry| entry.sweep.as_ref()) {
            *counts.entry(*source).or_insert(0) += 1;
        }
        let most = counts.values().copied().max()?;
        let many = counts.into_iter().filter(|(_, count)| count * 2 >= most);
        let source = many
            .map(|(source, _)| source)
            .min_by_key(|source| (!source.is_front(), *source))?;
        self.keep(
            |entry| entry.sweep.as_ref().is_none_or(|(other, _)| *other == source),
            |entry| {
                entry
                    .sweep
                    .as_ref()
                    .map(|(source, _)| source.to_string())
                    .unwrap_or_default()
            },
            &format!("the scans of {source} are played"),
        );
        Some(source)
    }

    /// Leaves out all entries but those that are kept.
    fn keep(&mut self, is_kept: impl Fn(&Entry) -> bool, name: impl Fn(&Entry) -> String, why: &str) {
        let left_out = &mut self.left_out;
        self.entries.retain(|entry| {
            let is_kept = is_kept(entry);
            if !is_kept {
                left_out.add(name(entry), Some(&format_args!("line {}", entry.line)), why);
            }
            is_kept
        });
    }

    /// Returns the clock of the scans, and the time of each entry since the first one.
    fn times(&mut self, interval: f64) -> (Clock, Vec<Duration>) {
        let scans: Vec<usize> = (self.entries.iter().enumerate())
            .filter_map(|(index, entry)| entry.sweep.is_some().then_some(index))
            .collect();
        let [sent, logged] = [0, 1].map(|clock| {
            let stamps: Vec<_> = scans
                .iter()
                .map(|scan| self.entries[*scan].reading.stamps[clock])
                .collect();
            let is_led_to = |scan: usize| {
                let lines = &self.entries[scans[scan - 1] + 1..scans[scan]];
                let lines = lines.iter().map(|entry| entry.reading.stamps[clock]);
                (stamps[scan - 1].zip(stamps[scan])).is_some_and(|(from, to)| clock::leads(lines, from, to))
            };
            Clock::new(&stamps, &is_led_to, interval)
        });
        let by_sender = sent.tells() >= logged.tells();
        let clock = if by_sender { sent } else { logged };
        let clock = self.judge(clock, &scans, interval);
        let stamp = |entry: &Entry| entry.reading.stamps[usize::from(!by_sender)];
        let mut times = Vec::with_capacity(self.entries.len());
        let mut begin = 0;
        let ends = scans.iter().copied().chain([self.entries.len()]);
        for (after, end) in ends.enumerate() {
            let stamps: Vec<_> = self.entries[begin..end].iter().map(stamp).collect();
            times.extend(clock.between(after.checked_sub(1), &stamps, interval));
            times.extend(clock.times.get(after));
            begin = end + 1;
        }
        let first = times.first().copied().unwrap_or(0.0);
        let since = |time: f64| Duration::try_from_secs_f64(time - first).unwrap_or_default();
        (clock, times.into_iter().map(since).collect())
    }

    /// Returns how long a robot is on its way from one entry to another, s.
    fn least_time(&self, from: usize, to: usize) -> f64 {
        let poses: Vec<Pose2D> = (self.entries[from..=to].iter())
            .filter_map(|entry| entry.reading.robot)
            .collect();
        let steps = poses
            .windows(2)
            .map(|pair| (pair[0].distance_to(&pair[1]), turn(&pair[0], &pair[1]).abs()));
        let (way, turned) = steps.fold((0.0, 0.0), |sum, step| (sum.0 + step.0, sum.1 + step.1));
        (way / SPEED.0).max(turned / SPEED.1).min(MAX_WAY_TIME)
    }

    /// Says what is wrong with the clock, and replaces one that tells nothing.
    fn judge(&mut self, clock: Clock, scans: &[usize], interval: f64) -> Clock {
        let line = |fault: &Fault| self.entries[scans[fault.scan]].line;
        if !clock.is_usable() {
            let first = self.entries[scans[0]].reading.stamps;
            self.notes.push(match first {
                [Some(stamp), _] | [None, Some(stamp)] if clock.stands_still => format!(
                    "its clock stands still at {stamp} s; the scans are played {interval} s apart, or more where the robot went far"
                ),
                _ => format!(
                    "its clocks do not tell when its {} scans were; the scans are played {interval} s apart, or more where the \
                     robot went far",
                    scans.len()
                ),
            });
            let gaps: Vec<f64> = (scans.windows(2))
                .map(|pair| self.least_time(pair[0], pair[1]).max(interval))
                .collect();
            return Clock::apart(&gaps);
        }
        if let Some((count, fault @ Fault { last, stamp, .. })) = &clock.faults.jumps {
            self.notes.push(format!(
                "its clock jumps {count} times, first from {last} s to {stamp} s (line {}); no time is played for a jump",
                line(fault)
            ));
        }
        if let Some((count, fault @ Fault { last, stamp, .. })) = &clock.faults.strange {
            self.notes.push(format!(
                "the times of {count} scans contradict those around them, first {stamp} s after {last} s (line {}); the scans \
                 are played in between",
                line(fault)
            ));
        }
        clock
    }
}

/// Gives scans without a pose the one between the poses around them; `None` if there are no poses.
fn with_poses(records: Vec<(Duration, Option<Pose2D>, Option<Scan>)>) -> Option<Vec<Record>> {
    let mut next = None;
    let mut nexts: Vec<Option<(Duration, Pose2D)>> = Vec::with_capacity(records.len());
    for (time, pose, _) in records.iter().rev() {
        next = pose.map(|pose| (*time, pose)).or(next);
        nexts.push(next);
    }
    let mut last = next?;
    let posed = records.into_iter().zip(nexts.into_iter().rev());
    Some(
        posed
            .map(|((time, pose, scan), next)| {
                let (until, to) = next.unwrap_or(last);
                let whole = until.saturating_sub(last.0).as_secs_f64();
                let share = if whole > 0.0 {
                    time.saturating_sub(last.0).as_secs_f64() / whole
                } else {
                    0.0
                };
                let pose = pose.unwrap_or_else(|| interpolate(&last.1, &to, share.min(1.0)));
                last = (time, pose);
                Record { time, pose, scan }
            })
            .collect(),
    )
}
