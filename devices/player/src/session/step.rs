//! The steps from the greeting to a robot that can be driven. In each, one request waits for its reply.

use std::collections::VecDeque;

use super::options::{Choice, Options};
use super::robot::{Laser, Ring, Robot};
use crate::data;
use crate::geometry::{self, RangerGeometry};
use crate::wire::FixedValue;
use crate::{Device, Error, Interface, Kind, Message, Mount};

/// Requests to the server.
const LIST_DEVICES: u8 = 1;
const CHANGE_SUBSCRIPTION: u8 = 3;
/// Modes of a subscription.
const OPEN_MODE: u32 = 1;
const CLOSE_MODE: u32 = 2;
/// Request to a base: motors on or off.
const SWITCH_MOTORS: u8 = 2;
/// Request for the places of sensors, in all interfaces that are used.
const GET_GEOMETRY: u8 = 1;
/// Request for the limits of a ranger.
const GET_CONFIGURATION: u8 = 5;

/// What is asked at present.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Inquiry {
    Greeting,
    List,
    Subscribe(Device),
    Unsubscribe(Device),
    Motors,
    Geometry(Device),
    Limits(Device, RangerGeometry),
    Done,
}

/// A robot that is being found.
#[derive(Clone, Debug)]
pub(super) struct Search {
    options: Options,
    pub(super) step: Inquiry,
    /// The devices to look at.
    candidates: VecDeque<Device>,
    pub(super) robot: Robot,
    pub(super) warnings: Vec<String>,
}

/// The next step, or why there is none.
type Next = Result<Inquiry, String>;

impl Inquiry {
    /// The request of this step.
    pub(super) fn request(&self, base: Device) -> Option<Message> {
        let server = Interface::SERVER.at(0);
        let (device, subtype, body) = match self {
            Self::Greeting | Self::Done => return None,
            Self::List => (server, LIST_DEVICES, Vec::new()),
            Self::Subscribe(device) => (server, CHANGE_SUBSCRIPTION, subscription(*device, OPEN_MODE)),
            Self::Unsubscribe(device) => (server, CHANGE_SUBSCRIPTION, subscription(*device, CLOSE_MODE)),
            Self::Motors => (base, SWITCH_MOTORS, 1_u32.to_be_bytes().to_vec()),
            Self::Geometry(device) => (*device, GET_GEOMETRY, Vec::new()),
            Self::Limits(device, _) => (*device, GET_CONFIGURATION, Vec::new()),
        };
        Some(Message::to(device, Kind::Request, subtype, body))
    }
}

/// The body of a subscription: address, mode, and an empty name of the driver.
fn subscription(device: Device, mode: u32) -> Vec<u8> {
    let fields = [0, 0, device.interface.0.into(), device.index.into(), mode, 0, 0];
    fields.into_iter().flat_map(u32::to_be_bytes).collect()
}

impl Search {
    pub(super) fn new(options: Options) -> Self {
        Self {
            options,
            step: Inquiry::Greeting,
            candidates: VecDeque::new(),
            robot: Robot {
                version: String::new(),
                base: Interface::BASE.at(options.base),
                driver: String::new(),
                laser: None,
                sonars: None,
                bumpers: None,
                battery: None,
                head: None,
            },
            warnings: Vec::new(),
        }
    }

    /// Returns whether a message is the reply to the request of this step.
    pub(super) fn is_reply(&self, message: &Message) -> bool {
        let is_reply = matches!(message.kind, Kind::Accepted | Kind::Refused);
        is_reply
            && (self.step.request(self.robot.base))
                .is_some_and(|request| (request.device, request.subtype) == (message.device, message.subtype))
    }

