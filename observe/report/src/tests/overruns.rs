//! What a page says of missed deadlines.

use super::*;

/// The text of a part of a page, without its tags.
fn plain(markup: &str) -> String {
    let parts = markup.split('<').filter_map(|part| part.split_once('>'));
    parts.map(|(_, text)| text).collect()
}

#[test]
fn the_overruns_of_the_whole_are_those_of_all_schemas() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("overruns.mcap");
    let recorder = recorder(&file, Some(hierarchy(["one", "two"])));
    turns(&recorder, ["one", "two"], |_, _| ());
    for (ms, schema) in [(10, "one"), (20, "one"), (30, "two")] {
        let (time, schema) = (59_900_000_000 + ms * 1_000_000, schema.to_owned());
        // A missed deadline is an event and a change of health.
        let overrun = What::Overrun {
            schema: schema.clone(),
            took: 2,
            budget: 1,
        };
        recorder.push_record(overrun.at(time).into());
        let health = Health::Overrun;
        recorder.push_record(What::HealthChanged { schema, health }.at(time).into());
    }
    recorder.finish();
    let page = page(
        &read(&Recording::open(&file).unwrap(), columns(600)),
        "overruns.mcap",
    );
    let (_, card) = page.split_once("<dt>Overruns</dt>").unwrap();
    let (card, _) = card.split_once("</dd>").unwrap();
    assert_eq!(plain(card), "3");
    let table = page
        .split("<table>")
        .find(|table| table.contains(">overruns</th>"));
    let (table, _) = table.unwrap().split_once("</table>").unwrap();
    let rows = table.split("<tr>").filter(|row| row.contains("<td"));
    let overruns = rows.map(|row| {
        let cells: Vec<_> = row.split("<td").skip(1).collect();
        // Refusals and faults follow.
        plain(&format!("<td{}", cells[cells.len() - 3]))
    });
    assert_eq!(overruns.collect::<Vec<_>>(), ["2", "1"]);
}
