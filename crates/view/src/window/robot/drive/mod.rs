//! Driving by hand: what a person wants becomes the modulation `want` of the application's schemas of the plugin `teleop`, written
//! again and again under a lease while a hand is there (R14), and let go of as soon as it is not. Who drives is decided there (R13).

#[cfg(feature = "gamepad")]
mod gamepad;
mod pad;

use std::time::{Duration, Instant};

use eframe::egui::{self, Slider, Ui, Vec2};
use jde_core::{Health, State};
use jde_host::snapshot::HoldKind;
use jde_link::Rate;
use jde_link::message::{Action, SchemaInfo};
use jde_panel::Ink;
use serde_json::{Value, json};

use super::senses::Senses;
use super::table;
use crate::look::{self, Look};
use crate::session::Session;
use pad::Pad;

/// The type of schema that drives a base, and that which turns a head.
const BASE: &str = "teleop/base";
const HEAD: &str = "teleop/head";
/// What is wanted is changed no more often: a robot's base takes no notice of more.
const BEAT: Duration = Duration::from_millis(40);
/// A hand that rests is told of so often, well within the patience of a schema that is driven.
const AGAIN: Duration = Duration::from_millis(100);
/// Speed at first, m/s: about that of a person who looks around.
const WALK: f64 = 0.3;
/// A refusal is shown for so long.
const SHOWN: Duration = Duration::from_secs(6);

/// The part of the window in which a person drives.
pub(super) struct Drive {
    /// Whether hands count at all.
    on: bool,
    since: Instant,
    /// Speed of a pad pushed all the way, m/s.
    speed: f64,
    base: Grip,
    head: Grip,
    #[cfg(feature = "gamepad")]
    gamepads: Option<gamepad::Gamepads>,
}

/// What a hand holds of one schema.
#[derive(Default)]
struct Grip {
    held: Option<Held>,
}

struct Held {
    schema: String,
    want: Value,
    since: Instant,
}

/// What the sticks of a game pad want.
#[derive(Clone, Copy, Default)]
struct Sticks {
    drive: Option<Vec2>,
    look: Option<Vec2>,
}

impl Drive {
    pub(super) fn new(speed: Option<f64>) -> Self {
        Self {
            on: false,
            since: Instant::now(),
            speed: speed.filter(|speed| speed.is_finite()).unwrap_or(WALK),
            base: Grip::default(),
            head: Grip::default(),
            #[cfg(feature = "gamepad")]
            gamepads: None,
        }
    }

