//! Tests of the page, parsed as a browser does.

use html5ever::tendril::TendrilSink;
use jde_drawing::map::{DriveMap, FailurePlace, PathPoint, RobotPath};
use markup5ever_rcdom::{Handle, NodeData, RcDom};

use super::*;

/// The page of an experiment whose texts all contain `text`, with this many failed drives.
fn report(text: &str, failed: usize) -> Report {
    let place = |place: usize| PathPoint {
        time: place as f64,
        x: place as f64,
        y: 1.0,
        heading: 0.0,
        winner: Some(0),
    };
    let path = DriveMap {
        title: text.to_owned(),
        schema_names: vec![text.to_owned()],
        paths: vec![RobotPath {
            robot: text.to_owned(),
            points: (0..5).map(place).collect(),
            ..RobotPath::default()
        }],
        ..DriveMap::default()
    };
    let table = Table {
        note: text.to_owned(),
        titles: ["name", text].map(title).to_vec(),
        rows: vec![vec![
            Cell::from(text),
            Cell {
                details: vec![text.to_owned()],
                ..Cell::from("7")
            },
        ]],
    };
    let drive = |number: usize| FailedDrive {
        number,
        axes: text.to_owned(),
        outcome: text.to_owned(),
        why: text.to_owned(),
        path: (number < IN_FULL).then(|| path.clone()),
        selections: vec![text.to_owned()],
        command: format!("jde experiment safe --drive {number} {text}"),
    };
    Report {
        name: format!("safe {text}"),
        doc: text.to_owned(),
        facts: vec![Fact {
            label: text.to_owned(),
            value: text.to_owned(),
            detail: text.to_owned(),
            is_bad: true,
        }],
        results: table.clone(),
        differences: table.clone(),
        properties: table,
        distributions: vec![distribution(text, &[1.5, 2.5, 2.5, f64::NAN])],
        places: vec![FailureMap {
            title: text.to_owned(),
            note: text.to_owned(),
            ground: DriveMap::default(),
            places: vec![FailurePlace {
                x: 1.0,
                y: 2.0,
                label: text.to_owned(),
            }],
        }],
        failures: (0..failed).map(drive).collect(),
        method: text.to_owned(),
    }
}

fn title(text: &str) -> Title {
    Title {
        text: text.to_owned(),
        is_number: true,
    }
}

fn distribution(text: &str, values: &[f64]) -> Distribution {
    Distribution {
        measure: text.to_owned(),
        unit: text.to_owned(),
        rows: vec![DistributionRow {
            name: text.to_owned(),
            passed: values.to_vec(),
            others: values.to_vec(),
            median: Some([2.5, 1.5, 2.5]),
        }],
    }
}

/// The elements of a page, which has no error of HTML.
fn elements(html: &str) -> Vec<Handle> {
    let dom = html5ever::parse_document(RcDom::default(), html5ever::ParseOpts::default()).one(html);
    assert!(dom.errors.borrow().is_empty(), "{:?}", dom.errors.borrow());
    let mut found = Vec::new();
    let mut open = vec![dom.document.clone()];
    while let Some(node) = open.pop() {
        open.extend(node.children.borrow().iter().cloned());
        if matches!(node.data, NodeData::Element { .. }) {
            found.push(node);
        }
    }
    found
}

fn count(elements: &[Handle], name: &str) -> usize {
    let is_named = |node: &&Handle| match &node.data {
        NodeData::Element { name: found, .. } => &*found.local == name,
        _ => false,
    };
    elements.iter().filter(is_named).count()
}

fn ids(elements: &[Handle]) -> Vec<String> {
    let ids = elements.iter().filter_map(|node| match &node.data {
        NodeData::Element { attrs, .. } => {
            let attrs = attrs.borrow();
            let id = attrs.iter().find(|attr| &*attr.name.local == "id");
            id.map(|id| id.value.to_string())
        }
        _ => None,
    });
    ids.collect()
}

#[test]
fn no_text_becomes_markup() {
    for text in [
        "<script>alert(1)</script>",
        "\"><img src=x onerror=alert(2)>",
        "</title></style></svg><img>",
        "'&amp;<!--",
    ] {
        let found = elements(&page(&report(text, IN_FULL + 1)));
        let harmless = elements(&page(&report("harmless", IN_FULL + 1)));
        assert_eq!(count(&found, "script") + count(&found, "img"), 0, "{text}");
        assert_eq!(found.len(), harmless.len(), "{text}");
    }
}

#[test]
fn the_page_loads_nothing_and_runs_nothing() {
    let page = page(&report("text", 3));
    for forbidden in ["http:", "https:", "src=", "@import", "url(//", "<link", "script"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(
        page.contains(
            "content=\"default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\""
        ),
        "{page}"
    );
}

#[test]
fn every_link_has_its_part_and_every_id_is_there_once() {
    let page = page(&report("text", 3));
    let mut ids = ids(&elements(&page));
    for part in [
        "results",
        "differences",
        "properties",
        "distributions",
        "places",
        "failures",
        "drive-2",
    ] {
        assert!(ids.iter().any(|id| id == part), "{part}: {ids:?}");
    }
    let total = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), total, "{ids:?}");
}

#[test]
fn an_experiment_without_drives_has_no_empty_parts() {
    let page = page(&Report::default());
    let found = elements(&page);
    assert_eq!(
        count(&found, "section") + count(&found, "table") + count(&found, "svg"),
        0,
        "{page}"
    );
}

#[test]
fn only_the_first_failed_drives_are_drawn_and_no_command_of_a_row_is_lost() {
    let page = page(&report("text", IN_FULL + 1_002));
    let found = elements(&page);
    // A distribution and a map of the world beside them.
    assert_eq!(count(&found, "svg"), IN_FULL + 2);
    assert_eq!(count(&found, "article"), IN_FULL);
    for (number, is_there) in [(0, true), (IN_FULL + 999, true), (IN_FULL + 1_000, false)] {
        let command = format!("safe --drive {number} text");
        assert_eq!(page.contains(&command), is_there, "{number}");
    }
    assert!(page.contains("2 further drives are only in"), "{page}");
}

#[test]
fn values_that_no_axis_can_show_draw_nothing() {
    for values in [&[][..], &[f64::NAN], &[f64::MIN, f64::MAX], &[f64::INFINITY]] {
        let report = Report {
            distributions: vec![distribution("time", values)],
            ..Report::default()
        };
        assert_eq!(count(&elements(&page(&report)), "svg"), 0, "{values:?}");
    }
}
