//! Every limit of a list refuses with its reason, whether the list is checked whole or while it grows.

use crate::common;
use jde_panel::{
    Area, Broken, Builder, Color, Holds, Ink, Item, List, MOST_BYTES, MOST_ENCODED, MOST_ITEMS, MOST_POINTS,
    MOST_SIDE, MOST_TEXT, Shape, Solid, Stroke, Trace, Wants, Words, check, decode, encode,
};

fn text(text: &str) -> Item {
    Item::Text {
        text: text.to_owned(),
        words: Words::Plain,
    }
}

fn button(id: &str) -> Item {
    Item::Button {
        id: id.to_owned(),
        label: "Go".to_owned(),
        enabled: true,
    }
}

fn canvas(shapes: Vec<Shape>) -> Item {
    Item::Canvas {
        id: "field".to_owned(),
        area: None,
        forward_up: false,
        shapes,
        wants: Wants::default(),
    }
}

fn scene(solids: Vec<Solid>) -> Item {
    Item::Scene {
        id: "space".to_owned(),
        frame: "odom".to_owned(),
        solids,
        wants: Wants::default(),
    }
}

fn line(points: Vec<[f64; 2]>) -> Shape {
    Shape::Line {
        points,
        closed: false,
        stroke: Stroke::default(),
    }
}

/// Checks a list whole, and while it is built widget by widget.
#[track_caller]
fn checked(items: Vec<Item>) -> Result<(), Broken> {
    let list = List { time: 0, items };
    let result = check(&list);
    let mut builder = Builder::new();
    for item in list.items {
        let opens = matches!(
            item,
            Item::Row { .. }
                | Item::Group { .. }
                | Item::Plot { .. }
                | Item::Canvas { .. }
                | Item::Scene { .. }
        );
        let added = builder.add(item);
        if added.is_ok() && opens {
            builder.end().expect("the widget was begun");
        }
    }
    assert_eq!(builder.finish(0).map(drop), result);
    result
}

#[track_caller]
fn assert_refused(items: Vec<Item>, message: &str) {
    let broken = checked(items).expect_err("the list is refused");
    assert_eq!(broken.to_string(), message);
}

#[test]
fn a_list_with_everything_passes() {
    assert_eq!(checked(common::all().items), Ok(()));
}

#[test]
fn ids_are_present_and_unique() {
    assert_refused(vec![button("")], "``: a widget of this kind needs an id");
    assert_refused(vec![button("go"), button("go")], "`go`: two widgets have this id");
    let row = Item::Row {
        items: vec![button("go")],
    };
    assert_refused(vec![row, button("go")], "`go`: two widgets have this id");
}

#[test]
fn the_length_of_a_text_is_limited() {
    assert_eq!(checked(vec![text(&"a".repeat(MOST_TEXT))]), Ok(()));
    assert_refused(
        vec![text(&"a".repeat(MOST_TEXT + 1))],
        "`a text`: a text has 4097 bytes, and 4096 are allowed",
    );
    let long = "a".repeat(MOST_TEXT + 1);
    let name = "a".repeat(40);
    assert_refused(
        vec![button(&long)],
        &format!("`{name}`: a text has 4097 bytes, and 4096 are allowed"),
    );
}

#[test]
fn the_total_size_of_texts_and_pixels_is_limited() {
    let image = |id: &str, rows| Item::Image {
        id: id.to_owned(),
        width: 1024,
        height: rows,
        channels: 4,
        pixels: vec![0; rows as usize * 4096],
        wants: Wants::default(),
    };
    assert!(matches!(checked(vec![image("a", 2049)]), Err(Broken::Huge(_))));
    assert!(matches!(
        checked(vec![image("a", 1024), image("b", 1024)]),
        Err(Broken::Huge(_))
    ));
    assert_eq!(checked(vec![image("a", 2047)]), Ok(()));
    let texts = vec![text(&"a".repeat(MOST_TEXT)); MOST_BYTES / MOST_TEXT + 1];
    assert!(matches!(checked(texts), Err(Broken::Huge(_))));
}

#[test]
fn the_pixels_of_an_image_match_its_size() {
    let image = |width, height, channels, bytes| Item::Image {
        id: "seen".to_owned(),
        width,
        height,
        channels,
        pixels: vec![0; bytes],
        wants: Wants::default(),
    };
    let short = "`seen`: it has not as many pixels as its width and height say";
    assert_refused(vec![image(2, 2, 3, 11)], short);
    assert_refused(vec![image(0, 2, 3, 0)], short);
    assert_refused(vec![image(u32::MAX, u32::MAX, 4, 0)], short);
    assert_refused(vec![image(2, 2, 2, 8)], "`seen`: a pixel has 1, 3 or 4 bytes");
    let wide = "`seen`: it is 5000 × 2 pixels, and 4096 to a side are allowed";
    assert_refused(vec![image(5000, 2, 1, 10_000)], wide);
    assert_eq!(checked(vec![image(MOST_SIDE, 1, 1, MOST_SIDE as usize)]), Ok(()));
}

