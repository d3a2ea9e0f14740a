//! The generated files of this project are those that the source makes.

use std::path::Path;

#[test]
fn the_generated_files_are_those_of_the_source() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let stale = jde_headers::stale(root);
    assert!(
        stale.is_empty(),
        "{stale:?}: `{}` renews them",
        jde_headers::RENEW
    );
}
