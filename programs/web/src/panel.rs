//! Panels and drawings as pages get them: in JSON, and of a bounded size, whatever a schema draws. Of many points some are
//! left out, and pictures become smaller.

use std::sync::Arc;

use jde_link::{Rate, Subscription};
use jde_panel::{Item, List, Shape};
use serde_json::{Value, json};

use crate::feeds::Parts;
use crate::model::Model;

/// How often a page shows a panel.
const RATE: Rate = Rate::Hz(5);
/// Points of a panel: more than a phone has columns, of several curves.
const MAX_POINTS: usize = 2500;
/// Bytes of all pictures of a panel.
const MAX_PIXELS: usize = 48 << 10;
/// The longest panel as JSON, bytes: 4 s of a slow mobile network.
const MAX_BYTES: usize = 128 << 10;

/// Subscribes to the panel of a schema, which becomes the only part of a topic. Waits for the link.
///
/// # Errors
/// The schema has no panel, or there is no connection.
pub(crate) fn open(model: &Model, schema: &str, parts: &Arc<Parts>) -> Result<Vec<Subscription>, String> {
    let sink = Arc::clone(parts);
    let watched = model
        .remote
        .watch_panel(schema, RATE, move |sample| match sample.list {
            Ok(list) => sink.set(0, &view(list)),
            Err(reason) => sink.set(0, &json!({ "error": reason })),
        });
    Ok(vec![watched.map_err(|error| error.to_string())?])
}

/// Returns the widgets of a list as a page gets them.
pub(crate) fn view(mut list: List) -> Value {
    let points: usize = list.walk().map(count).sum();
    let step = points.div_ceil(MAX_POINTS).max(1);
    let pictures: usize = list
        .walk()
        .map(|item| {
            if let Item::Image { pixels, .. } = item {
                pixels.len()
            } else {
                0
            }
        })
        .sum();
    let shrink = (1..)
        .find(|shrink| pictures / (shrink * shrink) <= MAX_PIXELS)
        .unwrap_or(1);
    let mut images = Vec::new();
    lessen(&mut list.items, step, shrink, &mut images);
    // Widgets always have a form in JSON.
    let mut items = serde_json::to_value(&list.items).unwrap_or_default();
    put(&mut items, &mut images.into_iter());
    let view = json!({ "items": items });
    if view.to_string().len() > MAX_BYTES {
        return json!({ "error": "this panel is too large for the page; the windows of jde view show it" });
    }
    view
}

/// Counts the points of a widget, without those inside it.
fn count(item: &Item) -> usize {
    let of_shape = |shape: &Shape| {
        if let Shape::Line { points, .. } | Shape::Points { points, .. } = shape {
            points.len()
        } else {
            0
        }
    };
    if let Item::Plot { traces, .. } = item {
        traces.iter().map(|trace| trace.points.len()).sum()
    } else if let Item::Canvas { shapes, .. } = item {
        shapes.iter().map(of_shape).sum()
    } else {
        0
    }
}

/// Leaves out points and pixels, and what is drawn in space. Takes the pictures out, in the order of the widgets.
fn lessen(items: &mut [Item], step: usize, shrink: usize, images: &mut Vec<Value>) {
    for item in items {
        match item {
            Item::Row { items } | Item::Group { items, .. } => lessen(items, step, shrink, images),
            Item::Plot { traces, .. } => traces.iter_mut().for_each(|trace| {
                sparse(&mut trace.points, step);
                for number in trace.points.as_flattened_mut() {
                    *number = format!("{number:.6e}").parse().unwrap_or(*number);
                }
            }),
            Item::Canvas { shapes, .. } => shapes.iter_mut().for_each(|shape| {
                if let Shape::Line { points, .. } | Shape::Points { points, .. } = shape {
                    thin(points, step);
                }
            }),
            Item::Scene { solids, .. } => solids.clear(),
            Item::Image {
                width,
                height,
                channels,
                pixels,
                ..
            } => {
                images.push(small(
                    &std::mem::take(pixels),
                    [*width as usize, *height as usize, usize::from(*channels)],
                    shrink,
                ));
            }
            Item::Text { .. }
            | Item::Value { .. }
            | Item::Button { .. }
            | Item::Toggle { .. }
            | Item::Slider { .. }
            | Item::Choice { .. }
            | Item::Table { .. } => {}
        }
    }
}

