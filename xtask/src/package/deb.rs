//! The packages of Debian: `jde` for those who run robots, `libjde0` for programs that run applications, `libjde-dev` for
//! those who write plugins and such programs, `python3-jde` for those who use Python, and `jde-dbgsym` with the symbols of
//! all of them.

use std::fmt::Write as _;
use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};

use super::{Release, prefix, python};
use crate::{project_files, shell};

/// The first revision of each version.
const REVISION: &str = "1";

/// What `libjde0` holds of the prefix.
const LIBRARY: &[&str] = &["lib/libjde.so.0"];
/// What `libjde-dev` holds of the prefix. `python3-jde` holds the package for Python, and `jde` the rest.
const DEVELOPMENT: &[&str] = &[
    "include",
    "lib/cmake",
    "lib/libjde.so",
    "share/jde/Cargo.toml",
    "share/jde/base",
    "share/jde/rules",
    "share/jde/plugin",
    "share/jde/devices",
];

/// The licence of the codes of tags.
const TAGS: &str = "robotics/tags/LICENSE-apriltag";

/// The folder of the package for Python in the prefix, and that of Debian's interpreters.
const PYTHON: [&str; 2] = ["lib/jde/python", "lib/python3/dist-packages"];

/// The libraries that the windows of `jde view` load when they open.
const WINDOWS: &str = "libegl1, libxcursor1, libxi6, libxkbcommon-x11-0, mesa-vulkan-drivers | vulkan-icd";

