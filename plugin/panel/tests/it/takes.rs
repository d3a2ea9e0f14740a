//! A panel accepts the gestures that it offers, and no others.

use crate::common;
use jde_panel::{Button, Gesture, Item, List, Touch, Wants};

fn result(list: &List, widget: &str, touch: Touch) -> String {
    let gesture = Gesture {
        widget: widget.to_owned(),
        touch,
    };
    match list.takes(&gesture) {
        Ok(()) => "accepted".to_owned(),
        Err(broken) => broken.to_string(),
    }
}

fn click() -> Touch {
    Touch::Clicked {
        at: [0.0; 3],
        button: Button::Primary,
    }
}

fn drag() -> Touch {
    Touch::Dragged {
        from: [0.0; 3],
        to: [1.0; 3],
        button: Button::Primary,
        ended: false,
    }
}

fn key() -> Touch {
    Touch::Key {
        key: "a".to_owned(),
        down: true,
    }
}

/// Returns the list with every kind of content. `enabled` states whether the button can be pressed.
fn list(enabled: bool) -> List {
    let mut list = common::all();
    let button = Item::Button {
        id: "now".to_owned(),
        label: String::new(),
        enabled,
    };
    let row = Item::Row { items: vec![button] };
    list.items.push(row);
    list
}

#[test]
fn offered_gestures_are_accepted() {
    for (widget, touch) in [
        ("now", Touch::Pressed),
        ("on", Touch::Toggled(true)),
        ("on", Touch::Toggled(false)),
        ("ahead", Touch::Moved(-1.0)),
        ("inner", Touch::Moved(3.0)),
        ("mode", Touch::Chose(1)),
        ("seen", click()),
        ("field", drag()),
        ("space", key()),
    ] {
        assert_eq!(result(&list(true), widget, touch), "accepted", "{widget}");
    }
}

#[test]
fn other_gestures_are_refused_with_the_reason() {
    let wrong = "it is not a widget of which this can be done";
    for (widget, touch, reason) in [
        ("gone", Touch::Pressed, "the panel shows no such widget now"),
        ("", Touch::Pressed, "the panel shows no such widget now"),
        ("now", Touch::Pressed, "it cannot be pressed now"),
        ("now", Touch::Toggled(true), wrong),
        ("on", Touch::Pressed, wrong),
        ("ahead", Touch::Moved(3.1), "3.1 is not from -1 to 3"),
        ("ahead", Touch::Moved(f64::NAN), "NaN is not from -1 to 3"),
        ("ahead", click(), wrong),
        ("mode", Touch::Chose(2), "it has 2 options, counted from 0"),
        ("table", Touch::Chose(0), wrong),
        ("more", Touch::Pressed, wrong),
        ("seen", drag(), "it takes no drags"),
        ("field", click(), "it takes no clicks"),
        ("field", key(), "it takes no keys"),
        ("space", click(), "it takes no clicks"),
        (
            "space",
            Touch::Pressed,
            "it is a picture: it can be clicked, dragged or given keys",
        ),
    ] {
        assert_eq!(
            result(&list(false), widget, touch),
            format!("`{widget}`: {reason}")
        );
    }
}

#[test]
fn every_widget_is_found_at_every_depth() {
    let list = list(true);
    let ids: Vec<_> = list.walk().filter_map(Item::id).collect();
    let known = [
        "go", "on", "more", "inner", "ahead", "mode", "seen", "plot", "table", "field", "empty", "space",
        "now",
    ];
    assert_eq!(ids, known);
    let rows = list.walk().filter(|item| matches!(item, Item::Row { .. }));
    assert_eq!(rows.count(), 3);
    let canvas = list.walk().find(|item| item.id() == Some("empty"));
    assert!(matches!(canvas, Some(Item::Canvas { wants, .. }) if *wants == Wants::default()));
}
