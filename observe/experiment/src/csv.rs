//! `results.csv`: the columns of `results.jsonl` without `failure`, as RFC 4180 has it. What has no value is
//! empty; texts are bare and in one line each, and an axis whose value is a table is JSON.

use std::io::{self, Write};

use csv::{Terminator, WriterBuilder};
use jde_files::escape;
use serde_json::Value;

use crate::result::{Columns, DriveResult};

/// Writes the results with a line of titles.
///
/// # Errors
/// The output cannot be written.
pub fn write(output: impl Write, columns: &Columns, results: &[&DriveResult]) -> io::Result<()> {
    let mut writer = WriterBuilder::new()
        .terminator(Terminator::CRLF)
        .from_writer(output);
    let measures = columns.measures.iter().map(|measure| &measure.name);
    writer.write_record(
        ["drive"]
            .into_iter()
            .chain(columns.axes.iter().map(String::as_str))
            .chain(["outcome", "end", "seconds"])
            .chain(columns.properties.iter().chain(measures).map(String::as_str))
            .chain(["why"]),
    )?;
    for result in results {
        let properties = result.properties.iter().map(optional);
        writer.write_record(
            [result.drive.to_string()]
                .into_iter()
                .chain(result.axes.iter().map(axis))
                .chain([result.outcome.word().to_owned(), escape(&result.end)])
                .chain([result.seconds.to_string()])
                .chain(properties.chain(result.measures.iter().map(optional)))
                .chain([escape(&result.why)]),
        )?;
    }
    writer.flush()
}

fn axis(value: &Value) -> String {
    match value {
        Value::String(text) => escape(text),
        Value::Null => String::new(),
        value => escape(&value.to_string()),
    }
}

fn optional(value: &Option<impl ToString>) -> String {
    value.as_ref().map(ToString::to_string).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::result::{MeasureColumn, Outcome};

    #[test]
    fn every_field_survives_commas_and_quotes_and_a_row_is_one_line() {
        let columns = Columns {
            axes: ["seed", "start", "variant"].map(str::to_owned).to_vec(),
            properties: vec!["near, or far".into(), "reached".into()],
            measures: vec![MeasureColumn {
                name: "nearest".into(),
                unit: "m".into(),
            }],
        };
        let result = DriveResult {
            drive: 7,
            axes: vec![json!(8), json!({ "x": 1.5 }), json!(null)],
            outcome: Outcome::Crashed,
            end: String::new(),
            seconds: 12.5,
            properties: vec![Some(true), None],
            measures: vec![Some(0.1)],
            why: "signal 11\nwhile \"goon\" iterated".into(),
            failure: None,
        };
        let mut text = Vec::new();
        write(&mut text, &columns, &[&result]).unwrap();
        assert_eq!(
            String::from_utf8(text).unwrap(),
            "drive,seed,start,variant,outcome,end,seconds,\"near, or far\",reached,nearest,why\r\n\
             7,8,\"{\"\"x\"\":1.5}\",,crashed,,12.5,true,,0.1,\"signal 11\\nwhile \"\"goon\"\" iterated\"\r\n"
        );
    }
}
