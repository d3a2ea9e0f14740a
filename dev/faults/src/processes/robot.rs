//! The robot of a case in processes of their own: served by a thread of this process, with its ground truth
//! visible.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context as _, Result};
use jde_p2os_server::{EndpointAddress, Options, Server};
use jde_sim::{Truth, World};
use parking_lot::Mutex;

use crate::application::Root;

/// Time between two reads of the ground truth. At each read the world falls behind real time by up to a step, so
/// the robot is judged by the time of its world.
const POLL_PERIOD: Duration = Duration::from_millis(50);
/// Speed that counts as standing, m/s and rad/s.
const STANDSTILL_SPEED: f64 = 0.01;

/// A robot behind TCP.
pub(super) struct RobotServer {
    /// `tcp:127.0.0.1:4711`.
    pub(super) address: String,
    truth: Arc<Mutex<Option<(f64, Truth)>>>,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Result<()>>,
}

impl RobotServer {
    pub(super) fn serve(root: &Root, seed: u64) -> Result<Self> {
        let file = root.0.join("worlds/office.toml");
        let (sender, receiver) = channel();
        let (stop, truth) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(None)));
        let (is_stopped, newest) = (Arc::clone(&stop), Arc::clone(&truth));
        let thread = std::thread::spawn(move || {
            let world =
                World::load(&file, seed).with_context(|| format!("cannot load {}", file.display()))?;
            let options = Options {
                tcp: Some(SocketAddr::from((Ipv4Addr::LOCALHOST, 0))),
                ..Options::default()
            };
            let mut server = Server::open(world, &options)?;
            let address = server.addresses().find_map(|(_, endpoint)| match endpoint {
                EndpointAddress::Tcp(address) => Some(address),
                _ => None,
            });
            // If this fails, the receiver no longer waits.
            let _ = sender.send(address);
            let robot = server.world().robots().next().map(|(robot, _)| robot);
            let robot = robot.context("the world has no robot")?;
            while !is_stopped.load(Ordering::Relaxed) {
                server.run(&is_stopped, Some(POLL_PERIOD), |_| {})?;
                let world = server.world();
                *newest.lock() = Some((world.now() as f64 / 1e9, world.truth(robot)));
            }
            Ok(())
        });
        let address = receiver
            .recv()
            .ok()
            .flatten()
            .context("the robot is not served")?;
        Ok(Self {
            address: format!("tcp:{address}"),
            truth,
            stop,
            thread,
        })
    }

    /// The world's time, s.
    pub(super) fn time(&self) -> f64 {
        self.truth.lock().as_ref().map_or(0.0, |(time, _)| *time)
    }

    /// The speed, m/s.
    pub(super) fn speed(&self) -> f64 {
        self.read_truth(|truth| truth.twist.linear.abs())
    }

    pub(super) fn is_standing(&self) -> bool {
        self.read_truth(|truth| truth.twist.linear.abs().max(truth.twist.angular.abs())) < STANDSTILL_SPEED
    }

    /// Ends the server; returns its error, if any.
    pub(super) fn stop(self) -> Option<String> {
        self.stop.store(true, Ordering::Relaxed);
        match self.thread.join() {
            Ok(Ok(())) => None,
            Ok(Err(error)) => Some(format!("the robot's server: {error:#}")),
            Err(_) => Some("the robot's server panicked".to_owned()),
        }
    }

    fn read_truth(&self, value: impl Fn(&Truth) -> f64) -> f64 {
        self.truth.lock().as_ref().map_or(0.0, |(_, truth)| value(truth))
    }
}