    /// Speed of a pad pushed all the way, m/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Shows it, and orders what a hand wants.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, senses: &Senses, look: &Look) {
        let base = driver(session, BASE, &senses.body);
        let head = driver(session, HEAD, &senses.body);
        let Some(base) = base else {
            self.stop(session);
            advice(ui, session, &senses.body);
            return;
        };
        ui.horizontal(|ui| {
            let was = self.on;
            ui.add_enabled_ui(!session.is_recording() && !session.is_gone(), |ui| {
                ui.toggle_value(&mut self.on, "Drive")
                    .on_hover_text("Drive by hand: off, no mouse, key or game pad moves the robot")
                    .on_disabled_hover_text("Nobody drives what does not run");
            });
            self.on &= !session.is_recording() && !session.is_gone();
            if self.on && !was {
                self.since = Instant::now();
            }
            let (words, ink) = self.status(session, senses, base, look);
            ui.colored_label(look::ink(ink, look), words);
        });
        self.refusals(ui, session, look);
        if !self.on {
            self.stop(session);
            #[cfg(feature = "gamepad")]
            {
                self.gamepads = None;
            }
            return;
        }
        let limits = limits(session, base);
        self.slider(ui, limits, look);
        let sticks = self.sticks(ui);
        let (drive, gaze) = pads(ui, head.is_some(), look);
        let share = (self.speed / limits.0).clamp(0.0, 1.0);
        let want = drive.or(sticks.drive).map(|push| {
            json!({
                "twist": {
                    "linear": { "x": f64::from(push.y) * self.speed, "y": 0.0, "z": 0.0 },
                    "angular": { "x": 0.0, "y": 0.0, "z": f64::from(-push.x) * limits.1 * share },
                },
                "wanted": true,
            })
        });
        self.base.order(ui, session, &base.name, want);
        if let Some(head) = head {
            let turn = number(session, head, "turn").unwrap_or(0.5);
            let want = gaze.or(sticks.look).map(|push| {
                json!({
                    "pan": f64::from(-push.x) * turn,
                    "tilt": f64::from(-push.y) * turn,
                    "wanted": true,
                })
            });
            self.head.order(ui, session, &head.name, want);
        }
    }

    /// Lets go of everything.
    fn stop(&mut self, session: &Session) {
        self.base.let_go(session);
        self.head.let_go(session);
    }

    fn slider(&mut self, ui: &mut Ui, (fast, _): (f64, f64), look: &Look) {
        self.speed = self.speed.min(fast);
        let (most, unit) = look.units.convert(fast, "m/s");
        let factor = most / fast;
        let mut shown = self.speed * factor;
        let slider = Slider::new(&mut shown, 0.0..=most)
            .text("Speed")
            .suffix(format!(" {unit}"))
            .max_decimals(2);
        let slid = ui
            .add(slider)
            .on_hover_text("How fast it drives when the pad is pushed all the way; turns as much slower");
        if slid.changed() {
            self.speed = shown / factor;
        }
    }

    /// Who drives, in words.
    fn status(&self, session: &Session, senses: &Senses, base: &SchemaInfo, look: &Look) -> (String, Ink) {
        let Some(view) = session.view(&base.name) else {
            return (format!("nothing is known of {}", base.name), Ink::Warn);
        };
        if let Health::Faulted(reason) = &view.health {
            return (format!("{} has failed: {reason}", base.name), Ink::Bad);
        }
        if let Some(hold) = &view.operator
            && matches!(hold.kind, HoldKind::Stopped | HoldKind::Unloaded)
        {
            return (
                format!("{} was {} by {}", base.name, hold.kind.word(), hold.by),
                Ink::Warn,
            );
        }
        let hand = self.base.held.is_some() || self.head.held.is_some();
        if view.authority && view.state == State::Winner {
            let speed = senses.commanded.value().map(|twist| table::speed(twist, look));
            let words = match (hand, speed) {
                (true, Some(speed)) => format!("driving: {speed}"),
                (true, None) => "driving".to_owned(),
                (false, _) => format!("{} drives for somebody else", base.name),
            };
            return (words, if hand { Ink::Accent } else { Ink::Warn });
        }
        match winner(session) {
            Some(winner) if hand => (format!("waiting: {winner} has control"), Ink::Warn),
            Some(winner) => (format!("{winner} has control"), Ink::Plain),
            None => ("nobody drives".to_owned(), Ink::Faint),
        }
    }

    /// What was refused since the switch was turned on.
    fn refusals(&self, ui: &mut Ui, session: &Session, look: &Look) {
        let refused = session
            .notices()
            .into_iter()
            .rev()
            .find(|notice| notice.failed && notice.at >= self.since && notice.at.elapsed() < SHOWN);
        if let (true, Some(refused)) = (self.on, refused) {
            ui.colored_label(look::ink(Ink::Bad, look), refused.text);
        }
    }

    #[cfg(feature = "gamepad")]
    fn sticks(&mut self, ui: &mut Ui) -> Sticks {
        let gamepads = self.gamepads.get_or_insert_with(gamepad::Gamepads::open);
        let grip = gamepads.grip();
        ui.weak(gamepads.words());
        if gamepads.any() {
            ui.ctx().request_repaint_after(BEAT);
        }
        let focused = ui.input(|input| input.focused);
        let grip = grip.filter(|_| focused);
        Sticks {
            drive: grip.as_ref().map(|grip| grip.drive),
            look: grip.map(|grip| grip.look),
        }
    }

    #[cfg(not(feature = "gamepad"))]
    fn sticks(&mut self, _: &mut Ui) -> Sticks {
        Sticks::default()
    }
}

impl Grip {
    /// Orders what is wanted, or lets go as soon as nothing is.
    fn order(&mut self, ui: &Ui, session: &Session, schema: &str, want: Option<Value>) {
        let Some(want) = want else {
            self.let_go(session);
            return;
        };
        if self.held.as_ref().is_some_and(|held| held.schema != schema) {
            self.let_go(session);
        }
        let new = |held: &Held| held.want != want && held.since.elapsed() >= BEAT;
        if self.held.as_ref().is_none_or(new) {
            self.held = Some(Held {
                schema: schema.to_owned(),
                want,
                since: Instant::now(),
            });
        }
        if let Some(held) = &self.held {
            session.hold(Action::Modulate {
                schema: held.schema.clone(),
                variable: "want".to_owned(),
                value: held.want.clone(),
            });
        }
        ui.ctx().request_repaint_after(AGAIN.min(BEAT));
    }

