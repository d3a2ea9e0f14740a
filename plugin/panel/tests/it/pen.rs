//! The valid input of a pen, and the result of invalid input: a list that is broken with a reason, and
//! nothing else.

#![allow(unsafe_code)]

use core::ffi::c_char;
use core::ptr;

use jde_abi::raw;
use jde_panel::{
    Button, Color, Gesture, Ink, Item, List, MOST_ITEMS, MOST_POINTS, Shape, Touch, lend_gesture, lend_pen,
    read_gesture,
};

fn widget(kind: u32) -> raw::Widget {
    raw::Widget {
        size: size_of::<raw::Widget>() as u32,
        kind,
        id: ptr::null(),
        label: ptr::null(),
        unit: ptr::null(),
        value: 0.0,
        least: 0.0,
        greatest: 0.0,
        area: [0.0; 4],
        texts: ptr::null(),
        pixels: ptr::null(),
        text_count: 0,
        number: 0,
        flags: 0,
        width: 0,
        height: 0,
        channels: 0,
    }
}

fn widget_with_id(kind: u32) -> raw::Widget {
    raw::Widget {
        id: c"it".as_ptr(),
        ..widget(kind)
    }
}

fn shape(kind: u32, points: &[f64], count: u32) -> raw::Shape {
    raw::Shape {
        size: size_of::<raw::Shape>() as u32,
        kind,
        points: points.as_ptr(),
        point_count: count,
        color: raw::INK_PLAIN,
        width: 0.0,
        radius: 0.0,
        extent: [0.0; 3],
        turned: [0.0; 3],
        text: ptr::null(),
        flags: 0,
        reserved: 0,
    }
}

/// A plugin's calls of a pen.
struct PenCalls(*const raw::Pen);

impl PenCalls {
    fn add(&self, widget: *const raw::Widget) -> i32 {
        // SAFETY: the pen is lent. The tests pass invalid widgets.
        unsafe { ((*self.0).add)((*self.0).drawing, widget) }
    }

    fn shape(&self, shape: *const raw::Shape) -> i32 {
        // SAFETY: as above.
        unsafe { ((*self.0).shape)((*self.0).drawing, shape) }
    }

    fn end(&self) -> i32 {
        // SAFETY: as above.
        unsafe { ((*self.0).end)((*self.0).drawing) }
    }
}

fn drawn(draw: impl FnOnce(&PenCalls)) -> Result<List, String> {
    let ((), list) = lend_pen(7, |pen| draw(&PenCalls(pen)));
    list.map_err(|broken| broken.to_string())
}

/// Checks that one widget is refused, and so is a valid one after it.
#[track_caller]
fn assert_refused(invalid: *const raw::Widget, reason: &str) {
    let result = drawn(|pen| {
        assert_eq!(pen.add(invalid), raw::BAD_ARGUMENT);
        assert_eq!(pen.add(&widget(raw::WIDGET_TEXT)), raw::BAD_ARGUMENT);
        assert_eq!(pen.end(), raw::BAD_ARGUMENT);
    });
    assert_eq!(result, Err(reason.to_owned()));
}

/// Checks that one shape is refused in a widget of that kind.
#[track_caller]
fn assert_shape_refused(container: u32, invalid: *const raw::Shape, reason: &str) {
    let result = drawn(|pen| {
        assert_eq!(pen.add(&widget_with_id(container)), raw::OK);
        assert_eq!(pen.shape(invalid), raw::BAD_ARGUMENT);
    });
    assert_eq!(result, Err(reason.to_owned()));
}

#[test]
fn a_list_contains_what_was_added() {
    let list = drawn(|pen| {
        let mut text = widget(raw::WIDGET_TEXT);
        text.label = c"hello".as_ptr();
        text.number = raw::WORDS_GOOD;
        assert_eq!(pen.add(&text), raw::OK);
        assert_eq!(pen.add(&widget_with_id(raw::WIDGET_CANVAS)), raw::OK);
        let mut line = shape(raw::SHAPE_LINE, &[0.0, 1.0, 2.0, 3.0], 2);
        line.color = 0x8010_2030;
        assert_eq!(pen.shape(&line), raw::OK);
        assert_eq!(pen.end(), raw::OK);
    })
    .expect("the list is valid");
    assert_eq!(list.time, 7);
    let [
        Item::Text { text, .. },
        Item::Canvas {
            shapes, area: None, ..
        },
    ] = &list.items[..]
    else {
        panic!("{list:#?}")
    };
    assert_eq!(text, "hello");
    let [Shape::Line { points, stroke, .. }] = &shapes[..] else {
        panic!("{shapes:#?}")
    };
    assert_eq!(points[..], [[0.0, 1.0], [2.0, 3.0]]);
    assert_eq!(stroke.color, Color::Exact([0x10, 0x20, 0x30, 0x80]));
}

