//! A recording of a killed process can be read up to the last flush.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use jde_log::Recording;
use jde_panel::List;
use jde_recorder::{Recorder, Stamps};
use jde_types::Value;
use jde_watchdog::Watchdog;

use crate::support::options;

/// The file that the child process records. Set in the child only.
const FILE: &str = "JDE_LOG_TEST_FILE";

/// Records until it is killed. Prints the number of messages that have reached the file whenever it changes.
fn record_until_killed(file: &Path) {
    let recorder = Recorder::create(file, options("victim", true)).unwrap();
    let topic = recorder.topic("/victim/count", Arc::new(u64::describe()), BTreeMap::new());
    let panel = recorder.panel("victim");
    let mut printed = 0;
    for number in 1.. {
        let stamps = Stamps {
            published: number,
            measured: number,
            sequence: number,
        };
        topic.put(&number.to_ne_bytes(), stamps);
        let list = List {
            time: number,
            items: Vec::new(),
        };
        panel.put_panel(&Ok(list), stamps);
        let kept = recorder.status().written;
        if kept > printed {
            printed = kept;
            // If this fails, the parent has ended, and this process ends too.
            println!("\nkept {printed}");
        }
    }
}

#[test]
fn a_recording_of_a_killed_process_is_read_up_to_its_last_flush() {
    let _watchdog = Watchdog::for_test();
    if let Some(file) = std::env::var_os(FILE) {
        return record_until_killed(file.as_ref());
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "killed::a_recording_of_a_killed_process_is_read_up_to_its_last_flush",
            "--nocapture",
        ])
        .env(FILE, &file)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    // The second flush comes half a second after the first.
    let kept = lines
        .filter_map(|line| line.unwrap().strip_prefix("kept ")?.parse::<u64>().ok())
        .nth(1)
        .expect("the child prints the number of kept messages");
    // SIGKILL: no code of the process runs after it.
    child.kill().unwrap();
    child.wait().unwrap();

    let recording = Recording::open(&file).unwrap();
    assert!(recording.damage().is_some(), "the index is missing");
    assert_eq!(recording.metadata("jde").unwrap()["application"], "victim");
    let messages: Vec<_> = recording.messages().unwrap().map(Result::unwrap).collect();
    assert!(messages.len() as u64 >= kept, "{} of {kept}", messages.len());
    let (values, panels): (Vec<_>, Vec<_>) = messages
        .iter()
        .partition(|message| message.channel.topic == "/victim/count");
    for (index, message) in values.iter().enumerate() {
        assert_eq!(message.log_time, index as u64 + 1, "no message is missing");
    }
    for (index, message) in panels.iter().enumerate() {
        assert_eq!(jde_log::panel::schema(&message.channel), Some("victim"));
        let list = jde_log::panel::read(&message.data).unwrap().unwrap();
        assert_eq!(list.time, index as u64 + 1);
    }
    assert!(panels.len().abs_diff(values.len()) <= 1);
}
