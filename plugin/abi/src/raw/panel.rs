//! The tables of the ability [`ABILITY_PANEL`]: a schema draws its own panel, and receives the gestures of
//! users on it.
//!
//! A panel is a list of widgets, drawn anew each time. The plugin adds one after another, with a [`Pen`] that
//! the host lends it for the duration of [`Panel::draw`]. The list itself belongs to the host and never
//! crosses the boundary. Three functions and two tables suffice for all widgets and shapes: a new kind is a
//! new number, which an older host refuses with a message, and no table changes for it.
//!
//! The first mistake invalidates the list: the panel then shows the reason, and everything that follows is
//! refused with [`super::BAD_ARGUMENT`].

use core::ffi::{c_char, c_void};

use super::Context;

/// The id of the ability, whose table is a [`Panel`]. It and all that belongs to it exist since minor version
/// 2.
pub const ABILITY_PANEL: &str = "jde.panel";

/// Widget: a text in `label`. `number` is its style, [`WORDS_PLAIN`] to [`WORDS_CODE`].
pub const WIDGET_TEXT: u32 = 0;
/// Widget: a number `value` with its name in `label` and its `unit`.
pub const WIDGET_VALUE: u32 = 1;
/// Widget: a button, with `id` and `label`. [`DISABLED`].
pub const WIDGET_BUTTON: u32 = 2;
/// Widget: a toggle, with `id` and `label`. `number` is 1 for on.
pub const WIDGET_TOGGLE: u32 = 3;
/// Widget: a slider, with `id`, `label`, `value`, `least`, `greatest`, `unit`.
pub const WIDGET_SLIDER: u32 = 4;
/// Widget: a choice, with `id`, `label` and the options in `texts`. `number` is the index of the present one.
pub const WIDGET_CHOICE: u32 = 5;
/// Widget: an image, with `id`, `pixels`, `width`, `height`, `channels`. [`WANTS_CLICKS`], [`WANTS_DRAGS`],
/// [`WANTS_KEYS`].
pub const WIDGET_IMAGE: u32 = 6;
/// Widget: a table, with `id`; `texts` are the headings of its `number` columns, and then the cells, row by
/// row.
pub const WIDGET_TABLE: u32 = 7;
/// Widget: the widgets up to its [`Pen::end`], beside each other.
pub const WIDGET_ROW: u32 = 8;
/// Widget: the widgets up to its [`Pen::end`] below `label`, with `id`. [`FOLDED`].
pub const WIDGET_GROUP: u32 = 9;
/// Widget: a plot, with `id` and `label`. `texts` are the labels of its axes, horizontal and vertical. Up to
/// its [`Pen::end`] it contains only shapes of [`SHAPE_LINE`], each with its name in `text`.
pub const WIDGET_PLOT: u32 = 10;
/// Widget: a plane in metres, with `id`. Up to its [`Pen::end`] it contains shapes with two numbers per
/// point. It shows `area` at first, if that is not empty. [`FORWARD_UP`], [`WANTS_CLICKS`], [`WANTS_DRAGS`],
/// [`WANTS_KEYS`].
pub const WIDGET_CANVAS: u32 = 11;
/// Widget: a space in metres, with `id`, in the frame of REP-105 that `label` names. Up to its [`Pen::end`]
/// it contains shapes with three numbers per point. [`WANTS_CLICKS`], [`WANTS_DRAGS`], [`WANTS_KEYS`].
pub const WIDGET_SCENE: u32 = 12;

/// Text style: plain.
pub const WORDS_PLAIN: u32 = 0;
/// Text style: a heading.
pub const WORDS_HEADING: u32 = 1;
/// Text style: less prominent.
pub const WORDS_FAINT: u32 = 2;
/// Text style: a good state.
pub const WORDS_GOOD: u32 = 3;
/// Text style: a warning.
pub const WORDS_WARNING: u32 = 4;
/// Text style: an error.
pub const WORDS_ERROR: u32 = 5;
/// Text style: a fixed-width font.
pub const WORDS_CODE: u32 = 6;

