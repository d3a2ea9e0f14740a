//! Driving by hand: the user's input becomes the modulation `want` of the schemas of the plugin `teleop`. It
//! is renewed under a lease while the control is held (R14), and released at once afterwards. Whether that
//! schema wins is decided by the application (R13).

mod drivable;
mod gamepad;
mod lease;
mod pad;

use std::time::{Duration, Instant};

use eframe::egui::{Label, RichText, Slider, Ui, Vec2};
use jde_core::{Health, State};
use jde_link::Rate;
use jde_link::message::SchemaInfo;
use jde_panel::Ink;
use serde_json::json;

use super::sensors::Sensors;
use super::table;
use crate::session::WindowSession;
use crate::style::{self, Style};
use drivable::DrivableSchemas;
use gamepad::Gamepads;
use lease::DriveLease;
use pad::Pad;

/// Initial speed, in m/s: walking slowly.
const WALKING_SPEED: f64 = 0.3;
/// How long a refusal is shown.
const REFUSAL_SHOWN: Duration = Duration::from_secs(6);

/// The part of the window for driving by hand.
pub(super) struct ManualDrive {
    /// Whether driving is switched on.
    on: bool,
    since: Instant,
    /// Speed at full deflection of a pad, in m/s.
    speed: f64,
    base: DriveLease,
    head: DriveLease,
    gamepads: Option<Gamepads>,
}

/// The maximum speeds that a schema allows.
#[derive(Clone, Copy)]
struct MaxSpeeds {
    /// In m/s.
    fast: f64,
    /// In rad/s.
    turn: f64,
}

/// The positions of a gamepad's sticks, while a shoulder button is held.
#[derive(Clone, Copy, Default)]
struct Sticks {
    drive: Option<Vec2>,
    head: Option<Vec2>,
}

impl ManualDrive {
    pub(super) fn new(speed: Option<f64>) -> Self {
        Self {
            on: false,
            since: Instant::now(),
            speed: speed
                .filter(|speed| speed.is_finite() && *speed > 0.0)
                .unwrap_or(WALKING_SPEED),
            base: DriveLease::default(),
            head: DriveLease::default(),
            gamepads: None,
        }
    }

