//! Plugin files, valid and invalid. A file that can be recognised as invalid is refused before any of its code
//! runs. The message names the file and the remedy. The tests build real libraries with cargo and `cc`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use jde_abi::raw;
use jde_app::parse;
use jde_host::{Lockstep, Options};
use jde_loader::{PluginError, Plugins, SearchPath};

use crate::delivered;
use tempfile::TempDir;

/// The beginning of the C source of most libraries of these tests.
const HEAD: &str = "#include \"jde.h\"\n\
    static void *create(const jde_schema *s, const jde_host *h, jde_context *c) { (void)s; (void)h; (void)c; static int instance; return &instance; }\n\
    static int32_t iterate(void *i, jde_context *c) { (void)i; (void)c; return JDE_OK; }\n\
    static const jde_schema schemas[] = {{.size = sizeof(jde_schema), .kind = JDE_MOTOR, .name = \"beat\", .doc = \"Beats.\",\n\
        .period_ns = 1000000, .create = create, .iterate = iterate}};\n";

/// The source of a plugin with one motor schema that is always ready.
fn beat(name: &str) -> String {
    format!("{HEAD}JDE_PLUGIN(\"{name}\", \"1\", \"Beats.\", schemas);\n")
}

/// Builds `lib<name>.so` from C source.
fn cc(folder: &Path, name: &str, source: &str) -> PathBuf {
    let (from, to) = (
        folder.join(format!("{name}.c")),
        folder.join(format!("lib{name}.so")),
    );
    fs::write(&from, source).expect("it is written");
    let include = concat!(env!("CARGO_MANIFEST_DIR"), "/../../include");
    let output = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=c11", "-I", include, "-o"])
        .args([&to, &from])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    to
}

/// The plugin `stop` as cargo builds it.
fn stop() -> PathBuf {
    delivered::folder().join("libstop.so")
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn no_plugins() -> Plugins {
    Plugins::new(SearchPath::default())
}

/// Checks that the file is refused with a message that begins with its path and contains the expected texts.
#[track_caller]
fn assert_refused(file: &Path, expected: &[&str]) {
    let error = no_plugins().open(file).expect_err("it is refused");
    assert!(matches!(error, PluginError::Unusable { .. }), "{error:?}");
    let message = error.to_string();
    assert!(message.starts_with(&format!("{}: ", file.display())), "{message}");
    for text in expected {
        assert!(message.contains(text), "`{text}` is not in: {message}");
    }
}

#[test]
fn a_plugin_that_cargo_built_is_loaded_and_described() {
    let plugin = no_plugins().open(&stop()).expect("it is a plugin");
    assert_eq!(plugin.description.name, "stop");
    assert_eq!(
        plugin.path.as_deref(),
        Some(stop().canonicalize().expect("it is there").as_path())
    );
    let ports = plugin.description.schemas[0]
        .ports
        .iter()
        .map(|port| port.name.as_str());
    assert_eq!(
        ports.collect::<Vec<_>>(),
        ["laser", "half_width", "ahead", "base"]
    );
}

#[test]
fn a_file_is_loaded_once_under_all_its_names() {
    let folder = folder();
    let file = cc(folder.path(), "beat", &beat("beat"));
    let link = folder.path().join("libother.so");
    std::os::unix::fs::symlink(&file, &link).expect("a link");
    let plugins = no_plugins();
    let first = plugins.open(&file).expect("it is a plugin");
    let second = plugins.open(&link).expect("it is a plugin");
    let third = plugins
        .load("beat", &[folder.path().to_owned()])
        .expect("it is a plugin");
    for other in [second, third] {
        assert!(std::sync::Arc::ptr_eq(&first.description, &other.description));
    }
}

#[test]
fn a_missing_plugin_is_reported_with_the_folders_that_were_searched() {
    let folder = folder();
    let error = no_plugins()
        .load("nothing", &[folder.path().to_owned()])
        .expect_err("there is none");
    let expected = format!(
        "there is no plugin `nothing` in\n    {} (named in the application)\n    jde.schemas (entry points of Python)",
        folder.path().display()
    );
    assert_eq!(error.to_string(), expected);
    assert_refused(
        &folder.path().join("libnothing.so"),
        &["cannot read it: No such file or directory"],
    );
}

#[test]
fn a_file_that_is_not_a_library_is_refused() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, bytes).expect("it is written");
        file
    };
    assert_refused(folder.path(), &["it is a directory", "name the library in it"]);
    assert_refused(
        &write("libempty.so", b""),
        &["the file is empty", "build or copy it again"],
    );
    assert_refused(
        &write("libtext.so", b"# not code\n"),
        &["no ELF header", "build it as a cdylib"],
    );
    assert_refused(
        &write("libhead.so", b"\x7fELF"),
        &["it is not a shared library that can be loaded"],
    );
    let executable = std::env::current_exe().expect("this test");
    let mut bytes = fs::read(stop()).expect("it is there");
    // ET_REL: an object file that has not been linked.
    bytes[16] = 1;
    assert_refused(
        &write("libobject.so", &bytes),
        &["it is an ELF file, but no shared library", "cdylib"],
    );
    // The machine number of another processor.
    (bytes[16], bytes[18]) = (3, 0x08);
    assert_refused(
        &write("libforeign.so", &bytes),
        &["it was built for another processor"],
    );
    // Position-independent executables are shared objects by their header; they export no plugin.
    assert_refused(&executable, &["not a jde plugin"]);
}

