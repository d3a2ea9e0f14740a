//! One robot of the world for its client: it does the handshake, executes commands, and sends the robot's
//! measurements. It takes and returns bytes, and never blocks.

mod head;
mod laser;
mod motion;
mod obey;
mod senses;

use core::time::Duration;

use jde_p2os::{Command, Model, Names, Packet, Receiver, Sync};
use jde_sim::{Pose2, RobotConfig, RobotId, STEP_NS, World};

use crate::event::What;
use head::Camera;
use laser::Laser;
use motion::Motion;

/// Time between two server information packets.
const CYCLE: Duration = Duration::from_millis(100);
/// Silence after which the motors stop.
pub(crate) const WATCHDOG: Duration = Duration::from_millis(2000);

/// A robot and its session.
#[derive(Debug)]
pub(crate) struct Station {
    robot: RobotId,
    model: Model,
    config: RobotConfig,
    start: Pose2,
    receiver: Receiver,
    phase: Phase,
    /// The next packet of a new client's handshake, while an earlier session is still open.
    hello: Option<Sync>,
    motion: Motion,
    laser: Laser,
    camera: Camera,
    sonars: bool,
    encoders: Asked,
    state: Asked,
    /// The pose in the client's frame at which the odometry of the world's robot is `zero`.
    named: Pose2,
    zero: Pose2,
    heard: Duration,
    silent: bool,
    next_sip: Duration,
    collisions: u64,
    out: Vec<u8>,
    happened: Vec<What>,
}

/// The progress of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// The station waits for this synchronisation.
    Waiting(Sync),
    /// The handshake is complete, and the servers are not open yet.
    Ready,
    /// The servers are open: the robot sends its information packets.
    Open,
}

/// How often a client wants a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    No,
    Once,
    Always,
}

/// Returns the subclass that robots of this model report.
fn subclass(model: &Model) -> String {
    model.subclasses.first().unwrap_or(&model.name).clone()
}

/// Returns the configuration of a robot of this model.
pub(crate) fn body(model: &Model) -> RobotConfig {
    let default = RobotConfig::default();
    let ticks_per_meter = match model.encoders.per_mm {
        0.0 => default.ticks_per_meter,
        ticks => ticks * 1000.0,
    };
    RobotConfig {
        radius: model.body.radius_mm / 1000.0,
        max_linear: model.limits.velocity_mm_s / 1000.0,
        max_angular: model.limits.rotation_deg_s.to_radians(),
        // Wheel speeds that differ by 2 mm/s turn the robot at `wheel_difference`.
        track: 0.002 / model.units.wheel_difference,
        ticks_per_meter,
        ..default
    }
}

