//! Application files: what is accepted, and what is refused in words.

mod catalogue;
mod family;
mod file;
mod good;
mod groups;
mod keys;
mod link;
mod remote;
mod roots;
mod times;
mod values;
mod wiring;
