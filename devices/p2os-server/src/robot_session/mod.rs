//! One robot of the world for its client: it does the handshake, executes commands, and sends the robot's
//! measurements. It takes and returns bytes, and never blocks.

mod commands;
mod head;
mod laser;
mod measurements;
mod motion;

use core::time::Duration;

use jde_p2os::{Command, Model, Names, Packet, Receiver, SyncStep};
use jde_sim::{Footprint, Pose2, RobotConfig, RobotId, STEP_NS, World};

use crate::event::EventKind;
use head::Camera;
use laser::Laser;
use motion::MotorCommands;

/// Time between two server information packets.
const SIP_INTERVAL: Duration = Duration::from_millis(100);
/// Silence after which the motors stop.
pub(crate) const WATCHDOG: Duration = Duration::from_millis(2000);

/// A robot and its session.
#[derive(Debug)]
pub(crate) struct RobotSession {
    robot: RobotId,
    model: Model,
    config: RobotConfig,
    start: Pose2,
    receiver: Receiver,
    phase: ClientProgress,
    /// The next packet of a new client's handshake, while an earlier session is still open.
    next_sync: Option<SyncStep>,
    motion: MotorCommands,
    laser: Laser,
    camera: Camera,
    sonars: bool,
    encoders: Subscription,
    state: Subscription,
    /// The pose in the client's frame at which the odometry of the world's robot is `odometry_origin`.
    client_pose: Pose2,
    odometry_origin: Pose2,
    last_received: Duration,
    silent: bool,
    next_sip: Duration,
    collisions: u64,
    output: Vec<u8>,
    events: Vec<EventKind>,
}

/// The progress of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ClientProgress {
    /// The session waits for this synchronisation.
    Waiting(SyncStep),
    /// The handshake is complete, and the servers are not open yet.
    Ready,
    /// The servers are open: the robot sends its information packets.
    Open,
}

/// How often a client has requested a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Subscription {
    No,
    Once,
    Always,
}

/// Returns the subclass that robots of this model report.
fn subclass(model: &Model) -> String {
    model.subclasses.first().unwrap_or(&model.name).clone()
}

/// Returns the configuration of a robot of this model.
pub(crate) fn robot_config(model: &Model) -> RobotConfig {
    let default = RobotConfig::default();
    let ticks_per_meter = match model.encoders.per_mm {
        0.0 => default.ticks_per_meter,
        ticks => ticks * 1000.0,
    };
    RobotConfig {
        footprint: Footprint::Circle {
            radius: model.body.radius_mm / 1000.0,
        },
        max_linear: model.limits.velocity_mm_s / 1000.0,
        max_angular: model.limits.rotation_deg_s.to_radians(),
        // Wheel speeds that differ by 2 mm/s turn the robot at `wheel_difference`.
        track: 0.002 / model.units.wheel_difference,
        ticks_per_meter,
        ..default
    }
}

impl RobotSession {
    pub(crate) fn new(world: &World, robot: RobotId, model: Model) -> Self {
        let config = world.config(robot).clone();
        let truth = world.truth(robot);
        Self {
            robot,
            receiver: Receiver::new(),
            phase: ClientProgress::Waiting(SyncStep::Zero),
            next_sync: None,
            motion: MotorCommands::new(&config),
            laser: Laser::new(),
            camera: Camera::new(&config.head),
            sonars: true,
            encoders: Subscription::No,
            state: Subscription::No,
            client_pose: Pose2::default(),
            odometry_origin: world.odometry(robot).pose,
            last_received: Duration::ZERO,
            silent: false,
            next_sip: Duration::ZERO,
            collisions: truth.collisions,
            output: Vec::new(),
            events: Vec::new(),
            start: truth.pose,
            model,
            config,
        }
    }

    /// Checks that its names, from the world and the model, fit into packets.
    ///
    /// # Errors
    /// If they do not.
    pub(crate) fn check_names(&self, world: &World) -> Result<(), jde_p2os::Error> {
        self.names(world).to_packet()?;
        self.configuration(world).to_packet()?;
        Ok(())
    }

