//! A list with every kind of content.

use jde_panel::{Area, Color, Ink, Item, List, Place, Shape, Solid, Stroke, Trace, Wants, Words};

pub(crate) const INKS: [Ink; 8] = [
    Ink::Plain,
    Ink::Faint,
    Ink::Accent,
    Ink::Good,
    Ink::Warn,
    Ink::Bad,
    Ink::Goal,
    Ink::Seen,
];
pub(crate) const WORDS: [Words; 7] = [
    Words::Plain,
    Words::Heading,
    Words::Faint,
    Words::Good,
    Words::Warning,
    Words::Error,
    Words::Code,
];

/// Every shape of a canvas, in every ink.
pub(crate) fn shapes() -> Vec<Shape> {
    let stroke = |place: usize| Stroke {
        color: INKS[place].into(),
        width: 0.5 + place as f32,
    };
    vec![
        Shape::Line {
            points: vec![[0.0, -0.5], [1e-9, 1e9]],
            closed: true,
            stroke: stroke(0),
        },
        Shape::Points {
            points: vec![[1.0, 2.0]],
            stroke: stroke(1),
        },
        Shape::Circle {
            center: [1.0, 2.0],
            radius: 0.25,
            filled: true,
            stroke: stroke(2),
        },
        Shape::Circle {
            center: [1.0, 2.0],
            radius: 0.0,
            filled: false,
            stroke: stroke(3),
        },
        Shape::Polygon {
            points: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            color: INKS[4].into(),
        },
        Shape::Arrow {
            from: [0.0, 0.0],
            to: [1.0, 0.0],
            stroke: stroke(5),
        },
        Shape::Label {
            at: [1.0, 1.0],
            text: "söme\ntext".to_owned(),
            color: INKS[6].into(),
        },
        Shape::Line {
            points: Vec::new(),
            closed: false,
            stroke: stroke(7),
        },
        Shape::Robot {
            pose: [1.0, 2.0, -3.0],
        },
    ]
}

/// Every shape of a scene.
pub(crate) fn solids() -> Vec<Solid> {
    let color = Color::Exact([1, 2, 3, 4]);
    let place = Place {
        at: [1.0, 2.0, 3.0],
        turned: [0.1, 0.2, 0.3],
    };
    vec![
        Solid::Line {
            points: vec![[0.0; 3], [1.0; 3]],
            color,
            width: 2.0,
        },
        Solid::Points {
            points: vec![[1.0, 2.0, 3.0]],
            color,
            width: 3.0,
        },
        Solid::Box {
            place,
            size: [1.0, 2.0, 3.0],
            color,
        },
        Solid::Sphere {
            center: [1.0, 2.0, 3.0],
            radius: 0.5,
            color,
        },
        Solid::Cylinder {
            place,
            radius: 0.5,
            height: 2.0,
            color,
        },
        Solid::Arrow {
            from: [0.0; 3],
            to: [1.0; 3],
            color,
        },
        Solid::Mesh {
            corners: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            color,
        },
        Solid::Label {
            at: [1.0; 3],
            text: "upper label".to_owned(),
            color: Color::Ink(Ink::Good),
        },
    ]
}

/// Returns a list with every widget and every style of text, and with contents in every widget that can have
/// them.
pub(crate) fn all() -> List {
    let wants = |place: usize| Wants {
        clicks: place == 0,
        drags: place == 1,
        keys: place == 2,
    };
    let texts = WORDS.map(|words| Item::Text {
        text: format!("{words:?}"),
        words,
    });
    let slider = |id: &str| Item::Slider {
        id: id.to_owned(),
        label: "Area ahead".to_owned(),
        value: 0.1 + 0.2,
        least: -1.0,
        greatest: 3.0,
        unit: "m".to_owned(),
    };
    let mut items = texts.to_vec();
    items.extend([
        Item::Value {
            label: "speed".to_owned(),
            value: -0.0,
            unit: "m/s".to_owned(),
        },
        Item::Row {
            items: vec![
                Item::Button {
                    id: "go".to_owned(),
                    label: "Go".to_owned(),
                    enabled: false,
                },
                Item::Toggle {
                    id: "on".to_owned(),
                    label: String::new(),
                    on: true,
                },
                Item::Group {
                    id: "more".to_owned(),
                    label: "More".to_owned(),
                    open: true,
                    items: vec![slider("inner"), Item::Row { items: Vec::new() }],
                },
            ],
        },
        slider("ahead"),
        Item::Choice {
            id: "mode".to_owned(),
            label: "Mode".to_owned(),
            options: vec!["slow".to_owned(), "fast".to_owned()],
            chosen: 1,
        },
        Item::Image {
            id: "seen".to_owned(),
            width: 2,
            height: 1,
            channels: 3,
            pixels: vec![0, 1, 2, 253, 254, 255],
            wants: wants(0),
        },
        Item::Plot {
            id: "plot".to_owned(),
            label: "Speed".to_owned(),
            across: "time, s".to_owned(),
            up: "speed, m/s".to_owned(),
            traces: vec![Trace {
                name: "wanted".to_owned(),
                color: Color::Ink(Ink::Accent),
                points: vec![[0.0, 0.1], [1.0, f64::MIN_POSITIVE]],
            }],
        },
        Item::Table {
            id: "table".to_owned(),
            columns: vec!["child".to_owned(), "state".to_owned()],
            rows: vec![vec!["stop".to_owned(), "winner".to_owned()]],
        },
        Item::Canvas {
            id: "field".to_owned(),
            area: Some(Area {
                least: [-1.0, -2.0],
                greatest: [3.0, 4.0],
            }),
            forward_up: true,
            shapes: shapes(),
            wants: wants(1),
        },
        Item::Canvas {
            id: "empty".to_owned(),
            area: None,
            forward_up: false,
            shapes: Vec::new(),
            wants: Wants::default(),
        },
        Item::Scene {
            id: "space".to_owned(),
            frame: "odom".to_owned(),
            solids: solids(),
            wants: wants(2),
        },
    ]);
    List {
        time: u64::MAX,
        items,
    }
}
