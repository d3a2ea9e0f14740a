//! Sets up the build for the macros of copper-rs.

fn main() {
    cu29_build::setup();
}
