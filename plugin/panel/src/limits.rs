//! The limits of a list. A broken or huge list is refused, with the reason, before it is drawn.

use std::collections::HashSet;

use crate::{Area, Item, List, Place, Shape, Solid, Trace};

/// The maximum of texts and pixels in a list, in bytes: a 1280 by 960 color image and as much again.
pub const MOST_BYTES: usize = 8 << 20;
/// The maximum size of an encoded list, in bytes: its texts and pixels, with its points and widgets.
pub const MOST_ENCODED: usize = 32 << 20;
/// The maximum number of widgets and shapes in a list.
pub const MOST_ITEMS: usize = 20_000;
/// The maximum number of points of all lines, curves and meshes.
pub const MOST_POINTS: usize = 400_000;
/// The maximum width and height of an image, in pixels. Every graphics card that can show these windows
/// supports it.
pub const MOST_SIDE: u32 = 4096;
/// The maximum length of a text, in bytes.
pub const MOST_TEXT: usize = 4096;
/// The maximum nesting depth of rows and groups.
const MAX_DEPTH: usize = 8;

/// Why a list is not shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Broken {
    /// The texts and pixels exceed the limit.
    #[error("its texts and pixels have {0} bytes, and {MOST_BYTES} are allowed")]
    Huge(usize),
    /// The encoded bytes exceed the limit.
    #[error("it comes in {0} bytes, and no list has more than {MOST_ENCODED}")]
    Encoded(usize),
    /// The bytes are not a list.
    #[error("it is not a list of widgets: {0}")]
    Bytes(String),
    /// Too many widgets and shapes.
    #[error("it has more than {MOST_ITEMS} widgets and shapes")]
    Items,
    /// Too many points.
    #[error("it has more than {MOST_POINTS} points")]
    Points,
    /// Rows and groups are nested too deeply.
    #[error("rows and groups stand more than {MAX_DEPTH} deep in each other")]
    Deep,
    /// An error in one widget.
    #[error("{widget}: {reason}")]
    Widget {
        /// The widget.
        widget: String,
        /// What is wrong.
        reason: String,
    },
}

/// Checks whether a list can be shown.
///
/// # Errors
/// [`Broken`], with the name of the widget.
pub fn check(list: &List) -> Result<(), Broken> {
    let mut checker = Checker::default();
    checker.items(&list.items, 0)
}

/// Counts the contents of a list, and refuses an error or an excess at once.
#[derive(Default)]
pub(crate) struct Checker {
    ids: HashSet<String>,
    items: usize,
    points: usize,
    bytes: usize,
}

impl Checker {
    fn items(&mut self, items: &[Item], depth: usize) -> Result<(), Broken> {
        items.iter().try_for_each(|item| {
            self.item(item, depth)?;
            self.inside(item, depth)
        })
    }

