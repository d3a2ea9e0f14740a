//! Plays a recording as the sensors of a robot, so that schemas, panels and tools work on it: at any speed,
//! paused, message by message, from any position. Commands are exported for display and have no effect.
//!
//! A replay shows how schemas would have decided, not how the robot would have moved. `jde replay --decide`
//! compares their decisions with the recorded ones.

mod output;
mod playhead;
mod reader;

use jde_schema::prelude::*;
use jde_schema::types::Body;

use output::{Output, Outputs};
use playhead::{PlaybackRequest, Playhead};
use reader::RecordingReader;

/// The progress of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Playback")]
pub struct Playback {
    /// Position, from the recording's first message.
    #[value(unit = "s")]
    pub position: f64,
    /// Length of the recording.
    #[value(unit = "s")]
    pub length: f64,
    /// Seconds of the recording per second.
    pub speed: f64,
    /// Number of messages played.
    pub messages: u64,
    /// Number of messages that do not match their type.
    pub spoilt: u64,
    /// Whether it plays: neither paused nor at its end.
    pub playing: Flag,
    /// Unused.
    pub padding: Padding<7>,
}

/// A robot that repeats the measurements of a recording.
///
/// Each export reads the topic that its modulation names, or else the first topic of its type. Without such a topic
/// it has no value. Times are converted to the application's. The mission is done when the recording ends.
#[derive(Describe)]
#[schema(driver, period = "10ms", budget = "50ms")]
pub struct Recording {
    /// The recording, an MCAP file of jde or of ROS 2.
    #[modulation(default = "", unit = "path", fixed)]
    file: Modulation<Text<1024>>,
    /// The laser's topic.
    #[modulation(default = "", fixed)]
    laser_topic: Modulation<Text<120>>,
    /// The sonars' topic.
    #[modulation(default = "", fixed)]
    sonars_topic: Modulation<Text<120>>,
    /// The odometry's topic.
    #[modulation(default = "", fixed)]
    odometry_topic: Modulation<Text<120>>,
    /// The bumpers' topic.
    #[modulation(default = "", fixed)]
    bumpers_topic: Modulation<Text<120>>,
    /// The topic of the head's angles.
    #[modulation(default = "", fixed)]
    pan_tilt_topic: Modulation<Text<120>>,
    /// The battery's topic.
    #[modulation(default = "", fixed)]
    battery_topic: Modulation<Text<120>>,
    /// The encoders' topic.
    #[modulation(default = "", fixed)]
    encoders_topic: Modulation<Text<120>>,
    /// The line sensor's topic.
    #[modulation(default = "", fixed)]
    line_sensor_topic: Modulation<Text<120>>,
    /// The inertial unit's topic.
    #[modulation(default = "", fixed)]
    imu_topic: Modulation<Text<120>>,
    /// The topic of the measured position.
    #[modulation(default = "", fixed)]
    position_fix_topic: Modulation<Text<120>>,
    /// The topic of the robot's body.
    #[modulation(default = "", fixed)]
    body_topic: Modulation<Text<120>>,
    /// The topic of the connection's state.
    #[modulation(default = "", fixed)]
    connection_topic: Modulation<Text<120>>,
    /// The pictures' topic.
    #[modulation(default = "", fixed)]
    image_topic: Modulation<Text<120>>,
    /// The topic of the depths. It must be named, because pictures have the same type.
    #[modulation(default = "", fixed)]
    depth_topic: Modulation<Text<120>>,
    /// Whether it is paused.
    #[modulation(default = Flag::FALSE)]
    paused: Modulation<Flag>,
    /// Seconds of the recording per second of the application.
    #[modulation(default = 1.0, min = 0.01, max = 100.0)]
    speed: Modulation<f64>,
    /// Position at which to continue, from the recording's first message. Each write takes effect.
    #[modulation(default = 0.0, unit = "s", min = 0.0)]
    position: Modulation<f64>,
    /// Messages to play while paused. Each write takes effect.
    #[modulation(default = 0, max = 100_000)]
    step: Modulation<u32>,
    /// Whether it starts again at its end.
    #[modulation(default = Flag::FALSE)]
    repeat: Modulation<Flag>,
    /// Speeds of the base, which have no effect.
    #[command(neutral = Twist::ZERO, validity = "1s")]
    velocity: Command<Twist>,
    /// Position of the head, which has no effect.
    #[command(neutral = HOLD, validity = "3600s")]
    head: Command<PanTilt>,
    /// The command in force for the base, for display and recording.
    #[export]
    wanted: Export<Twist>,
    /// The command in force for the head, for display and recording.
    #[export]
    wanted_head: Export<PanTilt>,
    /// The scan of the laser.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    /// The sonars.
    #[export(validity = "1s")]
    sonars: Export<RangeRing>,
    /// Pose and velocity.
    #[export(validity = "1s")]
    odometry: Export<Odometry>,
    /// The bumpers.
    #[export(validity = "1s")]
    bumpers: Export<Bumpers>,
    /// The position of the head.
    #[export(validity = "1s")]
    pan_tilt: Export<PanTilt>,
    /// The battery.
    #[export(lasting)]
    battery: Export<BatteryState>,
    /// The counts of the wheels.
    #[export(validity = "1s")]
    encoders: Export<WheelEncoders>,
    /// The line sensor.
    #[export(validity = "1s")]
    line_sensor: Export<LineSensor>,
    /// The inertial unit.
    #[export(validity = "1s")]
    imu: Export<Imu>,
    /// The measured position.
    #[export(validity = "1s")]
    position_fix: Export<PositionFix>,
    /// The outline of the robot and the places of its lasers; for windows.
    #[export(lasting)]
    body: Export<Body>,
    /// Whether the robot was connected.
    #[export(lasting)]
    connection: Export<Connection>,
    /// The pictures.
    #[export(validity = "1s")]
    image: Export<Image>,
    /// The depths of a camera.
    #[export(validity = "1s")]
    depth: Export<Image>,
    /// Progress of the recording.
    #[export(lasting)]
    playback: Export<Playback>,
    /// Seconds played, and their total; done at the end unless `repeat` is set.
    #[export(lasting)]
    mission: Export<Mission>,
    player: Option<Player>,
}

