//! Libraries that end every process which maps them. Each is reported, and verbs that only list or check
//! plugins survive. The libraries are built by cc.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::attached::{Place, schema};
use crate::reloading::Shelf;
use crate::support::{Said, jde, root, said};

/// Builds a plugin of one motor schema, whose library runs `constructor` when it is mapped.
pub(crate) fn library(folder: &Path, name: &str, constructor: &str) -> PathBuf {
    let (source, file) = (
        folder.join(format!("{name}.c")),
        folder.join(format!("lib{name}.so")),
    );
    let text = format!(
        "#include \"jde.h\"\n#include <stdio.h>\n#include <stdlib.h>\n\
         static void *make(const jde_schema *s, const jde_host *h, jde_context *c) {{ (void)s; (void)h; (void)c; static int it; return &it; }}\n\
         static int32_t iterate(void *i, jde_context *c) {{ (void)i; (void)c; return JDE_OK; }}\n\
         static const jde_schema schemas[] = {{{{.size = sizeof(jde_schema), .kind = JDE_MOTOR, .name = \"beat\", .doc = \"Beats.\",\n\
             .period_ns = 1000000, .create = make, .iterate = iterate}}}};\n\
         __attribute__((constructor)) static void begin(void) {{ {constructor} }}\n\
         JDE_PLUGIN(\"{name}\", \"1\", \"Beats.\", schemas);\n"
    );
    fs::write(&source, text).unwrap();
    let done = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=c11", "-I"])
        .arg(root().join("include"))
        .arg("-o")
        .args([&file, &source])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    file
}

fn in_folder(folder: &Path, args: &[&str]) -> Said {
    said(jde(args).env("JDE_PLUGIN_PATH", folder))
}

/// Writes an application of one schema.
fn application(folder: &Path, plugin: &str) -> String {
    let file = folder.join(format!("{plugin}.toml"));
    let text = format!("roots = [\"it\"]\n[schemas.it]\ntype = \"{plugin}\"\n");
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

#[test]
fn a_library_that_ends_whoever_maps_it_is_named_and_hides_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    library(place, "a_sound", "");
    let falls = library(place, "falls", "*(volatile int *)8 = 1;");
    library(place, "quits", "fputs(\"no licence\\n\", stderr); exit(3);");
    library(place, "z_sound", "");

    let plugins = in_folder(place, &["plugins"]);
    assert_eq!(plugins.status, Some(0), "{plugins:?}");
    for words in [
        "a_sound  1  beat",
        "libfalls.so: it cannot be loaded: its process was killed by SIGSEGV",
        "libquits.so: it cannot be loaded: its process exited by itself, with status 3, and said: no licence;",
        "build or copy it again",
        "z_sound  1  beat",
    ] {
        assert!(
            plugins.out.contains(words),
            "`{words}` is not in: {}",
            plugins.out
        );
    }

    for args in [
        vec!["check", &application(place, "falls")],
        vec!["run", &application(place, "falls"), "--plain"],
        vec!["describe", "falls"],
        vec!["describe", falls.to_str().unwrap()],
    ] {
        let told = in_folder(place, &args);
        assert_eq!(told.status, Some(3), "{args:?}: {told:?}");
        assert!(
            told.err.contains("libfalls.so: it cannot be loaded"),
            "{args:?}: {told:?}"
        );
    }
    // A misspelt name makes `check` look at all plugins for a suggestion.
    let slip = in_folder(place, &["check", &application(place, "a_sund")]);
    assert!(slip.err.contains("did you mean `a_sound`?"), "{slip:?}");
}

#[test]
fn whatever_bits_of_a_library_are_turned_the_others_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let whole = fs::read(library(folder.path(), "sound", "")).unwrap();
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % below
    };
    let mutants = 60;
    for number in 0..mutants {
        let mut bytes = whole.clone();
        for _ in 0..8 {
            bytes[random(whole.len())] ^= 1 << random(8);
        }
        fs::write(folder.path().join(format!("libm{number}.so")), bytes).unwrap();
    }
    let told = in_folder(folder.path(), &["plugins", "--json"]);
    assert_eq!(told.status, Some(0), "{told:?}");
    let listing = crate::support::json(&told.out);
    let here = &listing["folders"][0];
    let [found, unusable] = ["plugins", "unusable"].map(|list| here[list].as_array().unwrap().clone());
    assert_eq!(found.len() + unusable.len(), mutants + 1);
    assert!(
        found
            .iter()
            .any(|plugin| plugin["path"].as_str().unwrap().ends_with("libsound.so"))
    );
    // Otherwise the mutants were rejected without being loaded.
    let deaths = unusable
        .iter()
        .filter(|file| file["reason"].as_str().unwrap().contains("its process"));
    assert!(deaths.count() > 3, "{unusable:?}");
}

#[test]
fn a_build_that_would_end_the_application_does_not_take_over() {
    let (place, shelf) = (Place::new(), Shelf::new());
    let _robot = shelf.start(&place, &root().join("apps/safe-navigation.toml"), &[]);
    let folder = tempfile::tempdir().unwrap();
    shelf.write(&fs::read(library(folder.path(), "vff", "abort();")).unwrap());
    let refused = place.says(&["reload", "vff"]);
    assert_eq!(refused.status, Some(1), "{refused:?}");
    assert!(
        refused.err.contains("its process was killed by SIGABRT"),
        "{refused:?}"
    );
    let now = place.json(&["ps"]);
    assert_eq!(schema(&now, "vff")["faults"], 0);
}
