//! Reads a gamepad at the robot, without a window. It commands nothing: `teleop/gamepad` drives with what it exports.

use jde_device::{ConnectionReport, ConnectionState};
use jde_gamepad::{Controls, Link, LinkState, Wanted};
use jde_joy::Joy;
use jde_schema::prelude::*;

/// A gamepad or joystick of this machine.
///
/// Each iteration asks the kernel what is held at that moment. A pad that was unplugged has no value from then on, and is found
/// again when it returns. Of several pads none is taken unless one is named.
#[derive(Describe)]
#[schema(driver, period = "20ms", budget = "10ms")]
pub(crate) struct Gamepad {
    /// Its name; empty for any.
    #[modulation(default = "", fixed)]
    device_name: Modulation<Text<128>>,
    /// Its serial number or radio address, which tells two of a kind apart; empty for any.
    #[modulation(default = "", fixed)]
    serial_number: Modulation<Text<64>>,
    /// Its device file, best a link of /dev/input/by-id or /dev/input/by-path; empty for any.
    #[modulation(default = "", unit = "path", fixed)]
    device: Modulation<Text<256>>,
    /// Part of an axis around its middle that counts as its middle.
    #[modulation(default = 0.1, min = 0.0, max = 0.9)]
    deadzone: Modulation<f64>,
    /// Time after which a pad on which nothing changes has no value: for receivers that do not say that the pad is out of
    /// reach. With 0, never.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 3600.0, fixed)]
    max_silence: Modulation<f64>,
    /// What is held now.
    #[export(validity = "200ms")]
    joy: Export<Joy>,
    /// Whether the pad is connected.
    #[export(lasting)]
    connection: Export<Connection>,
    link: Option<Link>,
    report: ConnectionReport,
    is_exported: bool,
}

impl Schema for Gamepad {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.link.is_none() {
            let wanted = self.wanted(cx);
            let silence = self.max_silence.get(cx);
            let silence = (silence > 0.0).then(|| Duration::from_secs_f64(silence));
            self.link = Some(Link::new(move || jde_gamepad::open(&wanted), silence));
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(link) = &mut self.link else {
            return Err("it is not awake".into());
        };
        let held = link.step(cx.now());
        let state = match link.state() {
            LinkState::Searching => ConnectionState::Connecting,
            LinkState::Open(name) => ConnectionState::Connected(name),
            LinkState::Absent(reason) => ConnectionState::Lost(reason),
        };
        self.report
            .update(cx, &mut self.connection, state, link.attempts());
        match held {
            Some(controls) => {
                let joy = joy(&controls, self.deadzone.get(cx), cx.now());
                self.joy.write(cx, joy);
                self.is_exported = true;
            }
            None if core::mem::take(&mut self.is_exported) => self.joy.retract(cx),
            None => {}
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if self.link.take().is_some() {
            self.report.retract(cx, &mut self.connection);
        }
        self.joy.retract(cx);
        self.is_exported = false;
    }
}

impl Gamepad {
    fn wanted(&self, cx: &Context) -> Wanted {
        Wanted {
            name: self.device_name.get(cx).to_string(),
            serial: self.serial_number.get(cx).to_string(),
            device: self.device.get(cx).to_string(),
        }
    }
}

impl Inspect for Gamepad {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let wanted = self.wanted(cx);
        if let Err(missing) = jde_gamepad::check(&wanted) {
            match () {
                () if !wanted.device.is_empty() => problems.unavailable(&self.device, missing),
                () if !wanted.serial.is_empty() => problems.unavailable(&self.serial_number, missing),
                () => problems.unavailable(&self.device_name, missing),
            }
        }
    }
}

/// The message of ROS.
fn joy(controls: &Controls, deadzone: f64, now: Duration) -> Joy {
    let axes = controls
        .axes
        .iter()
        .map(|axis| without_dead_zone(*axis, deadzone as f32));
    Joy {
        header: Header::new(now, ""),
        axes: axes.take(16).collect(),
        buttons: controls
            .buttons
            .iter()
            .map(|pressed| i32::from(*pressed))
            .take(32)
            .collect(),
    }
}

/// Rescales a position: from 0 at the edge of the dead zone to 1 at the end of the axis.
fn without_dead_zone(position: f32, deadzone: f32) -> f32 {
    let beyond = (position.abs() - deadzone).max(0.0);
    (beyond / (1.0 - deadzone)).copysign(position)
}

jde_schema::export!("gamepad", "Reads a gamepad without a window.", [Gamepad]);

#[cfg(test)]
mod tests;
