//! Reads widgets from their table.

use jde_abi::raw;

use super::{array, codes, text};
use crate::limits::{MOST_BYTES, MOST_ITEMS, wrong};
use crate::{Area, Broken, Item, Wants};

/// Reads a widget.
///
/// # Safety
/// The pointers of the table follow the rules of `raw`.
pub(super) unsafe fn read(widget: &raw::Widget) -> Result<Item, Broken> {
    // SAFETY: the caller's contract, as for the calls below.
    let id = unsafe { text("a widget", widget.id) }?;
    // SAFETY: as above.
    let label = unsafe { text(&id, widget.label) }?;
    let name = if id.is_empty() { label.clone() } else { id.clone() };
    // SAFETY: as above.
    let unit = unsafe { text(&name, widget.unit) }?;
    // SAFETY: as above.
    let mut texts = unsafe { texts(&name, widget) }?;
    let flag = |flag| widget.flags & flag != 0;
    let wants = Wants {
        clicks: flag(raw::WANTS_CLICKS),
        drags: flag(raw::WANTS_DRAGS),
        keys: flag(raw::WANTS_KEYS),
    };
    let (value, number) = (widget.value, widget.number);
    Ok(match widget.kind {
        raw::WIDGET_TEXT => Item::Text {
            text: label,
            words: codes::words(number)?,
        },
        raw::WIDGET_VALUE => Item::Value { label, value, unit },
        raw::WIDGET_BUTTON => Item::Button {
            id,
            label,
            enabled: !flag(raw::DISABLED),
        },
        raw::WIDGET_TOGGLE => Item::Toggle {
            id,
            label,
            on: number != 0,
        },
        raw::WIDGET_SLIDER => Item::Slider {
            id,
            label,
            value,
            least: widget.least,
            greatest: widget.greatest,
            unit,
        },
        raw::WIDGET_CHOICE => Item::Choice {
            id,
            label,
            options: texts,
            chosen: number,
        },
        raw::WIDGET_IMAGE => Item::Image {
            // SAFETY: as above.
            pixels: unsafe { pixels(&name, widget) }?,
            id,
            width: widget.width,
            height: widget.height,
            channels: widget.channels.try_into().unwrap_or(0),
            wants,
        },
        raw::WIDGET_TABLE => {
            let columns = number as usize;
            if columns == 0 || !texts.len().is_multiple_of(columns) {
                return wrong(
                    &name,
                    format!("{} texts do not fill {columns} columns", texts.len()),
                );
            }
            let cells = texts.split_off(columns);
            Item::Table {
                id,
                columns: texts,
                rows: cells.chunks(columns).map(<[String]>::to_vec).collect(),
            }
        }
        raw::WIDGET_ROW => Item::Row { items: Vec::new() },
        raw::WIDGET_GROUP => Item::Group {
            id,
            label,
            open: !flag(raw::FOLDED),
            items: Vec::new(),
        },
        raw::WIDGET_PLOT => {
            let mut axes = texts.into_iter();
            Item::Plot {
                id,
                label,
                across: axes.next().unwrap_or_default(),
                up: axes.next().unwrap_or_default(),
                traces: Vec::new(),
            }
        }
        raw::WIDGET_CANVAS => Item::Canvas {
            id,
            area: area(widget.area),
            forward_up: flag(raw::FORWARD_UP),
            shapes: Vec::new(),
            wants,
        },
        raw::WIDGET_SCENE => Item::Scene {
            id,
            frame: label,
            solids: Vec::new(),
            wants,
        },
        other => {
            let last = raw::WIDGET_SCENE;
            return wrong(
                &name,
                format!("its kind is {other}, and this host knows 0 to {last}"),
            );
        }
    })
}

/// # Safety
/// As [`read`].
unsafe fn texts(name: &str, widget: &raw::Widget) -> Result<Vec<String>, Broken> {
    let count = widget.text_count as usize;
    if count > MOST_ITEMS {
        return Err(Broken::Items);
    }
    // SAFETY: the caller's contract.
    let all = unsafe { array(name, widget.texts, count) }?;
    let mut bytes = 0;
    let texts = all.iter().map(|pointer| {
        // SAFETY: the caller's contract.
        let text = unsafe { text(name, *pointer) }?;
        bytes += text.len();
        if bytes > MOST_BYTES {
            return Err(Broken::Huge(bytes));
        }
        Ok(text)
    });
    texts.collect()
}

/// # Safety
/// As [`read`].
unsafe fn pixels(name: &str, widget: &raw::Widget) -> Result<Vec<u8>, Broken> {
    let bytes = u64::from(widget.width)
        .saturating_mul(u64::from(widget.height))
        .saturating_mul(u64::from(widget.channels));
    let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);
    if bytes > MOST_BYTES {
        return Err(Broken::Huge(bytes));
    }
    // SAFETY: the caller's contract.
    Ok(unsafe { array(name, widget.pixels, bytes) }?.to_vec())
}

fn area([left, lower, right, upper]: [f64; 4]) -> Option<Area> {
    let is_empty = [left, lower, right, upper] == [0.0; 4];
    (!is_empty).then_some(Area {
        least: [left, lower],
        greatest: [right, upper],
    })
}