    /// Checks a widget at this depth, without its contents.
    pub(crate) fn item(&mut self, item: &Item, depth: usize) -> Result<(), Broken> {
        if depth > MAX_DEPTH {
            return Err(Broken::Deep);
        }
        self.count(1, 0)?;
        match item {
            Item::Text { text, .. } => self.text("a text", text),
            Item::Value { label, value, unit } => {
                self.text(label, label)?;
                self.text(label, unit)?;
                finite(label, &[*value])
            }
            Item::Button { id, label, .. } | Item::Toggle { id, label, .. } => {
                self.id(id)?;
                self.text(id, label)
            }
            Item::Slider {
                id,
                label,
                value,
                least,
                greatest,
                unit,
            } => {
                self.id(id)?;
                self.text(id, label)?;
                self.text(id, unit)?;
                finite(id, &[*value, *least, *greatest])?;
                if least > greatest {
                    return wrong(id, "its least value is above its greatest");
                }
                Ok(())
            }
            Item::Choice {
                id,
                label,
                options,
                chosen,
            } => {
                self.id(id)?;
                self.text(id, label)?;
                self.count(options.len(), 0)?;
                for option in options {
                    self.text(id, option)?;
                }
                if *chosen as usize >= options.len() {
                    return wrong(id, "what is chosen is none of its options");
                }
                Ok(())
            }
            Item::Image {
                id,
                width,
                height,
                channels,
                pixels,
                ..
            } => {
                self.id(id)?;
                if !matches!(channels, 1 | 3 | 4) {
                    return wrong(id, "a pixel has 1, 3 or 4 bytes");
                }
                let size = [*width, *height, u32::from(*channels)].map(u128::from);
                let bytes: u128 = size.into_iter().product();
                if bytes != pixels.len() as u128 || bytes == 0 {
                    return wrong(id, "it has not as many pixels as its width and height say");
                }
                if *width.max(height) > MOST_SIDE {
                    return wrong(
                        id,
                        format!("it is {width} × {height} pixels, and {MOST_SIDE} to a side are allowed"),
                    );
                }
                self.bytes(pixels.len())
            }
            Item::Plot {
                id,
                label,
                across,
                up,
                ..
            } => {
                self.id(id)?;
                for text in [label, across, up] {
                    self.text(id, text)?;
                }
                Ok(())
            }
            Item::Table { id, columns, rows } => {
                self.id(id)?;
                self.count(columns.len() + rows.len() * columns.len().max(1), 0)?;
                if rows.iter().any(|row| row.len() != columns.len()) {
                    return wrong(id, "a row has not as many texts as there are columns");
                }
                columns
                    .iter()
                    .chain(rows.iter().flatten())
                    .try_for_each(|text| self.text(id, text))
            }
            Item::Row { .. } => Ok(()),
            Item::Group { id, label, .. } => {
                self.id(id)?;
                self.text(id, label)
            }
            Item::Canvas { id, area, .. } => {
                self.id(id)?;
                if let Some(Area { least, greatest }) = area {
                    finite(id, least)?;
                    finite(id, greatest)?;
                    if least[0] >= greatest[0] || least[1] >= greatest[1] {
                        return wrong(id, "its area is empty");
                    }
                }
                Ok(())
            }
            Item::Scene { id, frame, .. } => {
                self.id(id)?;
                self.text(id, frame)
            }
        }
    }

    /// Checks the contents of a widget at this depth.
    pub(crate) fn inside(&mut self, item: &Item, depth: usize) -> Result<(), Broken> {
        match item {
            Item::Row { items } | Item::Group { items, .. } => self.items(items, depth + 1),
            Item::Plot { id, traces, .. } => traces.iter().try_for_each(|trace| self.trace(id, trace)),
            Item::Canvas { id, shapes, .. } => shapes.iter().try_for_each(|shape| self.shape(id, shape)),
            Item::Scene { id, solids, .. } => solids.iter().try_for_each(|solid| self.solid(id, solid)),
            Item::Text { .. }
            | Item::Value { .. }
            | Item::Button { .. }
            | Item::Toggle { .. }
            | Item::Slider { .. }
            | Item::Choice { .. }
            | Item::Image { .. }
            | Item::Table { .. } => Ok(()),
        }
    }

    pub(crate) fn trace(&mut self, id: &str, trace: &Trace) -> Result<(), Broken> {
        self.count(1, trace.points.len())?;
        self.text(id, &trace.name)?;
        finite(id, trace.points.as_flattened())
    }

    pub(crate) fn shape(&mut self, id: &str, shape: &Shape) -> Result<(), Broken> {
        match shape {
            Shape::Line { points, stroke, .. } | Shape::Points { points, stroke } => {
                self.count(1, points.len())?;
                width(id, stroke.width)?;
                finite(id, points.as_flattened())
            }
            Shape::Polygon { points, .. } => {
                self.count(1, points.len())?;
                finite(id, points.as_flattened())
            }
            Shape::Circle {
                center,
                radius,
                stroke,
                ..
            } => {
                self.count(1, 1)?;
                width(id, stroke.width)?;
                finite(id, center)?;
                size(id, &[*radius])
            }
            Shape::Arrow { from, to, stroke } => {
                self.count(1, 2)?;
                width(id, stroke.width)?;
                finite(id, from)?;
                finite(id, to)
            }
            Shape::Label { at, text, .. } => {
                self.count(1, 1)?;
                self.text(id, text)?;
                finite(id, at)
            }
            Shape::Robot { pose } => {
                self.count(1, 1)?;
                finite(id, pose)
            }
        }
    }