#[test]
fn the_number_of_widgets_shapes_cells_and_options_is_limited() {
    assert_eq!(checked(vec![text(""); MOST_ITEMS]), Ok(()));
    let too_many = "it has more than 20000 widgets and shapes";
    assert_refused(vec![text(""); MOST_ITEMS + 1], too_many);
    assert_refused(vec![canvas(vec![line(Vec::new()); MOST_ITEMS])], too_many);
    let table = Item::Table {
        id: "table".to_owned(),
        columns: vec![String::new(); 2],
        rows: vec![vec![String::new(); 2]; MOST_ITEMS / 2],
    };
    assert_refused(vec![table], too_many);
    let choice = Item::Choice {
        id: "mode".to_owned(),
        label: String::new(),
        options: vec![String::new(); MOST_ITEMS],
        chosen: 0,
    };
    assert_refused(vec![choice], too_many);
}

#[test]
fn the_number_of_points_is_limited() {
    let flat = |count| canvas(vec![line(vec![[0.0; 2]; count])]);
    assert_eq!(checked(vec![flat(MOST_POINTS)]), Ok(()));
    assert_refused(vec![flat(MOST_POINTS + 1)], "it has more than 400000 points");
    let mesh = Solid::Mesh {
        corners: vec![[0.0; 3]; MOST_POINTS + 2],
        color: Color::Ink(Ink::Plain),
    };
    assert_refused(vec![scene(vec![mesh])], "it has more than 400000 points");
}

#[test]
fn the_largest_list_that_passes_can_be_sent() {
    let solid = Solid::Points {
        points: vec![[0.1, 0.2, 0.3]; MOST_POINTS],
        color: Color::Ink(Ink::Plain),
        width: 1.0,
    };
    let mut items = vec![scene(vec![solid])];
    let labels = MOST_ITEMS / 2;
    items.extend((0..labels).map(|number| Item::Slider {
        id: format!("{number}"),
        label: "a".repeat(MOST_BYTES / labels - 20),
        value: 0.1,
        least: 0.0,
        greatest: 1.0,
        unit: "m/s".to_owned(),
    }));
    let list = List { time: 0, items };
    assert_eq!(check(&list), Ok(()));
    let bytes = encode(&list);
    assert!(bytes.len() <= MOST_ENCODED, "{}", bytes.len());
    assert!(decode::<List>(&bytes).is_ok());
}

#[test]
fn the_depth_of_rows_and_groups_is_limited() {
    let nested = |depth| (0..depth).fold(text(""), |inner, _| Item::Row { items: vec![inner] });
    assert_eq!(checked(vec![nested(8)]), Ok(()));
    assert_refused(
        vec![nested(9)],
        "rows and groups stand more than 8 deep in each other",
    );
    let mut builder = Builder::new();
    for _ in 0..9 {
        builder
            .add(Item::Row { items: Vec::new() })
            .expect("the depth is allowed");
    }
    assert_eq!(builder.add(Item::Row { items: Vec::new() }), Err(Broken::Deep));
}

#[test]
fn numbers_are_finite_and_sizes_not_negative() {
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let value = Item::Value {
            label: "speed".to_owned(),
            value: number,
            unit: String::new(),
        };
        assert_refused(vec![value], &format!("`speed`: a number is {number}"));
        assert_refused(
            vec![canvas(vec![line(vec![[0.0, number]])])],
            &format!("`field`: a number is {number}"),
        );
        let plot = Item::Plot {
            id: "plot".to_owned(),
            label: String::new(),
            across: String::new(),
            up: String::new(),
            traces: vec![Trace {
                name: String::new(),
                color: Color::Ink(Ink::Plain),
                points: vec![[number, 0.0]],
            }],
        };
        assert_refused(vec![plot], &format!("`plot`: a number is {number}"));
        for solid in broken_solids(number) {
            assert_refused(
                vec![scene(vec![solid])],
                &format!("`space`: a number is {number}"),
            );
        }
    }
    let circle = Shape::Circle {
        center: [0.0; 2],
        radius: -1.0,
        filled: false,
        stroke: Stroke::default(),
    };
    assert_refused(vec![canvas(vec![circle])], "`field`: a size is -1");
    for width in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let arrow = Shape::Arrow {
            from: [0.0; 2],
            to: [1.0; 2],
            stroke: Stroke {
                width,
                ..Stroke::default()
            },
        };
        assert_refused(
            vec![canvas(vec![arrow])],
            &format!("`field`: a line of width {width}"),
        );
    }
}

