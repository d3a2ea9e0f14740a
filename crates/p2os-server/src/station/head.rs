//! The pan-tilt camera at a robot's first auxiliary port: a VC-C4 that executes and answers every frame.
//!
//! The camera's positive directions are right and up, the world's are left and down.

use std::collections::VecDeque;

use jde_p2os::{AuxPort, HEAD_UNIT, HeadAnswer, HeadCommand, HeadFrame, HeadParser, MOST_ZOOM, SerialAux};
use jde_sim::{Head, HeadConfig};

/// Most bytes of answers that wait to be requested.
const MOST_SAID: usize = 190;
/// The status of an unknown command.
const UNKNOWN: u8 = 0x35;

/// The camera, and the buffer of its port.
#[derive(Debug)]
pub(crate) struct Camera {
    parser: HeadParser,
    /// Bytes of answers that the client has not fetched.
    said: VecDeque<u8>,
    /// The number of bytes that the client has requested.
    wanted: usize,
    on: bool,
    /// The last command to the head.
    aim: jde_sim::HeadCommand,
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
            said: VecDeque::new(),
            wanted: 0,
            on: false,
            aim: jde_sim::HeadCommand::default(),
            speeds: [config.max_pan_speed, config.max_tilt_speed],
            tilts: [units(-config.max_tilt_down), units(config.max_tilt_up)],
            zoom: 0,
        }
    }

    /// Processes bytes at the port, while the head has the angles of `head`.
    pub(crate) fn hear(&mut self, bytes: &[u8], head: Head) {
        let mut parser = std::mem::take(&mut self.parser);
        parser.receive(bytes, |frame| match frame {
            HeadFrame::Command(command) => {
                let answer = self.obey(&command, head);
                let room = MOST_SAID - self.said.len();
                // Bytes that exceed the buffer are lost, as in a real one.
                self.said.extend(answer.to_bytes().into_iter().take(room));
            }
            HeadFrame::Answer(_) => {}
        });
        self.parser = parser;
    }

    /// Requests `count` bytes of the answers; 0 discards all of them.
    pub(crate) fn ask(&mut self, count: u16) {
        self.wanted = usize::from(count).min(MOST_SAID);
        if count == 0 {
            self.said.clear();
        }
    }

    /// Returns the requested bytes, once they have all arrived.
    pub(crate) fn answer(&mut self) -> Option<SerialAux> {
        if self.wanted == 0 || self.said.len() < self.wanted {
            return None;
        }
        let bytes = self.said.drain(..std::mem::take(&mut self.wanted)).collect();
        Some(SerialAux {
            port: AuxPort::One,
            bytes,
        })
    }

    /// Returns the present command to the head.
    pub(crate) fn command(&self) -> jde_sim::HeadCommand {
        self.aim
    }

    /// Stops the head where it is.
    pub(crate) fn hold(&mut self) {
        self.aim = jde_sim::HeadCommand::default();
    }

    fn obey(&mut self, command: &HeadCommand, head: Head) -> HeadAnswer {
        match command {
            HeadCommand::Power(on) => {
                self.on = *on;
                self.hold();
            }
            // A simulated world is always in focus.
            HeadCommand::Control | HeadCommand::Focus(_) => {}
            HeadCommand::Init => self.aim_at(0.0, 0.0),
            HeadCommand::PanSpeed(speed) => {
                self.speeds[0] = f64::from(*speed) * HEAD_UNIT;
                self.aim.pan_speed = self.aim.pan_speed.min(self.speeds[0]);
            }
            HeadCommand::TiltSpeed(speed) => {
                self.speeds[1] = f64::from(*speed) * HEAD_UNIT;
                self.aim.tilt_speed = self.aim.tilt_speed.min(self.speeds[1]);
            }
            HeadCommand::Stop => self.hold(),
            HeadCommand::PanTilt { pan, tilt } => {
                let [least, most] = self.tilts;
                self.aim_at(-radians(*pan), -radians((*tilt).clamp(least, most)));
            }
            HeadCommand::TiltRange { least, most } => self.tilts = [*least, *most],
            HeadCommand::Where => return HeadAnswer::place(units(-head.pan), units(-head.tilt)),
            HeadCommand::Zoom(zoom) => self.zoom = (*zoom).min(MOST_ZOOM),
            HeadCommand::Zoomed => return HeadAnswer::zoom(self.zoom),
            HeadCommand::MostZoom => return HeadAnswer::zoom(MOST_ZOOM),
            HeadCommand::Other { .. } => {
                return HeadAnswer {
                    status: UNKNOWN,
                    data: Vec::new(),
                };
            }
        }
        HeadAnswer::done()
    }

    fn aim_at(&mut self, pan: f64, tilt: f64) {
        if self.on {
            self.aim = jde_sim::HeadCommand {
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
        camera.hear(&HeadCommand::Power(true).to_bytes(), Head::default());
        camera
    }

    #[test]
    fn to_the_right_and_up_of_the_camera_are_negative_for_the_world() {
        let mut camera = camera();
        let right_and_up = HeadCommand::PanTilt { pan: 400, tilt: 100 };
        camera.hear(&right_and_up.to_bytes(), Head::default());
        let aim = camera.command();
        assert!((aim.pan + 45f64.to_radians()).abs() < 1e-9, "{aim:?}");
        assert!((aim.tilt + 11.25f64.to_radians()).abs() < 1e-9, "{aim:?}");
        assert!(aim.pan_speed > 0.0 && aim.tilt_speed > 0.0);
        camera.hear(&HeadCommand::Stop.to_bytes(), Head::default());
        assert_eq!(camera.command(), jde_sim::HeadCommand::default());
    }

    #[test]
    fn a_camera_that_is_off_does_not_turn() {
        let mut camera = Camera::new(&HeadConfig::default());
        let aside = HeadCommand::PanTilt { pan: 400, tilt: 0 };
        camera.hear(&aside.to_bytes(), Head::default());
        assert_eq!(camera.command(), jde_sim::HeadCommand::default());
    }

    #[test]
    fn answers_come_when_they_are_asked_for_and_whole() {
        let mut camera = camera();
        assert_eq!(camera.answer(), None);
        camera.ask(0);
        camera.ask(6);
        assert_eq!(camera.answer(), None, "it was forgotten");
        let [first, rest @ ..] = &HeadCommand::Control.to_bytes()[..] else {
            panic!("a frame has bytes")
        };
        camera.hear(&[*first], Head::default());
        assert_eq!(camera.answer(), None);
        camera.hear(rest, Head::default());
        let answer = camera.answer().expect("six bytes");
        assert_eq!(answer.bytes, [0xFE, 0x30, 0x30, 0x30, 0x00, 0xEF]);
        assert_eq!(camera.answer(), None, "it was fetched");
    }

    #[test]
    fn it_tells_where_it_looks() {
        let mut camera = camera();
        camera.ask(0);
        let head = Head {
            pan: -30f64.to_radians(),
            tilt: 9f64.to_radians(),
            ..Head::default()
        };
        camera.hear(&HeadCommand::Where.to_bytes(), head);
        camera.ask(14);
        let bytes = camera.answer().expect("a place").bytes;
        let Ok(HeadFrame::Answer(answer)) = HeadFrame::from_bytes(&bytes) else {
            panic!("{bytes:02x?}")
        };
        assert_eq!(answer.pan_tilt(), Some((267, -80)));
    }

    #[test]
    fn it_tilts_within_the_range_that_was_set() {
        let mut camera = camera();
        let range = HeadCommand::TiltRange {
            least: -100,
            most: 200,
        };
        camera.hear(&range.to_bytes(), Head::default());
        for (wanted, allowed) in [(300, 200), (-150, -100), (50, 50)] {
            let place = HeadCommand::PanTilt { pan: 0, tilt: wanted };
            camera.hear(&place.to_bytes(), Head::default());
            assert_eq!(units(-camera.command().tilt), allowed);
        }
    }

    #[test]
    fn it_tells_how_far_it_zoomed_and_how_far_it_can() {
        let mut camera = camera();
        let mut told = |first: HeadCommand, asked: HeadCommand| {
            camera.hear(&first.to_bytes(), Head::default());
            camera.ask(0);
            camera.hear(&asked.to_bytes(), Head::default());
            camera.ask(10);
            camera.answer().expect("ten bytes").bytes
        };
        for (set, is) in [(0, 0), (700, 700), (9000, 1960)] {
            let bytes = told(HeadCommand::Zoom(set), HeadCommand::Zoomed);
            assert_eq!(bytes, HeadAnswer::zoom(is).to_bytes());
        }
        let bytes = told(HeadCommand::Control, HeadCommand::MostZoom);
        assert_eq!(bytes, HeadAnswer::zoom(1960).to_bytes());
    }

    #[test]
    fn a_port_that_nobody_reads_holds_no_more_than_it_can() {
        let mut camera = camera();
        for _ in 0..1000 {
            camera.hear(&HeadCommand::Control.to_bytes(), Head::default());
        }
        assert!(camera.said.len() <= MOST_SAID);
    }
}