#[test]
fn an_invalid_table_is_refused() {
    assert_refused(
        ptr::null(),
        "`a widget`: the pointer to its table is null or not aligned",
    );
    assert_refused(
        ptr::without_provenance(1),
        "`a widget`: the pointer to its table is null or not aligned",
    );
    let mut small = widget(raw::WIDGET_TEXT);
    small.size -= 1;
    assert_refused(
        &small,
        "`a widget`: a table says it has 127 bytes, and this ABI needs 128",
    );
    assert_eq!(size_of::<raw::Widget>(), 128);
    let mut larger = widget(raw::WIDGET_TEXT);
    larger.size += 8;
    drawn(|pen| assert_eq!(pen.add(&larger), raw::OK)).expect("a larger table is accepted");
}

#[test]
fn unknown_kinds_text_styles_and_colors_are_refused() {
    assert_refused(
        &widget_with_id(13),
        "`it`: its kind is 13, and this host knows 0 to 12",
    );
    let mut words = widget(raw::WIDGET_TEXT);
    words.number = 7;
    assert_refused(&words, "`a text`: there are no words 7");
    let mut ink = shape(raw::SHAPE_LINE, &[], 0);
    ink.color = 8;
    assert_shape_refused(raw::WIDGET_CANVAS, &ink, "`it`: there is no ink 8");
    assert_shape_refused(
        raw::WIDGET_CANVAS,
        &shape(raw::SHAPE_MESH, &[], 0),
        "`it`: a canvas has no shape of kind 10",
    );
    assert_shape_refused(
        raw::WIDGET_SCENE,
        &shape(raw::SHAPE_ROBOT, &[], 0),
        "`it`: a scene has no shape of kind 6",
    );
    assert_shape_refused(
        raw::WIDGET_PLOT,
        &shape(raw::SHAPE_POINTS, &[], 0),
        "`it`: a plot holds nothing but lines",
    );
    assert_shape_refused(
        raw::WIDGET_GROUP,
        &shape(raw::SHAPE_LINE, &[], 0),
        "`it`: a shape outside of a plot, canvas or scene",
    );
}

#[test]
fn texts_that_are_not_utf8_are_refused() {
    let bytes: [c_char; 2] = [-1, 0];
    let mut text = widget_with_id(raw::WIDGET_BUTTON);
    text.label = bytes.as_ptr();
    assert_refused(&text, "`it`: a text is not UTF-8");
}

#[test]
fn counts_are_checked_before_their_elements() {
    let mut choice = widget_with_id(raw::WIDGET_CHOICE);
    choice.text_count = 2;
    assert_refused(&choice, "`it`: a pointer to 2 elements is null or not aligned");
    choice.texts = ptr::without_provenance(8);
    choice.text_count = MOST_ITEMS as u32 + 1;
    assert_refused(&choice, "it has more than 20000 widgets and shapes");
    let mut image = widget_with_id(raw::WIDGET_IMAGE);
    (image.width, image.height, image.channels) = (u32::MAX, u32::MAX, u32::MAX);
    image.pixels = ptr::without_provenance(8);
    assert_refused(
        &image,
        &format!(
            "its texts and pixels have {} bytes, and 8388608 are allowed",
            usize::MAX
        ),
    );
    let mut table = widget_with_id(raw::WIDGET_TABLE);
    let cells = [c"a".as_ptr(); 3];
    (table.texts, table.text_count, table.number) = (cells.as_ptr(), 3, 2);
    assert_refused(&table, "`it`: 3 texts do not fill 2 columns");
    table.number = 0;
    assert_refused(&table, "`it`: 3 texts do not fill 0 columns");

    let mut line = shape(raw::SHAPE_LINE, &[], MOST_POINTS as u32 + 1);
    line.points = ptr::without_provenance(8);
    assert_shape_refused(raw::WIDGET_CANVAS, &line, "it has more than 400000 points");
    line.point_count = 1;
    line.points = ptr::without_provenance(4);
    assert_shape_refused(
        raw::WIDGET_CANVAS,
        &line,
        "`it`: a pointer to 2 elements is null or not aligned",
    );
}

#[test]
fn shapes_have_the_number_of_points_of_their_kind() {
    for (kind, count, needed) in [
        (raw::SHAPE_ARROW, 1, 2),
        (raw::SHAPE_LABEL, 2, 1),
        (raw::SHAPE_CIRCLE, 0, 1),
        (raw::SHAPE_ROBOT, 2, 1),
    ] {
        assert_shape_refused(
            raw::WIDGET_CANVAS,
            &shape(kind, &[0.0; 6], count),
            &format!("`it`: a shape has {count} points, and its kind has {needed}"),
        );
    }
    for kind in [raw::SHAPE_BOX, raw::SHAPE_SPHERE, raw::SHAPE_CYLINDER] {
        assert_shape_refused(
            raw::WIDGET_SCENE,
            &shape(kind, &[0.0; 6], 2),
            "`it`: a shape has 2 points, and its kind has 1",
        );
    }
}

