//! Surveys of complete, triggered and damaged recordings.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use jde_conditions::{Condition, Names, Triggers};
use jde_core::{Case, State};
use jde_log::{GroupSurvey, Recording, SchemaProblems, Survey};
use jde_recorder::{Recorder, Stamps, TriggerOptions};
use jde_records::wire::EventMessage;
use jde_records::{CandidateRecord, DecidedBy, Decision, RunRecord};
use jde_types::Value;

use crate::support::options;

const SECOND: u64 = 1_000_000_000;

fn survey(file: &Path) -> Survey {
    Survey::of(&Recording::open(file).unwrap()).unwrap()
}

fn decision(time_s: f64, group: &str, case: &str, changed: bool) -> RunRecord {
    RunRecord::Decision(Decision {
        number: 1,
        time_s,
        group: group.to_owned(),
        case: Case::named(case).unwrap(),
        candidates: vec![CandidateRecord {
            name: "goon".to_owned(),
            state: State::Ready,
            ready: true,
            urgency: None,
        }],
        before: None,
        choice: Some("goon".to_owned()),
        decider: DecidedBy::Nobody,
        reason: String::new(),
        cause: String::new(),
        changed,
        takeover_us: None,
        refused: Vec::new(),
    })
}

fn event(time_s: f64, kind: &str, text: &str) -> RunRecord {
    let message = EventMessage {
        time_s,
        kind: kind.to_owned(),
        schema: Some("goon".to_owned()),
        text: text.to_owned(),
        ..EventMessage::default()
    };
    RunRecord::Other(message.try_into().expect("a record"))
}

/// Records ten values a second for `seconds` s, and records of selections and events. Three values are lost.
fn drive(recorder: &Recorder, seconds: u64) {
    let topic = recorder.topic("/robot/count", Arc::new(u64::describe()), BTreeMap::new());
    topic.add_lost(3);
    let mut records = vec![
        decision(1.0, "roots", "alone", true),
        decision(2.0, "base", "alone", true),
        decision(3.0, "base", "alone", false),
        event(4.0, "overrun", "missed its deadline"),
        event(4.0, "overrun", "took 3.000 ms of 1.000 ms"),
        event(5.0, "faulted", "it divided by zero"),
        event(6.0, "refused", "a wake"),
        decision(7.0, "base", "collision", true),
    ]
    .into_iter()
    .peekable();
    for tenth in 0..seconds * 10 {
        let time = tenth * SECOND / 10;
        while let Some(record) = records.next_if(|record| record.time() <= time) {
            recorder.push_record(record);
        }
        let stamps = Stamps {
            published: time,
            measured: time,
            sequence: tenth,
        };
        topic.put(&tenth.to_ne_bytes(), stamps);
    }
}

#[test]
fn a_survey_counts_messages_selections_and_problems() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.mcap");
    let recorder = Recorder::create(&file, options("bench", true)).unwrap();
    drive(&recorder, 10);
    recorder.finish();
    let survey = survey(&file);
    assert_eq!(survey.application.as_deref(), Some("bench"));
    assert_eq!((survey.seed, survey.application_start_ns), (Some(0), Some(0)));
    assert_eq!(survey.bytes, file.metadata().unwrap().len());
    assert_eq!((survey.messages, survey.seconds()), (108, 9.9));
    let count = survey
        .topics
        .iter()
        .find(|topic| topic.topic == "/robot/count")
        .unwrap();
    assert_eq!(
        (count.messages, count.bytes, count.rate_hz),
        (100, 100 * 12, Some(10.0))
    );
    assert_eq!(count.type_name, "std_msgs/msg/UInt64");
    assert_eq!(survey.decisions, 4);
    let group = |group: &str, decisions, switches| GroupSurvey {
        group: group.to_owned(),
        decisions,
        switches,
    };
    assert_eq!(survey.groups, [group("roots", 1, 1), group("base", 3, 2)]);
    assert_eq!(
        survey.troubled,
        [SchemaProblems {
            schema: "goon".to_owned(),
            faults: 1,
            overruns: 1,
            refused: 1,
            late: 0,
            last_fault: Some("it divided by zero".to_owned()),
        }]
    );
    assert_eq!(survey.lost, BTreeMap::from([("/robot/count".to_owned(), 3)]));
    assert_eq!((survey.triggers, survey.damage), (Vec::new(), None));
}

#[test]
fn a_survey_does_not_count_the_selection_in_force_at_the_beginning() {
    let folder = tempfile::tempdir().unwrap();
    let names = Names {
        groups: vec!["base".to_owned()],
        ..Names::default()
    };
    let condition = Condition::new("conflict:base", &names).unwrap();
    let trigger_options = TriggerOptions {
        triggers: Triggers::new(names, vec![condition]),
        before: 2 * SECOND,
        after: SECOND,
        memory: 1 << 20,
        on_file: Box::new(|_, _| {}),
    };
    let recorder = Recorder::create_triggered(
        &folder.path().join("drive.mcap"),
        options("bench", true),
        trigger_options,
    )
    .unwrap();
    drive(&recorder, 20);
    recorder.finish();
    let survey = survey(&folder.path().join("drive-001.mcap"));
    assert_eq!(survey.seconds(), 3.0);
    assert_eq!(survey.decisions, 1, "the three earlier selections do not count");
    let cause = &survey.triggers[0];
    assert_eq!(
        (cause.condition.as_str(), cause.reason.as_str(), cause.time_s),
        ("conflict:base", "conflict in base", 7.0)
    );
}

/// Returns the middle of the last chunk of a file.
fn last_chunk(bytes: &[u8]) -> usize {
    let (mut at, mut last) = (8, None);
    // A record is an opcode, a length and a body. The last one is the end of the file, or its footer.
    while let Some(length) = bytes.get(at + 1..at + 9) {
        let length = u64::from_le_bytes(length.try_into().unwrap()) as usize;
        if bytes[at] == 6 {
            last = Some(at + 9 + length / 2);
        }
        at += 9 + length;
    }
    last.expect("the file has a chunk")
}

#[test]
fn a_damaged_recording_is_surveyed_up_to_the_damage() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.mcap");
    let recorder = Recorder::create(&file, options("bench", true)).unwrap();
    drive(&recorder, 6_000);
    recorder.finish();
    let bytes = std::fs::read(&file).unwrap();
    let complete = survey(&file);
    // The index still refers to the corrupted chunk.
    let within = last_chunk(&bytes);
    let mut corrupted = bytes.clone();
    corrupted[within] ^= 0x40;
    for (damaged, offset) in [(&bytes[..bytes.len() / 2], bytes.len() / 2), (&corrupted, within)] {
        std::fs::write(&file, damaged).unwrap();
        let survey = survey(&file);
        let damage = survey.damage.as_ref().unwrap();
        assert!(damage.offset.unwrap() <= offset as u64, "{damage:?}");
        assert!(survey.messages > 0 && survey.messages < complete.messages);
        assert!(survey.last_ns < complete.last_ns);
    }
}
