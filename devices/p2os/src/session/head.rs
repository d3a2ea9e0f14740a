//! The head: one command to the camera at a time, then its reply, or a pause if it cannot reply.

use core::time::Duration;

use super::{Event, HeadSetpoint};
use crate::head::{HeadCommand, HeadFrame, HeadParser, HeadReply, UNIT};
use crate::{AuxPort, Command, SerialAux};

/// How long a reply may take: the camera's tenth of a second, and the round trip over a slow serial line.
const REPLY_TIMEOUT: Duration = Duration::from_millis(400);
/// Time between two commands to a camera that cannot reply.
const ONE_WAY_PAUSE: Duration = Duration::from_millis(150);
/// Time between two requests for the angles. Each takes 50 bytes of a line that carries 960 a second and also
/// the robot's state.
const QUERY_PERIOD: Duration = Duration::from_millis(200);
/// Pause after power-on, and after a reply that reports busy or another error.
const RECOVERY_PAUSE: Duration = Duration::from_millis(500);
/// Unanswered commands after which the camera counts as one that cannot reply.
const MAX_UNANSWERED: u32 = 6;

/// Greatest angles of the camera, units right and left, down and up.
const PAN_UNITS: (f64, f64) = (-875.0, 875.0);
const TILT_UNITS: (f64, f64) = (-267.0, 790.0);
/// Least and greatest speeds, units a second.
const PAN_SPEED: (f64, f64) = (8.0, 800.0);
const TILT_SPEED: (f64, f64) = (8.0, 662.0);

/// One axis, in the units and directions of the camera.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    /// The angle: measured, or computed from the commands.
    position: f64,
    /// The angle last commanded.
    sent: i16,
    /// The speed last commanded.
    speed: u16,
}

/// A camera and the state of its commands.
#[derive(Clone, Debug)]
pub(super) struct HeadChannel {
    has_replies: bool,
    parser: HeadParser,
    /// The commands of the initialization that are still to be sent.
    initialization: &'static [HeadCommand],
    pending: Option<(HeadCommand, Duration)>,
    paused_until: Duration,
    query_at: Duration,
    unanswered: u32,
    pan: Axis,
    tilt: Axis,
    /// The time of the computed angles.
    estimated_at: Duration,
}

/// Power on, control by the line, zero positions.
const INITIALIZATION: &[HeadCommand] = &[HeadCommand::Power(true), HeadCommand::Control, HeadCommand::Init];

impl HeadChannel {
    pub(super) fn new(has_replies: bool, now: Duration) -> Self {
        Self {
            has_replies,
            parser: HeadParser::default(),
            initialization: INITIALIZATION,
            pending: None,
            paused_until: now,
            query_at: now,
            unanswered: 0,
            pan: Axis::default(),
            tilt: Axis::default(),
            estimated_at: now,
        }
    }

    /// Sends the next command, if it is time for one.
    pub(super) fn drive(
        &mut self,
        setpoint: &HeadSetpoint,
        now: Duration,
        mut send: impl FnMut(Command),
    ) -> Option<Event> {
        self.estimate(now);
        let mut warning = None;
        if let Some((_, since)) = &self.pending {
            if now.saturating_sub(*since) < REPLY_TIMEOUT {
                return None;
            }
            self.pending = None;
            self.unanswered += 1;
            if self.unanswered >= MAX_UNANSWERED {
                self.has_replies = false;
                let message = "the camera does not reply; it is commanded without confirmation, and its angles are computed";
                warning = Some(Event::Warning(message.to_owned()));
            }
        }
        if now < self.paused_until {
            return warning;
        }
        let Some(next) = self.next(setpoint, now) else {
            if self.has_replies {
                return warning;
            }
            self.paused_until = now + ONE_WAY_PAUSE;
            return warning.or(Some(self.event()));
        };
        if self.has_replies {
            // Discard unread bytes, then request as many bytes as the reply will have. Both precede the
            // command: its reply may arrive at once, and must not be discarded.
            send(Command::GetAux(0));
            send(Command::GetAux(if next == HeadCommand::GetPanTilt {
                14
            } else {
                6
            }));
        }
        send(Command::Tty2(next.to_bytes()));
        if self.has_replies {
            self.pending = Some((next, now));
        } else {
            self.paused_until = now
                + if self.initialization.is_empty() {
                    ONE_WAY_PAUSE
                } else {
                    RECOVERY_PAUSE
                };
            self.apply(&next);
        }
        warning
    }

