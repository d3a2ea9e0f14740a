//! The loop: it advances the world, admits clients and transfers bytes. One thread does all of it, and never
//! waits for a client.

use core::net::SocketAddr;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::io;
use std::time::Instant;

use jde_p2os::{Model, ModelError};
use jde_sim::{STEP_NS, World, WorldError};
use rustix::event::{PollFd, Timespec, poll};

use crate::endpoint::{Endpoint, EndpointAddress};
use crate::event::{Event, EventKind};
use crate::quota::Quota;
use crate::robot_session::{RobotSession, WATCHDOG};
use crate::world_clock::WorldClock;

/// Most bytes read from one client in a round, so that no client delays the others.
const MAX_READ: usize = 4096;
/// Silence after which a client on a serial line counts as gone, because a serial line does not report that.
const SILENCE_LIMIT: Duration = Duration::from_secs(8);
/// The default model of a robot.
const P3DX: &str = "p3dx";
/// Most steps of the world between two reads of the lines: half of the time between two server information
/// packets.
const MAX_STEPS: usize = 5;
const WORLD_STEP: Duration = Duration::from_nanos(STEP_NS);

/// The settings of a server.
#[derive(Clone, Debug)]
pub struct Options {
    /// The address of the first robot. The others get the following ports, in the order of the world's file.
    /// With port 0 the system chooses every port.
    pub tcp: Option<SocketAddr>,
    /// Whether each robot also has a pseudo-terminal.
    pub terminal: bool,
    /// The models of robots that are not a P3-DX: name and model.
    pub models: Vec<(String, Model)>,
    /// Seconds of the world in one second of the machine.
    pub speed: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            tcp: None,
            terminal: false,
            models: Vec::new(),
            speed: 1.0,
        }
    }
}

/// Why a world cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The world has no robot to serve.
    #[error("the world `{0}` has no robot: add a start, such as [robots.pioneer] start = {{ x = 1, y = 1 }}")]
    NoRobots(String),
    /// Neither TCP nor terminals were requested.
    #[error("no client could connect: serve the robots at a TCP address, at terminals, or both")]
    NoEndpoints,
    /// A model for a robot that the world does not have.
    #[error("the world has no robot `{robot}`; it has {}", known.join(", "))]
    NoSuchRobot {
        /// The requested name.
        robot: String,
        /// The robots of the world.
        known: Vec<String>,
    },
    /// A robot's name, or those of its model, are too long for a packet.
    #[error(
        "the names of robot `{robot}` do not fit into a packet: {error}; give it or its model a shorter name"
    )]
    Names {
        /// The robot.
        robot: String,
        /// The reason.
        error: jde_p2os::Error,
    },
    /// There are more robots than ports.
    #[error("there is no port after 65535 for robot `{0}`: start at a lower one")]
    NoPort(String),
    /// A line could not be opened.
    #[error("robot `{robot}` cannot be served at {place}: {error}")]
    Endpoint {
        /// The robot.
        robot: String,
        /// Its address, or "a pseudo-terminal".
        place: String,
        /// The reason.
        error: io::Error,
    },
    /// The world refused a robot.
    #[error(transparent)]
    World(#[from] WorldError),
    /// A model is invalid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The system could not wait for the lines.
    #[error("cannot wait for clients: {0}")]
    Wait(io::Error),
}

/// The totals of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotStats {
    /// Its name in the world.
    pub robot: String,
    /// Metres driven.
    pub travelled: f64,
    /// How many times it collided with something.
    pub collisions: u64,
    /// Its least distance from anything, m.
    pub min_clearance: f64,
    /// Sessions of clients with it.
    pub sessions: u64,
}

/// A world and the lines to its robots.
pub struct Server {
    world: World,
    robots: Vec<ServedRobot>,
    speed: f64,
}

struct ServedRobot {
    name: String,
    session: RobotSession,
    endpoints: Vec<Endpoint>,
    sessions: u64,
    quota: Quota,
}

