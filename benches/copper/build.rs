//! Tells the macros of copper-rs where they keep things.

fn main() {
    cu29_build::setup();
}