/// Widget flag: reports clicks.
pub const WANTS_CLICKS: u32 = 1;
/// Widget flag: reports drags. Without it a drag moves the view.
pub const WANTS_DRAGS: u32 = 2;
/// Widget flag: reports keys while it has the focus.
pub const WANTS_KEYS: u32 = 4;
/// Widget flag: shown with x up and y to the left, the frame of a robot that faces up the screen.
pub const FORWARD_UP: u32 = 8;
/// Widget flag: cannot be pressed at present.
pub const DISABLED: u32 = 16;
/// Widget flag: folded at first.
pub const FOLDED: u32 = 32;

/// Shape: a line through `points` in their order. [`CLOSED`].
pub const SHAPE_LINE: u32 = 0;
/// Shape: separate `points`. `width` is their diameter.
pub const SHAPE_POINTS: u32 = 1;
/// Shape: an arrow from the first of two `points` to the second.
pub const SHAPE_ARROW: u32 = 2;
/// Shape: the `text` at the one point.
pub const SHAPE_LABEL: u32 = 3;
/// Shape of a canvas: a circle of `radius` about the one point. [`FILLED`].
pub const SHAPE_CIRCLE: u32 = 4;
/// Shape of a canvas: a filled convex polygon with the corners `points`.
pub const SHAPE_POLYGON: u32 = 5;
/// Shape of a canvas: the robot that the application drives at the one point, its heading in `turned[2]`.
pub const SHAPE_ROBOT: u32 = 6;
/// Shape of a scene: a box of `extent` about the one point, `turned`.
pub const SHAPE_BOX: u32 = 7;
/// Shape of a scene: a sphere of `radius` about the one point.
pub const SHAPE_SPHERE: u32 = 8;
/// Shape of a scene: a cylinder of `radius` about the one point, `extent[2]` high, `turned`.
pub const SHAPE_CYLINDER: u32 = 9;
/// Shape of a scene: triangles with three `points` each, counter-clockwise seen from outside.
pub const SHAPE_MESH: u32 = 10;

/// Shape flag: the line returns from the last point to the first.
pub const CLOSED: u32 = 1;
/// Shape flag: filled.
pub const FILLED: u32 = 2;

/// Color: that of text. Colors below 256 are inks, which fit the viewer's theme.
pub const INK_PLAIN: u32 = 0;
/// Color: less prominent.
pub const INK_FAINT: u32 = 1;
/// Color: the main subject.
pub const INK_ACCENT: u32 = 2;
/// Color: a good state; free.
pub const INK_GOOD: u32 = 3;
/// Color: a warning; near.
pub const INK_WARN: u32 = 4;
/// Color: a failure; an obstacle.
pub const INK_BAD: u32 = 5;
/// Color: a target.
pub const INK_GOAL: u32 = 6;
/// Color: measured data.
pub const INK_SEEN: u32 = 7;

/// Gesture: a button was pressed.
pub const TOUCH_PRESSED: u32 = 0;
/// Gesture: a toggle was switched; `number` is 1 for on.
pub const TOUCH_TOGGLED: u32 = 1;
/// Gesture: a slider was moved to `value`.
pub const TOUCH_MOVED: u32 = 2;
/// Gesture: the option with the index `number` of a choice was chosen.
pub const TOUCH_CHOSE: u32 = 3;
/// Gesture: clicked at `at` with `button`.
pub const TOUCH_CLICKED: u32 = 4;
/// Gesture: dragged from `from` to `at` with `button`. [`DRAG_ENDED`].
pub const TOUCH_DRAGGED: u32 = 5;
/// Gesture: the `key` went down (`number` is 1) or up.
pub const TOUCH_KEY: u32 = 6;

/// Button: the left one.
pub const BUTTON_PRIMARY: u32 = 0;
/// Button: the right one.
pub const BUTTON_SECONDARY: u32 = 1;
/// Button: the middle one.
pub const BUTTON_MIDDLE: u32 = 2;

/// Gesture flag: the drag has ended.
pub const DRAG_ENDED: u32 = 1;

/// The table that [`super::Schema::ability`] returns for [`ABILITY_PANEL`].
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Panel {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Draws the panel in its present state. Called only while a viewer shows it: while the schema is SLEPT,
    /// or after an iteration or a check, whose values [`super::Host::read`] still returns. It must change
    /// nothing: any call that writes, wakes or puts to sleep is [`super::REFUSED`], and the panel shows that.
    /// An error is shown in the panel and is no fault.
    pub draw: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Pen) -> i32>,
    /// Handles a gesture on a widget. Called between two iterations, and like an iteration. An error is a
    /// fault. May be null.
    pub touch: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Gesture) -> i32>,
}