#[test]
fn a_truncated_library_is_refused_at_every_length() {
    let folder = folder();
    let whole = fs::read(cc(folder.path(), "beat", &beat("beat"))).expect("it is there");
    let file = folder.path().join("libcut.so");
    for length in (0..whole.len()).step_by(61).chain([whole.len() - 1]) {
        fs::write(&file, &whole[..length]).expect("it is written");
        let message = no_plugins().open(&file).expect_err("it is truncated").to_string();
        assert!(
            message.starts_with(&file.display().to_string()),
            "{length}: {message}"
        );
    }
    let whole = fs::read(stop()).expect("it is there");
    for length in [
        64,
        4096,
        whole.len() / 3,
        whole.len() / 2,
        whole.len() - 4096,
        whole.len() - 1,
    ] {
        fs::write(&file, &whole[..length]).expect("it is written");
        assert_refused(&file, &["build or copy it again"]);
    }
}

#[test]
fn a_library_that_is_not_a_plugin_is_refused_before_it_is_loaded() {
    let folder = folder();
    // The constructor would create this file if the library were loaded.
    let mark = folder.path().join("mark");
    let source = format!(
        "#include <stdio.h>\n__attribute__((constructor)) static void run(void) {{ fclose(fopen(\"{}\", \"w\")); }}\nint answer = 42;\n",
        mark.display()
    );
    assert_refused(
        &cc(folder.path(), "plain", &source),
        &["exports no symbol `jde_plugin`", "not a jde plugin"],
    );
    // The symbol alone is not sufficient, and ABI 99 is not supported.
    let symbols = [
        (
            "unmarked",
            "const char jde_plugin[256] = \"JDEPLUG0\";\n",
            "the mark of a jde plugin",
        ),
        (
            "other",
            "const char jde_plugin[256] = \"JDEPLUG1\\x63\";\n",
            "built for ABI 99.0",
        ),
        ("late", "char jde_plugin[256];\n", "the mark of a jde plugin"),
    ];
    for (name, symbol, expected) in symbols {
        assert_refused(
            &cc(folder.path(), name, &format!("{source}{symbol}")),
            &[expected],
        );
    }
    assert!(!mark.exists());
}

#[test]
fn a_symbol_of_the_right_name_that_is_not_a_plugin_is_refused() {
    let folder = folder();
    let mark = "does not begin with the mark of a jde plugin";
    let cases = [
        ("zeros", "char jde_plugin[256];\n"),
        ("small", "int jde_plugin = 7;\n"),
        (
            "function",
            "int jde_plugin(int a) { return a * a * a + a * a + 1; }\n",
        ),
        (
            "odd",
            "struct { char a; char jde[255]; } __attribute__((packed)) all = {0};\n\
                 extern char jde_plugin[] __attribute__((alias(\"all\")));\n",
        ),
    ];
    for (name, source) in cases {
        assert_refused(&cc(folder.path(), name, source), &[mark, "jde.h"]);
    }
}

#[test]
fn an_older_and_a_newer_major_version_are_refused_with_both_numbers() {
    let folder = folder();
    let ours = format!("this host's {}.{}", raw::ABI_MAJOR, raw::ABI_MINOR);
    let versions = [
        (
            "past",
            0,
            7,
            format!("it was built for ABI 0.7, older than {ours}; build it again with this host's SDK"),
        ),
        (
            "major",
            2,
            0,
            format!("it was built for ABI 2.0, newer than {ours}"),
        ),
    ];
    for (name, major, minor, expected) in versions {
        // Only the head is defined: the table of another version may have any layout after it.
        let head = format!(
            "#include \"jde.h\"\nconst struct {{ uint64_t magic; uint32_t major, minor; uint64_t rest[16]; }} jde_plugin = {{JDE_MAGIC, {major}, {minor}, {{0}}}};\n"
        )
        .replace("#include \"jde.h\"", "#include <stdint.h>\n#define JDE_MAGIC UINT64_C(0x3147554c5045444a)");
        assert_refused(&cc(folder.path(), name, &head), &[&expected]);
    }
}

