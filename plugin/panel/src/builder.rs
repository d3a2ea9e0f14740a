//! A list that grows widget by widget. It refuses an error or an excess at once, and everything after it, so
//! drawing without end uses no memory. It never returns a broken list.

use crate::limits::{Checker, wrong};
use crate::{Broken, Item, List, Shape, Solid, Trace};

/// A list that grows.
#[derive(Default)]
pub struct Builder {
    items: Vec<Item>,
    /// The open widgets, each inside the one before.
    open: Vec<Item>,
    checker: Checker,
    broken: Option<Broken>,
}

/// What can be added to the open widget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Widgets: none is open, or a row or group is.
    Widgets,
    /// The curves of a plot.
    Traces,
    /// The shapes of a canvas.
    Shapes,
    /// The shapes of a scene.
    Solids,
}

impl Builder {
    /// Returns an empty builder.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns why the list is broken, if it is.
    #[must_use]
    pub fn broken(&self) -> Option<&Broken> {
        self.broken.as_ref()
    }

    /// Returns the name of the open widget, for messages.
    #[must_use]
    pub fn inside(&self) -> &str {
        self.open.last().map_or("", name)
    }

    /// Returns what can be added now.
    #[must_use]
    pub fn holds(&self) -> Holds {
        match self.open.last() {
            Some(Item::Plot { .. }) => Holds::Traces,
            Some(Item::Canvas { .. }) => Holds::Shapes,
            Some(Item::Scene { .. }) => Holds::Solids,
            Some(_) | None => Holds::Widgets,
        }
    }

    /// Breaks the list with this reason, if it is not broken already.
    pub fn refuse(&mut self, reason: Broken) {
        self.broken.get_or_insert(reason);
    }

    /// Adds a widget below the last, or beside it in a row. A row, group, plot, canvas or scene stays open
    /// until [`Self::end`].
    ///
    /// # Errors
    /// Why the list is broken. The same holds for the methods below.
    pub fn add(&mut self, item: Item) -> Result<(), Broken> {
        self.step(|builder| {
            if builder.holds() != Holds::Widgets {
                return wrong(builder.inside(), "no widget can stand inside it");
            }
            let depth = builder.open.len();
            builder.checker.item(&item, depth)?;
            builder.checker.inside(&item, depth)?;
            if opens(&item) {
                builder.open.push(item);
            } else {
                builder.put(item);
            }
            Ok(())
        })
    }

    /// Adds a shape to the open canvas.
    ///
    /// # Errors
    /// Why the list is broken.
    pub fn shape(&mut self, shape: Shape) -> Result<(), Broken> {
        self.step(|builder| match builder.open.last_mut() {
            Some(Item::Canvas { id, shapes, .. }) => {
                builder.checker.shape(id, &shape)?;
                shapes.push(shape);
                Ok(())
            }
            other => wrong(
                other.map_or("", |item| name(item)),
                "a shape of a canvas outside of one",
            ),
        })
    }

    /// Adds a shape to the open scene.
    ///
    /// # Errors
    /// Why the list is broken.
    pub fn solid(&mut self, solid: Solid) -> Result<(), Broken> {
        self.step(|builder| match builder.open.last_mut() {
            Some(Item::Scene { id, solids, .. }) => {
                builder.checker.solid(id, &solid)?;
                solids.push(solid);
                Ok(())
            }
            other => wrong(
                other.map_or("", |item| name(item)),
                "a shape of a scene outside of one",
            ),
        })
    }

    /// Adds a curve to the open plot.
    ///
    /// # Errors
    /// Why the list is broken.
    pub fn trace(&mut self, trace: Trace) -> Result<(), Broken> {
        self.step(|builder| match builder.open.last_mut() {
            Some(Item::Plot { id, traces, .. }) => {
                builder.checker.trace(id, &trace)?;
                traces.push(trace);
                Ok(())
            }
            other => wrong(other.map_or("", |item| name(item)), "a curve outside of a plot"),
        })
    }

    /// Ends the widget that was opened last.
    ///
    /// # Errors
    /// Why the list is broken.
    pub fn end(&mut self) -> Result<(), Broken> {
        self.step(|builder| match builder.open.pop() {
            Some(item) => {
                builder.put(item);
                Ok(())
            }
            None => wrong("", "an end of nothing that was begun"),
        })
    }

    /// Returns the list, drawn at `time`, in nanoseconds since the application's start.
    ///
    /// # Errors
    /// Why the list is broken.
    pub fn finish(mut self, time: u64) -> Result<List, Broken> {
        self.step(|builder| match builder.open.last() {
            Some(open) => wrong(name(open), "it was begun and not ended"),
            None => Ok(()),
        })?;
        Ok(List {
            time,
            items: self.items,
        })
    }

    fn step(&mut self, step: impl FnOnce(&mut Self) -> Result<(), Broken>) -> Result<(), Broken> {
        let result = match &self.broken {
            Some(broken) => Err(broken.clone()),
            None => step(self),
        };
        if let Err(broken) = &result
            && self.broken.is_none()
        {
            self.broken = Some(broken.clone());
            // A broken list is never shown.
            (self.items, self.open) = (Vec::new(), Vec::new());
        }
        result
    }

    fn put(&mut self, item: Item) {
        match self.open.last_mut() {
            Some(Item::Row { items } | Item::Group { items, .. }) => items.push(item),
            Some(_) | None => self.items.push(item),
        }
    }
}

/// Returns whether a widget can contain something.
fn opens(item: &Item) -> bool {
    matches!(
        item,
        Item::Row { .. } | Item::Group { .. } | Item::Plot { .. } | Item::Canvas { .. } | Item::Scene { .. }
    )
}

/// Returns the name of a widget in messages.
fn name(item: &Item) -> &str {
    match item {
        Item::Value { label, .. } => label,
        Item::Row { .. } => "a row",
        item => item.id().unwrap_or("a text"),
    }
}
