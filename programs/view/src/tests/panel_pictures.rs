//! Pictures of a panel with every widget, dark and light.

use eframe::egui::Theme;
use egui_kittest::{SnapshotOptions, SnapshotResults};
use jde_panel::{Ink, Item, Trace, Wants, Words};

use super::panel::{clicks, field, harness_of};

/// A list with every widget.
fn everything() -> Vec<Item> {
    let text = |text: &str, words| Item::Text {
        text: text.to_owned(),
        words,
    };
    let traces = [("free", Ink::Good, 0.0), ("near", Ink::Warn, 1.0)].map(|(name, color, phase)| Trace {
        name: name.to_owned(),
        color: color.into(),
        points: (0..200)
            .map(|n| f64::from(n) * 0.05)
            .map(|x| [x, (x + phase).sin()])
            .collect(),
    });
    vec![
        text("Everything", Words::Heading),
        Item::Row {
            items: vec![
                text("plain", Words::Plain),
                text("faint", Words::Faint),
                text("good", Words::Good),
                text("warning", Words::Warning),
                text("error", Words::Error),
                text("code()", Words::Code),
            ],
        },
        Item::Value {
            label: "Speed".to_owned(),
            value: 0.4,
            unit: "m/s".to_owned(),
        },
        Item::Slider {
            id: "turn".to_owned(),
            label: "Turn rate".to_owned(),
            value: 0.5,
            least: 0.0,
            greatest: 1.0,
            unit: "rad/s".to_owned(),
        },
        Item::Choice {
            id: "way".to_owned(),
            label: "Way".to_owned(),
            options: vec!["straight".to_owned(), "around".to_owned()],
            chosen: 1,
        },
        Item::Row {
            items: vec![
                Item::Button {
                    id: "go".to_owned(),
                    label: "Go".to_owned(),
                    enabled: true,
                },
                Item::Button {
                    id: "no".to_owned(),
                    label: "Not now".to_owned(),
                    enabled: false,
                },
                Item::Toggle {
                    id: "quiet".to_owned(),
                    label: "Quiet".to_owned(),
                    on: true,
                },
                Item::Value {
                    label: "Heading".to_owned(),
                    value: 1.0,
                    unit: "rad".to_owned(),
                },
            ],
        },
        Item::Row {
            items: vec![
                field(clicks(), true),
                Item::Image {
                    id: "seen".to_owned(),
                    // Primes: no edge of an enlarged pixel falls on the centre of a screen pixel,
                    // where renderers differ.
                    width: 31,
                    height: 23,
                    channels: 3,
                    pixels: (0..31 * 23)
                        .flat_map(|n| [(n % 31 * 8) as u8, (n / 31 * 11) as u8, 90])
                        .collect(),
                    wants: Wants::default(),
                },
            ],
        },
        Item::Row {
            items: vec![
                Item::Plot {
                    id: "curves".to_owned(),
                    label: "Distances".to_owned(),
                    across: "time, s".to_owned(),
                    up: "distance, m".to_owned(),
                    traces: traces.into(),
                },
                Item::Table {
                    id: "rows".to_owned(),
                    columns: vec!["name".to_owned(), "distance".to_owned()],
                    rows: (0..30)
                        .map(|n| vec![format!("wall {n}"), format!("{n} m")])
                        .collect(),
                },
            ],
        },
        Item::Group {
            id: "more".to_owned(),
            label: "More".to_owned(),
            open: true,
            items: vec![Item::Scene {
                id: "space".to_owned(),
                frame: "odom".to_owned(),
                solids: Vec::new(),
                wants: Wants::default(),
            }],
        },
    ]
}

#[test]
fn a_panel_with_every_widget_matches_its_snapshots() {
    // Renderers differ in the rounding at the edges of letters.
    let options = SnapshotOptions::new().threshold(1.5).max_failed_pixels(60);
    let mut results = SnapshotResults::new();
    for (theme, name) in [(Theme::Dark, "panel-dark"), (Theme::Light, "panel-light")] {
        let mut harness = harness_of(everything(), [760.0, 640.0], theme);
        harness.snapshot_options(name, &options);
        results.extend_harness(&mut harness);
    }
}
