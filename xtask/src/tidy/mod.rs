//! The checks that rustfmt and clippy cannot make. Each check is a function in a file of its own. It reads
//! the tree and reports what is wrong, where, and what to do. No check changes anything.

mod cells;
mod events;
mod features;
pub(crate) mod fences;
mod first_command;
mod floors;
mod header;
mod honest_tests;
mod layering;
mod length;
pub(crate) mod licences;
pub(crate) mod links;
mod locked;
mod machine_paths;
mod module_files;
mod rules;
mod rust;
mod same_on_all;
mod sources;
mod streams;
mod tree;
mod unfinished;
mod unsafe_places;
mod unused;
mod versions;
mod whitespace;
mod words;

use std::path::Path;

use anyhow::{Result, bail};

use self::tree::{Tree, Violation};
use crate::metadata::Metadata;

/// Checks the whole tree and returns the violations, ordered by place.
fn violations(root: &Path) -> Result<Vec<Violation>> {
    let tree = Tree::read(root)?;
    let metadata = Metadata::with_dependencies(root)?;
    let mut found = [
        layering::check(&tree, &metadata),
        cells::check(&tree),
        events::check(&tree),
        fences::check(&tree),
        features::check(&tree, &metadata),
        first_command::check(&tree)?,
        header::check(&tree),
        honest_tests::check(&tree),
        length::check(&tree),
        licences::check(&metadata),
        links::check(&tree),
        locked::check(&tree),
        machine_paths::check(&tree),
        module_files::check(&tree),
        rules::check(&tree),
        same_on_all::check(&tree),
        sources::check(&tree),
        streams::check(&tree),
        unfinished::check(&tree),
        unsafe_places::check(&tree),
        unused::check(&tree, &metadata),
        versions::check(&tree, &metadata),
        whitespace::check(&tree),
        words::check(&tree),
    ]
    .concat();
    found.sort();
    Ok(found)
}

/// Prints all violations. Returns an error if there is any.
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