/// One package.
struct Package {
    name: &'static str,
    section: &'static str,
    /// The further lines that state on what it depends.
    relations: String,
    /// One line, and a paragraph.
    description: [&'static str; 2],
    /// Further files for `dpkg`, by their names. Those that begin with `#!` are programs.
    control: &'static [(&'static str, &'static str)],
}

/// Makes the packages of a prefix. Returns their files.
pub(super) fn make(release: &Release<'_>, prefix: &Path) -> Result<Vec<PathBuf>> {
    let version = format!("{}-{REVISION}", release.version);
    let work = release.folder.join("deb");
    project_files::empty(&work)?;
    // Debian's tools know the trees of packages by this folder.
    let [main, library, development, python] =
        ["jde", "libjde0", "libjde-dev", "python3-jde"].map(|name| work.join("debian").join(name));
    let symbols = release.symbols();
    fs::create_dir_all(&main)?;
    shell::read(
        Command::new("cp")
            .arg("--archive")
            .arg(prefix)
            .arg(main.join("usr")),
    )?;
    let parts = [
        (LIBRARY, &library),
        (DEVELOPMENT, &development),
        (&PYTHON[..1], &python),
    ];
    for (parts, package) in parts {
        for part in parts {
            let (from, to) = (main.join("usr").join(part), package.join("usr").join(part));
            fs::create_dir_all(to.parent().unwrap_or(&to))?;
            fs::rename(&from, &to).with_context(|| format!("{} cannot be moved", from.display()))?;
        }
    }
    let [prefix_python, debian_python] = PYTHON.map(|folder| python.join("usr").join(folder));
    fs::create_dir_all(&debian_python)?;
    fs::rename(prefix_python.join("jde"), debian_python.join("jde"))?;
    // The program looks there for an interpreter that is not Debian's.
    symlink("../../python3/dist-packages/jde", prefix_python.join("jde"))?;
    // Debian has them in the file `copyright` of each package.
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        fs::remove_file(main.join("usr/share/jde").join(licence))?;
    }
    let unit = Path::new("lib/systemd/system/jde@.service");
    fs::create_dir_all(main.join("usr").join(unit).parent().unwrap_or(&main))?;
    fs::copy(
        release.root.join("packaging/jde@.service"),
        main.join("usr").join(unit),
    )?;
    let packages = [
        (
            main.clone(),
            Package {
                name: "jde",
                section: "science",
                relations: format!(
                    "Depends: {}\nRecommends: {WINDOWS}\nSuggests: libjde-dev, python3-jde\n",
                    libraries(&work, &programs(&main)?)?
                ),
                description: [
                    "robot behaviours that run side by side, of which one acts",
                    "A behaviour is a plugin, a schema. In each group of schemas one acts, and the program can always \
                 say why that one. This package contains the program, its plugins with drivers and a simulator, \
                 example applications and the documentation.",
                ],
                control: &[],
            },
        ),
        (
            library.clone(),
            Package {
                name: "libjde0",
                section: "libs",
                relations: format!(
                    "Depends: jde (= {version}), {}\n",
                    libraries(&work, &[library.join("usr").join(LIBRARY[0])])?
                ),
                description: [
                    "robot behaviours that run side by side (shared library)",
                    "This package contains the library with which programs in C and C++ run applications in their own \
                 process.",
                ],
                control: &[
                    ("shlibs", "libjde 0 libjde0\n"),
                    ("triggers", "activate-noawait ldconfig\n"),
                ],
            },
        ),
        (
            development,
            Package {
                name: "libjde-dev",
                section: "libdevel",
                relations: format!(
                    "Depends: jde (= {version}), libjde0 (= {version})\nSuggests: cargo, cmake\n"
                ),
                description: [
                    "robot behaviours that run side by side (development files)",
                    "This package contains what plugins for jde, and programs that run its applications, are written \
                 with: the headers for C and C++, and the crates for Rust, which `jde new schema` uses.",
                ],
                control: &[],
            },
        ),
        (
            python,
            Package {
                name: "python3-jde",
                section: "python",
                relations: format!(
                    "Depends: jde (= {version}), python3 (>= 3.10), {}\nSuggests: python3-numpy, python3-pytest\n",
                    libraries(&work, &[debian_python.join(python::MODULE)])?
                ),
                description: [
                    "robot behaviours that run side by side (package for Python)",
                    "This package contains the module `jde`, with which schemas are written in Python, and programs in \
                 Python run applications, read recordings and operate robots.",
                ],
                control: &[
                    (
                        "postinst",
                        "#!/bin/sh\nset -e\nif command -v py3compile > /dev/null; then py3compile -p python3-jde; fi\n",
                    ),
                    (
                        "prerm",
                        "#!/bin/sh\nset -e\nif command -v py3clean > /dev/null; then py3clean -p python3-jde; fi\n",
                    ),
                ],
            },
        ),
        (
            symbols,
            Package {
                name: "jde-dbgsym",
                section: "debug",
                relations: format!("Depends: jde (= {version})\nAuto-Built-Package: debug-symbols\n"),
                description: [
                    "robot behaviours that run side by side (symbols)",
                    "This package contains the names and the lines of the program, of its plugins, of the library and of the \
                 module for Python. With it, debuggers and backtraces name the line of each call.",
                ],
                control: &[],
            },
        ),
    ];
    let mut files = Vec::new();
    for (tree, package) in &packages {
        files.push(package.write(release, &version, tree)?);
    }
    fs::remove_dir_all(work)?;
    Ok(files)
}

