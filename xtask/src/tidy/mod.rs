//! The gate of the tree: what rustfmt and clippy cannot see. Each check is a function in a file of its own;
//! it reads the tree and says what is wrong, where, and what to do. None of them changes anything.

mod arrows;
mod fences;
mod header;
mod honest_tests;
mod length;
mod licences;
mod links;
mod machine_paths;
mod rules;
mod rust;
mod sources;
mod streams;
mod tree;
mod unfinished;
mod unsafe_places;
mod unused;
mod versions;
mod whitespace;

use std::path::Path;

use anyhow::{Result, bail};

use self::tree::{Tree, Violation};
use crate::metadata::Metadata;

/// Looks at the whole tree and returns the violations, in the order of their places.
fn violations(root: &Path) -> Result<Vec<Violation>> {
    let tree = Tree::read(root)?;
    let metadata = Metadata::with_dependencies(root)?;
    let mut found = [
        arrows::check(&tree, &metadata),
        fences::check(&tree),
        header::check(&tree),
        honest_tests::check(&tree),
        length::check(&tree),
        licences::check(&metadata),
        links::check(&tree),
        machine_paths::check(&tree),
        rules::check(&tree),
        sources::check(&tree),
        streams::check(&tree),
        unfinished::check(&tree),
        unsafe_places::check(&tree),
        unused::check(&tree, &metadata),
        versions::check(&tree, &metadata),
        whitespace::check(&tree),
    ]
    .concat();
    found.sort();
    Ok(found)
}

/// Prints what is not tidy; an error when there is any.
pub(crate) fn run(root: &Path) -> Result<()> {
    let found = violations(root)?;
    for violation in &found {
        println!("{violation}");
    }
    if !found.is_empty() {
        bail!("{} places are not tidy", found.len());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_tree_is_tidy() {
        let found = super::violations(&crate::root()).unwrap();
        let text: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert!(found.is_empty(), "\n{}\n", text.join("\n"));
    }
}
