//! The files under `include/` are those that the current Rust source generates.

use std::path::Path;

#[test]
fn the_headers_are_renewed() {
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../include");
    for (name, text) in jde_headers::all() {
        let file = std::fs::read_to_string(include.join(name)).unwrap_or_default();
        assert!(
            file == text,
            "include/{name} is stale; `{}` renews it",
            jde_headers::RENEW
        );
    }
}