/// The default command of the head.
const HOLD: PanTilt = PanTilt {
    header: Header {
        stamp: Time { sec: 0, nanosec: 0 },
        frame_id: Text::EMPTY,
    },
    pan: 0.0,
    tilt: 0.0,
    pan_velocity: 0.0,
    tilt_velocity: 0.0,
};

/// A recording that is being played.
struct Player {
    reader: RecordingReader,
    outputs: Outputs,
    playhead: Playhead,
    spoilt: u64,
}

impl Schema for Recording {
    fn awake(&mut self, cx: &Context) -> Result {
        if let Some(player) = &mut self.player {
            // Time asleep does not advance the recording.
            player.playhead.wake(cx.now());
            return Ok(());
        }
        let reader = self.open_reader(cx)?;
        let outputs = self.outputs(cx, &reader)?;
        for damage in reader.damage() {
            warn!(cx, "{damage}");
        }
        for line in reader.left_out().lines() {
            warn!(cx, "{line}");
        }
        info!(cx, "{} s of {}", reader.length().as_secs_f64(), outputs.names());
        self.player = Some(Player {
            playhead: Playhead::new(cx.now(), reader.length()),
            reader,
            outputs,
            spoilt: 0,
        });
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.wanted.write(cx, *self.velocity.get(cx).value());
        self.wanted_head.write(cx, *self.head.get(cx).value());
        let Some(mut player) = self.player.take() else {
            return Err("it has no recording".into());
        };
        let (position, step) = (self.position.sample(cx), self.step.sample(cx));
        let plan = player.playhead.advance(&PlaybackRequest {
            now: cx.now(),
            paused: self.paused.get(cx).get(),
            speed: self.speed.get(cx),
            position: (position.sequence(), *position.value()),
            step: (step.sequence(), *step.value()),
            repeat: self.repeat.get(cx).get(),
        });
        let played = self.play(cx, &mut player, plan);
        for line in player.outputs.take_left_out() {
            warn!(cx, "{line}");
        }
        self.export_state(cx, &player);
        self.player = Some(player);
        played
    }
}

impl Inspect for Recording {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let Some(reader) = problems.expect(&self.file, self.open_reader(cx)) else {
            return;
        };
        let mut all_found = true;
        let outputs = self.outputs_or(cx, &reader, |topic, error| {
            all_found = false;
            problems.wrong(topic, error);
            Ok(())
        });
        if all_found {
            problems.expect(
                &self.file,
                outputs.and_then(|outputs| require_outputs(outputs, &reader)),
            );
        }
    }
}

impl Recording {
    fn open_reader(&self, cx: &Context) -> Result<RecordingReader> {
        let file = self.file.get(cx);
        if file.is_empty() {
            return Err(
                "it has no recording; give it one: file = \"drive.mcap\", or --set NAME.file=drive.mcap"
                    .into(),
            );
        }
        Ok(RecordingReader::open(file.as_str())?)
    }

    fn outputs(&self, cx: &Context, reader: &RecordingReader) -> Result<Outputs> {
        require_outputs(self.outputs_or(cx, reader, |_, error| Err(error))?, reader)
    }

