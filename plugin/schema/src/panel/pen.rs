//! The pen with which a schema draws its panel.

use core::ops::RangeInclusive;

use jde_abi::raw;
use jde_panel::Words;
use jde_types::Image;

use super::pixels;
use super::plane::{Canvas, Plot};
use super::space::Scene;
use super::widget::Widget;

/// Draws widgets from top to bottom. An `id` names a widget in gestures, is unique in the panel and is not
/// shown. The first mistake, such as a duplicate id or a number that is NaN, is shown instead of the panel.
pub struct Pen<'p> {
    raw: &'p raw::Pen,
}

impl<'p> Pen<'p> {
    pub(crate) fn of(raw: &'p raw::Pen) -> Self {
        Self { raw }
    }
}

impl Pen<'_> {
    /// Draws a heading.
    pub fn heading(&mut self, text: impl AsRef<str>) {
        self.words(Words::Heading, text);
    }

    /// Draws a text.
    pub fn text(&mut self, text: impl AsRef<str>) {
        self.words(Words::Plain, text);
    }

    /// Draws a text in the style that `words` states.
    pub fn words(&mut self, words: Words, text: impl AsRef<str>) {
        self.widget(raw::WIDGET_TEXT, "", text.as_ref())
            .number(words.code());
    }

    /// Draws a number with its name and its unit, such as "m/s" or "rad". Viewers convert it to the units
    /// that their users prefer.
    pub fn value(&mut self, label: impl AsRef<str>, value: impl Into<f64>, unit: &str) {
        self.widget(raw::WIDGET_VALUE, "", label.as_ref())
            .value(value.into(), unit);
    }

    /// Draws a button: see [`Gesture::pressed`](super::Gesture). Append `.enabled(false)` if it cannot be
    /// pressed at present.
    pub fn button(&mut self, id: &str, label: impl AsRef<str>) -> Widget<'_> {
        self.widget(raw::WIDGET_BUTTON, id, label.as_ref())
    }

    /// Draws a toggle, which is on or off.
    pub fn toggle(&mut self, id: &str, label: impl AsRef<str>, on: bool) {
        self.widget(raw::WIDGET_TOGGLE, id, label.as_ref())
            .number(u32::from(on));
    }

    /// Draws a slider for a number within `range`.
    pub fn slider(
        &mut self,
        id: &str,
        label: impl AsRef<str>,
        value: f64,
        range: RangeInclusive<f64>,
        unit: &str,
    ) {
        let mut slider = self
            .widget(raw::WIDGET_SLIDER, id, label.as_ref())
            .value(value, unit);
        slider.table.least = *range.start();
        slider.table.greatest = *range.end();
    }

    /// Draws a choice of one among several options. `chosen` is the index of the present one.
    pub fn choice<T: AsRef<str>>(
        &mut self,
        id: &str,
        label: impl AsRef<str>,
        options: impl IntoIterator<Item = T>,
        chosen: usize,
    ) {
        self.widget(raw::WIDGET_CHOICE, id, label.as_ref())
            .texts(options)
            .number(u32::try_from(chosen).unwrap_or(u32::MAX));
    }

    /// Draws an image in an encoding of cameras: "rgb8", "bgr8", "rgba8", "bgra8" or "mono8". The coordinates
    /// of clicks are pixels.
    pub fn image<'s>(&'s mut self, id: &str, image: &'s Image) -> Widget<'s> {
        let (channels, pixels) = pixels::of(image);
        let mut widget = self.widget(raw::WIDGET_IMAGE, id, "").pixels(pixels);
        (widget.table.width, widget.table.height) = (image.width, image.height);
        widget.table.channels = channels;
        widget
    }

    /// Draws a table of texts. Each row has as many cells as `heads`.
    pub fn table<H: AsRef<str>, C: AsRef<str>, R: IntoIterator<Item = C>>(
        &mut self,
        id: &str,
        heads: impl IntoIterator<Item = H>,
        rows: impl IntoIterator<Item = R>,
    ) {
        let table = self.widget(raw::WIDGET_TABLE, id, "").texts(heads);
        let columns = table.text_count() as u32;
        table.number(columns).texts(rows.into_iter().flatten());
    }

    /// Draws widgets beside each other.
    pub fn row(&mut self, inside: impl FnOnce(&mut Pen)) {
        self.widget(raw::WIDGET_ROW, "", "")
            .around(|raw| inside(&mut Pen { raw }));
    }

    /// Draws widgets below a heading, which the user can fold.
    pub fn group(&mut self, id: &str, label: impl AsRef<str>, inside: impl FnOnce(&mut Pen)) {
        self.widget(raw::WIDGET_GROUP, id, label.as_ref())
            .around(|raw| inside(&mut Pen { raw }));
    }

    /// Draws the same as [`group`](Self::group), folded at first.
    pub fn folded(&mut self, id: &str, label: impl AsRef<str>, inside: impl FnOnce(&mut Pen)) {
        let mut group = self.widget(raw::WIDGET_GROUP, id, label.as_ref());
        group.flag(raw::FOLDED, true);
        group.around(|raw| inside(&mut Pen { raw }));
    }

    /// Draws a plane in metres, with pan and zoom: `pen.canvas("field").forward_up().show(|plane| { ... })`.
    pub fn canvas(&mut self, id: &str) -> Canvas<'_> {
        Canvas::new(self.widget(raw::WIDGET_CANVAS, id, ""))
    }

    /// Draws a space in metres, in a frame of REP-105 such as "odom" or "base_link". Viewers show it by
    /// itself and in their 3D view.
    pub fn scene(&mut self, id: &str, frame: &str) -> Scene<'_> {
        Scene::new(self.widget(raw::WIDGET_SCENE, id, frame))
    }

    /// Draws curves: `pen.plot("speed", "Speed").axes("time, s", "m/s").show(|curves| { ... })`.
    pub fn plot(&mut self, id: &str, label: impl AsRef<str>) -> Plot<'_> {
        Plot::new(self.widget(raw::WIDGET_PLOT, id, label.as_ref()))
    }

    fn widget(&mut self, kind: u32, id: &str, label: &str) -> Widget<'_> {
        Widget::new(self.raw, kind, id, label)
    }
}