    /// Processes bytes at a time of the world.
    pub(crate) fn receive(&mut self, world: &mut World, bytes: &[u8], now: Duration) {
        let mut receiver = std::mem::take(&mut self.receiver);
        receiver.receive(bytes, now, |packet| self.handle_packet(world, &packet, now));
        self.receiver = receiver;
    }

    /// Commands the motors and the head for the next step of the world.
    pub(crate) fn step(&mut self, world: &mut World, now: Duration) {
        if self.phase == ClientProgress::Open
            && !self.silent
            && now.saturating_sub(self.last_received) > WATCHDOG
        {
            self.silent = true;
            self.motion.stop();
            self.push_event(EventKind::Silent(WATCHDOG));
        }
        let odometry = world.odometry(self.robot);
        let heading = self.pose(world).heading;
        let dt = STEP_NS as f64 * 1e-9;
        let twist = self.motion.command(&self.config, heading, odometry.twist, dt);
        // The world refuses only numbers that are not finite, and these come from whole numbers.
        let _ = world.command(self.robot, twist);
        let _ = world.command_head(self.robot, self.camera.command());
    }

    /// Sends what is due after a step of the world.
    pub(crate) fn send_due(&mut self, world: &World, now: Duration) {
        let collisions = world.truth(self.robot).collisions;
        if std::mem::replace(&mut self.collisions, collisions) < collisions {
            self.push_event(EventKind::Collided);
        }
        if self.phase != ClientProgress::Open {
            return;
        }
        if let Some(reply) = self.camera.take_reply() {
            self.send(reply.to_packet());
        }
        if now < self.next_sip {
            return;
        }
        // Computed from the previous time, so that the cycle does not drift. Missed packets are not sent
        // later.
        self.next_sip += SIP_INTERVAL;
        if self.next_sip <= now {
            self.next_sip = now + SIP_INTERVAL;
        }
        let pose = self.pose(world);
        self.send(self.sip(world, pose).to_packet());
        if self.encoders.take_due() {
            self.send(Ok(self.encoder_packet(world).to_packet()));
        }
        for packet in self.laser.sweep(world, self.robot, pose) {
            self.send(packet.to_packet());
        }
        if self.state.take_due() {
            self.send(self.true_state(world).to_packet());
        }
    }

    /// Resets the session after the client has left.
    pub(crate) fn end_session(&mut self, event: EventKind) {
        self.reset();
        self.push_event(event);
    }

    /// Switches the motors off, and resets everything that the client has set.
    fn reset(&mut self) {
        self.motion = MotorCommands::new(&self.config);
        self.camera.stop();
        self.laser = Laser::new();
        self.sonars = true;
        (self.encoders, self.state) = (Subscription::No, Subscription::No);
        self.phase = ClientProgress::Waiting(SyncStep::Zero);
        self.next_sync = None;
        self.receiver = Receiver::new();
        self.silent = false;
        self.output.clear();
    }

    /// Returns the time since the client last sent a packet, or arrived.
    pub(crate) fn silence(&self, now: Duration) -> Duration {
        now.saturating_sub(self.last_received)
    }

    /// Records the arrival of a client, and restarts the measurement of its silence.
    pub(crate) fn begin_session(&mut self, event: EventKind, now: Duration) {
        self.last_received = now;
        self.push_event(event);
    }

    /// Records an event.
    pub(crate) fn push_event(&mut self, event: EventKind) {
        self.events.push(event);
    }

