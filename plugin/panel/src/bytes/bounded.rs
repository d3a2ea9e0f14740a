//! Sequences of a list, counted while they are decoded. An excess is refused before memory is allocated for
//! it. The counts are never higher than those of [`crate::check`], so every list that passes there also
//! passes here.

use std::cell::Cell;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::limits::{MOST_ITEMS, MOST_POINTS};
use crate::{Broken, Item};

/// What the list that is being decoded may still contain.
#[derive(Clone, Copy)]
struct Budget {
    items: usize,
    points: usize,
}

thread_local! {
    /// `None` while no list is decoded: a single part is bounded by its bytes only.
    static BUDGET: Cell<Option<Budget>> = const { Cell::new(None) };
}

/// Decodes the widgets of a whole list.
pub(crate) fn list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Item>, D::Error> {
    struct Restore(Option<Budget>);
    impl Drop for Restore {
        fn drop(&mut self) {
            BUDGET.set(self.0);
        }
    }
    let budget = Budget {
        items: MOST_ITEMS,
        points: MOST_POINTS,
    };
    let _restore = Restore(BUDGET.replace(Some(budget)));
    items(deserializer)
}

/// Decodes widgets, shapes, curves, options or headings.
pub(crate) fn items<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    deserializer.deserialize_seq(Counted(|| charge(1, 0), PhantomData))
}

/// Decodes the points of a line, curve or mesh.
pub(crate) fn points<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    deserializer.deserialize_seq(Counted(|| charge(0, 1), PhantomData))
}

/// Decodes the rows of a table. A row without cells counts as one cell.
pub(crate) fn cells<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<String>>, D::Error> {
    #[derive(Deserialize)]
    struct Row(#[serde(deserialize_with = "items")] Vec<String>);
    let remaining_items = || BUDGET.get().map(|budget| budget.items);
    let mut previous = remaining_items();
    let rows = Counted(
        || {
            // The cells of a row are already counted.
            if remaining_items() == previous {
                charge(1, 0)?;
            }
            previous = remaining_items();
            Ok(())
        },
        PhantomData::<Row>,
    );
    let rows = deserializer.deserialize_seq(rows)?;
    Ok(rows.into_iter().map(|Row(cells)| cells).collect())
}

/// Returns the error that the decoder reported as a text.
pub(super) fn broken(message: String) -> Broken {
    let limits = [Broken::Items, Broken::Points];
    let limits = limits.into_iter().find(|broken| broken.to_string() == message);
    limits.unwrap_or(Broken::Bytes(message))
}

fn charge(items: usize, points: usize) -> Result<(), Broken> {
    let Some(budget) = BUDGET.get() else {
        return Ok(());
    };
    let items = budget.items.checked_sub(items).ok_or(Broken::Items)?;
    let points = budget.points.checked_sub(points).ok_or(Broken::Points)?;
    BUDGET.set(Some(Budget { items, points }));
    Ok(())
}

/// A sequence whose elements are each granted or refused.
struct Counted<F, T>(F, PhantomData<T>);

impl<'de, F: FnMut() -> Result<(), Broken>, T: Deserialize<'de>> Visitor<'de> for Counted<F, T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a sequence")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut all = Vec::new();
        while let Some(element) = seq.next_element()? {
            (self.0)().map_err(A::Error::custom)?;
            all.push(element);
        }
        Ok(all)
    }
}