/// Keeps the first of so many points each, and the last one, to the millimetre.
pub(crate) fn thin(points: &mut Vec<[f64; 2]>, step: usize) {
    sparse(points, step);
    for number in points.as_flattened_mut() {
        *number = (*number * 1e3).round() / 1e3;
    }
}

/// Keeps the first of so many points each, and the last one.
fn sparse(points: &mut Vec<[f64; 2]>, step: usize) {
    let last = points.len().saturating_sub(1);
    let mut place = 0_usize;
    points.retain(|_| {
        place += 1;
        (place - 1).is_multiple_of(step) || place - 1 == last
    });
}

/// Returns a picture of which every so many-th pixel is kept, in each direction.
fn small(pixels: &[u8], [width, height, channels]: [usize; 3], shrink: usize) -> Value {
    let (columns, rows) = (width.div_ceil(shrink), height.div_ceil(shrink));
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (row * width + column) * shrink));
    let kept: Vec<u8> = places
        .flat_map(|place| {
            pixels
                .get(place * channels..(place + 1) * channels)
                .unwrap_or_default()
        })
        .copied()
        .collect();
    json!({ "width": columns, "height": rows, "size": [width, height], "pixels": base64(&kept) })
}

/// Puts the pictures back.
fn put(items: &mut Value, images: &mut impl Iterator<Item = Value>) {
    for item in items.as_array_mut().into_iter().flatten() {
        if let Some(Value::Object(image)) = item.get_mut("image") {
            if let Some(Value::Object(small)) = images.next() {
                image.extend(small);
            }
        } else {
            for kind in ["row", "group"] {
                if let Some(inner) = item.get_mut(kind).and_then(|about| about.get_mut("items")) {
                    put(inner, images);
                }
            }
        }
    }
}

/// RFC 4648, as browsers read it.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for piece in bytes.chunks(3) {
        let part = |place: usize| u32::from(piece.get(place).copied().unwrap_or(0));
        let bits = part(0) << 16 | part(1) << 8 | part(2);
        for letter in 0..4 {
            let place = (bits >> (18 - 6 * letter) & 63) as usize;
            text.push(if letter > piece.len() {
                '='
            } else {
                char::from(LETTERS[place])
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use jde_panel::{Stroke, Wants};

    use super::*;

    fn list(items: Vec<Item>) -> List {
        List { time: 0, items }
    }

    fn picture(side: u32) -> Item {
        Item::Image {
            id: "camera".to_owned(),
            width: side,
            height: side,
            channels: 3,
            pixels: vec![7; (side * side * 3) as usize],
            wants: Wants::default(),
        }
    }

    #[test]
    fn whatever_a_schema_draws_a_page_gets_little() {
        let points = (0..400_000).map(|place| [f64::from(place) / 3.0, 0.0]).collect();
        let scan = Shape::Points {
            points,
            stroke: Stroke::default(),
        };
        let canvas = Item::Canvas {
            id: "scan".to_owned(),
            area: None,
            forward_up: false,
            shapes: vec![scan],
            wants: Wants::default(),
        };
        let inner = Item::Row {
            items: vec![picture(1000), canvas],
        };
        let view = view(list(vec![inner, picture(2)]));
        assert!(view.to_string().len() < MAX_BYTES);
        let row = &view["items"][0]["row"]["items"];
        assert_eq!(row[0]["image"]["size"], json!([1000, 1000]));
        assert_eq!(row[0]["image"]["width"], 125);
        let kept = row[1]["canvas"]["shapes"][0]["points"]["points"]
            .as_array()
            .unwrap();
        assert!(kept.len() <= MAX_POINTS + 1, "{}", kept.len());
        assert_eq!(kept[1], json!([53.333, 0.0]));
        assert_eq!(view["items"][1]["image"]["pixels"], "BwcH");
    }

    #[test]
    fn what_stays_too_large_is_said_in_words() {
        let text = |_| Item::Text {
            text: "x".repeat(4000),
            words: Default::default(),
        };
        let view = view(list((0..100).map(text).collect()));
        assert!(view["error"].as_str().unwrap().contains("too large"), "{view}");
    }

    #[test]
    fn bytes_are_written_as_browsers_read_them() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
