//! Sensor data in numbers, one row per sensor, with its age. Sensors that the application lacks are listed as
//! text.

use std::collections::BTreeSet;

use eframe::egui::{self, Color32, Rect, RichText, Sense, Stroke, StrokeKind, Ui, vec2};
use jde_link::message::Action;
use jde_panel::Ink;
use jde_types::{
    BatteryState, Bumpers, Imu, LaserScan, Odometry, PanTilt, PositionFix, RangeRing, Twist, Vector3,
    WheelEncoders,
};

use super::reading::{Freshness, NoReading, Sleeper, VariableState};
use super::sensors::Sensors;
use crate::session::WindowSession;
use crate::style::{self, Style};

/// Charge below which a battery is low, and nearly empty, from 0 to 1.
const LOW_CHARGE: f32 = 0.3;
const EMPTY_CHARGE: f32 = 0.15;
/// Opacity of the bar of a charge, and of a stale one, on which a text in the weak color can be read.
const BAR_OPACITY: f32 = 0.45;
const STALE_BAR_OPACITY: f32 = 0.2;
/// Opacity of the cells of a stale line sensor.
const STALE_CELL_OPACITY: f32 = 0.3;

/// Shows the table. Without a session it has no buttons that wake schemas: for pictures.
pub(super) fn show(ui: &mut Ui, senses: &Sensors, session: Option<&WindowSession>, style: &Style) {
    let mut rows = Rows {
        style,
        absent: Vec::new(),
        sleepers: BTreeSet::new(),
    };
    egui::Grid::new("senses")
        .num_columns(3)
        .spacing([10.0, 5.0])
        .striped(true)
        .show(ui, |ui| {
            rows.row(ui, "Place", "odometry", &senses.odometry, |ui, odometry, _| {
                ui.label(place(odometry, style));
            });
            rows.row(ui, "Speed", "", &senses.odometry, |ui, odometry, stale| {
                ui.colored_label(
                    style::color_of(ink(Ink::Good, stale), style),
                    speed(&odometry.twist.twist, style),
                );
            });
            if let VariableState::Present(twist, _) = &senses.commanded {
                ui.label("Commanded")
                    .on_hover_text("The command to the base that is in force");
                ui.colored_label(style::color_of(Ink::Accent, style), speed(twist, style));
            } else {
                ui.label("Commanded")
                    .on_hover_text("The command to the base that is in force");
                ui.weak("nothing in force");
            }
            ui.end_row();
            rows.row(ui, "Laser", "laser", &senses.laser, |ui, laser, _| {
                ui.label(scan(laser, style));
            });
            rows.row(ui, "Sonars", "sonars", &senses.sonars, |ui, sonars, _| {
                ui.label(echoes(sonars, style));
            });
            rows.row(ui, "Bumpers", "bumpers", &senses.bumpers, |ui, bumpers, stale| {
                let (text, bad) = pressed(bumpers);
                if bad {
                    ui.colored_label(style::color_of(ink(Ink::Bad, stale), style), text);
                } else {
                    ui.label(text);
                }
            });
            rows.row(ui, "Line", "line sensor", &senses.line, |ui, line, stale| {
                strip(ui, &line.brightness, stale, style);
            });
            rows.row(ui, "Inertia", "inertial unit", &senses.imu, |ui, imu, _| {
                ui.label(inertia(imu, style))
                    .on_hover_text("Turn rate about z, and specific forces along x, y and z");
            });
            rows.row(
                ui,
                "Position",
                "position sensor",
                &senses.position,
                |ui, fix, _| {
                    ui.label(position(fix, style))
                        .on_hover_text("x, y, and the greater standard deviation of the two");
                },
            );
            rows.row(ui, "Wheels", "encoders", &senses.encoders, |ui, encoders, _| {
                ui.label(ticks(encoders))
                    .on_hover_text("The counts of the encoders");
            });
            rows.row(ui, "Battery", "battery", &senses.battery, |ui, battery, stale| {
                gauge(ui, battery, stale, style)
            });
            rows.row(ui, "Head", "pan-tilt head", &senses.head, |ui, head, _| {
                ui.label(gaze(head, style));
            });
        });
    for sleeper in &rows.sleepers {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("{}.", sleeper.message()));
            if let Some(session) = session {
                play(ui, session, Some(sleeper));
            }
        });
    }
    if senses.cameras.is_empty() {
        rows.absent.push("camera");
    }
    for sensor in rows.absent {
        ui.weak(format!("no {sensor} in this application"));
    }
}

/// Shows the age of a value, or "live", because hundredths of seconds would not be readable.
pub(super) fn age(ui: &mut Ui, fresh: &Freshness, style: &Style) {
    let text = RichText::new(fresh.message()).small();
    let text = if fresh.stale {
        text.color(style::color_of(Ink::Warn, style))
    } else {
        text.weak()
    };
    ui.label(text).on_hover_text(format!("the age of {}", fresh.name));
}

