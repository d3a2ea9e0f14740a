//! Builds and loads plugins in C and C++.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use jde_abi::{raw, read};

/// Loads a plugin in C or C++ and returns the table of its first schema. The plugin stays loaded.
pub(super) fn load(source: &str) -> &'static raw::Schema {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join(source);
    let name = source
        .file_stem()
        .and_then(|name| name.to_str())
        .expect("a name")
        .to_owned();
    let plugin = open(&compile(&source, &name));
    // SAFETY: the table of a plugin that stays loaded; `read::plugin` validates it first.
    unsafe {
        read::plugin(plugin).expect("the tables are valid");
        &*(*plugin).schemas
    }
}

pub(super) fn open(library: &Path) -> *const raw::Plugin {
    // SAFETY: a library of ours, without constructors.
    let library = unsafe { libloading::Library::new(library) }.expect("it loads");
    // SAFETY: the symbol is a table, and only its address is taken.
    let symbol =
        unsafe { library.get::<*const raw::Plugin>(raw::ENTRY_SYMBOL) }.expect("it exports its table");
    // SAFETY: as above.
    let plugin = unsafe { symbol.try_as_raw_ptr() }
        .expect("an address")
        .cast_const()
        .cast();
    std::mem::forget(library);
    plugin
}

pub(super) fn compile(source: &Path, name: &str) -> PathBuf {
    // Tests run in parallel, and two of them may compile the same source.
    static COMPILED: AtomicUsize = AtomicUsize::new(0);
    let number = COMPILED.fetch_add(1, Ordering::Relaxed);
    let library = output(&format!("lib{name}-{number}.so"));
    let in_cpp = source.extension().is_some_and(|extension| extension == "cpp");
    let (compiler, standard, more) = match in_cpp {
        true => ("c++", "-std=c++17", "-Wconversion"),
        false => ("cc", "-std=c99", "-pedantic"),
    };
    let mut compile = Command::new(compiler);
    compile.args([standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", more, "-I"]);
    run(compile
        .arg(include())
        .args(["-shared", "-fPIC", "-o"])
        .arg(&library)
        .arg(source)
        .arg("-lm"));
    library
}

pub(super) fn run(command: &mut Command) {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?} needs a C and a C++ compiler: {error}"));
    assert!(
        output.status.success(),
        "{command:?}: {}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

pub(super) fn output(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

pub(super) fn include() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../include")
}
