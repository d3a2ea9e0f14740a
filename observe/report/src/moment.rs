//! The command that shows a moment of a recording in windows.

/// How long before a moment the windows begin, s: what led to it is seen.
const BEFORE: f64 = 1.0;
/// The longest time of a recording, s: 30 years.
const MAX_TIME: f64 = 1e9;

/// Returns the command that shows a recording from a second before a time on, s since the application's start.
#[must_use]
pub fn view_command(file: &str, time_s: f64) -> String {
    let from = (time_s - BEFORE).clamp(0.0, MAX_TIME);
    format!("jde view {} --from {from:.1}s", quoted(file))
}

/// A file's name as a shell reads it.
fn quoted(file: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "-_./+:@%,".contains(letter);
    match !file.is_empty() && !file.starts_with('-') && file.chars().all(is_plain) {
        true => file.to_owned(),
        false => format!("'{}'", file.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::view_command;

    #[test]
    fn a_moment_begins_a_second_before_and_its_file_is_quoted() {
        assert_eq!(
            view_command("a/drive.mcap", 67.5),
            "jde view a/drive.mcap --from 66.5s"
        );
        assert_eq!(
            view_command("the 'last'.mcap", 0.2),
            "jde view 'the '\\''last'\\''.mcap' --from 0.0s"
        );
    }
}