    /// Takes the bytes to send.
    pub(crate) fn take_bytes(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.output)
    }

    /// Takes the events that have occurred.
    pub(crate) fn take_events(&mut self) -> Vec<EventKind> {
        std::mem::take(&mut self.events)
    }

    pub(crate) fn robot(&self) -> RobotId {
        self.robot
    }

    fn handle_packet(&mut self, world: &mut World, packet: &Packet, now: Duration) {
        self.last_received = now;
        self.silent = false;
        match (self.phase, SyncStep::from_packet(packet)) {
            // A client that starts again, or did not receive the reply.
            (ClientProgress::Waiting(_), Some(SyncStep::Zero)) => self.echo(SyncStep::Zero, SyncStep::One),
            (ClientProgress::Waiting(SyncStep::One | SyncStep::Two), Some(SyncStep::One)) => {
                self.echo(SyncStep::One, SyncStep::Two)
            }
            (ClientProgress::Waiting(SyncStep::Two), Some(SyncStep::Two)) => self.complete_handshake(world),
            // Other packets before the handshake belong to an older session.
            (ClientProgress::Waiting(_), _) => {}
            // The three steps are also PULSE, OPEN and CLOSE. No client opens an open session. So in this
            // order they are the handshake of another client, whose predecessor left unnoticed.
            (ClientProgress::Open, Some(SyncStep::Two)) if self.next_sync == Some(SyncStep::Two) => {
                self.end_session(EventKind::ClientLeft(
                    "another client starts a handshake on its line".to_owned(),
                ));
                self.send(Ok(SyncStep::Zero.to_packet()));
                self.send(Ok(SyncStep::One.to_packet()));
                self.complete_handshake(world);
            }
            (phase, sync) => {
                self.next_sync = match sync {
                    Some(SyncStep::Zero) if phase == ClientProgress::Open => Some(SyncStep::One),
                    Some(SyncStep::One) if self.next_sync == Some(SyncStep::One) => Some(SyncStep::Two),
                    _ => None,
                };
                self.execute(world, Command::from_packet(packet), now);
            }
        }
    }

    /// Completes the handshake.
    fn complete_handshake(&mut self, world: &World) {
        self.send(self.names(world).to_packet());
        self.phase = ClientProgress::Ready;
        self.push_event(EventKind::Connected);
    }

    fn names(&self, world: &World) -> Names {
        Names {
            name: world.robot_name(self.robot).to_owned(),
            class: self.model.class.clone(),
            subclass: subclass(&self.model),
        }
    }

    fn echo(&mut self, sync: SyncStep, next: SyncStep) {
        self.send(Ok(sync.to_packet()));
        self.phase = ClientProgress::Waiting(next);
    }

    /// Returns the pose of the odometry, in the client's frame.
    fn pose(&self, world: &World) -> Pose2 {
        let odometry = world.odometry(self.robot).pose;
        let (sin, cos) = libm::sincos(self.odometry_origin.heading);
        let (dx, dy) = (
            odometry.x - self.odometry_origin.x,
            odometry.y - self.odometry_origin.y,
        );
        let local = Pose2::new(
            cos * dx + sin * dy,
            cos * dy - sin * dx,
            odometry.heading - self.odometry_origin.heading,
        );
        self.client_pose.compose(local)
    }

    /// Makes `new_pose` the present pose of the robot in the client's frame.
    fn set_client_pose(&mut self, world: &World, new_pose: Pose2) {
        self.motion
            .shift_heading(new_pose.heading - self.pose(world).heading);
        self.client_pose = new_pose;
        self.odometry_origin = world.odometry(self.robot).pose;
    }

    fn send(&mut self, packet: Result<Packet, jde_p2os::Error>) {
        // Only names can make a packet too long, and `check_names` has refused such names.
        if let Ok(packet) = packet {
            self.output.extend(packet.to_bytes());
        }
    }
}

impl Subscription {
    fn of(mode: u16) -> Self {
        match mode {
            0 => Self::No,
            1 => Self::Once,
            _ => Self::Always,
        }
    }

    /// Returns whether the packet is due now.
    fn take_due(&mut self) -> bool {
        let is_due = *self != Self::No;
        if *self == Self::Once {
            *self = Self::No;
        }
        is_due
    }
}