    /// Takes the reply to the request of this step and enters the next one.
    ///
    /// # Errors
    /// If this server cannot be used, with the reason.
    pub(super) fn take_reply(&mut self, reply: &Message) -> Result<(), String> {
        let is_accepted = reply.kind == Kind::Accepted;
        let unreadable = |error: Error| error.to_string();
        self.step = match self.step.clone() {
            Inquiry::List => self.take_list(&devices(reply).map_err(unreadable)?)?,
            Inquiry::Subscribe(device) => {
                let (mode, driver) = granted(reply).map_err(unreadable)?;
                self.take_subscription(device, is_accepted && mode == OPEN_MODE, driver)?
            }
            Inquiry::Geometry(device) if is_accepted => {
                self.take_geometry(device, reply).map_err(unreadable)?
            }
            Inquiry::Geometry(device) if device.interface == Interface::RANGER => {
                Inquiry::Limits(device, RangerGeometry::default())
            }
            Inquiry::Geometry(device) => self.assign(device, Vec::new()),
            Inquiry::Limits(device, geometry) => {
                let limits = is_accepted.then(|| data::ranger_config(reply));
                let limits = limits.transpose().map_err(unreadable)?;
                self.assign_ranger(device, &geometry, limits.unwrap_or_default())
            }
            // A base whose motors cannot be switched has none to switch on.
            Inquiry::Motors | Inquiry::Unsubscribe(_) => self.next_candidate(),
            Inquiry::Greeting | Inquiry::Done => return Ok(()),
        };
        Ok(())
    }

    /// Chooses the devices to look at.
    fn take_list(&mut self, list: &[Device]) -> Next {
        let Options {
            laser,
            sonars,
            bumpers,
            battery,
            head,
            ..
        } = self.options;
        let mut candidates = vec![self.robot.base];
        candidates.extend([laser, sonars].into_iter().filter_map(Choice::device));
        if laser == Choice::Auto || sonars == Choice::Auto {
            candidates.extend(of(list, Interface::RANGER));
        }
        let others = [
            (laser, Interface::LASER),
            (sonars, Interface::SONAR),
            (bumpers, Interface::BUMPER),
            (battery, Interface::POWER),
            (head, Interface::HEAD),
        ];
        for (choice, interface) in others {
            match choice {
                Choice::Auto => candidates.extend(of(list, interface).into_iter().take(1)),
                Choice::None => {}
                Choice::Device(device) => candidates.push(device),
            }
        }
        if let Some(missing) = candidates.iter().find(|device| !list.contains(device)) {
            let present: Vec<String> = list.iter().map(Device::to_string).collect();
            return Err(format!("it has no {missing}; it has {}", present.join(", ")));
        }
        for device in candidates {
            if !self.candidates.contains(&device) {
                self.candidates.push_back(device);
            }
        }
        Ok(self.next_candidate())
    }

    fn next_candidate(&mut self) -> Inquiry {
        while let Some(device) = self.candidates.pop_front() {
            if self.is_wanted(device) {
                return Inquiry::Subscribe(device);
            }
        }
        Inquiry::Done
    }

    fn is_wanted(&self, device: Device) -> bool {
        let Options { laser, sonars, .. } = self.options;
        let has_laser = self.robot.laser.is_some() || laser != Choice::Auto;
        let has_sonars = self.robot.sonars.is_some() || sonars != Choice::Auto;
        let is_named = [laser, sonars].contains(&Choice::Device(device));
        is_named
            || match device.interface {
                Interface::RANGER => !has_laser || !has_sonars,
                Interface::LASER => !has_laser,
                Interface::SONAR => !has_sonars,
                _ => true,
            }
    }

    fn take_subscription(&mut self, device: Device, is_granted: bool, driver: String) -> Next {
        if !is_granted && device.interface == Interface::BASE {
            return Err(format!("it refused {device}; its own messages say why"));
        }
        if !is_granted {
            self.warnings.push(format!("the server refused {device}"));
            return Ok(self.next_candidate());
        }
        Ok(match device.interface {
            Interface::BASE => {
                self.robot.driver = driver;
                Inquiry::Motors
            }
            Interface::POWER | Interface::HEAD => self.assign(device, Vec::new()),
            _ => Inquiry::Geometry(device),
        })
    }