/// Returns every shape of a scene, with `number` in one of its places.
fn broken_solids(number: f64) -> Vec<Solid> {
    let mut solids = common::solids();
    for solid in &mut solids {
        match solid {
            Solid::Line { points, .. } | Solid::Points { points, .. } => points[0][2] = number,
            Solid::Box { place, .. } => place.turned[1] = number,
            Solid::Sphere { radius, .. } => *radius = number,
            Solid::Cylinder { height, .. } => *height = number,
            Solid::Arrow { to, .. } => to[0] = number,
            Solid::Mesh { corners, .. } => corners[1][1] = number,
            Solid::Label { at, .. } => at[2] = number,
        }
    }
    solids
}

#[test]
fn contradictory_widgets_are_refused() {
    let slider = |least, greatest| Item::Slider {
        id: "ahead".to_owned(),
        label: String::new(),
        value: 9.0,
        least,
        greatest,
        unit: String::new(),
    };
    assert_eq!(
        checked(vec![slider(1.0, 1.0)]),
        Ok(()),
        "the value may be out of range"
    );
    assert_refused(
        vec![slider(2.0, 1.0)],
        "`ahead`: its least value is above its greatest",
    );
    for options in [0, 2] {
        let choice = Item::Choice {
            id: "mode".to_owned(),
            label: String::new(),
            options: vec![String::new(); options],
            chosen: 2,
        };
        assert_refused(vec![choice], "`mode`: what is chosen is none of its options");
    }
    let table = Item::Table {
        id: "table".to_owned(),
        columns: vec![String::new(); 2],
        rows: vec![vec![String::new()]],
    };
    assert_refused(
        vec![table],
        "`table`: a row has not as many texts as there are columns",
    );
    let mesh = Solid::Mesh {
        corners: vec![[0.0; 3]; 4],
        color: Color::Ink(Ink::Plain),
    };
    assert_refused(
        vec![scene(vec![mesh])],
        "`space`: a mesh has three corners to a triangle",
    );
    for greatest in [[0.0, 1.0], [1.0, 0.0]] {
        let empty = Item::Canvas {
            id: "field".to_owned(),
            area: Some(Area {
                least: [0.0; 2],
                greatest,
            }),
            forward_up: false,
            shapes: Vec::new(),
            wants: Wants::default(),
        };
        assert_refused(vec![empty], "`field`: its area is empty");
    }
}

#[test]
fn content_in_the_wrong_place_is_refused() {
    let refusal = |steps: &dyn Fn(&mut Builder)| {
        let mut builder = Builder::new();
        steps(&mut builder);
        builder.finish(0).expect_err("the list is refused").to_string()
    };
    let shape = || line(Vec::new());
    assert_eq!(
        refusal(&|b| drop(b.shape(shape()))),
        "``: a shape of a canvas outside of one"
    );
    assert_eq!(
        refusal(&|b| {
            b.add(canvas(Vec::new())).expect("a canvas is allowed");
            assert_eq!((b.holds(), b.inside()), (Holds::Shapes, "field"));
            drop(b.add(text("inside")));
        }),
        "`field`: no widget can stand inside it"
    );
    assert_eq!(
        refusal(&|b| {
            b.add(scene(Vec::new())).expect("a scene is allowed");
            drop(b.shape(shape()));
        }),
        "`space`: a shape of a canvas outside of one"
    );
    assert_eq!(
        refusal(&|b| drop(b.end())),
        "``: an end of nothing that was begun"
    );
    assert_eq!(
        refusal(&|b| drop(b.add(canvas(Vec::new())))),
        "`field`: it was begun and not ended"
    );
}

#[test]
fn after_the_first_error_nothing_is_accepted_and_its_reason_is_kept() {
    let mut builder = Builder::new();
    builder.add(button("go")).expect("the first is accepted");
    let duplicate = builder.add(button("go")).expect_err("the second is refused");
    for _ in 0..3 {
        assert_eq!(builder.add(text("more")), Err(duplicate.clone()));
        assert_eq!(builder.end(), Err(duplicate.clone()));
    }
    builder.refuse(Broken::Deep);
    assert_eq!(builder.broken(), Some(&duplicate));
    assert_eq!(builder.finish(0), Err(duplicate));
}

#[test]
fn the_bench_of_cpp_has_the_same_limits() {
    let header = include_str!("../../../../include/jde/bench_panel.hpp");
    let megabytes = MOST_BYTES >> 20;
    let limits = format!(
        "most_items = {MOST_ITEMS}, most_points = {MOST_POINTS}, most_bytes = {megabytes} << 20, \
         most_text = {MOST_TEXT}, most_side = {MOST_SIDE};"
    );
    assert!(header.contains(&limits), "{limits}");
}
