//! The father of safe navigation: gives its children the targets, one after another.
