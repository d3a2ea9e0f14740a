//! Converts the modulations into a robot to look for. Every mistake in them is an error before a port is
//! opened.

use jde_device::port::{Address, Backoff, Port};
use jde_device::{Device, inspect_port};
use jde_player::{Choice, Interface, Options};
use jde_schema::prelude::*;

use crate::Robot;
use crate::link::Link;

/// The interfaces of each kind of device.
const LASERS: &[Interface] = &[Interface::RANGER, Interface::LASER];
const SONARS: &[Interface] = &[Interface::RANGER, Interface::SONAR];
const BUMPERS: &[Interface] = &[Interface::BUMPER];
const BATTERIES: &[Interface] = &[Interface::POWER];
const HEADS: &[Interface] = &[Interface::HEAD];

impl Robot {
    /// The robot that the modulations describe. Opens no port.
    pub(crate) fn settings(&self, cx: &Context) -> Result<Device<Link>> {
        let options = Options {
            base: u16::try_from(self.base.get(cx))?,
            laser: choice("laser_device", &self.laser_device.get(cx), LASERS)?,
            sonars: choice("sonar_device", &self.sonar_device.get(cx), SONARS)?,
            bumpers: choice("bumper_device", &self.bumper_device.get(cx), BUMPERS)?,
            battery: choice("battery_device", &self.battery_device.get(cx), BATTERIES)?,
            head: choice("head_device", &self.head_device.get(cx), HEADS)?,
        };
        Ok(Device::new(
            Port::new(self.address(cx)?, Backoff::default()),
            options,
        ))
    }

    fn address(&self, cx: &Context) -> Result<Address> {
        let port = self.port.get(cx);
        match Address::parse(port.as_str())? {
            address @ Address::Tcp { .. } => Ok(address),
            Address::Serial { .. } => {
                Err(format!("port = \"{port}\": Player servers are behind TCP: tcp:HOST:6665").into())
            }
        }
    }
}

impl Inspect for Robot {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
        let devices = [
            (&self.laser_device, "laser_device", LASERS),
            (&self.sonar_device, "sonar_device", SONARS),
            (&self.bumper_device, "bumper_device", BUMPERS),
            (&self.battery_device, "battery_device", BATTERIES),
            (&self.head_device, "head_device", HEADS),
        ];
        for (modulation, key, interfaces) in devices {
            problems.expect(modulation, choice(key, &modulation.get(cx), interfaces));
        }
    }
}

fn choice(key: &str, text: &Text<28>, interfaces: &[Interface]) -> Result<Choice> {
    let named = match text.as_str() {
        "auto" => Some(Choice::Auto),
        "none" => Some(Choice::None),
        name => (name.parse::<jde_player::Device>().ok())
            .filter(|device| interfaces.contains(&device.interface))
            .map(Choice::Device),
    };
    named.ok_or_else(|| {
        let names: Vec<String> = interfaces.iter().map(|kind| format!("{kind}:INDEX")).collect();
        format!(
            "{key} = \"{text}\": it can be auto, none or {}",
            names.join(" or ")
        )
        .into()
    })
}
