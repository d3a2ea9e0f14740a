//! Writes new schemas, drivers, applications, worlds and robots, most from the templates beside this crate's sources.
//!
//! Never writes into an existing folder, or over a file.

mod kind;
mod name;
mod real_robot;
mod robot;
mod world;

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use jde_isolation::python::{folders, of_environment};
use jde_session::paths;
use jde_terminal::{self as terminal, FAINT, TITLE};

use crate::failure::{self, Failure};
use name::Name;

pub(crate) use kind::TemplateKind;
pub(crate) use real_robot::{BASES, Driver, LASERS, write_real_robot};
pub(crate) use robot::write_robot;
pub(crate) use world::write_world;

/// Writes a template into a folder of its name, and prints what to do next.
///
/// # Errors
/// The name is invalid, the folder exists already, or the files cannot be written.
pub(crate) fn write(kind: TemplateKind, name: &str, folder: &Path) -> Result<(), Failure> {
    let is_used = |word: &str| kind.files().any(|(file, text)| is_taken(file, text, word));
    let name = checked(name, is_used)?;
    let folder = folder.join(&name.kebab);
    create_folder(&folder)?;
    let jde = program();
    for (file, text) in kind.files() {
        let module = name.kebab.replace('-', "_");
        let path = folder.join(file.replace("__crate__", &module));
        let text = text
            .replace("__name__", &name.kebab)
            .replace("__Name__", &name.camel)
            .replace("__crate__", &module)
            .replace("__about__", kind.about())
            .replace("__build__", kind.build_folder())
            .replace("__prefix__", &prefix())
            .replace("__python__", &python())
            .replace("__dependencies__", &dependencies(kind))
            .replace("__jde__", &jde);
        let written = path
            .parent()
            .map_or(Ok(()), fs::create_dir_all)
            .and_then(|()| fs::write(&path, text));
        written.map_err(Failure::file(&path))?;
    }
    let mut out = terminal::out();
    let shown = failure::display_path(&folder);
    writeln!(
        out,
        "{TITLE}{shown}{TITLE:#} is created {FAINT}(its README.md describes it){FAINT:#}; next:"
    )?;
    writeln!(out)?;
    writeln!(out, "  cd {shown}")?;
    for line in kind.next_commands() {
        let line = line.replace("__jde__", &jde).replace("__python__", &python());
        writeln!(out, "  {line}")?;
    }
    Ok(())
}

/// Checks a name.
fn checked(name: &str, is_used: impl Fn(&str) -> bool) -> Result<Name, Failure> {
    Name::new(name, is_used).map_err(|wrong| {
        Failure::usage(
            wrong,
            "write small letters and digits, with single hyphens between: follow-wall",
        )
    })
}

/// Makes the folder. Fails if it exists.
fn create_folder(folder: &Path) -> Result<(), Failure> {
    let parent = folder.parent().map_or(Ok(()), jde_files::create_folder);
    parent
        .and_then(|()| fs::create_dir(folder))
        .map_err(|error| not_created(folder, error))
}