    /// Speed at full deflection of a pad, in m/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Shows the controls, and orders what the user drives.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &WindowSession, senses: &Sensors, style: &Style) {
        let DrivableSchemas { base, head } =
            DrivableSchemas::of(&session.schemas().schemas, &senses.body, &senses.bodies);
        let Some(base) = base else {
            self.stop(session);
            drivable::advice(ui, session, &senses.body);
            return;
        };
        ui.horizontal(|ui| {
            let was_on = self.on;
            ui.add_enabled_ui(!session.is_recording() && !session.is_over(), |ui| {
                ui.toggle_value(&mut self.on, "Drive")
                    .on_hover_text(
                        "Drive by hand: while this is off, no mouse, key or gamepad moves the robot",
                    )
                    .on_disabled_hover_text("Only a running application can be driven");
            });
            self.on &= !session.is_recording() && !session.is_over();
            if self.on && !was_on {
                self.since = Instant::now();
            }
            let (text, color) = self.status(session, senses, base, style);
            let text = RichText::new(text).color(style::color_of(color, style));
            // A long text must not move the pad from under the mouse. It is whole in the tooltip.
            ui.add(Label::new(text).truncate());
        });
        self.refusals(ui, session, style);
        if !self.on {
            self.stop(session);
            self.gamepads = None;
            return;
        }
        let limits = MaxSpeeds::of(session, base);
        let head = head.map(|head| (head, number(session, head, "turn")));
        let Some(limits) = limits else {
            // Without limits, the scale of the pad is not known. The chosen speed is kept.
            self.stop(session);
            ui.weak(format!("waiting for the limits of {}", base.name));
            return;
        };
        if limits.fast <= 0.0 {
            self.stop(session);
            ui.weak(format!("{} does not move while its `fast` is 0", base.name));
            return;
        }
        self.slider(ui, limits.fast, style);
        let sticks = self.gamepads.get_or_insert_default().sticks(ui);
        let (drive, gaze) = pads(ui, head.is_some_and(|(_, turn)| turn.is_some()), style);
        let speed = self.speed.min(limits.fast);
        let want = drive.or(sticks.drive).map(|push| {
            json!({
                "twist": {
                    "linear": { "x": f64::from(push.y) * speed, "y": 0.0, "z": 0.0 },
                    "angular": { "x": 0.0, "y": 0.0, "z": f64::from(-push.x) * limits.turn * speed / limits.fast },
                },
                "wanted": true,
            })
        });
        self.base.order(ui, session, &base.name, want);
        if let Some((head, Some(turn))) = head {
            let want = gaze.or(sticks.head).map(|push| {
                json!({
                    "pan": f64::from(-push.x) * turn,
                    "tilt": f64::from(-push.y) * turn,
                    "wanted": true,
                })
            });
            self.head.order(ui, session, &head.name, want);
        }
    }

    /// Releases all holds.
    fn stop(&mut self, session: &WindowSession) {
        self.base.let_go(session);
        self.head.let_go(session);
    }

    /// Shows the slider of the speed. It is limited by a slow robot, but keeps the chosen speed for a faster
    /// one.
    fn slider(&mut self, ui: &mut Ui, fast: f64, style: &Style) {
        let (most, unit) = style.units.convert(fast, "m/s");
        let factor = most / fast;
        let mut shown = self.speed.min(fast) * factor;
        let slider = Slider::new(&mut shown, 0.0..=most)
            .text("Speed")
            .suffix(format!(" {unit}"))
            .max_decimals(2);
        let response = ui
            .add(slider)
            .on_hover_text("The speed at full deflection of the pad; the turn rate scales with it");
        if response.changed() {
            self.speed = shown / factor;
        }
    }

    /// Returns a text that names the schema in control, and its color.
    fn status(
        &self,
        session: &WindowSession,
        senses: &Sensors,
        base: &SchemaInfo,
        style: &Style,
    ) -> (String, Ink) {
        let Some(view) = session.view(&base.name) else {
            return (format!("no state of {} has arrived", base.name), Ink::Warn);
        };
        if let Health::Faulted(reason) = &view.health {
            return (format!("{} has failed: {reason}", base.name), Ink::Bad);
        }
        if let Some(stop) = view.stop() {
            return (format!("{} was {stop}", base.name), Ink::Warn);
        }
        let is_held = self.base.holds() || self.head.holds();
        if view.authority && view.state == State::Winner {
            let speed = senses.commanded.value().map(|twist| table::speed(twist, style));
            let text = match (is_held, speed) {
                (true, Some(speed)) => format!("driving: {speed}"),
                (true, None) => "driving".to_owned(),
                (false, _) => format!("{} follows another operator", base.name),
            };
            return (text, if is_held { Ink::Accent } else { Ink::Warn });
        }
        match winner(session) {
            Some(winner) if is_held => (format!("waiting: {winner} has control"), Ink::Warn),
            Some(winner) => (format!("{winner} has control"), Ink::Plain),
            None => ("no schema drives".to_owned(), Ink::Faint),
        }
    }

    /// Shows the last refusal since driving was switched on.
    fn refusals(&self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        let refused = session
            .notices()
            .into_iter()
            .rev()
            .find(|notice| notice.at >= self.since && notice.at.elapsed() < REFUSAL_SHOWN);
        if let (true, Some(refused)) = (self.on, refused) {
            ui.colored_label(style::color_of(Ink::Bad, style), refused.text);
        }
    }
}

impl MaxSpeeds {
    /// Reads the limits. `None` until they have arrived.
    fn of(session: &WindowSession, base: &SchemaInfo) -> Option<Self> {
        Some(Self {
            fast: number(session, base, "fast")?,
            turn: number(session, base, "turn")?.max(0.0),
        })
    }
}

fn number(session: &WindowSession, schema: &SchemaInfo, modulation: &str) -> Option<f64> {
    let name = format!("{}.{modulation}", schema.name);
    session.read::<f64>(&name, Rate::Hz(2)).map(|(number, _)| number)
}

/// The winner of the roots.
fn winner(session: &WindowSession) -> Option<&str> {
    let snapshot = session.snapshot();
    let roots = snapshot.groups.iter().find(|group| group.father.is_none())?;
    Some(snapshot.schemas.get(roots.winner?)?.name.as_str())
}

/// Shows the pads, side by side if there is space. Returns their deflections.
fn pads(ui: &mut Ui, head: bool, style: &Style) -> (Option<Vec2>, Option<Vec2>) {
    let (mut drive, mut gaze) = (None, None);
    let width = ui.available_width();
    let side = if head {
        (0.5 * width - 8.0).clamp(110.0, 170.0)
    } else {
        width.clamp(110.0, 170.0)
    };
    ui.horizontal_wrapped(|ui| {
        let pad = Pad {
            name: "Drive pad",
            labels: ["right", "left", "ahead", "back"],
            side,
        };
        drive = pad.show(ui, style);
        if head {
            let pad = Pad {
                name: "Look pad",
                labels: ["right", "left", "look up", "down"],
                side,
            };
            gaze = pad.show(ui, style);
        }
    });
    ui.weak("Arrows or WASD while a pad has the focus, Space holds the robot still");
    (drive, gaze)
}