    /// Processes bytes that arrived at the auxiliary port.
    pub(super) fn receive(&mut self, aux: &SerialAux, now: Duration) -> Option<Event> {
        if aux.port != AuxPort::One {
            return None;
        }
        let mut frames = Vec::new();
        self.parser.receive(&aux.bytes, |frame| frames.push(frame));
        let mut event = None;
        for frame in frames {
            let HeadFrame::Reply(reply) = frame else {
                continue;
            };
            let Some((command, _)) = self.pending.take() else {
                continue;
            };
            self.unanswered = 0;
            if reply.status != HeadReply::OK {
                self.paused_until = now + RECOVERY_PAUSE;
                continue;
            }
            self.apply(&command);
            if command == HeadCommand::Power(true) {
                self.paused_until = now + RECOVERY_PAUSE;
            }
            if let Some((pan, tilt)) = reply.pan_tilt() {
                (self.pan.position, self.tilt.position) = (pan.into(), tilt.into());
                self.estimated_at = now;
                event = Some(self.event());
            }
        }
        event
    }

    fn event(&self) -> Event {
        Event::Head {
            pan: -self.pan.position * UNIT,
            tilt: -self.tilt.position * UNIT,
        }
    }

    /// Returns the next command: first the initialization, then the changes of the setpoint, then a request
    /// for the angles.
    fn next(&mut self, setpoint: &HeadSetpoint, now: Duration) -> Option<HeadCommand> {
        if let Some(initialization) = self.initialization.first() {
            return Some(initialization.clone());
        }
        let pan = aim(self.pan, -setpoint.pan, setpoint.pan_speed, PAN_UNITS, PAN_SPEED);
        let tilt = aim(
            self.tilt,
            -setpoint.tilt,
            setpoint.tilt_speed,
            TILT_UNITS,
            TILT_SPEED,
        );
        let pan_tilt = HeadCommand::PanTilt {
            pan: pan.sent,
            tilt: tilt.sent,
        };
        if pan.speed != self.pan.speed {
            return Some(HeadCommand::PanSpeed(pan.speed));
        }
        if tilt.speed != self.tilt.speed {
            return Some(HeadCommand::TiltSpeed(tilt.speed));
        }
        if (pan.sent, tilt.sent) != (self.pan.sent, self.tilt.sent) {
            return Some(pan_tilt);
        }
        // A camera that cannot reply receives no requests: its angles are computed.
        if !self.has_replies || now < self.query_at {
            return None;
        }
        self.query_at = now + QUERY_PERIOD;
        Some(HeadCommand::GetPanTilt)
    }

    /// Records a command that was executed.
    fn apply(&mut self, command: &HeadCommand) {
        match command {
            HeadCommand::PanSpeed(speed) => self.pan.speed = *speed,
            HeadCommand::TiltSpeed(speed) => self.tilt.speed = *speed,
            HeadCommand::PanTilt { pan, tilt } => (self.pan.sent, self.tilt.sent) = (*pan, *tilt),
            HeadCommand::Power(_) | HeadCommand::Control | HeadCommand::Init => {
                self.initialization = self.initialization.get(1..).unwrap_or_default();
            }
            HeadCommand::Stop
            | HeadCommand::TiltRange { .. }
            | HeadCommand::GetPanTilt
            | HeadCommand::Zoom(_)
            | HeadCommand::GetZoom
            | HeadCommand::GetMaxZoom
            | HeadCommand::Focus(_)
            | HeadCommand::Other { .. } => {}
        }
    }

    /// Moves the computed angles toward the commanded ones.
    fn estimate(&mut self, now: Duration) {
        let elapsed = now.saturating_sub(self.estimated_at).as_secs_f64();
        self.estimated_at = now;
        for axis in [&mut self.pan, &mut self.tilt] {
            let largest_step = f64::from(axis.speed) * elapsed;
            axis.position += (f64::from(axis.sent) - axis.position).clamp(-largest_step, largest_step);
        }
    }
}

/// Returns the angle and the speed to command for an axis. Without a speed the axis stays at its present
/// angle.
fn aim(axis: Axis, angle: f64, speed: f64, ends: (f64, f64), speeds: (f64, f64)) -> Axis {
    if !(speed.abs() > 0.0 && angle.is_finite()) {
        // An axis that has arrived, up to rounding, keeps its commanded angle to the unit.
        let arrived = (axis.position - f64::from(axis.sent)).abs() < 2.0;
        let sent = if arrived {
            axis.sent
        } else {
            axis.position.round() as i16
        };
        return Axis { sent, ..axis };
    }
    Axis {
        position: axis.position,
        sent: (angle / UNIT).clamp(ends.0, ends.1).round() as i16,
        speed: (speed.abs() / UNIT).clamp(speeds.0, speeds.1).round() as u16,
    }
}
