//! Checks that the generated files of this project are up to date.

use std::path::Path;

#[test]
fn the_generated_files_are_up_to_date() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let stale = jde_headers::stale(root);
    assert!(
        stale.is_empty(),
        "{stale:?}: `{}` renews them",
        jde_headers::RENEW
    );
}
