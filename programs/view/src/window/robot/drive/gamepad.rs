//! Gamepads: while a shoulder button is held, the sticks act as the pads of the window. It sends no
//! commands.

use std::path::Path;
use std::time::{Duration, Instant};

use eframe::egui::{Ui, Vec2, vec2};
use jde_gamepad::{Controls, Link, LinkState, Pad, Wanted, pads};

use super::Sticks;
use super::lease::BEAT;

/// Fraction of a stick's travel below which it is at rest.
const DEAD_ZONE: f32 = 0.12;
/// The shoulder buttons.
const SHOULDER_BUTTONS: [usize; 2] = [9, 10];
/// Interval at which new gamepads are looked for.
const LIST_INTERVAL: Duration = Duration::from_secs(1);

/// The gamepads of this machine.
pub(super) struct Gamepads {
    links: Vec<(Pad, Link)>,
    start: Instant,
    /// Time since the start at which they were last listed.
    listed: Option<Duration>,
}

impl Default for Gamepads {
    fn default() -> Self {
        Self {
            links: Vec::new(),
            start: Instant::now(),
            listed: None,
        }
    }
}

impl Gamepads {
    /// Shows the status of the gamepads, and returns the positions of their sticks. Call in each frame.
    pub(super) fn sticks(&mut self, ui: &mut Ui) -> Sticks {
        let sticks = self.held(self.start.elapsed());
        ui.weak(self.status());
        let interval = if self.links.is_empty() {
            LIST_INTERVAL
        } else {
            BEAT
        };
        ui.ctx().request_repaint_after(interval);
        let focused = ui.input(|input| input.focused);
        sticks.filter(|_| focused).unwrap_or_default()
    }

    /// Returns the sticks of the first pad with a held shoulder button.
    fn held(&mut self, now: Duration) -> Option<Sticks> {
        if self
            .listed
            .is_none_or(|listed| now.saturating_sub(listed) >= LIST_INTERVAL)
        {
            self.listed = Some(now);
            self.take(pads(Path::new("/sys/class/input")));
        }
        let mut held = None;
        for (_, link) in &mut self.links {
            held = held.or(link.step(now).as_ref().and_then(sticks));
        }
        held
    }

    /// Takes the pads that are there, and lets those go that are not.
    fn take(&mut self, pads: Vec<Pad>) {
        self.links.retain(|(pad, _)| pads.contains(pad));
        for pad in pads {
            if self.links.iter().all(|(known, _)| *known != pad) {
                let wanted = Wanted {
                    device: pad.path.display().to_string(),
                    ..Wanted::default()
                };
                self.links
                    .push((pad, Link::new(move || jde_gamepad::open(&wanted), None)));
            }
        }
    }

    /// The status of the gamepads, as text.
    fn status(&self) -> String {
        match self.links.first() {
            None => "no gamepad is connected".to_owned(),
            Some((pad, link)) => match link.state() {
                LinkState::Absent(reason) => reason.to_owned(),
                LinkState::Searching | LinkState::Open(_) => {
                    format!("{}: hold a shoulder button and push a stick", pad.name)
                }
            },
        }
    }
}

/// The sticks, if a shoulder button is held.
fn sticks(controls: &Controls) -> Option<Sticks> {
    let is_held = |number: &usize| controls.buttons.get(*number) == Some(&true);
    if !SHOULDER_BUTTONS.iter().any(is_held) {
        return None;
    }
    // Those of a pad are positive to the left.
    let stick = |first: usize| match controls.axes.get(first..first + 2) {
        Some([left, ahead]) => without_dead_zone(vec2(-left, *ahead)),
        _ => Vec2::ZERO,
    };
    Some(Sticks {
        drive: Some(stick(0)),
        head: Some(stick(2)),
    })
}

/// Rescales a stick's position: from 0 at the edge of the dead zone to at most 1.
fn without_dead_zone(push: Vec2) -> Vec2 {
    let length = push.length();
    if length < DEAD_ZONE {
        return Vec2::ZERO;
    }
    push / length * ((length - DEAD_ZONE) / (1.0 - DEAD_ZONE)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stick_has_a_dead_zone_and_full_deflection_at_its_edge() {
        assert_eq!(without_dead_zone(vec2(0.05, -0.1)), Vec2::ZERO);
        assert!((without_dead_zone(vec2(0.0, 1.0)) - vec2(0.0, 1.0)).length() < 1e-6);
        assert!(
            without_dead_zone(vec2(0.13, 0.0)).length() < 0.02,
            "no jump at the edge of the dead zone"
        );
        assert!(
            (without_dead_zone(vec2(1.0, 1.0)).length() - 1.0).abs() < 1e-6,
            "a corner is not faster"
        );
    }

    #[test]
    fn the_sticks_count_while_a_shoulder_button_is_held() {
        let mut controls = Controls {
            axes: vec![1.0, 0.0, 0.0, -1.0, 0.0, 0.0],
            buttons: vec![true; 9],
        };
        controls.buttons.resize(15, false);
        assert!(sticks(&controls).is_none(), "other buttons are held");
        controls.buttons[10] = true;
        let held = sticks(&controls).unwrap();
        assert_eq!(held.drive, Some(vec2(-1.0, 0.0)), "to the left");
        assert_eq!(held.head, Some(vec2(0.0, -1.0)), "down");
    }
}
