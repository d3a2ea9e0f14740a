//! Libraries whose constructors end the process that loads them. The executable reports each of them and
//! keeps running. The tests build the libraries with cc.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::attached::{Sandbox, schema};
use crate::reloading::PluginFolder;
use crate::support::{RunOutput, jde, output_of, root};

/// Builds a plugin of one motor schema, whose library runs `constructor` when it is loaded.
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
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=c11", "-I"])
        .arg(root().join("include"))
        .arg("-o")
        .args([&file, &source])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(
        compiled.status.success(),
        "{}",
        String::from_utf8_lossy(&compiled.stderr)
    );
    file
}

fn run_with_plugins(folder: &Path, args: &[&str]) -> RunOutput {
    output_of(jde(args).env("JDE_PLUGIN_PATH", folder))
}

/// Writes an application of one schema.
fn application(folder: &Path, plugin: &str) -> String {
    let file = folder.join(format!("{plugin}.toml"));
    let text = format!("roots = [\"it\"]\n[schemas.it]\ntype = \"{plugin}\"\n");
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

#[test]
fn a_library_that_ends_its_process_is_reported_and_the_others_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    library(folder, "a_sound", "");
    let crashes = library(folder, "crashes", "*(volatile int *)8 = 1;");
    library(folder, "exits", "fputs(\"no licence\\n\", stderr); exit(3);");
    library(folder, "z_sound", "");

    let plugins = run_with_plugins(folder, &["plugins"]);
    assert_eq!(plugins.status, Some(0), "{plugins:?}");
    for expected in [
        "a_sound  1  beat",
        "libcrashes.so: it cannot be loaded: its process was killed by SIGSEGV",
        "libexits.so: it cannot be loaded: its process exited by itself, with status 3, and said: no licence;",
        "build or copy it again",
        "z_sound  1  beat",
    ] {
        assert!(
            plugins.out.contains(expected),
            "`{expected}` is not in: {}",
            plugins.out
        );
    }

    for args in [
        vec!["check", &application(folder, "crashes")],
        vec!["run", &application(folder, "crashes"), "--plain"],
        vec!["describe", "crashes"],
        vec!["describe", crashes.to_str().unwrap()],
    ] {
        let output = run_with_plugins(folder, &args);
        assert_eq!(output.status, Some(3), "{args:?}: {output:?}");
        assert!(
            output.err.contains("libcrashes.so: it cannot be loaded"),
            "{args:?}: {output:?}"
        );
    }
    // To suggest a name, `check` examines all plugins.
    let misspelled = run_with_plugins(folder, &["check", &application(folder, "a_sund")]);
    assert!(
        misspelled.err.contains("did you mean `a_sound`?"),
        "{misspelled:?}"
    );
}

#[test]
fn libraries_with_flipped_bits_do_not_keep_a_sound_one_from_being_listed() {
    let folder = tempfile::tempdir().unwrap();
    let original = fs::read(library(folder.path(), "sound", "")).unwrap();
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % below
    };
    let mutants = 60;
    for number in 0..mutants {
        let mut bytes = original.clone();
        for _ in 0..8 {
            bytes[random(original.len())] ^= 1 << random(8);
        }
        fs::write(folder.path().join(format!("libm{number}.so")), bytes).unwrap();
    }
    let output = run_with_plugins(folder.path(), &["plugins", "--json"]);
    assert_eq!(output.status, Some(0), "{output:?}");
    let listing = crate::support::json(&output.out);
    let listed = &listing["folders"][0];
    let [found, unusable] = ["plugins", "unusable"].map(|list| listed[list].as_array().unwrap().clone());
    assert_eq!(found.len() + unusable.len(), mutants + 1);
    assert!(
        found
            .iter()
            .any(|plugin| plugin["path"].as_str().unwrap().ends_with("libsound.so"))
    );
    // Some mutants must be loaded, not rejected before.
    let crashes = unusable
        .iter()
        .filter(|file| file["reason"].as_str().unwrap().contains("its process"));
    assert!(crashes.count() > 3, "{unusable:?}");
}

#[test]
fn reload_refuses_a_build_whose_loading_ends_the_process() {
    let (sandbox, plugin_folder) = (Sandbox::new(), PluginFolder::new());
    let _robot = plugin_folder.start(&sandbox, &root().join("apps/safe-navigation.toml"), &[]);
    let folder = tempfile::tempdir().unwrap();
    plugin_folder.write(&fs::read(library(folder.path(), "vff", "abort();")).unwrap());
    let refused = sandbox.run(&["reload", "vff"]);
    assert_eq!(refused.status, Some(1), "{refused:?}");
    assert!(
        refused.err.contains("its process was killed by SIGABRT"),
        "{refused:?}"
    );
    let now = sandbox.json(&["ps"]);
    assert_eq!(schema(&now, "vff")["faults"], 0);
}
