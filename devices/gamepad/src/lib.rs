//! The gamepads of this machine, by the kernel's input devices: which are there, and what a person holds. It needs no window,
//! no daemon and no library of the system, and it moves nothing.

mod layout;
mod link;
mod list;
mod open;
mod wanted;

pub use layout::{Controls, Range};
pub use link::{Found, Link, LinkState, Source};
pub use list::{Pad, pads};
pub use open::{check, open};
pub use wanted::Wanted;
