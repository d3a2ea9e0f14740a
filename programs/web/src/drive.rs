//! Driving by hand from a page: the modulation `want` of a teleoperator, under a lease (R14), for as long as the page
//! itself says that the pad is held. Whether that schema wins is decided by the application (R13).
//!
//! The hold ends when the page lets go, when it is silent, when it drives by an old picture, and when its socket ends,
//! whatever else still answers there: a browser answers pings for a page that is frozen.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_link::message::Action;
use serde_json::json;
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;

use crate::model::MaxSpeeds;
use crate::order::DriveOrder;
use crate::server::Page;
use crate::state::DrivingView;

/// A pad that is not said to be held for this time is let go. A page says it every 80 ms.
const PATIENCE: Duration = Duration::from_millis(400);
/// The lease: after this time without renewal, as of a page's process that died, the application undoes the order. It is
/// that of the windows.
const LEASE_MS: u64 = 600;
/// The greatest age of the picture by which somebody drives: the way to the page and back.
pub(crate) const MAX_AGE: Duration = Duration::from_millis(700);

/// Drives as the newest order wants, until its sender is gone. `by` is the name of this socket alone.
pub(crate) async fn run(
    page: Arc<Page>,
    (socket, by): (u64, String),
    mut wanted: watch::Receiver<Option<(DriveOrder, Instant)>>,
    answers: mpsc::Sender<String>,
) {
    let mut held: Option<String> = None;
    // Whether the page has been told that it drives, since it was told otherwise.
    let mut is_told = false;
    loop {
        let changed = match held {
            Some(_) => timeout(PATIENCE, wanted.changed()).await,
            None => Ok(wanted.changed().await),
        };
        let order = match changed {
            // An order that waited for the one before is as old as a silence, and one of a page that is gone is none.
            Ok(Ok(())) => {
                let newest = wanted.borrow_and_update().clone();
                let newest = newest.filter(|(_, at)| at.elapsed() < PATIENCE && !answers.is_closed());
                newest.map(|(order, _)| order)
            }
            Ok(Err(_)) => {
                if let Some(schema) = held {
                    let_go(&page, socket, &by, schema).await;
                }
                return;
            }
            Err(_) => None,
        };
        if let Some(schema) = held.take_if(|held| order.as_ref().is_none_or(|order| order.schema != *held)) {
            let_go(&page, socket, &by, schema).await;
            report(&answers, false, "released");
            is_told = false;
        }
        let Some(order) = order else { continue };
        let outcome = hold(&page, socket, &by, &order).await;
        match outcome {
            Ok(()) => {
                held = Some(order.schema);
                if !is_told {
                    report(&answers, true, "");
                }
                is_told = true;
            }
            Err(reason) => {
                report(&answers, false, &reason);
                is_told = false;
            }
        }
    }
}

async fn hold(page: &Arc<Page>, socket: u64, by: &str, order: &DriveOrder) -> Result<(), String> {
    let schema = order.schema.as_str();
    if !page.model.teleoperators().any(|known| known == schema) {
        return Err(format!("`{schema}` does not drive by hand"));
    }
    let limits = page.model.max_speeds(schema);
    let limits = limits.ok_or_else(|| format!("the limits of `{schema}` are not known yet"))?;
    {
        let mut drivers = page.drivers.lock();
        match drivers.get(schema) {
            Some((other, view)) if *other != socket => return Err(format!("{} drives now", view.by)),
            Some(_) => {}
            None => {
                let view = DrivingView {
                    schema: schema.to_owned(),
                    by: by.to_owned(),
                };
                drivers.insert(schema.to_owned(), (socket, view));
            }
        }
    }
    let action = Action::Modulate {
        schema: schema.to_owned(),
        variable: "want".to_owned(),
        value: want(order, limits),
    };
    let outcome = page.operate(by, action, Some(LEASE_MS)).await;
    if outcome.is_err() {
        free(page, socket, schema);
    }
    outcome.map(drop)
}

async fn let_go(page: &Arc<Page>, socket: u64, by: &str, schema: String) {
    free(page, socket, &schema);
    // If it fails, the lease ends soon.
    if let Err(error) = page.operate(by, Action::LetGo { schema }, Some(LEASE_MS)).await {
        tracing::warn!("{by} let go of the pad, and the application did not answer: {error}");
    }
}

fn free(page: &Page, socket: u64, schema: &str) {
    let mut drivers = page.drivers.lock();
    if drivers.get(schema).is_some_and(|(owner, _)| *owner == socket) {
        drivers.remove(schema);
    }
}

/// The wanted motion, as from the pad of the windows.
fn want(order: &DriveOrder, limits: MaxSpeeds) -> serde_json::Value {
    let fast = limits.fast.max(0.0);
    let speed = order.speed.clamp(0.0, fast);
    let share = if fast > 0.0 { speed / fast } else { 0.0 };
    json!({
        "twist": {
            "linear": { "x": order.ahead.clamp(-1.0, 1.0) * speed, "y": 0.0, "z": 0.0 },
            "angular": { "x": 0.0, "y": 0.0, "z": order.left.clamp(-1.0, 1.0) * limits.turn * share },
        },
        "wanted": true,
    })
}

/// Says how the hold stands. A page that does not read learns it from its next state.
fn report(answers: &mpsc::Sender<String>, held: bool, text: &str) {
    let message = json!({ "t": "drive", "held": held, "text": text });
    let _ = answers.try_send(message.to_string());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(ahead: f64, left: f64, speed: f64, fast: f64) -> (f64, f64) {
        let order = DriveOrder {
            schema: "teleop".to_owned(),
            ahead,
            left,
            speed,
            tick: 0,
        };
        let want = want(&order, MaxSpeeds { fast, turn: 1.0 });
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        assert_eq!(want["wanted"], true);
        (
            number(&want["twist"]["linear"]["x"]),
            number(&want["twist"]["angular"]["z"]),
        )
    }

    #[test]
    fn no_page_drives_faster_than_the_schema_allows() {
        assert_eq!(wanted(1.0, 0.0, 0.3, 0.5), (0.3, 0.0));
        assert_eq!(wanted(-1.0, 1.0, 0.25, 0.5), (-0.25, 0.5));
        assert_eq!(wanted(100.0, -100.0, 100.0, 0.5), (0.5, -1.0));
        assert_eq!(wanted(1.0, 1.0, -1.0, 0.5), (0.0, 0.0));
        assert_eq!(wanted(1.0, 1.0, 0.3, 0.0), (0.0, 0.0));
    }
}
