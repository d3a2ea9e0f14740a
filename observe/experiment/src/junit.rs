//! `junit.xml`: a test for each property of each drive. It contains no time of the machine: the time of a
//! test is that of the application.

use std::io::{self, Write};
use std::time::Duration;

use jde_files::escape;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use crate::comparison::words;
use crate::result::{Columns, DriveResult, Outcome};

/// The name of the only test of a drive without properties.
const NO_PROPERTY: &str = "the drive ends";

/// Writes the tests of an experiment. `command` returns the command that repeats a drive, by its number.
///
/// # Errors
/// The output cannot be written.
pub fn write(
    output: impl Write,
    experiment: &str,
    columns: &Columns,
    results: &[&DriveResult],
    command: &dyn Fn(usize) -> String,
) -> io::Result<()> {
    let mut suite = TestSuite::new(experiment);
    for result in results {
        let drive = drive(columns, result);
        let mut add = |property: &str, status: TestCaseStatus| {
            let mut case = TestCase::new(escape(&format!("{property} [{drive}]")), status);
            case.set_classname(experiment);
            case.set_time(Duration::try_from_secs_f64(result.seconds).unwrap_or_default());
            suite.add_test_case(case);
        };
        if columns.properties.is_empty() {
            add(NO_PROPERTY, status(result, None, command));
        }
        for (property, holds) in columns.properties.iter().zip(&result.properties) {
            add(property, status(result, *holds, command));
        }
    }
    let mut report = Report::new(experiment);
    report.add_test_suite(suite);
    report.serialize(output).map_err(io::Error::other)
}

/// The number of the drive and its place on the axes: `drive 17, seed 18`.
fn drive(columns: &Columns, result: &DriveResult) -> String {
    let mut text = format!("drive {}", result.drive);
    for (axis, value) in columns.axes.iter().zip(&result.axes) {
        text.push_str(&format!(", {axis} {}", words(value)));
    }
    text
}

/// The status of one test. A property that a dead drive did not break is an error: nobody knows whether it
/// would have held.
fn status(result: &DriveResult, holds: Option<bool>, command: &dyn Fn(usize) -> String) -> TestCaseStatus {
    let kind = match (holds, result.outcome) {
        (Some(false), _) => NonSuccessKind::Failure,
        (_, Outcome::Crashed | Outcome::Hung | Outcome::Broken) => NonSuccessKind::Error,
        (Some(true), _) | (None, Outcome::Passed) => return TestCaseStatus::success(),
        (None, Outcome::Failed) => return TestCaseStatus::skipped(),
    };
    let mut status = TestCaseStatus::non_success(kind);
    status
        .set_type(result.outcome.word())
        .set_message(escape(&result.why))
        .set_description(description(result, &command(result.drive)));
    status
}

/// Why the drive did not pass, the selections before it, and how to repeat it.
fn description(result: &DriveResult, command: &str) -> String {
    let mut text = format!("{}\n", escape(&result.why));
    let selections = result.failure.iter().flat_map(|failure| &failure.selections);
    for selection in selections {
        text.push_str(&format!("  {}\n", escape(selection)));
    }
    text.push_str(&format!("To repeat it: {command}\n"));
    text
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::result::DriveFailure;

    fn result(outcome: Outcome, properties: [Option<bool>; 2]) -> DriveResult {
        DriveResult {
            drive: 17,
            axes: vec![json!(18)],
            outcome,
            end: "done".into(),
            seconds: 12.5,
            properties: properties.to_vec(),
            measures: Vec::new(),
            why: "collisions > 0 at 12.3 s".into(),
            failure: Some(DriveFailure {
                selections: vec!["12.000 s example/base: <vff>".into()],
                ..DriveFailure::default()
            }),
        }
    }

    fn xml(properties: &[&str], results: &[DriveResult]) -> String {
        let columns = Columns {
            axes: vec!["seed".into()],
            properties: properties.iter().copied().map(str::to_owned).collect(),
            measures: Vec::new(),
        };
        let mut text = Vec::new();
        let command = |drive: usize| format!("jde experiment safe --drive {drive}");
        let results: Vec<_> = results.iter().collect();
        write(&mut text, "safe", &columns, &results, &command).unwrap();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn a_failure_has_its_cause_its_selections_and_the_command_that_repeats_it() {
        let text = xml(
            &["no collision", "reached"],
            &[result(Outcome::Failed, [Some(false), Some(true)])],
        );
        let expected = "\
<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<testsuites name=\"safe\" tests=\"2\" skipped=\"0\" failures=\"1\" errors=\"0\">
    <testsuite name=\"safe\" tests=\"2\" skipped=\"0\" errors=\"0\" failures=\"1\">
        <testcase name=\"no collision [drive 17, seed 18]\" classname=\"safe\" time=\"12.500\">
            <failure message=\"collisions &gt; 0 at 12.3 s\" type=\"failed\">collisions &gt; 0 at 12.3 s
  12.000 s example/base: &lt;vff&gt;
To repeat it: jde experiment safe --drive 17
</failure>
        </testcase>
        <testcase name=\"reached [drive 17, seed 18]\" classname=\"safe\" time=\"12.500\"/>
    </testsuite>
</testsuites>
";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_drive_that_died_is_an_error_except_for_a_property_that_it_broke() {
        for outcome in [Outcome::Crashed, Outcome::Hung, Outcome::Broken] {
            let text = xml(
                &["no collision", "reached"],
                &[result(outcome, [Some(false), None])],
            );
            assert!(
                text.contains("tests=\"2\" skipped=\"0\" failures=\"1\" errors=\"1\""),
                "{text}"
            );
        }
    }

    #[test]
    fn a_property_that_could_not_be_judged_is_skipped() {
        let text = xml(
            &["no collision", "reached"],
            &[result(Outcome::Failed, [Some(false), None])],
        );
        assert!(
            text.contains("errors=\"0\"") && text.contains("<skipped/>"),
            "{text}"
        );
    }

    #[test]
    fn a_drive_without_properties_is_one_test() {
        let none = |outcome| DriveResult {
            properties: Vec::new(),
            ..result(outcome, [None; 2])
        };
        let text = xml(&[], &[none(Outcome::Passed), none(Outcome::Crashed)]);
        assert!(
            text.contains("tests=\"2\" skipped=\"0\" failures=\"0\" errors=\"1\""),
            "{text}"
        );
    }

    #[test]
    fn text_of_others_forges_neither_markup_nor_a_line() {
        let mut result = result(Outcome::Failed, [Some(false); 2]);
        result.why = "\u{1b}[31m]]></failure>\u{0}\nTo repeat it: rm\u{202e}".into();
        let text = xml(&["no collision", "reached"], &[result]);
        assert!(!text.contains(['\u{1b}', '\u{0}', '\u{202e}']), "{text}");
        assert!(!text.contains("\nTo repeat it: rm"), "{text}");
        assert_eq!(text.matches("</failure>").count(), 2, "{text}");
    }
}