impl Server {
    /// Adds all robots of the world at their starts, and opens their lines.
    ///
    /// # Errors
    /// A world without robots, no kind of line requested, models for robots that it does not have, names too
    /// long for a packet, a start that is not free, a line that cannot be opened.
    pub fn open(mut world: World, options: &Options) -> Result<Self, ServerError> {
        let names: Vec<String> = world.robot_names().map(str::to_owned).collect();
        if names.is_empty() {
            return Err(ServerError::NoRobots(world.name().to_owned()));
        }
        if options.tcp.is_none() && !options.terminal {
            return Err(ServerError::NoEndpoints);
        }
        if let Some((robot, _)) = options.models.iter().find(|(name, _)| !names.contains(name)) {
            return Err(ServerError::NoSuchRobot {
                robot: robot.clone(),
                known: names,
            });
        }
        let p3dx = Model::named(P3DX)?;
        let mut robots = Vec::new();
        for (number, name) in names.into_iter().enumerate() {
            let model = options.models.iter().find(|(robot, _)| *robot == name);
            let model = model.map_or(&p3dx, |(_, model)| model).clone();
            let id = world.add_robot(&name, crate::robot_session::robot_config(&model))?;
            let session = RobotSession::new(&world, id, model);
            if let Err(error) = session.check_names(&world) {
                return Err(ServerError::Names { robot: name, error });
            }
            robots.push(ServedRobot {
                session,
                endpoints: open_endpoints(&name, number, options)?,
                sessions: 0,
                quota: Quota::default(),
                name,
            });
        }
        Ok(Self {
            world,
            robots,
            speed: options.speed,
        })
    }

    /// Returns the addresses of each robot, in the order of the world's file. A robot with two lines occurs
    /// twice.
    pub fn addresses(&self) -> impl Iterator<Item = (&str, EndpointAddress)> {
        self.robots.iter().flat_map(|robot| {
            let addresses = robot
                .endpoints
                .iter()
                .filter_map(|endpoint| endpoint.address().ok());
            addresses.map(|address| (robot.name.as_str(), address))
        })
    }

    /// Returns the world in its present state.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the totals of each robot so far.
    pub fn stats(&self) -> Vec<RobotStats> {
        let stats = |robot: &ServedRobot| {
            let truth = self.world.truth(robot.session.robot());
            RobotStats {
                robot: robot.name.clone(),
                travelled: truth.travelled,
                collisions: truth.collisions,
                min_clearance: truth.min_clearance,
                sessions: robot.sessions,
            }
        };
        self.robots.iter().map(stats).collect()
    }

    /// Serves until `stop` is set or `limit` of the machine's time is over, and calls `on_event` with each
    /// event, at most twenty a second for each robot. It reads `stop` once a round, at least every five steps
    /// of the world.
    ///
    /// # Errors
    /// If the system cannot wait for several lines at once.
    pub fn run(
        &mut self,
        stop: &AtomicBool,
        limit: Option<Duration>,
        mut on_event: impl FnMut(&Event),
    ) -> Result<(), ServerError> {
        let start = Instant::now();
        let mut clock = WorldClock::new(Duration::from_nanos(self.world.now()), self.speed);
        while !stop.load(Ordering::Relaxed) && limit.is_none_or(|limit| start.elapsed() < limit) {
            let now = self.step(clock.now());
            clock.limit_backlog(now);
            self.receive_all(now);
            self.send_all();
            self.report(now, start.elapsed(), &mut on_event);
            let next = Duration::from_nanos(self.world.now()) + WORLD_STEP;
            self.wait(clock.until(next))?;
        }
        let time = clock.now();
        for robot in &mut self.robots {
            if let Some(count) = robot.quota.take_dropped() {
                on_event(&robot.event(time, EventKind::EventsDropped(count)));
            }
        }
        Ok(())
    }

    /// Advances the world up to `now`, by at most [`MAX_STEPS`] steps, and returns the time that it has
    /// reached. So a machine that is too slow for the speed still reads its clients in between.
    fn step(&mut self, now: Duration) -> Duration {
        for _ in 0..MAX_STEPS {
            let time = Duration::from_nanos(self.world.now());
            if time + WORLD_STEP > now {
                break;
            }
            for robot in &mut self.robots {
                robot.session.step(&mut self.world, time);
            }
            self.world.advance_to(self.world.now() + STEP_NS);
            for robot in &mut self.robots {
                robot.session.send_due(&self.world, time + WORLD_STEP);
            }
        }
        Duration::from_nanos(self.world.now())
    }

    fn receive_all(&mut self, now: Duration) {
        for robot in &mut self.robots {
            // A client that leaves now makes room for one that arrives now.
            for number in 0..robot.endpoints.len() {
                robot.receive(number, &mut self.world, now);
            }
            robot.accept_clients(now);
        }
    }

    fn send_all(&mut self) {
        for robot in &mut self.robots {
            let bytes = robot.session.take_bytes();
            for endpoint in &mut robot.endpoints {
                if let Err(reason) = endpoint.write(&bytes) {
                    robot.session.end_session(EventKind::ClientLeft(reason));
                }
            }
        }
    }