    pub(crate) fn solid(&mut self, id: &str, solid: &Solid) -> Result<(), Broken> {
        match solid {
            Solid::Line {
                points,
                width: line_width,
                ..
            }
            | Solid::Points {
                points,
                width: line_width,
                ..
            } => {
                self.count(1, points.len())?;
                width(id, *line_width)?;
                finite(id, points.as_flattened())
            }
            Solid::Mesh { corners, .. } => {
                self.count(1, corners.len())?;
                if !corners.len().is_multiple_of(3) {
                    return wrong(id, "a mesh has three corners to a triangle");
                }
                finite(id, corners.as_flattened())
            }
            Solid::Box { place, size, .. } => {
                self.count(1, 1)?;
                check_place(id, place)?;
                self::size(id, size)
            }
            Solid::Sphere { center, radius, .. } => {
                self.count(1, 1)?;
                finite(id, center)?;
                size(id, &[*radius])
            }
            Solid::Cylinder {
                place,
                radius,
                height,
                ..
            } => {
                self.count(1, 1)?;
                check_place(id, place)?;
                size(id, &[*radius, *height])
            }
            Solid::Arrow { from, to, .. } => {
                self.count(1, 2)?;
                finite(id, from)?;
                finite(id, to)
            }
            Solid::Label { at, text, .. } => {
                self.count(1, 1)?;
                self.text(id, text)?;
                finite(id, at)
            }
        }
    }

    fn id(&mut self, id: &str) -> Result<(), Broken> {
        self.text(id, id)?;
        if id.is_empty() {
            return wrong(id, "a widget of this kind needs an id");
        }
        if id.chars().any(char::is_control) {
            return wrong(id, "its id has control characters, and no gesture may have them");
        }
        if !self.ids.insert(id.to_owned()) {
            return wrong(id, "two widgets have this id");
        }
        Ok(())
    }

    fn text(&mut self, widget: &str, text: &str) -> Result<(), Broken> {
        if text.len() > MOST_TEXT {
            let reason = format!("a text has {} bytes, and {MOST_TEXT} are allowed", text.len());
            return wrong(widget, reason);
        }
        self.bytes(text.len())
    }

    fn bytes(&mut self, bytes: usize) -> Result<(), Broken> {
        self.bytes += bytes;
        if self.bytes > MOST_BYTES {
            return Err(Broken::Huge(self.bytes));
        }
        Ok(())
    }

    fn count(&mut self, items: usize, points: usize) -> Result<(), Broken> {
        self.items += items;
        self.points += points;
        if self.items > MOST_ITEMS {
            return Err(Broken::Items);
        }
        if self.points > MOST_POINTS {
            return Err(Broken::Points);
        }
        Ok(())
    }
}

fn check_place(id: &str, place: &Place) -> Result<(), Broken> {
    finite(id, &place.at)?;
    finite(id, &place.turned)
}

fn width(id: &str, width: f32) -> Result<(), Broken> {
    if width > 0.0 && width.is_finite() {
        return Ok(());
    }
    wrong(id, format!("a line of width {width}"))
}

fn finite(widget: &str, numbers: &[f64]) -> Result<(), Broken> {
    match numbers.iter().find(|number| !number.is_finite()) {
        None => Ok(()),
        Some(number) => wrong(widget, format!("a number is {number}")),
    }
}

/// Checks that the numbers are finite and not negative.
fn size(widget: &str, numbers: &[f64]) -> Result<(), Broken> {
    finite(widget, numbers)?;
    match numbers.iter().find(|number| **number < 0.0) {
        None => Ok(()),
        Some(number) => wrong(widget, format!("a size is {number}")),
    }
}

/// Reports an error in a widget. Of its name, only the first 40 characters appear, without control characters
/// that could control a terminal.
pub(crate) fn wrong<T>(widget: &str, reason: impl Into<String>) -> Result<T, Broken> {
    let printable = |letter: char| if letter.is_control() { '?' } else { letter };
    let name: String = widget.chars().take(40).map(printable).collect();
    Err(Broken::Widget {
        widget: format!("`{name}`"),
        reason: reason.into(),
    })
}
