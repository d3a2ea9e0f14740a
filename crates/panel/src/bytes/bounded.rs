//! Sequences of a list, counted while they are read: what is more than any list may hold is refused before there is memory for it.
//! It counts no more than [`crate::check`] does, so that nothing is refused here that would pass there.

use std::cell::Cell;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::limits::{MOST_ITEMS, MOST_POINTS};
use crate::{Broken, Item};

/// What else the list that is read may hold.
#[derive(Clone, Copy)]
struct Room {
    items: usize,
    points: usize,
}

thread_local! {
    /// Nothing while no list is read: a part by itself has no other bound than its bytes.
    static ROOM: Cell<Option<Room>> = const { Cell::new(None) };
}

/// The widgets of a whole list.
pub(crate) fn list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Item>, D::Error> {
    struct Restore(Option<Room>);
    impl Drop for Restore {
        fn drop(&mut self) {
            ROOM.set(self.0);
        }
    }
    let room = Room {
        items: MOST_ITEMS,
        points: MOST_POINTS,
    };
    let _restore = Restore(ROOM.replace(Some(room)));
    items(deserializer)
}

/// Widgets, shapes, curves, options or headings.
pub(crate) fn items<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    deserializer.deserialize_seq(Counted(|| take(1, 0), PhantomData))
}

/// Points of a line, curve or mesh.
pub(crate) fn points<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    deserializer.deserialize_seq(Counted(|| take(0, 1), PhantomData))
}

/// The rows of a table; one without cells counts as one with a cell.
pub(crate) fn cells<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<String>>, D::Error> {
    #[derive(Deserialize)]
    struct Row(#[serde(deserialize_with = "items")] Vec<String>);
    let left = || ROOM.get().map(|room| room.items);
    let mut before = left();
    let rows = Counted(
        || {
            // A row takes room for its cells by itself.
            if left() == before {
                take(1, 0)?;
            }
            before = left();
            Ok(())
        },
        PhantomData::<Row>,
    );
    let rows = deserializer.deserialize_seq(rows)?;
    Ok(rows.into_iter().map(|Row(cells)| cells).collect())
}

/// What is wrong, out of the words of whoever read it.
pub(super) fn broken(said: String) -> Broken {
    let known = [Broken::Items, Broken::Points];
    let known = known.into_iter().find(|broken| broken.to_string() == said);
    known.unwrap_or(Broken::Bytes(said))
}

fn take(items: usize, points: usize) -> Result<(), Broken> {
    let Some(room) = ROOM.get() else {
        return Ok(());
    };
    let items = room.items.checked_sub(items).ok_or(Broken::Items)?;
    let points = room.points.checked_sub(points).ok_or(Broken::Points)?;
    ROOM.set(Some(Room { items, points }));
    Ok(())
}

/// A sequence each element of which must be granted.
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