#[test]
fn a_closed_line_in_space_ends_at_its_first_point() {
    let list = drawn(|pen| {
        pen.add(&widget_with_id(raw::WIDGET_SCENE));
        let mut line = shape(raw::SHAPE_LINE, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0], 3);
        line.flags = raw::CLOSED;
        pen.shape(&line);
        pen.end();
    })
    .expect("the list is valid");
    let Item::Scene { solids, .. } = &list.items[0] else {
        panic!("{list:#?}")
    };
    let jde_panel::Solid::Line { points, .. } = &solids[0] else {
        panic!("{solids:#?}")
    };
    assert_eq!(points.len(), 4);
    assert_eq!(points[0], points[3]);
}

#[test]
fn a_pen_without_its_drawing_is_refused() {
    let ((), list) = lend_pen(0, |pen| {
        // SAFETY: the pen is lent, and its functions check for null first.
        unsafe {
            assert_eq!(((*pen).end)(ptr::null_mut()), raw::BAD_ARGUMENT);
            assert_eq!(((*pen).add)(ptr::null_mut(), ptr::null()), raw::BAD_ARGUMENT);
            assert_eq!(((*pen).shape)(ptr::null_mut(), ptr::null()), raw::BAD_ARGUMENT);
        }
    });
    assert_eq!(list, Ok(List::default()), "no list was broken");
}

#[test]
fn colors_have_distinct_numbers() {
    for ink in [
        Ink::Plain,
        Ink::Faint,
        Ink::Accent,
        Ink::Good,
        Ink::Warn,
        Ink::Bad,
        Ink::Goal,
        Ink::Seen,
    ] {
        assert!(Color::Ink(ink).code() < 256);
    }
    assert_eq!(Color::Exact([1, 2, 3, 255]).code(), 0xff01_0203);
    assert_eq!(
        Color::Exact([1, 2, 3, 0]).code(),
        0x0101_0203,
        "the number is never that of an ink"
    );
}

#[test]
fn a_lent_gesture_is_read_unchanged() {
    let (at, button) = ([1.0, 2.0, 3.0], Button::Secondary);
    for touch in [
        Touch::Pressed,
        Touch::Toggled(true),
        Touch::Moved(-0.5),
        Touch::Chose(3),
        Touch::Clicked { at, button },
        Touch::Dragged {
            from: [0.5; 3],
            to: at,
            button: Button::Middle,
            ended: true,
        },
        Touch::Key {
            key: "a".to_owned(),
            down: true,
        },
    ] {
        let gesture = Gesture {
            widget: "field".to_owned(),
            touch,
        };
        // SAFETY: the table lives for the call.
        let read = lend_gesture("ana@laptop", &gesture, |table| unsafe { read_gesture(table) });
        assert_eq!(read, Ok(Some(("ana@laptop".to_owned(), gesture))));
    }
    let broken = Gesture {
        widget: "fi\0eld".to_owned(),
        touch: Touch::Pressed,
    };
    // SAFETY: as above.
    let read = lend_gesture("", &broken, |table| unsafe { read_gesture(table) });
    let (_, gesture) = read.expect("the table is valid").expect("the gesture is known");
    assert_eq!(gesture.widget, "fi", "the name ends at the first NUL");
    // SAFETY: null is checked.
    assert!(unsafe { read_gesture(ptr::null()) }.is_err());
}

#[test]
fn gestures_of_later_versions_are_ignored() {
    let read = |kind: u32, button: u32| {
        let table = raw::Gesture {
            size: size_of::<raw::Gesture>() as u32,
            kind,
            widget: c"go".as_ptr(),
            by: c"ana@laptop".as_ptr(),
            key: ptr::null(),
            from: [0.0; 3],
            at: [0.0; 3],
            value: 0.0,
            number: 0,
            button,
            flags: 0,
            reserved: 0,
        };
        // SAFETY: the table lives for the call.
        unsafe { read_gesture(&raw const table) }.map(|known| known.map(|(_, gesture)| gesture.touch))
    };
    assert_eq!(read(99, 0), Ok(None), "unknown kind");
    assert_eq!(read(raw::TOUCH_CLICKED, 99), Ok(None), "unknown button");
    assert_eq!(read(raw::TOUCH_DRAGGED, 99), Ok(None));
    assert_eq!(
        read(raw::TOUCH_PRESSED, 99),
        Ok(Some(Touch::Pressed)),
        "a press has no button"
    );
}