#[test]
fn an_invalid_table_is_refused_with_the_place_of_the_error() {
    let folder = folder();
    let table = |size: &str, name: &str, count: u32| {
        format!(
            "{HEAD}const struct jde_plugin jde_plugin = {{JDE_MAGIC, 1, 0, {size}, 0, {name}, \"1\", \"\", schemas, {count}, 0}};\n"
        )
    };
    let whole = "sizeof(struct jde_plugin)";
    let schema = |from: &str, to: &str| beat("beat").replace(from, to);
    let cases = [
        (
            "short",
            table("16", "\"short\"", 1),
            "its description is wrong at the plugin: ",
        ),
        ("none", table(whole, "\"none\"", 0), "it holds no schema"),
        (
            "nameless",
            table(whole, "0", 1),
            "its description is wrong at the plugin: ",
        ),
        (
            "spaced",
            table(whole, "\"no name\"", 1),
            "its description is wrong at the plugin: ",
        ),
        (
            "still",
            schema(".period_ns = 1000000", ".period_ns = 0"),
            "schema `beat`: period_ns is 0",
        ),
        (
            "strange",
            schema("JDE_MOTOR", "9"),
            "kind is 9, and only 0 to 2 exist",
        ),
        (
            "narrow",
            schema(".size = sizeof(jde_schema)", ".size = 8"),
            "its description is wrong at plugin `beat`",
        ),
        (
            "idle",
            schema(".iterate = iterate", ".iterate = 0"),
            "create or iterate is null",
        ),
        (
            "abort",
            format!(
                "{HEAD}const struct jde_plugin jde_plugin = {{JDE_MAGIC, 1, 0, {whole}, JDE_PLUGIN_ABORTS, \"abort\", \"1\", \"\", schemas, 1, 0}};\n"
            ),
            "build it with panic = \"unwind\"",
        ),
    ];
    for (name, source, expected) in cases {
        assert_refused(&cc(folder.path(), name, &source), &[expected]);
    }
}

#[test]
fn a_symbol_that_is_smaller_than_its_declared_table_is_refused() {
    let folder = folder();
    let source = "#include <stdint.h>\n\
        const struct { uint64_t magic; uint32_t major, minor, size, flags; } jde_plugin =\n\
        {UINT64_C(0x3147554c5045444a), 1, 0, 4096, 0};\n";
    assert_refused(
        &cc(folder.path(), "small", source),
        &["its symbol `jde_plugin` has 24 bytes", "jde.h"],
    );
}

#[test]
fn a_plugin_with_an_undefined_symbol_is_refused() {
    let folder = folder();
    let source = format!(
        "{}extern int nobody_defines_this(void);\nint call_it(void) {{ return nobody_defines_this(); }}\n",
        beat("undefined")
    );
    let file = cc(folder.path(), "undefined", &source);
    assert_refused(
        &file,
        &[
            "the system cannot load it: ",
            "nobody_defines_this",
            "link the library that defines it into the plugin",
        ],
    );
    let message = no_plugins().open(&file).expect_err("it is refused").to_string();
    assert_eq!(
        message.matches("libundefined.so").count(),
        2,
        "the private copy is not named: {message}"
    );
}

#[test]
fn a_plugin_under_another_name_is_refused() {
    let folder = folder();
    cc(folder.path(), "alias", &beat("beat"));
    let error = no_plugins()
        .load("alias", &[folder.path().to_owned()])
        .expect_err("it holds another plugin");
    let expected = format!(
        "{} holds the plugin `beat`, not `alias`: rename the file or the plugin",
        folder.path().join("libalias.so").display()
    );
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_library_that_is_overwritten_keeps_running() {
    let folder = folder();
    let file = cc(folder.path(), "beat", &beat("beat"));
    let plugins = no_plugins();
    let text = format!(
        "roots = [\"heart\"]\nplugins = [\"{}\"]\n[schemas.heart]\ntype = \"beat\"\n",
        folder.path().display()
    );
    let application =
        parse(&text, Path::new("apps/heart.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let mut lockstep = Lockstep::start(application, &plugins, Options::default()).expect("it starts");
    let handle = lockstep.handle();
    lockstep.run_until(50_000_000);
    let before = handle.snapshot().schemas[0].iterations;
    assert_eq!(before, 51);
    // Overwrites the file in place, as some builds do. That would kill a process that maps the file itself.
    fs::write(&file, b"").expect("it is written");
    lockstep.run_until(100_000_000);
    assert_eq!(handle.snapshot().schemas[0].iterations, 101);
    // A `Plugins` reads a file once; a new `Plugins` reads the empty file.
    assert!(plugins.open(&file).is_ok());
    assert_refused(&file, &["the file is empty"]);
}
