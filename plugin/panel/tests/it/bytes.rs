//! Lists and gestures as bytes: decoding inverts encoding, and invalid bytes are refused with a reason.

use crate::{checks, common};
use jde_panel::{
    Broken, Button, Gesture, Item, List, MOST_ENCODED, MOST_ITEMS, MOST_POINTS, Shape, Stroke, Touch, Wants,
    check, decode, encode,
};
use proptest::prelude::*;

fn gestures() -> Vec<Gesture> {
    let (at, button) = ([0.1 + 0.2, -2.0, 1e300], Button::Middle);
    let touches = [
        Touch::Pressed,
        Touch::Toggled(true),
        Touch::Moved(0.1 + 0.2),
        Touch::Chose(u32::MAX),
        Touch::Clicked { at, button },
        Touch::Dragged {
            from: [0.0; 3],
            to: at,
            button: Button::Secondary,
            ended: true,
        },
        Touch::Key {
            key: "ArrowUp".to_owned(),
            down: false,
        },
    ];
    touches
        .into_iter()
        .map(|touch| Gesture {
            widget: "field".to_owned(),
            touch,
        })
        .collect()
}

#[test]
fn decoding_inverts_encoding() {
    let list = common::all();
    assert_eq!(check(&list), Ok(()));
    assert_eq!(decode::<List>(&encode(&list)), Ok(list));
    for gesture in gestures() {
        assert_eq!(decode::<Gesture>(&encode(&gesture)), Ok(gesture));
    }
}

#[test]
fn json_has_the_same_form() {
    let list = common::all();
    let json = serde_json::to_string(&list).expect("it can be written as JSON");
    assert_eq!(
        serde_json::from_str::<List>(&json).expect("the JSON is a list"),
        list
    );
    let clicked = &gestures()[4];
    assert_eq!(
        serde_json::to_value(clicked).expect("it can be written as JSON"),
        serde_json::json!({
            "widget": "field",
            "touch": { "clicked": { "at": [0.1 + 0.2, -2.0, 1e300], "button": "middle" } }
        })
    );
}

#[test]
fn the_documentation_shows_a_list_and_a_gesture() {
    let text = include_str!("../../../../docs/panels.md");
    let mut blocks = text
        .split("```json")
        .skip(1)
        .filter_map(|rest| rest.split("```").next());
    let list: List =
        serde_json::from_str(blocks.next().expect("there is a list")).expect("the JSON is a list");
    assert_eq!(check(&list), Ok(()));
    assert_eq!(list.items.len(), 3);
    let gesture: Gesture =
        serde_json::from_str(blocks.next().expect("there is a gesture")).expect("the JSON is a gesture");
    assert_eq!(gesture.clicked("field"), Some([1.2, 3.4, 0.0]));
}

#[test]
fn more_bytes_than_the_limit_are_refused_at_once() {
    let zeros = vec![0; MOST_ENCODED + 1];
    assert_eq!(decode::<List>(&zeros), Err(Broken::Encoded(MOST_ENCODED + 1)));
}

#[test]
fn bytes_nested_without_end_are_refused() {
    let nested = vec![0x81; 100_000];
    assert!(matches!(decode::<List>(&nested), Err(Broken::Bytes(_))));
}

fn encoded(items: Vec<Item>) -> Vec<u8> {
    encode(&List { time: 0, items })
}

fn table(columns: usize, rows: Vec<Vec<String>>) -> Item {
    Item::Table {
        id: "table".to_owned(),
        columns: vec![String::new(); columns],
        rows,
    }
}

fn line(points: usize) -> Item {
    Item::Canvas {
        id: "plane".to_owned(),
        area: None,
        forward_up: false,
        shapes: vec![Shape::Line {
            points: vec![[0.5, 0.5]; points],
            closed: false,
            stroke: Stroke::default(),
        }],
        wants: Wants::default(),
    }
}

#[test]
fn an_oversized_list_is_refused_while_it_is_decoded() {
    let empty = |rows: usize| table(0, vec![Vec::new(); rows]);
    let rows = vec![Item::Row { items: Vec::new() }; MOST_ITEMS + 1];
    let options = Item::Choice {
        id: "choice".to_owned(),
        label: String::new(),
        options: vec![String::new(); MOST_ITEMS],
        chosen: 0,
    };
    for items in [
        rows,
        vec![empty(MOST_ITEMS)],
        vec![empty(MOST_ITEMS / 2), empty(MOST_ITEMS / 2)],
        vec![table(2, vec![vec![String::new(); 2]; MOST_ITEMS / 2])],
        vec![table(MOST_ITEMS, Vec::new())],
        vec![options],
    ] {
        assert_eq!(decode::<List>(&encoded(items)), Err(Broken::Items));
    }
    assert_eq!(
        decode::<List>(&encoded(vec![line(MOST_POINTS / 2), line(MOST_POINTS / 2 + 1)])),
        Err(Broken::Points)
    );
}

#[test]
fn the_largest_allowed_lists_are_decoded() {
    let row = Item::Row { items: Vec::new() };
    for items in [
        vec![row.clone(); MOST_ITEMS],
        vec![table(1, vec![vec![String::new()]; MOST_ITEMS - 2])],
        vec![table(0, vec![Vec::new(); MOST_ITEMS - 1])],
        vec![line(MOST_POINTS)],
    ] {
        let list = List { time: 0, items };
        assert_eq!(check(&list), Ok(()));
        assert_eq!(decode::<List>(&encode(&list)).as_ref(), Ok(&list));
        let json = serde_json::to_string(&list).expect("it can be written as JSON");
        assert_eq!(serde_json::from_str::<List>(&json).ok().as_ref(), Some(&list));
    }
    // The counts of one list affect neither the next list nor a single widget.
    let bytes = encode(&row);
    for _ in 0..=MOST_ITEMS {
        assert_eq!(decode::<Item>(&bytes).as_ref(), Ok(&row));
    }
}

#[test]
fn a_gesture_with_control_characters_is_refused() {
    let key = |key: &str| Touch::Key {
        key: key.to_owned(),
        down: true,
    };
    for (widget, touch) in [
        ("go\u{1b}[2J", Touch::Pressed),
        ("go\n", Touch::Pressed),
        ("go", key("a\u{9b}2J")),
        ("go", key("\u{7}")),
    ] {
        let gesture = Gesture {
            widget: widget.to_owned(),
            touch,
        };
        let message = gesture.check().expect_err("the gesture is refused").to_string();
        assert!(message.ends_with("a name with control characters"), "{message}");
        assert!(!message.contains(char::is_control), "{message:?}");
    }
}

proptest! {
    #[test]
    fn the_checks_hold_for_random_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..512)) {
        checks::list(&bytes);
        checks::gesture(&bytes);
    }

    #[test]
    fn the_checks_hold_for_a_list_with_changed_bytes(
        changes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<proptest::sample::Index>(),
    ) {
        let mut bytes = encode(&common::all());
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        bytes.truncate(cut.index(bytes.len()) + 1);
        checks::list(&bytes);
    }
}
