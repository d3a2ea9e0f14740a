//! Gives the library its name for the linker. The number changes when programs must be built again.

fn main() {
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libjde.so.0");
    println!("cargo::rerun-if-changed=build.rs");
}
