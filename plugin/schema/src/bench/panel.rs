//! The panel of a schema, on the bench: it can be drawn, touched and examined widget by widget. A widget that
//! does not exist panics with a message: it is a mistake of the test or of the schema.

#![allow(unsafe_code)]

use jde_abi::{raw, table};
use jde_panel::{Item, List, Shape, Solid, Touch, Trace};

use super::names::unknown;
use super::{Bench, Failure};

/// The contents of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    list: List,
}

/// The schema's own panel.
impl<S> Bench<S> {
    /// Draws the panel, as if a viewer showed it.
    ///
    /// # Errors
    /// The error that the panel would show instead of its contents: the schema panics, writes, or draws what
    /// cannot be shown.
    ///
    /// # Panics
    /// If the schema has no panel.
    pub fn draw(&mut self) -> Result<Drawn, Failure> {
        let draw = self.panel().draw;
        let Some(draw) = draw else {
            panic!(
                "the panel of `{}` cannot be drawn: its `draw` is null",
                self.description.name
            )
        };
        self.state.drawing = Some(Vec::new());
        let time = u64::try_from(self.state.now.as_nanos()).unwrap_or(u64::MAX);
        let (drawn, list) = jde_panel::lend_pen(time, |pen| {
            // SAFETY: the table's own function, instance and context, and a pen that lives until it returns.
            self.call(|instance, cx| unsafe { draw(instance, cx, pen) })
        });
        let attempts = self.state.drawing.take().unwrap_or_default();
        let refused = |reason| Failure {
            code: raw::REFUSED,
            reason,
        };
        if let Some(attempt) = attempts.first() {
            return Err(refused(format!(
                "it tried to {attempt} while its panel was drawn"
            )));
        }
        drawn?;
        list.map(|list| Drawn { list })
            .map_err(|broken| refused(broken.to_string()))
    }

    /// Performs a gesture on a widget, as the operator "ana@laptop".
    ///
    /// # Errors
    /// If the schema fails or panics.
    ///
    /// # Panics
    /// If the schema has no panel, or one that cannot be touched.
    pub fn touch(&mut self, widget: &str, touch: Touch) -> Result<(), Failure> {
        let Some(call) = self.panel().touch else {
            panic!(
                "the panel of `{}` cannot be touched: its `touch` is null",
                self.description.name
            )
        };
        let gesture = jde_panel::Gesture {
            widget: widget.to_owned(),
            touch,
        };
        jde_panel::lend_gesture("ana@laptop", &gesture, |gesture| {
            // SAFETY: the table's own function, instance and context, and a gesture that lives until the
            // function returns.
            self.call(|instance, cx| unsafe { call(instance, cx, gesture) })
        })
    }

    fn panel(&self) -> raw::Panel {
        // SAFETY: the bench has read and validated this table.
        match unsafe { table::ability(&self.table, raw::ABILITY_PANEL) } {
            Ok(Some(panel)) => panel,
            Ok(None) => panic!(
                "`{}` has no panel; write `impl Panel` for it",
                self.description.name
            ),
            Err(wrong) => panic!("the panel of `{}` cannot be used: {wrong}", self.description.name),
        }
    }
}

impl Drawn {
    /// Returns all widgets.
    #[must_use]
    pub fn list(&self) -> &List {
        &self.list
    }

    /// Returns the texts, from top to bottom.
    #[must_use]
    pub fn texts(&self) -> Vec<&str> {
        let texts = self.list.walk().filter_map(|item| match item {
            Item::Text { text, .. } => Some(&**text),
            _ => None,
        });
        texts.collect()
    }

    /// Returns the number with this name.
    #[must_use]
    #[track_caller]
    pub fn value(&self, label: &str) -> f64 {
        let values = self.list.walk().filter_map(|item| match item {
            Item::Value { label, value, .. } => Some((&**label, *value)),
            _ => None,
        });
        let values: Vec<_> = values.collect();
        let found = values.iter().find(|(name, _)| *name == label);
        match found {
            Some((_, value)) => *value,
            None => unknown("value", label, values.iter().map(|(name, _)| *name)),
        }
    }

    /// Returns the widget with this id.
    #[must_use]
    #[track_caller]
    pub fn widget(&self, id: &str) -> &Item {
        let found = self.list.walk().find(|item| item.id() == Some(id));
        match found {
            Some(item) => item,
            None => unknown("widget", id, self.list.walk().filter_map(Item::id)),
        }
    }

    /// Returns whether there is a widget with this id.
    #[must_use]
    pub fn has(&self, id: &str) -> bool {
        self.list.walk().any(|item| item.id() == Some(id))
    }

    /// Returns whether this button can be pressed.
    #[must_use]
    #[track_caller]
    pub fn can_press(&self, button: &str) -> bool {
        match self.widget(button) {
            Item::Button { enabled, .. } => *enabled,
            other => panic!("`{button}` is no button: {other:?}"),
        }
    }

    /// Returns whether this toggle is on.
    #[must_use]
    #[track_caller]
    pub fn is_on(&self, toggle: &str) -> bool {
        match self.widget(toggle) {
            Item::Toggle { on, .. } => *on,
            other => panic!("`{toggle}` is no toggle: {other:?}"),
        }
    }

    /// Returns the value of this slider.
    #[must_use]
    #[track_caller]
    pub fn slider(&self, slider: &str) -> f64 {
        match self.widget(slider) {
            Item::Slider { value, .. } => *value,
            other => panic!("`{slider}` is no slider: {other:?}"),
        }
    }

    /// Returns the chosen option of this choice.
    #[must_use]
    #[track_caller]
    pub fn chosen(&self, choice: &str) -> &str {
        match self.widget(choice) {
            Item::Choice { options, chosen, .. } => &options[*chosen as usize],
            other => panic!("`{choice}` is no choice: {other:?}"),
        }
    }

    /// Returns the shapes of this canvas.
    #[must_use]
    #[track_caller]
    pub fn shapes(&self, canvas: &str) -> &[Shape] {
        match self.widget(canvas) {
            Item::Canvas { shapes, .. } => shapes,
            other => panic!("`{canvas}` is no canvas: {other:?}"),
        }
    }

    /// Returns the shapes of this scene.
    #[must_use]
    #[track_caller]
    pub fn solids(&self, scene: &str) -> &[Solid] {
        match self.widget(scene) {
            Item::Scene { solids, .. } => solids,
            other => panic!("`{scene}` is no scene: {other:?}"),
        }
    }

    /// Returns the curves of this plot.
    #[must_use]
    #[track_caller]
    pub fn curves(&self, plot: &str) -> &[Trace] {
        match self.widget(plot) {
            Item::Plot { traces, .. } => traces,
            other => panic!("`{plot}` is no plot: {other:?}"),
        }
    }
}
