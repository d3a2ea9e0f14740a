//! The pan-tilt camera at a robot's first auxiliary port: a VC-C4 that executes every frame and replies to
//! it.
//!
//! The camera's positive directions are right and up, the world's are left and down.

use std::collections::VecDeque;

use jde_p2os::{AuxPort, HEAD_UNIT, HeadCommand, HeadFrame, HeadParser, HeadReply, MAX_ZOOM, SerialAux};
use jde_sim::{Head, HeadConfig};

/// Most bytes of replies that wait to be requested.
const MAX_REPLY_BYTES: usize = 190;
/// The status of an unknown command.
const UNKNOWN_COMMAND: u8 = 0x35;

/// The camera, and the buffer of its port.
#[derive(Debug)]
pub(crate) struct Camera {
    parser: HeadParser,
    /// Bytes of replies that the client has not fetched.
    reply_bytes: VecDeque<u8>,
    /// The number of bytes that the client has requested.
    requested: usize,
    on: bool,
    /// The last command to the head.
    target: jde_sim::HeadCommand,
    /// rad/s, as last set.
    speeds: [f64; 2],
    /// The least and the greatest tilt, units up, as last set.
    tilts: [i16; 2],
    /// As last set. It has no effect: no picture is taken through this camera.
    zoom: u16,
}

impl Camera {
    /// Switched off, at full speed, with the full range of tilt and no zoom.
    pub(crate) fn new(config: &HeadConfig) -> Self {
        Self {
            parser: HeadParser::default(),
            reply_bytes: VecDeque::new(),
            requested: 0,
            on: false,
            target: jde_sim::HeadCommand::default(),
            speeds: [config.max_pan_speed, config.max_tilt_speed],
            tilts: [units(-config.max_tilt_down), units(config.max_tilt_up)],
            zoom: 0,
        }
    }

    /// Processes bytes at the port, while the head has the angles of `head`.
    pub(crate) fn receive(&mut self, bytes: &[u8], head: Head) {
        let mut parser = std::mem::take(&mut self.parser);
        parser.receive(bytes, |frame| match frame {
            HeadFrame::Command(command) => {
                let reply = self.execute(&command, head);
                let capacity = MAX_REPLY_BYTES - self.reply_bytes.len();
                // Bytes that exceed the buffer are lost, as in a real one.
                self.reply_bytes
                    .extend(reply.to_bytes().into_iter().take(capacity));
            }
            HeadFrame::Reply(_) => {}
        });
        self.parser = parser;
    }

    /// Requests `count` bytes of the replies; 0 discards all of them.
    pub(crate) fn request(&mut self, count: u16) {
        self.requested = usize::from(count).min(MAX_REPLY_BYTES);
        if count == 0 {
            self.reply_bytes.clear();
        }
    }

    /// Returns the requested bytes, once they have all arrived.
    pub(crate) fn take_reply(&mut self) -> Option<SerialAux> {
        if self.requested == 0 || self.reply_bytes.len() < self.requested {
            return None;
        }
        let bytes = self
            .reply_bytes
            .drain(..std::mem::take(&mut self.requested))
            .collect();
        Some(SerialAux {
            port: AuxPort::One,
            bytes,
        })
    }

    /// Returns the present command to the head.
    pub(crate) fn command(&self) -> jde_sim::HeadCommand {
        self.target
    }

    /// Stops the head at its present angles.
    pub(crate) fn stop(&mut self) {
        self.target = jde_sim::HeadCommand::default();
    }

    fn execute(&mut self, command: &HeadCommand, head: Head) -> HeadReply {
        match command {
            HeadCommand::Power(on) => {
                self.on = *on;
                self.stop();
            }
            // A simulated world is always in focus.
            HeadCommand::Control | HeadCommand::Focus(_) => {}
            HeadCommand::Init => self.set_target(0.0, 0.0),
            HeadCommand::PanSpeed(speed) => {
                self.speeds[0] = f64::from(*speed) * HEAD_UNIT;
                self.target.pan_speed = self.target.pan_speed.min(self.speeds[0]);
            }
            HeadCommand::TiltSpeed(speed) => {
                self.speeds[1] = f64::from(*speed) * HEAD_UNIT;
                self.target.tilt_speed = self.target.tilt_speed.min(self.speeds[1]);
            }
            HeadCommand::Stop => self.stop(),
            HeadCommand::PanTilt { pan, tilt } => {
                let [min, max] = self.tilts;
                self.set_target(-radians(*pan), -radians((*tilt).clamp(min, max)));
            }
            HeadCommand::TiltRange { min, max } => self.tilts = [*min, *max],
            HeadCommand::GetPanTilt => return HeadReply::position(units(-head.pan), units(-head.tilt)),
            HeadCommand::Zoom(zoom) => self.zoom = (*zoom).min(MAX_ZOOM),
            HeadCommand::GetZoom => return HeadReply::zoom(self.zoom),
            HeadCommand::GetMaxZoom => return HeadReply::zoom(MAX_ZOOM),
            HeadCommand::Other { .. } => {
                return HeadReply {
                    status: UNKNOWN_COMMAND,
                    data: Vec::new(),
                };
            }
        }
        HeadReply::success()
    }