    fn report(&mut self, now: Duration, elapsed: Duration, on_event: &mut impl FnMut(&Event)) {
        for robot in &mut self.robots {
            if let Some(count) = robot.quota.renew(elapsed) {
                on_event(&robot.event(now, EventKind::EventsDropped(count)));
            }
            for kind in robot.session.take_events() {
                robot.sessions += u64::from(kind == EventKind::Connected);
                if robot.quota.allow() {
                    on_event(&robot.event(now, kind));
                }
            }
        }
    }

    /// Waits until a client arrives or sends bytes, or the time is over.
    fn wait(&self, time: Duration) -> Result<(), ServerError> {
        let poll_fds = self
            .robots
            .iter()
            .flat_map(|robot| robot.endpoints.iter().flat_map(Endpoint::poll_fds));
        let mut poll_fds: Vec<PollFd<'_>> = poll_fds
            .map(|(fd, flags)| PollFd::from_borrowed_fd(fd, flags))
            .collect();
        let time = Timespec::try_from(time).unwrap_or(Timespec {
            tv_sec: 0,
            tv_nsec: STEP_NS as i64,
        });
        match poll(&mut poll_fds, Some(&time)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(ServerError::Wait(error.into())),
        }
    }
}

impl ServedRobot {
    fn event(&self, time: Duration, kind: EventKind) -> Event {
        let robot = self.name.clone();
        Event { time, robot, kind }
    }

    /// Admits the waiting clients, or refuses them.
    fn accept_clients(&mut self, now: Duration) {
        for number in 0..self.endpoints.len() {
            let Some(client) = self.endpoints[number].accept() else {
                continue;
            };
            if self.has_room(now) {
                self.session
                    .begin_session(EventKind::ClientArrived(client.name.clone()), now);
                self.endpoints[number].admit(client);
            } else {
                self.session.push_event(EventKind::ClientRefused(client.name));
            }
        }
    }

    fn receive(&mut self, number: usize, world: &mut World, now: Duration) {
        let endpoint = &mut self.endpoints[number];
        let has_client = endpoint.client_name().is_some();
        let mut buffer = [0; MAX_READ];
        let count = match endpoint.read(&mut buffer) {
            Ok(count) => count,
            Err(reason) => return self.session.end_session(EventKind::ClientLeft(reason)),
        };
        if count > 0 {
            // On a terminal a client appears with its first bytes. The bytes of a refused client are dropped.
            if has_client || self.admit_terminal(number, now) {
                self.session.receive(world, &buffer[..count], now);
            }
        } else if has_client && endpoint.is_terminal() && self.session.silence(now) > SILENCE_LIMIT {
            let reason = endpoint.hang_up("no packet arrived for too long");
            self.session.end_session(EventKind::ClientLeft(reason));
        }
    }

    /// Admits the sender of bytes on a terminal, or refuses it.
    fn admit_terminal(&mut self, number: usize, now: Duration) -> bool {
        let has_room = self.has_room(now);
        let name = self.endpoints[number].name();
        if has_room {
            self.session.begin_session(EventKind::ClientArrived(name), now);
            self.endpoints[number].admit_sender();
        } else {
            self.session.push_event(EventKind::ClientRefused(name));
        }
        has_room
    }

    /// Returns whether another client may connect. A client whose silence has stopped the motors makes room.
    fn has_room(&mut self, now: Duration) -> bool {
        let Some(occupied) = self
            .endpoints
            .iter_mut()
            .find(|endpoint| endpoint.client_name().is_some())
        else {
            return true;
        };
        if self.session.silence(now) <= WATCHDOG {
            return false;
        }
        let reason = occupied.hang_up("it was silent, and another client connected");
        self.session.end_session(EventKind::ClientLeft(reason));
        true
    }
}

/// Opens the lines of robot number `number`, counted from 0.
fn open_endpoints(robot: &str, number: usize, options: &Options) -> Result<Vec<Endpoint>, ServerError> {
    let mut endpoints = Vec::new();
    let failed = |place: String| {
        let robot = robot.to_owned();
        |error| ServerError::Endpoint { robot, place, error }
    };
    if let Some(mut address) = options.tcp {
        if address.port() != 0 {
            let port = u16::try_from(number)
                .ok()
                .and_then(|number| address.port().checked_add(number));
            address.set_port(port.ok_or_else(|| ServerError::NoPort(robot.to_owned()))?);
        }
        endpoints.push(Endpoint::tcp(address).map_err(failed(address.to_string()))?);
    }
    if options.terminal {
        endpoints.push(Endpoint::terminal().map_err(failed("a pseudo-terminal".to_owned()))?);
    }
    Ok(endpoints)
}