    /// Finds the topics to play. Calls `on_error` for each modulation that names an unsuitable topic.
    fn outputs_or(
        &self,
        cx: &Context,
        reader: &RecordingReader,
        mut on_error: impl FnMut(&Modulation<Text<120>>, Error) -> Result,
    ) -> Result<Outputs> {
        let mut outputs = Outputs::default();
        macro_rules! add {
            ($($sensor:ident: $output:ident as $topic:ident),*) => {$(
                if let Err(error) = outputs.add::<$sensor>(reader, Output::$output, &self.$topic.get(cx)) {
                    on_error(&self.$topic, error)?;
                }
            )*};
        }
        // Before the pictures, which then come from another topic.
        if !self.depth_topic.get(cx).is_empty() {
            add!(Image: Depth as depth_topic);
        }
        add!(
            LaserScan: Laser as laser_topic,
            RangeRing: Sonars as sonars_topic,
            Odometry: Odometry as odometry_topic,
            Bumpers: Bumpers as bumpers_topic,
            PanTilt: PanTilt as pan_tilt_topic,
            BatteryState: Battery as battery_topic,
            WheelEncoders: Encoders as encoders_topic,
            LineSensor: LineSensor as line_sensor_topic,
            Imu: Imu as imu_topic,
            PositionFix: PositionFix as position_fix_topic,
            Body: Body as body_topic,
            Connection: Connection as connection_topic,
            Image: Image as image_topic
        );
        Ok(outputs)
    }

    /// Publishes the messages that are due.
    fn play(&mut self, cx: &Context, player: &mut Player, plan: playhead::PlaybackStep) -> Result {
        if let Some(position) = plan.seek {
            // Publishes the last values before the position, so that no schema uses values of another position.
            for message in player.reader.seek(position, |topic| player.outputs.has(topic))? {
                self.publish(cx, player, &message);
            }
        }
        let until = player.playhead.position();
        let mut remaining = plan.messages;
        while let Some(message) = player
            .reader
            .next(until, remaining, |topic| player.outputs.has(topic))?
        {
            player.playhead.played(message.at, remaining.is_some());
            remaining = remaining.map(|count| count - 1);
            self.publish(cx, player, &message);
        }
        Ok(())
    }

    fn publish(&mut self, cx: &Context, player: &mut Player, message: &reader::TimedMessage) {
        let published = player.playhead.time_of(message.at, cx.now());
        let (output, bytes) = match player.outputs.read(message) {
            Some(Ok(decoded)) => decoded,
            Some(Err(_)) => {
                player.spoilt += 1;
                return;
            }
            None => return,
        };
        macro_rules! put {
            ($export:ident) => {{
                let mut room = self.$export.loan(cx);
                room.as_bytes_mut().copy_from_slice(bytes);
                let time = published.saturating_sub(message.age(room.header.stamp));
                room.header.stamp = time.into();
                room.publish_at(time);
            }};
        }
        match output {
            Output::Laser => put!(laser),
            Output::Sonars => put!(sonars),
            Output::Odometry => put!(odometry),
            Output::Bumpers => put!(bumpers),
            Output::PanTilt => put!(pan_tilt),
            Output::Battery => put!(battery),
            Output::Encoders => put!(encoders),
            Output::LineSensor => put!(line_sensor),
            Output::Imu => put!(imu),
            Output::PositionFix => put!(position_fix),
            Output::Body => put!(body),
            Output::Connection => put!(connection),
            Output::Image => put!(image),
            Output::Depth => put!(depth),
        }
    }

    fn export_state(&mut self, cx: &Context, player: &Player) {
        let Player {
            playhead,
            reader,
            spoilt,
            ..
        } = player;
        let ended = playhead.has_ended() && !self.repeat.get(cx).get();
        self.playback.write(
            cx,
            Playback {
                position: playhead.position().as_secs_f64(),
                length: reader.length().as_secs_f64(),
                speed: self.speed.get(cx),
                messages: playhead.messages(),
                spoilt: *spoilt,
                playing: Flag::from(playhead.is_playing()),
                padding: Padding::default(),
            },
        );
        let mission = Mission {
            state: if ended { Mission::DONE } else { Mission::RUNNING },
            reached: playhead.position().as_secs() as u32,
            total: reader.length().as_secs() as u32,
            note: Text::new("seconds played"),
            ..Mission::default()
        };
        self.mission.write(cx, mission);
    }
}

/// Returns the topics, or an error if there are none.
fn require_outputs(outputs: Outputs, reader: &RecordingReader) -> Result<Outputs> {
    if outputs.is_empty() {
        return Err(format!(
            "{} has no topic that a robot senses; it has {}",
            reader.path(),
            reader.topics()
        )
        .into());
    }
    Ok(outputs)
}

jde_schema::export!(
    "replay",
    "Plays a recording as the sensors of a robot.",
    [Recording]
);

#[cfg(test)]
mod tests;
