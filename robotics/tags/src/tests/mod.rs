//! Tags that are drawn, and then found.

mod detector;
mod family;
mod pose;
mod scene;