/// The list of widgets under construction; opaque to the plugin.
#[repr(C)]
pub struct Drawing {
    _opaque: [u8; 0],
}

/// The functions with which a plugin draws. Valid only until its [`Panel::draw`] returns, and on its thread.
/// They copy their arguments.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Pen {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// The first argument of the functions below.
    pub drawing: *mut Drawing,
    /// Adds a widget below the last one, or beside it in a row. A container is open until `end`.
    pub add: unsafe extern "C" fn(*mut Drawing, *const Widget) -> i32,
    /// Adds a shape to the open plot, canvas or scene.
    pub shape: unsafe extern "C" fn(*mut Drawing, *const Shape) -> i32,
    /// Closes the row, group, plot, canvas or scene that was opened last.
    pub end: unsafe extern "C" fn(*mut Drawing) -> i32,
}

/// A widget. Each kind uses the fields that the comment of its number names. The others are 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Widget {
    /// Bytes of this table.
    pub size: u32,
    /// [`WIDGET_TEXT`] to [`WIDGET_SCENE`].
    pub kind: u32,
    /// Identifies it in gestures and in the settings of viewers. Unique in the panel and not shown.
    pub id: *const c_char,
    /// The text on it or beside it.
    pub label: *const c_char,
    /// Unit in SI symbols: "m/s", "rad"; empty for none.
    pub unit: *const c_char,
    /// A number; finite.
    pub value: f64,
    /// Least value; finite.
    pub least: f64,
    /// Greatest value; finite, not below the least.
    pub greatest: f64,
    /// Least x, least y, greatest x, greatest y, m; all 0 for none.
    pub area: [f64; 4],
    /// Several texts.
    pub texts: *const *const c_char,
    /// Rows of pixels from the top, without gaps.
    pub pixels: *const u8,
    /// The number of texts.
    pub text_count: u32,
    /// A whole number.
    pub number: u32,
    /// [`WANTS_CLICKS`] to [`FOLDED`].
    pub flags: u32,
    /// Columns of pixels.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// Bytes of a pixel: 1 (grey), 3 (red, green, blue) or 4 (and the opacity).
    pub channels: u32,
}

/// A shape, or a curve of a plot. Each kind uses the fields that the comment of its number names. The others
/// are 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Shape {
    /// Bytes of this table.
    pub size: u32,
    /// [`SHAPE_LINE`] to [`SHAPE_MESH`].
    pub kind: u32,
    /// Its points, two or three numbers each as its widget has them; finite.
    pub points: *const f64,
    /// The number of points.
    pub point_count: u32,
    /// One of [`INK_PLAIN`] to [`INK_SEEN`], or exactly 0xAARRGGBB, of which AA, the opacity, is not 0.
    pub color: u32,
    /// Width of lines, or diameter of points, in points of the screen; 0 for the default.
    pub width: f64,
    /// Radius, m.
    pub radius: f64,
    /// Along x, y and z, m.
    pub extent: [f64; 3],
    /// Roll, pitch and yaw, rad.
    pub turned: [f64; 3],
    /// Its text.
    pub text: *const c_char,
    /// [`CLOSED`], [`FILLED`].
    pub flags: u32,
    /// 0.
    pub reserved: u32,
}

/// A gesture of a user on a widget. Valid until [`Panel::touch`] returns. Positions are in metres in the
/// plane or frame of a canvas or scene, and in pixels from the upper left corner of an image. If a position
/// has two numbers, the third is 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Gesture {
    /// Bytes of this table.
    pub size: u32,
    /// [`TOUCH_PRESSED`] to [`TOUCH_KEY`].
    pub kind: u32,
    /// The widget's id.
    pub widget: *const c_char,
    /// The operator: "ana@laptop".
    pub by: *const c_char,
    /// The name of a key: "a", "Space", "ArrowUp".
    pub key: *const c_char,
    /// Where a drag began.
    pub from: [f64; 3],
    /// Where it is.
    pub at: [f64; 3],
    /// A number.
    pub value: f64,
    /// A whole number.
    pub number: u32,
    /// [`BUTTON_PRIMARY`] to [`BUTTON_MIDDLE`].
    pub button: u32,
    /// [`DRAG_ENDED`].
    pub flags: u32,
    /// 0.
    pub reserved: u32,
}