impl Package {
    /// Completes the tree of a package with what Debian requires, and packs it.
    fn write(&self, release: &Release<'_>, version: &str, tree: &Path) -> Result<PathBuf> {
        let maintainer = maintainer(release.root)?;
        let doc = tree.join("usr/share/doc").join(self.name);
        if self.section == "debug" {
            // Debian wants nothing but symbols in such a package, and the package on which it depends has the rest.
            fs::create_dir_all(tree.join("usr/share/doc"))?;
            symlink("jde", &doc)?;
        } else {
            write_doc(release, version, &maintainer, &doc)?;
        }
        let debian = tree.join("DEBIAN");
        fs::create_dir_all(&debian)?;
        let sums = "find usr -type f -print0 | LC_ALL=C sort -z | xargs -0 md5sum";
        let sums = shell::read(Command::new("sh").args(["-c", sums]).current_dir(tree))?;
        fs::write(debian.join("md5sums"), sums)?;
        let size = shell::read(
            Command::new("du")
                .args(["--summarize", "--apparent-size", "--block-size=1K"])
                .arg(tree),
        )?;
        let size = size.split_whitespace().next().context("`du` prints no size")?;
        let architecture = shell::read(Command::new("dpkg").arg("--print-architecture"))?;
        let Self {
            name,
            section,
            relations,
            description: [summary, paragraph],
            control: files,
        } = self;
        for (file, text) in *files {
            let file = debian.join(file);
            fs::write(&file, text)?;
            if text.starts_with("#!") {
                fs::set_permissions(file, Permissions::from_mode(0o755))?;
            }
        }
        let control = format!(
            "Package: {name}\nVersion: {version}\nSource: jde\nSection: {section}\nPriority: optional\nArchitecture: {architecture}\
             Maintainer: {maintainer}\nInstalled-Size: {size}\n{relations}Description: {summary}\n{}",
            folded(paragraph)
        );
        fs::write(debian.join("control"), control)?;
        shell::read(
            Command::new("chmod")
                .args(["--recursive", "u=rwX,go=rX"])
                .arg(tree),
        )?;
        let file = release
            .folder
            .join(format!("{name}_{version}_{}.deb", architecture.trim()));
        let mut pack = Command::new("dpkg-deb");
        pack.args([
            "--build",
            "--root-owner-group",
            "-Zxz",
            &format!("-z{}", release.level),
        ])
        .arg(tree)
        .arg(&file);
        shell::run(pack.env("SOURCE_DATE_EPOCH", &release.time), release.paint)?;
        Ok(file)
    }
}

/// Writes the files that Debian requires of a package: its licences and its changes.
fn write_doc(release: &Release<'_>, version: &str, maintainer: &str, doc: &Path) -> Result<()> {
    fs::create_dir_all(doc)?;
    let licence = fs::read_to_string(release.root.join("LICENSE-MIT"))?;
    let date = |form| {
        let time = format!("--date=@{}", release.time);
        shell::read(
            Command::new("date")
                .args(["--utc", form, &time])
                .env("LC_ALL", "C"),
        )
    };
    let tags = fs::read_to_string(release.root.join(TAGS))?;
    fs::write(
        doc.join("copyright"),
        copyright(&licence, &tags, date("+%Y")?.trim())?,
    )?;
    let date = date("--rfc-email")?;
    let changes = format!(
        "jde ({version}) unstable; urgency=medium\n\n  * Version {}: changelog.gz lists its changes.\n\n -- {maintainer}  {date}",
        release.version
    );
    fs::copy(release.root.join("CHANGELOG.md"), doc.join("changelog"))?;
    fs::write(doc.join("changelog.Debian"), changes)?;
    for file in ["changelog", "changelog.Debian"] {
        prefix::gzip(&doc.join(file))?;
    }
    Ok(())
}

/// Returns the name and the address of whoever makes the packages, as Debian's tools do: `DEBFULLNAME` and
/// `DEBEMAIL`, or else those of the last commit.
fn maintainer(root: &Path) -> Result<String> {
    let of_commit = |form: &str| {
        let mut git = Command::new("git");
        shell::read(
            git.args(["log", "-1", &format!("--format={form}")])
                .current_dir(root),
        )
    };
    let read = |variable: &str, form: &str| std::env::var(variable).or_else(|_| of_commit(form));
    let (name, address) = (read("DEBFULLNAME", "%an")?, read("DEBEMAIL", "%ae")?);
    Ok(format!("{} <{}>", name.trim(), address.trim()))
}

/// Returns the program and its plugins.
fn programs(main: &Path) -> Result<Vec<PathBuf>> {
    let mut programs = vec![main.join("usr/bin/jde")];
    for plugin in fs::read_dir(main.join("usr/lib/jde"))? {
        programs.push(plugin?.path());
    }
    Ok(programs)
}

