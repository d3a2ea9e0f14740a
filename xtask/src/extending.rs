//! Applies every change that `docs/extending.md` shows to a copy of the project, counts the files that each
//! changes, and builds the copy.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, ensure};

use crate::project_files;
use crate::shell;
use crate::step::StepOutcome;
use crate::test::{Context, LINTING_COMPILER};

const PAGE: &str = "docs/extending.md";
const BEGIN: &str = "```diff\n";
const END: &str = "\n```\n";

/// A section with a change.
#[derive(Debug, PartialEq, Eq)]
struct Extension {
    title: String,
    /// The numbers of files that the page states.
    stated: String,
    patch: String,
}

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    let page = fs::read_to_string(context.root.join(PAGE))?;
    let extensions = extensions(&page);
    ensure!(!extensions.is_empty(), "{PAGE} shows no change");
    let copy = context.target.join("extending");
    copy_project(&context.root, &copy)?;
    for extension in &extensions {
        let counted = counted(&extension.patch);
        ensure!(
            extension.stated == counted,
            "{PAGE}, {}: it states `{}`, and its change has `{counted}`",
            extension.title,
            extension.stated
        );
        let patch = copy.join("change.diff");
        fs::write(&patch, &extension.patch)?;
        let mut git = Command::new("git");
        git.args(["apply", "change.diff"]).current_dir(&copy);
        shell::run(&mut git, context.paint)
            .with_context(|| format!("{PAGE}, {}: its change does not fit any more", extension.title))?;
    }
    // The whole workspace, so that the libraries have the features of the step before, and are not checked again.
    let target = target(context);
    let check = context.cargo(&["check", "--lib", "--workspace"]);
    let test = context.cargo(&["test", "--lib", "--package", "jde-core"]);
    for mut cargo in [check, test] {
        cargo.current_dir(&copy).arg("--target-dir").arg(&target);
        // The changes are compiled, and not linted; as in the step before.
        cargo.env_remove(LINTING_COMPILER);
        shell::run(&mut cargo, context.paint)?;
    }
    Ok(StepOutcome::Passed)
}

/// Returns the target folder of the copy: one of its own, since cargo takes equal packages of two folders for the same,
/// and would later take those of the copy for those of the project. In CI no build follows.
fn target(context: &Context) -> PathBuf {
    match context.ci {
        true => context.target.clone(),
        false => context.target.join("extending-build"),
    }
}

/// Copies the project.
fn copy_project(root: &Path, copy: &Path) -> Result<()> {
    project_files::empty(copy)?;
    project_files::copy(root, &["."], copy)?;
    // Git applies a change to a folder of a project only if that is a project of its own.
    shell::read(Command::new("git").args(["init", "--quiet"]).current_dir(copy))?;
    Ok(())
}

fn extensions(page: &str) -> Vec<Extension> {
    let sections = page.split("\n## ").skip(1);
    sections
        .filter_map(|section| {
            let (text, rest) = section.split_once(BEGIN)?;
            let (patch, _) = rest.split_once(END)?;
            let mut lines = text.lines().filter(|line| !line.is_empty());
            Some(Extension {
                title: lines.next()?.to_owned(),
                stated: lines.next()?.to_owned(),
                patch: format!("{patch}\n"),
            })
        })
        .collect()
}

fn counted(patch: &str) -> String {
    let all = patch
        .lines()
        .filter(|line| line.starts_with("diff --git "))
        .count();
    let new = patch.lines().filter(|line| *line == "--- /dev/null").count();
    let files = if new == 1 { "file" } else { "files" };
    format!("{new} new {files}, {} changed.", all - new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_and_its_stated_files_are_read() {
        let page = "# T\n\n## A\n\nno change\n\n## B\n\n1 new file, 1 changed.\n\nText.\n\n```diff\ndiff --git a/x b/x\n\
                    --- /dev/null\n+++ b/x\ndiff --git a/y b/y\n--- a/y\n+++ b/y\n```\n";
        let [extension] = &extensions(page)[..] else {
            panic!("one section has a change")
        };
        assert_eq!(extension.title, "B");
        assert_eq!(counted(&extension.patch), extension.stated);
    }
}
