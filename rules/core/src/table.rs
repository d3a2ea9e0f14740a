//! Lists of which the entries are numbered by a type of their own, so that a group cannot index a list of schemas.
//!
//! Data only.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut, Index, IndexMut};

/// The number of an entry of a [`Table`].
pub trait Id: Copy {
    /// Returns the number of the entry at this index.
    fn new(index: usize) -> Self;

    /// Returns the index of the entry.
    fn index(self) -> usize;
}

/// A list that is indexed by its own type of numbers.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Table<I, T> {
    entries: Vec<T>,
    numbers: PhantomData<fn(I)>,
}

impl<I: Id, T> Table<I, T> {
    /// Returns the numbers of all entries.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = I> + ExactSizeIterator + use<I, T> {
        (0..self.entries.len()).map(I::new)
    }

    /// Returns all entries with their numbers.
    pub fn entries(&self) -> impl DoubleEndedIterator<Item = (I, &T)> + ExactSizeIterator {
        self.ids().zip(&self.entries)
    }

    /// Returns the entry of this number, if there is one.
    pub fn get(&self, id: I) -> Option<&T> {
        self.entries.get(id.index())
    }

    /// Returns the entry of this number for a change, if there is one.
    pub fn get_mut(&mut self, id: I) -> Option<&mut T> {
        self.entries.get_mut(id.index())
    }

    /// Returns the number of the first entry of which this is true.
    pub fn find(&self, is_it: impl FnMut(&T) -> bool) -> Option<I> {
        self.entries.iter().position(is_it).map(I::new)
    }

    /// Returns a table of the same numbers, with what a function makes of each of them.
    pub fn map_ids<U>(&self, entry: impl FnMut(I) -> U) -> Table<I, U> {
        self.ids().map(entry).collect()
    }

    /// Adds an entry.
    pub fn push(&mut self, entry: T) {
        self.entries.push(entry);
    }
}

impl<I: Id, T> Index<I> for Table<I, T> {
    type Output = T;

    #[inline]
    fn index(&self, id: I) -> &T {
        &self.entries[id.index()]
    }
}

impl<I: Id, T> IndexMut<I> for Table<I, T> {
    #[inline]
    fn index_mut(&mut self, id: I) -> &mut T {
        &mut self.entries[id.index()]
    }
}

impl<I, T> Deref for Table<I, T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.entries
    }
}

impl<I, T> DerefMut for Table<I, T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.entries
    }
}

impl<I, T> Default for Table<I, T> {
    fn default() -> Self {
        Self::from(Vec::new())
    }
}

impl<I, T> From<Vec<T>> for Table<I, T> {
    fn from(entries: Vec<T>) -> Self {
        Self {
            entries,
            numbers: PhantomData,
        }
    }
}

impl<I, T> FromIterator<T> for Table<I, T> {
    fn from_iter<E: IntoIterator<Item = T>>(entries: E) -> Self {
        Self::from(entries.into_iter().collect::<Vec<_>>())
    }
}

impl<I, T> IntoIterator for Table<I, T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(self) -> Self::IntoIter {
        self.entries.into_iter()
    }
}

impl<'a, I, T> IntoIterator for &'a Table<I, T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.entries.iter()
    }
}
