//! Files that somebody else has written, read within a budget, and files that replace others as a whole.
//!
//! It knows no format. A reader of a format takes its bytes from [`read`] or [`read_unpacked`], counts in a [`Budget`]
//! what it makes of them, and names in [`LeftOut`] what it does not understand. Whoever prints their texts takes [`escape`].

mod budget;
mod folder;
mod left_out;
mod read;
mod replace;
mod text;

pub use budget::{Budget, Exceeded};
pub use folder::create_folder;
pub use left_out::LeftOut;
pub use read::{open, read, read_text, read_undamaged, read_unpacked};
pub use replace::replace;
pub use text::{escape, escape_except, is_control};
