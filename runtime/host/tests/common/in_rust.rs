//! A schema in Rust in a call: what a behaviour requests goes through its ports.

use std::cell::RefCell;

use jde_schema::prelude::*;

use super::io::{Answer, Caller, Request};
use super::schemas::{Mark, Motor};

const REFUSED: Answer = (Outcome::Refused, 0.0, 0);

fn accepted(number: f64, count: u64) -> Answer {
    (Outcome::Accepted, number, count)
}

fn holds(holds: bool) -> Answer {
    if holds { accepted(0.0, 0) } else { REFUSED }
}

/// A schema in a call, and what the call lends it.
pub(super) struct InRust<'a, 'p> {
    pub(super) cx: &'a Context<'a>,
    pub(super) motor: Option<&'a Motor>,
    pub(super) eye_input: Option<&'a Import<f64>>,
    pub(super) eye: Option<RefCell<(&'a mut Export<f64>, &'a mut Export<Mark>)>>,
    pub(super) level: Option<&'a Level<'a>>,
    pub(super) pen: Option<RefCell<&'a mut Pen<'p>>>,
    pub(super) saving: Option<RefCell<&'a mut Saving>>,
    /// The number that another instance saved.
    pub(super) saved: Option<f64>,
}

impl<'a> InRust<'a, '_> {
    pub(super) fn new(cx: &'a Context<'a>) -> Self {
        Self {
            cx,
            motor: None,
            eye_input: None,
            eye: None,
            level: None,
            pen: None,
            saving: None,
            saved: None,
        }
    }
}

impl Caller for InRust<'_, '_> {
    fn request(&self, request: Request, text: &str, number: f64) -> Answer {
        let cx = self.cx;
        let eye = || {
            self.eye
                .as_ref()
                .expect("the instance is perceptive")
                .borrow_mut()
        };
        let pen = || self.pen.as_ref().expect("the call draws").borrow_mut();
        match request {
            Request::Seed => return accepted(0.0, cx.seed()),
            Request::Now => return accepted(0.0, cx.now().as_nanos() as u64),
            Request::RealTime => return holds(cx.require_real_time().is_ok()),
            Request::Log => info!(cx, "{text}"),
            Request::Input if self.eye_input.is_some() => {
                let sample = self.eye_input.and_then(|input| input.get(cx));
                return sample.map_or(REFUSED, |sample| accepted(*sample, sample.sequence()));
            }
            Request::Publish => eye().0.write(cx, number),
            Request::Retract => eye().0.retract(cx),
            Request::PublishMark => {
                let mut mark = Mark {
                    label: Text::truncated(text),
                    ..Mark::default()
                };
                mark.places.push(Pose2D::new(number, 0.0, 0.0)).expect("room");
                eye().1.write(cx, mark);
            }
            Request::Text => pen().text(text),
            Request::Value => pen().value(text, number, "m"),
            Request::Button => drop(pen().button(text, text)),
            Request::Save => {
                let saving = self.saving.as_ref().expect("the call saves");
                saving.borrow_mut().put(&number);
            }
            Request::Restore => {
                return self.saved.map_or(REFUSED, |number| accepted(number, 0));
            }
            _ => return self.request_of_motor(request, text, number),
        }
        holds(true)
    }

    fn group(&self) -> String {
        let level = self.level.expect("the call is an arbitration");
        level.group().to_owned()
    }
}

impl InRust<'_, '_> {
    fn request_of_motor(&self, request: Request, role: &str, number: f64) -> Answer {
        let cx = self.cx;
        let motor = self.motor.expect("the instance is a motor schema");
        let level = || self.level.expect("the call is an arbitration");
        let read = |import: &Import<f64>| {
            let sample = import.get(cx);
            sample.map_or(REFUSED, |sample| accepted(*sample, sample.sequence()))
        };
        let outcome = match request {
            Request::Input => return read(&motor.input),
            Request::Other => return read(&motor.other),
            Request::Mark => {
                let mark = motor.mark.get(cx).filter(|mark| mark.label.as_str() == role);
                return mark.map_or(REFUSED, |mark| {
                    let places = mark.places.as_slice();
                    accepted(places.last().map_or(0.0, |place| place.x), places.len() as u64)
                });
            }
            Request::Gain => return accepted(motor.gain.get(cx), 0),
            Request::Grip => return accepted(motor.grip.get(cx), 0),
            Request::IsReady => return holds(level().is_ready(motor.child(role))),
            Request::Collides => return holds(level().case() == Case::Collision),
            Request::Urgency => {
                let candidate = level().candidate(motor.child(role));
                return candidate.map_or(REFUSED, |candidate| accepted(candidate.urgency, 0));
            }
            Request::State => {
                let status = motor.child(role).status(cx);
                return status.map_or(REFUSED, |status| {
                    accepted(f64::from(u8::from(status.faulted)), status.state as u64)
                });
            }
            Request::SetPolicy => motor.child(role).set_policy(cx, Policy::URGENCY),
            Request::Command => motor.base.command(cx, Twist::planar(number, 0.0)),
            Request::Reach => motor.arm.command(cx, Twist::planar(number, 0.0)),
            Request::Wake => motor.child(role).wake(cx),
            Request::Sleep => motor.child(role).sleep(cx),
            Request::ModulateA => motor.gain_of_a.set(cx, number),
            Request::RetimeA => motor.period_of_a.set(cx, number),
            other => panic!("{other:?} is no request of a motor schema"),
        };
        (outcome, 0.0, 0)
    }
}
