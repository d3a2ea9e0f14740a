//! What must hold for any bytes that are given as a recording. The fuzz target runs the same function.

use std::io::Write;

use jde_log::{RecordedVariables, Recording, Survey};

/// A file is refused, or what can be read of it is read: its messages in the order of their times, each as a value or with a
/// reason why it is none.
pub(crate) fn recording(data: &[u8]) {
    let mut file = tempfile::NamedTempFile::new().expect("there is room for a file");
    file.write_all(data).expect("there is room for it");
    let Ok(recording) = Recording::open(file.path()) else {
        return;
    };
    let variables = RecordedVariables::of(&recording);
    let mut left_out = variables.left_out().clone();
    let (mut value, mut before) = (Vec::new(), 0);
    for message in recording
        .messages()
        .expect("the file is there")
        .map_while(Result::ok)
    {
        // Chunks may state other times than their messages have.
        before = before.max(message.log_time);
        variables.check(&message, &mut value, &mut left_out);
    }
    for name in recording.attachments() {
        let _ = recording.attachment(name);
    }
    let survey = Survey::of(&recording).expect("the file is there");
    assert_eq!(survey.last_ns.unwrap_or(0).max(before), before);
    assert_eq!(survey.left_out, left_out.lines().collect::<Vec<_>>());
}