/// A button with which an operator wakes a SLEPT schema.
pub(super) fn play(ui: &mut Ui, session: &WindowSession, sleeper: Option<&Sleeper>) {
    let Some(Sleeper { schema, stop }) = sleeper else {
        return;
    };
    let tip = match stop {
        Some(_) => "End the stop, and wake it as an operator, until it is released",
        None => "Wake it as an operator, until it is released",
    };
    let button = ui.button(format!("Play {schema}")).on_hover_text(tip);
    if button.clicked() {
        session.act(Action::Play {
            schema: schema.clone(),
        });
    }
}

struct Rows<'a> {
    style: &'a Style,
    /// Names of sensors that the application lacks.
    absent: Vec<&'static str>,
    /// The schemas that sleep, and would export values.
    sleepers: BTreeSet<Sleeper>,
}

impl Rows<'_> {
    /// Adds a row, or registers an absent sensor. An empty `sensor` marks a second row of one sensor, whose
    /// absence is not shown again. `show` draws a stale value in the weak color.
    fn row<T>(
        &mut self,
        ui: &mut Ui,
        name: &str,
        sensor: &'static str,
        reading: &VariableState<T>,
        show: impl FnOnce(&mut Ui, &T, bool),
    ) {
        self.sleepers.extend(reading.sleeper().cloned());
        match reading {
            VariableState::Absent | VariableState::None(..) if sensor.is_empty() => {}
            VariableState::Absent | VariableState::None(_, NoReading::Never(_)) => self.absent.push(sensor),
            VariableState::None(variable, reason) => {
                ui.label(name).on_hover_text(variable);
                // Why one sleeps is said once, below: it may be long, and the plane is beside it.
                ui.weak(match reason {
                    NoReading::Asleep(_) => "asleep".to_owned(),
                    NoReading::Waiting
                    | NoReading::Silent(_)
                    | NoReading::Never(_)
                    | NoReading::Trouble(_) => reason.message(),
                })
                .on_hover_text(reason.message());
                ui.end_row();
            }
            VariableState::Present(value, fresh) => {
                ui.label(name).on_hover_text(&fresh.name);
                ui.scope(|ui| {
                    if fresh.stale {
                        ui.visuals_mut().override_text_color = Some(ui.visuals().weak_text_color());
                    }
                    show(ui, value, fresh.stale);
                });
                age(ui, fresh, self.style);
                ui.end_row();
            }
        }
    }
}

/// The color of a value: the weak one if it is stale.
fn ink(color: Ink, stale: bool) -> Ink {
    if stale { Ink::Faint } else { color }
}

fn place(odometry: &Odometry, style: &Style) -> String {
    let pose = odometry.pose2d();
    format!("{}  {}", point([pose.x, pose.y], style), angle(pose.theta, style))
}

fn position(fix: &PositionFix, style: &Style) -> String {
    let deviation = fix.covariance[0].max(fix.covariance[3]).max(0.0).sqrt();
    format!("{}  ± {}", point([fix.x, fix.y], style), length(deviation, style))
}

fn point([x, y]: [f64; 2], style: &Style) -> String {
    let (x, unit) = style.units.convert(x, "m");
    let (y, _) = style.units.convert(y, "m");
    let digits = if unit == "m" { 2 } else { 0 };
    format!("{x:.digits$}, {y:.digits$} {unit}")
}

fn inertia(imu: &Imu, style: &Style) -> String {
    let Vector3 { x, y, z } = imu.linear_acceleration;
    let turn = rate(imu.angular_velocity.z, style);
    format!("{turn}  {x:.1}, {y:.1}, {z:.1} m/s²")
}

/// Draws the cells of a line sensor from left to right, in the grey of what they see. Those of a stale value are faint, in
/// frames.
fn strip(ui: &mut Ui, brightness: &[f32], stale: bool, style: &Style) {
    let (area, response) = ui.allocate_exact_size(vec2(12.0 * brightness.len() as f32, 14.0), Sense::hover());
    for (cell, brightness) in brightness.iter().enumerate() {
        let left = area.left_top() + vec2(12.0 * cell as f32, 0.0);
        let grey = Color32::from_gray((255.0 * brightness.clamp(0.0, 1.0)) as u8);
        let rect = Rect::from_min_size(left, vec2(11.0, 14.0));
        if stale {
            let frame = Stroke::new(1.0, style::color_of(Ink::Faint, style));
            let faint = grey.gamma_multiply(STALE_CELL_OPACITY);
            ui.painter().rect(rect, 0.0, faint, frame, StrokeKind::Inside);
        } else {
            ui.painter().rect_filled(rect, 0.0, grey);
        }
    }
    response.on_hover_text("The brightness of the floor below each cell");
}

/// Formats the speed ahead and the turn rate.
pub(super) fn speed(twist: &Twist, style: &Style) -> String {
    let (ahead, unit) = style.units.convert(twist.linear.x, "m/s");
    let digits = if unit == "m/s" { 2 } else { 0 };
    let turn = rate(twist.angular.z, style);
    // Avoids "-0.00".
    let zero = 0.5 * 10_f64.powi(-(digits as i32));
    let ahead = if ahead.abs() < zero { 0.0 } else { ahead };
    format!("{ahead:.digits$} {unit}  {turn}")
}