/// Writes a new file. Fails if it exists.
fn write_file(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Failure> {
    File::create_new(path)
        .and_then(|mut file| file.write_all(contents.as_ref()))
        .map_err(|error| not_created(path, error))
}

/// Why a file or a folder could not be made.
fn not_created(path: &Path, error: io::Error) -> Failure {
    match error.kind() {
        ErrorKind::AlreadyExists => Failure::usage(
            format!("{} already exists", failure::display_path(path)),
            "choose another name, or another folder with --path",
        ),
        _ => Failure::file(path)(error),
    }
}

/// Returns the dependencies of a package on crates of jde: those of the installation or of the checkout of this
/// build if they exist, else published versions.
fn dependencies(kind: TemplateKind) -> String {
    let line = |folder: &&str| {
        let path = paths::data().join(folder);
        let (_, name) = folder.rsplit_once('/').unwrap_or_default();
        if path.join("Cargo.toml").is_file() {
            // Escape the path as a TOML string. Rust's debug form differs only for characters that no such path
            // has.
            format!("jde-{name} = {{ path = {:?} }}", path.display().to_string())
        } else {
            format!("jde-{name} = {:?}", env!("CARGO_PKG_VERSION"))
        }
    };
    kind.crates().iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Returns where CMake finds the package `jde`: the prefix of an installation, or the checkout.
fn prefix() -> String {
    let data = paths::data();
    let installed = data
        .ends_with("share/jde")
        .then(|| data.ancestors().nth(2))
        .flatten();
    installed.unwrap_or(&data).display().to_string()
}

/// Returns how the user calls an interpreter that has the package for Python: that of the virtual environment of this
/// program, or by the folder of this build's package, or without one if the package was installed for the interpreter
/// itself.
fn python() -> String {
    // An interpreter of an environment is a link to one that is not.
    let folder = |file: &Path| file.parent().and_then(|folder| folder.canonicalize().ok());
    let interpreter = of_environment(None).map_or("python3".to_owned(), |own| called(&own, folder));
    let data = paths::data();
    let folder = folders(None)
        .find(|folder| folder.is_dir())
        .or_else(|| (!data.ends_with("share/jde")).then(|| data.join("target/python")));
    match folder {
        Some(folder) => format!("PYTHONPATH={} {interpreter}", folder.display()),
        None => interpreter,
    }
}

/// Returns how the user calls this program.
fn program() -> String {
    let own = std::env::current_exe().unwrap_or_else(|_| PathBuf::from("jde"));
    called(&own, |file| file.canonicalize().ok())
}

/// Returns how the user calls a program: by name if PATH finds it, else by path. Two files with the same key are the
/// same program.
fn called(own: &Path, key: impl Fn(&Path) -> Option<PathBuf>) -> String {
    let name = own.file_name().unwrap_or_default();
    let found = std::env::var_os("PATH").and_then(|path| {
        std::env::split_paths(&path)
            .map(|folder| folder.join(name))
            .find(|file| file.is_file())
    });
    let called = match found {
        Some(file) if key(&file) == key(own) => Path::new(name),
        Some(_) | None => own,
    };
    called.display().to_string()
}

/// Whether a file of a template uses a name for something else: a type in code, a module in Python, an instance in
/// an application.
fn is_taken(file: &str, text: &str, name: &str) -> bool {
    let imports = |line: &str| line.split(' ').nth(1) == Some(name) && line.contains("import ");
    if file.ends_with(".py") && text.lines().any(imports) {
        return true;
    }
    let is_code = [".rs", ".hpp", ".cpp", ".c", ".py"]
        .iter()
        .any(|end| file.ends_with(end));
    if !is_code {
        return text.contains(&format!("[schemas.{name}]"));
    }
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    let mut words = code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'));
    name.starts_with(char::is_uppercase) && words.any(|word| word == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_template_replaces_types_and_instances_and_no_other_words() {
        let is_used = |kind: TemplateKind, name| kind.files().any(|(file, text)| is_taken(file, text, name));
        assert!(is_used(TemplateKind::Motor, "Twist"));
        assert!(is_used(TemplateKind::Motor, "pioneer"));
        assert!(is_used(TemplateKind::Perceptive, "face"));
        assert!(is_used(TemplateKind::Driver, "Jaws"));
        assert!(is_used(TemplateKind::MotorPython, "jde"));
        assert!(is_used(TemplateKind::MotorPython, "Bench"));
        assert!(is_used(TemplateKind::Application, "guide"));
        for name in ["gripper", "Gripper", "wall", "Wall", "follow"] {
            assert!(
                TemplateKind::ALL.iter().all(|kind| !is_used(*kind, name)),
                "{name}"
            );
        }
    }

    #[test]
    fn templates_contain_no_unknown_placeholder() {
        for (file, text) in TemplateKind::ALL.iter().flat_map(|kind| kind.files()) {
            let filled = [
                "__name__",
                "__Name__",
                "__crate__",
                "__about__",
                "__build__",
                "__prefix__",
                "__python__",
                "__dependencies__",
                "__jde__",
            ]
            .iter()
            .fold(text.to_owned(), |text, mark| text.replace(mark, ""));
            // Names of Python.
            let filled = filled.replace("__pycache__", "").replace("__init__", "");
            assert!(!filled.contains("__"), "{file}");
        }
    }
}