    fn set_target(&mut self, pan: f64, tilt: f64) {
        if self.on {
            self.target = jde_sim::HeadCommand {
                pan,
                tilt,
                pan_speed: self.speeds[0],
                tilt_speed: self.speeds[1],
            };
        }
    }
}

fn radians(units: i16) -> f64 {
    f64::from(units) * HEAD_UNIT
}

fn units(radians: f64) -> i16 {
    (radians / HEAD_UNIT).round() as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        let mut camera = Camera::new(&HeadConfig::default());
        camera.receive(&HeadCommand::Power(true).to_bytes(), Head::default());
        camera
    }

    #[test]
    fn right_and_up_of_the_camera_are_negative_in_the_world() {
        let mut camera = camera();
        let right_and_up = HeadCommand::PanTilt { pan: 400, tilt: 100 };
        camera.receive(&right_and_up.to_bytes(), Head::default());
        let target = camera.command();
        assert!((target.pan + 45f64.to_radians()).abs() < 1e-9, "{target:?}");
        assert!((target.tilt + 11.25f64.to_radians()).abs() < 1e-9, "{target:?}");
        assert!(target.pan_speed > 0.0 && target.tilt_speed > 0.0);
        camera.receive(&HeadCommand::Stop.to_bytes(), Head::default());
        assert_eq!(camera.command(), jde_sim::HeadCommand::default());
    }

    #[test]
    fn a_camera_that_is_off_does_not_turn() {
        let mut camera = Camera::new(&HeadConfig::default());
        let aside = HeadCommand::PanTilt { pan: 400, tilt: 0 };
        camera.receive(&aside.to_bytes(), Head::default());
        assert_eq!(camera.command(), jde_sim::HeadCommand::default());
    }

    #[test]
    fn replies_are_returned_complete_and_only_on_request() {
        let mut camera = camera();
        assert_eq!(camera.take_reply(), None);
        camera.request(0);
        camera.request(6);
        assert_eq!(camera.take_reply(), None, "the earlier reply was discarded");
        let [first, rest @ ..] = &HeadCommand::Control.to_bytes()[..] else {
            panic!("a frame has bytes")
        };
        camera.receive(&[*first], Head::default());
        assert_eq!(camera.take_reply(), None);
        camera.receive(rest, Head::default());
        let reply = camera.take_reply().expect("six bytes");
        assert_eq!(reply.bytes, [0xFE, 0x30, 0x30, 0x30, 0x00, 0xEF]);
        assert_eq!(camera.take_reply(), None, "the reply was already fetched");
    }

    #[test]
    fn a_reply_contains_the_angles() {
        let mut camera = camera();
        camera.request(0);
        let head = Head {
            pan: -30f64.to_radians(),
            tilt: 9f64.to_radians(),
            ..Head::default()
        };
        camera.receive(&HeadCommand::GetPanTilt.to_bytes(), head);
        camera.request(14);
        let bytes = camera.take_reply().expect("angles").bytes;
        let Ok(HeadFrame::Reply(reply)) = HeadFrame::from_bytes(&bytes) else {
            panic!("{bytes:02x?}")
        };
        assert_eq!(reply.pan_tilt(), Some((267, -80)));
    }

    #[test]
    fn the_tilt_stays_within_the_configured_range() {
        let mut camera = camera();
        let range = HeadCommand::TiltRange { min: -100, max: 200 };
        camera.receive(&range.to_bytes(), Head::default());
        for (tilt, allowed) in [(300, 200), (-150, -100), (50, 50)] {
            let command = HeadCommand::PanTilt { pan: 0, tilt };
            camera.receive(&command.to_bytes(), Head::default());
            assert_eq!(units(-camera.command().tilt), allowed);
        }
    }

    #[test]
    fn replies_contain_the_present_and_the_greatest_zoom() {
        let mut camera = camera();
        let mut reply_to = |first: HeadCommand, query: HeadCommand| {
            camera.receive(&first.to_bytes(), Head::default());
            camera.request(0);
            camera.receive(&query.to_bytes(), Head::default());
            camera.request(10);
            camera.take_reply().expect("ten bytes").bytes
        };
        for (zoom, expected) in [(0, 0), (700, 700), (9000, 1960)] {
            let bytes = reply_to(HeadCommand::Zoom(zoom), HeadCommand::GetZoom);
            assert_eq!(bytes, HeadReply::zoom(expected).to_bytes());
        }
        let bytes = reply_to(HeadCommand::Control, HeadCommand::GetMaxZoom);
        assert_eq!(bytes, HeadReply::zoom(1960).to_bytes());
    }

    #[test]
    fn the_buffer_of_an_unread_port_is_bounded() {
        let mut camera = camera();
        for _ in 0..1000 {
            camera.receive(&HeadCommand::Control.to_bytes(), Head::default());
        }
        assert!(camera.reply_bytes.len() <= MAX_REPLY_BYTES);
    }
}