    fn take_geometry(&mut self, device: Device, reply: &Message) -> Result<Inquiry, Error> {
        Ok(match device.interface {
            Interface::RANGER => Inquiry::Limits(device, geometry::ranger(reply)?),
            Interface::LASER => self.assign(device, vec![geometry::laser(reply)?]),
            Interface::SONAR => self.assign(device, geometry::sonar(reply)?),
            _ => self.assign(device, geometry::bumpers(reply)?),
        })
    }

    /// Uses a device at these mounts, and goes on to the next one.
    fn assign(&mut self, device: Device, mounts: Vec<Mount>) -> Inquiry {
        match device.interface {
            Interface::LASER => {
                self.robot.laser = Some(Laser {
                    device,
                    mount: mounts.first().copied().unwrap_or_default(),
                    limits: None,
                });
            }
            Interface::SONAR => {
                self.robot.sonars = Some(Ring {
                    device,
                    mounts,
                    view: 0.0,
                    range_min: 0.0,
                    range_max: 0.0,
                });
            }
            Interface::BUMPER => self.robot.bumpers = Some((device, mounts)),
            Interface::POWER => self.robot.battery = Some(device),
            _ => self.robot.head = Some(device),
        }
        self.next_candidate()
    }

    /// Uses a ranger as laser or as sonars, or gives it up.
    fn assign_ranger(
        &mut self,
        device: Device,
        geometry: &RangerGeometry,
        limits: data::RangerConfig,
    ) -> Inquiry {
        let [angle_min, angle_max, _resolution, range_min, range_max] = limits;
        let Options { laser, sonars, .. } = self.options;
        let is_named = |choice: Choice| choice == Choice::Device(device);
        let mounts: Vec<Mount> = (geometry.elements.iter())
            .map(|element| geometry.mount.transform(element))
            .collect();
        let is_array = mounts.len() > 1;
        if is_named(sonars)
            || (sonars == Choice::Auto && is_array && !is_named(laser)) && self.robot.sonars.is_none()
        {
            self.robot.sonars = Some(Ring {
                device,
                mounts,
                view: angle_max - angle_min,
                range_min,
                range_max,
            });
            return self.next_candidate();
        }
        let has_angles = limits.iter().all(|limit| limit.is_finite()) && angle_max > angle_min;
        if is_named(laser) || (laser == Choice::Auto && !is_array) && self.robot.laser.is_none() {
            if has_angles {
                self.robot.laser = Some(Laser {
                    device,
                    mount: *mounts.first().unwrap_or(&geometry.mount),
                    limits: Some([angle_min, angle_max, range_min, range_max]),
                });
                return self.next_candidate();
            }
            self.warnings.push(format!(
                "{device} does not report its angles, so it cannot be the laser"
            ));
        }
        Inquiry::Unsubscribe(device)
    }
}

impl Choice {
    fn device(self) -> Option<Device> {
        match self {
            Self::Device(device) => Some(device),
            Self::Auto | Self::None => None,
        }
    }
}

/// Returns the devices of an interface, the lowest index first.
fn of(list: &[Device], interface: Interface) -> Vec<Device> {
    let mut devices: Vec<Device> = list
        .iter()
        .copied()
        .filter(|device| device.interface == interface)
        .collect();
    devices.sort_unstable();
    devices
}

/// An address in a list: host, port, interface, index.
impl FixedValue for Device {
    const SIZE: usize = 16;

    fn read(bytes: &[u8]) -> Self {
        // Wider numbers name no device of a server.
        let narrow =
            |index: usize| u16::try_from(u32::read(&bytes[4 * index..4 * index + 4])).unwrap_or(u16::MAX);
        Interface(narrow(2)).at(narrow(3))
    }
}

fn devices(reply: &Message) -> Result<Vec<Device>, Error> {
    data::reader(reply).array("devices")
}

/// Returns the mode that was granted, and the name of the driver.
fn granted(reply: &Message) -> Result<(u32, String), Error> {
    let mut reader = data::reader(reply);
    let _device: Device = reader.get("address")?;
    let mode = reader.get("mode")?;
    let name = reader.bytes("name")?;
    let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
    Ok((mode, name[..end].escape_ascii().to_string()))
}