fn angle(angle: f64, style: &Style) -> String {
    let (angle, unit) = style.units.convert(angle, "rad");
    match unit.as_str() {
        "deg" => format!("{:.0}°", if angle.abs() < 0.5 { 0.0 } else { angle }),
        unit => format!("{angle:.2} {unit}"),
    }
}

fn rate(turn: f64, style: &Style) -> String {
    let (turn, unit) = style.units.convert(turn, "rad/s");
    let digits = if unit == "deg/s" { 0 } else { 2 };
    let zero = 0.5 * 10_f64.powi(-(digits as i32));
    let turn = if turn.abs() < zero { 0.0 } else { turn };
    format!("{turn:.digits$} {unit}")
}

fn scan(laser: &LaserScan, style: &Style) -> String {
    let beams = laser.ranges.len();
    let nearest = laser
        .points()
        .min_by(|one, other| one.range.total_cmp(&other.range));
    match nearest {
        None => format!("nothing near, {beams} beams"),
        Some(point) => format!(
            "nearest {} {}",
            length(point.range, style),
            aside(point.angle, style)
        ),
    }
}

fn echoes(sonars: &RangeRing, style: &Style) -> String {
    let nearest = sonars
        .echoes()
        .min_by(|one, other| one.range.total_cmp(&other.range));
    match nearest {
        None => "nothing near".to_owned(),
        Some(echo) => {
            let toward = sonars.poses.get(echo.sonar).map_or(0.0, |mount| mount.theta);
            format!("nearest {} {}", length(echo.range, style), aside(toward, style))
        }
    }
}

fn length(length: f64, style: &Style) -> String {
    let (length, unit) = style.units.convert(length, "m");
    let digits = if unit == "m" { 2 } else { 0 };
    format!("{length:.digits$} {unit}")
}

/// Formats a direction: an angle in rad, positive to the left.
fn aside(toward: f64, style: &Style) -> String {
    if toward.abs() < 5_f64.to_radians() {
        return "ahead".to_owned();
    }
    let side = if toward > 0.0 { "left" } else { "right" };
    format!("{} {side}", angle(toward.abs(), style))
}

/// Which bumpers are pressed, as text, and whether that needs attention.
fn pressed(bumpers: &Bumpers) -> (String, bool) {
    let count = |side: &[jde_types::Flag]| side.iter().filter(|pressed| pressed.get()).count();
    let (front, rear) = (count(&bumpers.front), count(&bumpers.rear));
    let mut text = match (front, rear) {
        (0, 0) => "none pressed".to_owned(),
        (front, 0) => format!("{front} pressed ahead"),
        (0, rear) => format!("{rear} pressed behind"),
        (front, rear) => format!("{front} pressed ahead, {rear} behind"),
    };
    let stalled = bumpers.stalled.get();
    if stalled {
        text.push_str(", wheels held");
    }
    (text, front + rear > 0 || stalled)
}

fn ticks(encoders: &WheelEncoders) -> String {
    format!("left {}  right {}", encoders.left, encoders.right)
}

fn gauge(ui: &mut Ui, battery: &BatteryState, stale: bool, style: &Style) {
    let volts = if battery.voltage.is_nan() {
        String::new()
    } else {
        format!("{:.1} V", battery.voltage)
    };
    let charge = battery.percentage;
    if charge.is_nan() {
        ui.label(if volts.is_empty() {
            "not measured".to_owned()
        } else {
            volts
        });
        return;
    }
    let (color, note) = match charge {
        charge if charge < EMPTY_CHARGE => (Ink::Bad, "  nearly empty"),
        charge if charge < LOW_CHARGE => (Ink::Warn, "  low"),
        _ => (Ink::Good, ""),
    };
    let text = format!("{:.0} %{note}  {volts}", charge * 100.0);
    let opacity = if stale { STALE_BAR_OPACITY } else { BAR_OPACITY };
    let fill: Color32 = style::color_of(ink(color, stale), style).gamma_multiply(opacity);
    let bar = egui::ProgressBar::new(charge.clamp(0.0, 1.0))
        .fill(fill)
        .desired_width(150.0);
    let text = RichText::new(text).color(style::color_of(ink(Ink::Plain, stale), style));
    ui.add(bar.text(text));
}

fn gaze(head: &PanTilt, style: &Style) -> String {
    let side = match head.pan {
        pan if pan.abs() < 0.5_f64.to_radians() => "ahead".to_owned(),
        pan if pan > 0.0 => format!("{} left", angle(pan, style)),
        pan => format!("{} right", angle(-pan, style)),
    };
    let height = match head.tilt {
        tilt if tilt.abs() < 0.5_f64.to_radians() => "level".to_owned(),
        tilt if tilt > 0.0 => format!("{} down", angle(tilt, style)),
        tilt => format!("{} up", angle(-tilt, style)),
    };
    format!("{side}, {height}")
}
