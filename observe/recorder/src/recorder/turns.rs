//! Records every turn of every schema.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_app::Application;
use jde_log::RecordedHierarchy;
use jde_log::TURNS_TOPIC;
use jde_records::turn::{OnTurn, Turn};
use jde_types::Value;

use super::Recorder;
use crate::Stamps;

/// Records every turn of an application, for a replay. `lockstep` states whether it runs in virtual
/// time.
#[must_use]
pub fn turns(recorder: &Recorder, application: &Application, lockstep: bool) -> OnTurn {
    let hierarchy = RecordedHierarchy::of(application, lockstep);
    let metadata = BTreeMap::from([
        (
            "doc".to_owned(),
            "What every schema did, and what it saw.".to_owned(),
        ),
        hierarchy.metadata_entry(),
    ]);
    let topic = recorder.topic(TURNS_TOPIC, Arc::new(Turn::describe()), metadata);
    let count = AtomicU64::new(0);
    Arc::new(move |turn: &Turn| {
        let time = turn.time();
        let stamps = Stamps {
            published: time,
            measured: time,
            sequence: count.fetch_add(1, Ordering::Relaxed) + 1,
        };
        // A turn for which there is no room is counted as lost by the topic.
        topic.put(turn.as_bytes(), stamps);
    })
}