impl Station {
    pub(crate) fn new(world: &World, robot: RobotId, model: Model) -> Self {
        let config = world.config(robot).clone();
        let truth = world.truth(robot);
        Self {
            robot,
            receiver: Receiver::new(),
            phase: Phase::Waiting(Sync::Zero),
            hello: None,
            motion: Motion::new(&config),
            laser: Laser::new(),
            camera: Camera::new(&config.head),
            sonars: true,
            encoders: Asked::No,
            state: Asked::No,
            named: Pose2::default(),
            zero: world.odometry(robot).pose,
            heard: Duration::ZERO,
            silent: false,
            next_sip: Duration::ZERO,
            collisions: truth.collisions,
            out: Vec::new(),
            happened: Vec::new(),
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
    pub(crate) fn hear(&mut self, world: &mut World, bytes: &[u8], now: Duration) {
        let mut receiver = std::mem::take(&mut self.receiver);
        receiver.receive(bytes, now, |packet| self.packet(world, &packet, now));
        self.receiver = receiver;
    }

    /// Commands the motors and the head for the next step of the world.
    pub(crate) fn step(&mut self, world: &mut World, now: Duration) {
        if self.phase == Phase::Open && !self.silent && now.saturating_sub(self.heard) > WATCHDOG {
            self.silent = true;
            self.motion.stop();
            self.note(What::Silent(WATCHDOG));
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
    pub(crate) fn tell(&mut self, world: &World, now: Duration) {
        let collisions = world.truth(self.robot).collisions;
        if std::mem::replace(&mut self.collisions, collisions) < collisions {
            self.note(What::Touched);
        }
        if self.phase != Phase::Open {
            return;
        }
        if let Some(answer) = self.camera.answer() {
            self.send(answer.to_packet());
        }
        if now < self.next_sip {
            return;
        }
        // Absolute, so that the cycle does not drift. Missed packets are not made up for.
        self.next_sip += CYCLE;
        if self.next_sip <= now {
            self.next_sip = now + CYCLE;
        }
        let pose = self.pose(world);
        self.send(self.sip(world, pose).to_packet());
        if self.encoders.take() {
            self.send(Ok(self.wheels(world).to_packet()));
        }
        for packet in self.laser.sweep(world, self.robot, pose) {
            self.send(packet.to_packet());
        }
        if self.state.take() {
            self.send(self.true_state(world).to_packet());
        }
    }

    /// Resets the station after the client has left.
    pub(crate) fn leave(&mut self, why: What) {
        self.forget();
        self.note(why);
    }

    /// Switches the motors off, and resets everything that the client has set.
    fn forget(&mut self) {
        self.motion = Motion::new(&self.config);
        self.camera.hold();
        self.laser = Laser::new();
        self.sonars = true;
        (self.encoders, self.state) = (Asked::No, Asked::No);
        self.phase = Phase::Waiting(Sync::Zero);
        self.hello = None;
        self.receiver = Receiver::new();
        self.silent = false;
        self.out.clear();
    }

    /// Returns the time since the client last sent a packet, or arrived.
    pub(crate) fn silence(&self, now: Duration) -> Duration {
        now.saturating_sub(self.heard)
    }

    /// Records the arrival of a client, and restarts the measurement of its silence.
    pub(crate) fn come(&mut self, who: What, now: Duration) {
        self.heard = now;
        self.note(who);
    }

    /// Records an event.
    pub(crate) fn note(&mut self, what: What) {
        self.happened.push(what);
    }

    /// Takes the bytes to send.
    pub(crate) fn take_bytes(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// Takes the events that have occurred.
    pub(crate) fn take_happened(&mut self) -> Vec<What> {
        std::mem::take(&mut self.happened)
    }

    pub(crate) fn robot(&self) -> RobotId {
        self.robot
    }

    fn packet(&mut self, world: &mut World, packet: &Packet, now: Duration) {
        self.heard = now;
        self.silent = false;
        match (self.phase, Sync::from_packet(packet)) {
            // A client that starts again, or did not receive the answer.
            (Phase::Waiting(_), Some(Sync::Zero)) => self.echo(Sync::Zero, Sync::One),
            (Phase::Waiting(Sync::One | Sync::Two), Some(Sync::One)) => self.echo(Sync::One, Sync::Two),
            (Phase::Waiting(Sync::Two), Some(Sync::Two)) => self.meet(world),
            // Other packets before the handshake belong to an older session.
            (Phase::Waiting(_), _) => {}
            // The three are also PULSE, OPEN and CLOSE. No client opens an open session. So in this order
            // they are the handshake of another client, whose predecessor left unnoticed.
            (Phase::Open, Some(Sync::Two)) if self.hello == Some(Sync::Two) => {
                self.leave(What::Left("another says hello on its line".to_owned()));
                self.send(Ok(Sync::Zero.to_packet()));
                self.send(Ok(Sync::One.to_packet()));
                self.meet(world);
            }
            (phase, sync) => {
                self.hello = match sync {
                    Some(Sync::Zero) if phase == Phase::Open => Some(Sync::One),
                    Some(Sync::One) if self.hello == Some(Sync::One) => Some(Sync::Two),
                    _ => None,
                };
                self.obey(world, Command::from_packet(packet), now);
            }
        }
    }

    /// Completes the handshake.
    fn meet(&mut self, world: &World) {
        self.send(self.names(world).to_packet());
        self.phase = Phase::Ready;
        self.note(What::Connected);
    }

    fn names(&self, world: &World) -> Names {
        Names {
            name: world.robot_name(self.robot).to_owned(),
            class: self.model.class.clone(),
            subclass: subclass(&self.model),
        }
    }

    fn echo(&mut self, sync: Sync, next: Sync) {
        self.send(Ok(sync.to_packet()));
        self.phase = Phase::Waiting(next);
    }

    /// Returns the pose of the odometry, in the client's frame.
    fn pose(&self, world: &World) -> Pose2 {
        let is = world.odometry(self.robot).pose;
        let (sin, cos) = self.zero.heading.sin_cos();
        let (dx, dy) = (is.x - self.zero.x, is.y - self.zero.y);
        let local = Pose2::new(
            cos * dx + sin * dy,
            cos * dy - sin * dx,
            is.heading - self.zero.heading,
        );
        self.named.compose(local)
    }

    /// Makes `named` the present pose of the robot in the client's frame.
    fn rename(&mut self, world: &World, named: Pose2) {
        self.motion.rename(named.heading - self.pose(world).heading);
        self.named = named;
        self.zero = world.odometry(self.robot).pose;
    }

    fn send(&mut self, packet: Result<Packet, jde_p2os::Error>) {
        // Only names can make a packet too long, and `check_names` has refused such names.
        if let Ok(packet) = packet {
            self.out.extend(packet.to_bytes());
        }
    }
}

impl Asked {
    fn of(often: u16) -> Self {
        match often {
            0 => Self::No,
            1 => Self::Once,
            _ => Self::Always,
        }
    }

    /// Returns whether the packet is wanted now.
    fn take(&mut self) -> bool {
        let wanted = *self != Self::No;
        if *self == Self::Once {
            *self = Self::No;
        }
        wanted
    }
}
