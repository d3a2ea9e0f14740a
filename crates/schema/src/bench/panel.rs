//! A panel that was drawn on the bench, to be looked at widget by widget. Widgets that are not there panic in words: they are
//! mistakes of the test, or of the schema.

use jde_panel::{Item, List, Shape, Solid, Trace};

use super::names::unknown;

/// What a panel shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    list: List,
}

impl Drawn {
    pub(super) fn new(list: List) -> Self {
        Self { list }
    }

    /// All of it.
    #[must_use]
    pub fn list(&self) -> &List {
        &self.list
    }

    /// Its texts, from top to bottom.
    #[must_use]
    pub fn texts(&self) -> Vec<&str> {
        let texts = self.items().into_iter().filter_map(|item| match item {
            Item::Text { text, .. } => Some(&**text),
            _ => None,
        });
        texts.collect()
    }

    /// The number with this name.
    #[must_use]
    #[track_caller]
    pub fn value(&self, label: &str) -> f64 {
        let values = self.items().into_iter().filter_map(|item| match item {
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

    /// The widget with this id.
    #[must_use]
    #[track_caller]
    pub fn widget(&self, id: &str) -> &Item {
        let items = self.items();
        let found = items.iter().find(|item| self::id(item) == Some(id));
        match found {
            Some(item) => item,
            None => unknown("widget", id, items.iter().filter_map(|item| self::id(item))),
        }
    }

    /// Whether there is a widget with this id.
    #[must_use]
    pub fn has(&self, id: &str) -> bool {
        self.items().into_iter().any(|item| self::id(item) == Some(id))
    }

    /// Whether this button can be pressed.
    #[must_use]
    #[track_caller]
    pub fn can_press(&self, button: &str) -> bool {
        match self.widget(button) {
            Item::Button { enabled, .. } => *enabled,
            other => panic!("`{button}` is no button: {other:?}"),
        }
    }

    /// Whether this toggle is on.
    #[must_use]
    #[track_caller]
    pub fn is_on(&self, toggle: &str) -> bool {
        match self.widget(toggle) {
            Item::Toggle { on, .. } => *on,
            other => panic!("`{toggle}` is no toggle: {other:?}"),
        }
    }

    /// What this slider is at.
    #[must_use]
    #[track_caller]
    pub fn slider(&self, slider: &str) -> f64 {
        match self.widget(slider) {
            Item::Slider { value, .. } => *value,
            other => panic!("`{slider}` is no slider: {other:?}"),
        }
    }

    /// Which of this choice is taken.
    #[must_use]
    #[track_caller]
    pub fn chosen(&self, choice: &str) -> &str {
        match self.widget(choice) {
            Item::Choice { options, chosen, .. } => &options[*chosen as usize],
            other => panic!("`{choice}` is no choice: {other:?}"),
        }
    }

    /// The shapes of this canvas.
    #[must_use]
    #[track_caller]
    pub fn shapes(&self, canvas: &str) -> &[Shape] {
        match self.widget(canvas) {
            Item::Canvas { shapes, .. } => shapes,
            other => panic!("`{canvas}` is no canvas: {other:?}"),
        }
    }

    /// The shapes of this scene.
    #[must_use]
    #[track_caller]
    pub fn solids(&self, scene: &str) -> &[Solid] {
        match self.widget(scene) {
            Item::Scene { solids, .. } => solids,
            other => panic!("`{scene}` is no scene: {other:?}"),
        }
    }

    /// The curves of this plot.
    #[must_use]
    #[track_caller]
    pub fn curves(&self, plot: &str) -> &[Trace] {
        match self.widget(plot) {
            Item::Plot { traces, .. } => traces,
            other => panic!("`{plot}` is no plot: {other:?}"),
        }
    }

    /// Every widget, those inside others after them.
    fn items(&self) -> Vec<&Item> {
        fn collect<'a>(items: &'a [Item], all: &mut Vec<&'a Item>) {
            for item in items {
                all.push(item);
                if let Item::Row { items } | Item::Group { items, .. } = item {
                    collect(items, all);
                }
            }
        }
        let mut all = Vec::new();
        collect(&self.list.items, &mut all);
        all
    }
}

fn id(item: &Item) -> Option<&str> {
    match item {
        Item::Text { .. } | Item::Value { .. } | Item::Row { .. } => None,
        Item::Button { id, .. }
        | Item::Toggle { id, .. }
        | Item::Slider { id, .. }
        | Item::Choice { id, .. }
        | Item::Image { id, .. }
        | Item::Plot { id, .. }
        | Item::Table { id, .. }
        | Item::Group { id, .. }
        | Item::Canvas { id, .. }
        | Item::Scene { id, .. } => Some(id),
    }
}