/// Returns the packages of the shared libraries that these files need.
fn libraries(work: &Path, files: &[PathBuf]) -> Result<String> {
    // The tool reads this file and nothing from it.
    fs::write(
        work.join("debian/control"),
        "Source: jde\n\nPackage: jde\nArchitecture: any\n",
    )?;
    let mut tool = Command::new("dpkg-shlibdeps");
    tool.arg("-O").args(files).current_dir(work);
    let output = shell::read(&mut tool)?;
    let libraries = output.trim().strip_prefix("shlibs:Depends=");
    Ok(libraries.context("`dpkg-shlibdeps` names no library")?.to_owned())
}

/// Returns the licences in Debian's form: that of the project, and that of the codes of tags.
fn copyright(mit: &str, tags: &str, year: &str) -> Result<String> {
    let ((holder, text), (others, terms)) = (holder(mit)?, holder(tags)?);
    let holder = holder.trim_start_matches("Copyright (c) ");
    let others = others
        .trim_start_matches("Copyright (C) ")
        .lines()
        .next()
        .unwrap_or_default();
    Ok(format!(
        "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: jde\n\
         Comment: /usr/share/doc/jde/third-party.txt.gz has the notices of the libraries that are built in.\n\n\
         Files: *\nCopyright: {year} {holder}\nLicense: Expat or Apache-2.0\n\n\
         Files: robotics/tags/src/codes.rs\nCopyright: {others}\nLicense: BSD-2-Clause\n\n\
         License: Expat\n{}\nLicense: BSD-2-Clause\n{}\nLicense: Apache-2.0\n \
         On Debian systems, the full text is in /usr/share/common-licenses/Apache-2.0.\n",
        folded(text),
        folded(terms)
    ))
}

/// Returns the second paragraph of a licence, which names the holder, and the text after it.
fn holder(licence: &str) -> Result<(&str, &str)> {
    let (_, rest) = licence.split_once("\n\n").context("a licence has no title")?;
    rest.split_once("\n\n").context("a licence names no holder")
}

/// Returns a text as the further lines of a field: indented, broken, and a dot for an empty line.
fn folded(text: &str) -> String {
    let mut folded = String::new();
    for line in text.trim().lines() {
        let mut width = 0;
        for word in line.split_whitespace() {
            let is_first = width == 0;
            if !is_first && width + word.len() >= 78 {
                folded.push_str("\n ");
                width = 0;
            } else {
                folded.push(' ');
            }
            folded.push_str(word);
            width += word.len() + 1;
        }
        if line.trim().is_empty() {
            folded.push_str(" .");
        }
        let _ = writeln!(folded);
    }
    folded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_indented_and_its_empty_lines_have_a_dot() {
        assert_eq!(folded("a b\n\nc\n"), " a b\n .\n c\n");
        let long = folded(&"word ".repeat(30));
        assert!(
            long.lines().all(|line| line.starts_with(" w") && line.len() < 80),
            "{long}"
        );
        assert_eq!(long.split_whitespace().count(), 30);
    }

    #[test]
    fn the_licence_of_the_project_has_debians_form() {
        let text = fs::read_to_string(crate::root().join("LICENSE-MIT")).unwrap();
        let tags = fs::read_to_string(crate::root().join(TAGS)).unwrap();
        let copyright = copyright(&text, &tags, "2026").unwrap();
        assert!(
            copyright.contains("\nCopyright: 2026 the jde authors\n"),
            "{copyright}"
        );
        assert!(
            copyright.contains("\nLicense: Expat\n Permission is hereby granted"),
            "{copyright}"
        );
        assert!(
            copyright.contains("\nCopyright: 2013-2016, The Regents of The University of Michigan.\n"),
            "{copyright}"
        );
        assert!(
            copyright.contains("\nLicense: BSD-2-Clause\n Redistribution and use"),
            "{copyright}"
        );
    }
}
