//! The wheel: with `pip` the tree of all packages becomes part of the prefix of an interpreter, a virtual environment
//! as a rule. There the executable finds the rest from its own place, and the interpreter finds the package for Python.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};

use super::Release;
use super::prefix::{LIBRARY, SONAME};
use crate::python::Environment;
use crate::{project_files, shell};

/// The name of the distribution; on PyPI the name `jde` is that of another project.
const DISTRIBUTION: &str = "jde_robot";

/// What `pip` and its index show of the wheel.
const README: &str = "programs/python/README.md";

/// The tools of the wheel: one packs it, the other finds on which systems it runs.
const ENVIRONMENT: Environment = Environment {
    folder: "wheel",
    packages: &["auditwheel==6.8.2", "wheel==0.48.0"],
    imports: &["auditwheel", "wheel"],
};

/// Makes the wheel of a prefix. Returns its file.
pub(super) fn make(release: &Release<'_>, prefix: &Path) -> Result<PathBuf> {
    let tree = release.folder.join("wheel");
    project_files::empty(&tree)?;
    let name = format!("{DISTRIBUTION}-{}", release.version);
    let parts = tree.join(format!("{name}.data"));
    let data = parts.join("data");
    fs::create_dir(&parts)?;
    shell::read(Command::new("cp").arg("--archive").args([prefix, &data]))?;
    fs::rename(data.join("bin"), parts.join("scripts"))?;
    fs::rename(data.join("lib/jde/python/jde"), tree.join("jde"))?;
    fs::remove_dir(data.join("lib/jde/python"))?;
    // A wheel has no links; the linker reads this file as one.
    let link = data.join("lib").join(LIBRARY);
    fs::remove_file(&link)?;
    fs::write(link, format!("INPUT({SONAME})\n"))?;
    let about = tree.join(format!("{name}.dist-info"));
    let licences = ["LICENSE-APACHE", "LICENSE-MIT"];
    project_files::copy(release.root, &licences, &about.join("licenses"))?;
    let readme = release.root.join(README);
    let readme = fs::read_to_string(&readme).with_context(|| readme.display().to_string())?;
    fs::write(
        about.join("METADATA"),
        format!(
            "Metadata-Version: 2.4\nName: {}\nVersion: {}\nSummary: Robot behaviours that run side by side, of which one acts\n\
             Requires-Python: >=3.10\nLicense-Expression: MIT OR Apache-2.0\n{}\
             Description-Content-Type: text/markdown\n\n{readme}",
            DISTRIBUTION.replace('_', "-"),
            release.version,
            licences
                .map(|licence| format!("License-File: {licence}\n"))
                .concat()
        ),
    )?;
    let platform = format!("linux_{}", std::env::consts::ARCH);
    fs::write(
        about.join("WHEEL"),
        format!("Wheel-Version: 1.0\nGenerator: jde\nRoot-Is-Purelib: false\nTag: cp310-abi3-{platform}\n"),
    )?;
    let file = pack(release, &tree, &format!("{name}-cp310-abi3-{platform}.whl"))?;
    fs::remove_dir_all(tree)?;
    Ok(file)
}

/// Packs the tree as the file `name`, and renames it after the oldest systems that have the libraries it needs.
fn pack(release: &Release<'_>, tree: &Path, name: &str) -> Result<PathBuf> {
    let python = ENVIRONMENT.interpreter(&release.metadata.target_directory, release.paint)?;
    let tool = |module: &str| {
        let mut tool = Command::new(&python);
        tool.args(["-m", module])
            .current_dir(&release.folder)
            .env("SOURCE_DATE_EPOCH", &release.time);
        tool
    };
    shell::run(tool("wheel").arg("pack").arg(tree), release.paint)?;
    let audit = shell::read(tool("auditwheel").args(["show", "--json", name]))?;
    let audit: serde_json::Value = serde_json::from_str(&audit)?;
    let platform = audit["overall_tag"].as_str();
    let platform = platform.context("`auditwheel` names no platform")?;
    let retagged = shell::read(tool("wheel").args(["tags", "--remove", "--platform-tag", platform, name]))?;
    Ok(release.folder.join(retagged.trim()))
}
