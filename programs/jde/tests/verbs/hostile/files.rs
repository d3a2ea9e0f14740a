//! The parts of which hostile files are made.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;

pub(super) fn nothing(_: &Path) {}

pub(super) fn write(folder: &Path, name: &str, content: impl AsRef<[u8]>) {
    fs::write(folder.join(name), content).expect("a written file");
}

pub(super) fn app(folder: &Path, text: &str) {
    write(folder, "app.toml", text);
}

pub(super) fn pipe(folder: &Path, name: &str) {
    let made = Command::new("mkfifo").arg(folder.join(name)).status();
    assert!(made.expect("mkfifo is installed").success());
}

/// A file of a terabyte that takes no place.
pub(super) fn sparse(folder: &Path, name: &str) {
    write(folder, name, "");
    lengthen(folder, name);
}

/// Lengthens a file to a terabyte.
pub(super) fn lengthen(folder: &Path, name: &str) {
    let file = File::options()
        .write(true)
        .open(folder.join(name))
        .expect("a file");
    // Some file systems have no files as large.
    let sizes = [1 << 40, 1 << 33];
    assert!(sizes.iter().any(|size| file.set_len(*size).is_ok()));
}

/// Adds a text to a gzip file, many times: parts that follow each other are one file.
pub(super) fn add_packed(folder: &Path, name: &str, text: &[u8], times: usize) {
    let mut packing = GzEncoder::new(Vec::new(), Compression::best());
    packing.write_all(text).expect("it is written");
    let part = packing.finish().expect("it is written");
    let file = File::options().append(true).create(true).open(folder.join(name));
    file.and_then(|mut file| file.write_all(&part.repeat(times)))
        .expect("it is written");
}

pub(super) fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, number| {
        text += &line(number);
        text.push('\n');
        text
    })
}

pub(super) fn list(count: usize, item: impl Fn(usize) -> String) -> String {
    format!("[{}]", lines(count, |number| format!("\"{}\",", item(number))))
}
