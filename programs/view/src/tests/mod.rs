//! Tests of the windows on real applications, with widgets found by label, clicked and typed into; and
//! pictures of them.

mod bodies;
mod common;
mod drawn_text;
mod events;
mod frame;
mod letters;
mod painter;
mod panel;
mod panel_pictures;
mod panel_sliders;
mod readable;
mod robot;
mod scope;
mod scope_live;
mod space;
mod stop;
mod values;