    fn let_go(&mut self, session: &Session) {
        if let Some(held) = self.held.take() {
            session.let_go(&held.schema);
        }
    }
}

/// The schema of a type that commands this body, or the first of them.
fn driver<'a>(session: &'a Session, type_name: &str, body: &str) -> Option<&'a SchemaInfo> {
    let all = &session.schemas().schemas;
    let commands = |schema: &&SchemaInfo| {
        schema.ports.iter().any(|port| {
            let target = port
                .variable
                .as_deref()
                .and_then(|variable| variable.split_once('.'));
            port.role == "actuator" && target.is_some_and(|(owner, _)| owner == body)
        })
    };
    all.iter()
        .filter(|schema| schema.type_name == type_name)
        .find(commands)
        .or_else(|| all.iter().find(|schema| schema.type_name == type_name))
}

/// The greatest speeds that the schema allows, m/s and rad/s.
fn limits(session: &Session, base: &SchemaInfo) -> (f64, f64) {
    let fast = number(session, base, "fast").filter(|fast| *fast > 0.0);
    let turn = number(session, base, "turn").filter(|turn| *turn >= 0.0);
    (fast.unwrap_or(WALK), turn.unwrap_or(WALK))
}

fn number(session: &Session, schema: &SchemaInfo, modulation: &str) -> Option<f64> {
    let name = format!("{}.{modulation}", schema.name);
    session.read::<f64>(&name, Rate::Hz(2)).map(|(number, _)| number)
}

/// The winner of the roots.
fn winner(session: &Session) -> Option<&str> {
    let snapshot = session.snapshot();
    let roots = snapshot.groups.iter().find(|group| group.father.is_none())?;
    Some(snapshot.schemas.get(roots.winner?)?.name.as_str())
}

/// The pads, side by side or below each other as there is room; what hands want of them.
fn pads(ui: &mut Ui, head: bool, look: &Look) -> (Option<Vec2>, Option<Vec2>) {
    let (mut drive, mut gaze) = (None, None);
    let room = ui.available_width();
    let side = if head {
        (0.5 * room - 8.0).clamp(110.0, 170.0)
    } else {
        room.clamp(110.0, 170.0)
    };
    ui.horizontal_wrapped(|ui| {
        let pad = Pad {
            name: "Drive pad",
            words: ["right", "left", "ahead", "back"],
            side,
        };
        drive = pad.show(ui, look);
        if head {
            let pad = Pad {
                name: "Look pad",
                words: ["right", "left", "look up", "down"],
                side,
            };
            gaze = pad.show(ui, look);
        }
    });
    ui.weak("Arrows or WASD while a pad has the focus, Space stands still");
    (drive, gaze)
}

/// How to add what is not there.
fn advice(ui: &mut Ui, session: &Session, body: &str) {
    if body.is_empty() {
        ui.weak("nothing in this application drives");
        return;
    }
    let roots = session
        .schemas()
        .groups
        .iter()
        .find(|group| group.father.is_none());
    let roots = roots.map_or(&[][..], |group| &group.members);
    let mut names = vec!["\"teleop\"".to_owned()];
    names.extend(roots.iter().map(|root| format!("\"{root}\"")));
    let command = session
        .variables()
        .iter()
        .find(|variable| variable.owner == body && variable.type_name == "geometry_msgs/msg/Twist");
    let command = command.map_or_else(|| format!("{body}.velocity"), |command| command.name.clone());
    let lines = format!(
        "roots = [{}]\n\n[schemas.teleop]\ntype      = \"teleop/base\"\nactuators = {{ base = \"{command}\" }}\n",
        names.join(", ")
    );
    ui.label("Nobody can drive this application by hand. In its file, these lines let one:");
    ui.add(
        egui::TextEdit::multiline(&mut lines.as_str())
            .code_editor()
            .desired_rows(5)
            .desired_width(f32::INFINITY),
    );
    if ui.button("Copy").on_hover_text("Copy the lines").clicked() {
        ui.ctx().copy_text(lines);
    }
}
