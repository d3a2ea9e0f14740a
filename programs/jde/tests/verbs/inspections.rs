//! Inspections before the start. Problems of modulations are reported with file and line. A failed inspection
//! is reported with its plugin, and the other inspections still run. The tests build the plugins with cc.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{RunOutput, app, jde, jde_with_plugins, output_of, root};

/// Builds a plugin of one driver with a modulation `name` and an inspection with the code `body`.
fn plugin(folder: &Path, name: &str, include: &Path, body: &str) {
    let (source, file) = (
        folder.join(format!("{name}.c")),
        folder.join(format!("lib{name}.so")),
    );
    let text = format!(
        "#include \"jde.h\"\n#include <fcntl.h>\n#include <stdlib.h>\n#include <unistd.h>\n\
         static const jde_field fields[] = {{{{sizeof(jde_field), JDE_F64, JDE_ONE, 1u, \"data\", \"\", \"\", 0u, 0u, NULL}}}};\n\
         static const jde_type number = {{sizeof(jde_type), 1u, \"std_msgs/msg/Float64\", \"\", 8u, 8u, fields}};\n\
         static const double one = 1.0;\n\
         static const jde_port ports[] = {{JDE_PORT_MODULATION(\"line\", \"\", \"\", number, one, 0.0, 9.0, 0u),\n\
             JDE_PORT_EXPORT(\"seen\", \"\", number), JDE_PORT_IMPORT(\"near\", \"\", number, JDE_OPTIONAL)}};\n\
         static const jde_host *host;\n\
         static void *make(const jde_schema *s, const jde_host *h, jde_context *c) {{ (void)s; (void)c; host = h; static int it; return &it; }}\n\
         static int32_t iterate(void *i, jde_context *c) {{ (void)i; (void)c; return JDE_OK; }}\n\
         #ifdef JDE_ABILITY_INSPECT\n\
         static int32_t inspect(void *i, jde_context *cx, const jde_problems *problems) {{\n\
             (void)i; (void)cx; (void)problems; {body} return JDE_OK; }}\n\
         static const jde_inspect inspection = {{sizeof(jde_inspect), 0u, inspect}};\n\
         static const void *ability(const char *id) {{ return strcmp(id, JDE_ABILITY_INSPECT) == 0 ? &inspection : NULL; }}\n\
         #define ABILITY ability\n\
         #else\n\
         #define ABILITY NULL\n\
         #endif\n\
         static const jde_schema schemas[] = {{{{.size = sizeof(jde_schema), .kind = JDE_DRIVER, .name = \"it\", .doc = \"It.\",\n\
             .period_ns = 1000000, .ports = ports, .port_count = 3u, .create = make, .iterate = iterate, .ability = ABILITY}}}};\n\
         JDE_PLUGIN(\"{name}\", \"1\", \"It.\", schemas);\n"
    );
    fs::write(&source, text).unwrap();
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=gnu11", "-I"])
        .arg(include)
        .arg("-o")
        .args([&file, &source])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(
        compiled.status.success(),
        "{}",
        String::from_utf8_lossy(&compiled.stderr)
    );
}

/// Returns the folder of the current header.
fn current_include() -> std::path::PathBuf {
    root().join("include")
}

/// Writes an application of a schema that always wins, and one driver of each plugin.
fn application(folder: &Path, drivers: &[&str]) -> String {
    let mut text = String::from("roots = [\"root\"]\n[schemas.root]\ntype = \"beat\"\n");
    for driver in drivers {
        text += &format!("[schemas.{driver}]\ntype = \"{driver}\"\nline = 4\n");
    }
    crate::damaged::library(folder, "beat", "");
    let file = folder.join("app.toml");
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

fn run_in(folder: &Path, args: &[&str]) -> RunOutput {
    output_of(jde(args).current_dir(folder).env("JDE_PLUGIN_PATH", folder))
}

const WRONG: &str = "double line = *(const double *)jde_get(host, cx, 0u, sizeof(double), NULL);\n\
     if (line > 3.0) jde_problem(problems, JDE_PROBLEM_WRONG, 0u, \"there is no line 4: it can be 0 to 3\");";
const UNAVAILABLE: &str =
    "jde_problem(problems, JDE_PROBLEM_UNAVAILABLE, 0u, \"line 4 is not there: plug it in\");";

#[test]
fn a_wrong_modulation_is_reported_with_its_line_and_nothing_starts() {
    let folder = tempfile::tempdir().unwrap();
    plugin(folder.path(), "driver", &current_include(), WRONG);
    let app = application(folder.path(), &["driver"]);
    for args in [vec!["check", &app], vec!["run", &app, "--for", "1s"]] {
        let output = run_in(folder.path(), &args);
        assert_eq!(output.status, Some(2), "{output:?}");
        for part in [
            "error: `line` of schema `driver`: there is no line 4: it can be 0 to 3",
            "app.toml:6:",
        ] {
            assert!(output.err.contains(part), "`{part}` is not in: {}", output.err);
        }
        assert!(output.out.is_empty(), "{}", output.out);
    }
    let option = run_in(folder.path(), &["check", &app, "--set", "driver.line=5"]);
    assert!(
        option.err.contains("--set driver.line=5: `line` of schema"),
        "{}",
        option.err
    );
    let valid = run_in(folder.path(), &["check", &app, "--set", "driver.line=3"]);
    assert_eq!((valid.status, &*valid.err), (Some(0), ""));
}

#[test]
fn the_faults_of_a_file_that_an_application_names_are_shown_with_their_lines() {
    for (schema, name, text, shown) in [
        (
            "type = \"sim/robot\"\nworld = \"w.toml\"",
            "w.toml",
            "[[circles]]\ncenter = [0, 0]\nradius = -1\n",
            [
                "w.toml:3:10: `radius` of circle 1 is -1: expected more than 0",
                "    3 | radius = -1",
                "      |          ^^",
            ],
        ),
        (
            "type = \"sim/robot\"\nmodel = \"r.toml\"\nworld = \"w.toml\"",
            "r.toml",
            "bumper = true\n",
            [
                "r.toml:1:1: unknown key `bumper` in the robot",
                "    1 | bumper = true",
                "      | ^^^^^^",
            ],
        ),
        (
            "type = \"map/file\"\nfile = \"m.yaml\"",
            "m.yaml",
            "image: m.pgm\nresolution: 5 cm\norigin: [0, 0, 0]\n",
            [
                "m.yaml:2:13: `resolution` is not a number: expected more than 0 m",
                "    2 | resolution: 5 cm",
                "      |             ^^^^",
            ],
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("w.toml"), "").unwrap();
        fs::write(folder.path().join(name), text).unwrap();
        let application = format!("[schemas.it]\n{schema}\n");
        fs::write(folder.path().join("app.toml"), application).unwrap();
        let check = output_of(jde_with_plugins(&["check", "app.toml"]).current_dir(&folder));
        assert_eq!(check.status, Some(2), "{check:?}");
        for line in shown {
            assert!(check.err.contains(line), "`{line}` is not in: {}", check.err);
        }
    }
}

#[test]
fn an_inspection_tells_an_import_that_is_bound_from_one_that_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let body = "jde_sample near;\n\
        if (host->read(cx, 2u, &near) == JDE_UNBOUND) jde_problem(problems, JDE_PROBLEM_WRONG, 0u, \"bind near\");";
    plugin(folder.path(), "driver", &current_include(), body);
    let app = application(folder.path(), &["driver"]);
    let unbound = run_in(folder.path(), &["check", &app]);
    assert!(unbound.err.contains("bind near"), "{unbound:?}");
    let text = fs::read_to_string(&app).unwrap() + "imports = { near = \"driver.seen\" }\n";
    fs::write(&app, text).unwrap();
    let bound = run_in(folder.path(), &["check", &app]);
    assert_eq!((bound.status, &*bound.err), (Some(0), ""));
}

#[test]
fn an_unavailable_device_is_an_error_of_check_and_a_warning_of_run() {
    let folder = tempfile::tempdir().unwrap();
    plugin(folder.path(), "driver", &current_include(), UNAVAILABLE);
    let app = application(folder.path(), &["driver"]);
    let check = run_in(folder.path(), &["check", &app]);
    assert_eq!(check.status, Some(2), "{check:?}");
    assert!(
        check
            .err
            .contains("error: `line` of schema `driver`: line 4 is not there"),
        "{check:?}"
    );
    assert!(
        check.out.contains("contracts"),
        "the contracts are shown too: {}",
        check.out
    );
    let run = run_in(folder.path(), &["run", &app, "--for", "100ms", "--lockstep"]);
    assert_eq!(run.status, Some(0), "{run:?}");
    assert!(
        run.err
            .contains("warning: `line` of schema `driver`: line 4 is not there"),
        "{run:?}"
    );
}

#[test]
fn an_export_that_is_wrong_is_an_error_and_no_warning() {
    let folder = tempfile::tempdir().unwrap();
    let body = "jde_problem(problems, JDE_PROBLEM_WRONG, 1u, \"nothing is seen\");";
    plugin(folder.path(), "driver", &current_include(), body);
    let app = application(folder.path(), &["driver"]);
    let run = run_in(folder.path(), &["run", &app, "--for", "100ms", "--lockstep"]);
    assert_eq!(run.status, Some(2), "{run:?}");
    assert!(
        run.err
            .contains("error: `seen` of schema `driver`: nothing is seen"),
        "{run:?}"
    );
}

#[test]
fn a_failed_inspection_is_reported_with_its_plugin_and_the_others_run() {
    let folder = tempfile::tempdir().unwrap();
    let bodies = [
        ("crashes", "*(volatile int *)8 = 1;", "SIGSEGV"),
        ("hangs", "for (;;) usleep(1000);", "did not end within 5 s"),
        (
            "logs",
            "for (;;) host->log(cx, JDE_INFO, \"x\", 1u);",
            "did not end within 5 s",
        ),
        (
            "unknown_kind",
            "jde_problem(problems, 7u, 0u, \"what\");",
            "unknown kind 7",
        ),
        (
            "unknown_modulation",
            "jde_problem(problems, JDE_PROBLEM_WRONG, 9u, \"what\");",
            "modulation 9",
        ),
        ("fails", "return jde_failed(host, cx, \"no power\");", "no power"),
        ("exits", "exit(0);", "exited by itself"),
        (
            "garbles",
            "for (int f = 3; f < 64; f++) if (write(f, \"nonsense nonsense nonsense nonsense nonsense nonsense nonsense\", 60) > 0) {}",
            "garbles",
        ),
    ];
    for (name, body, _) in bodies {
        plugin(folder.path(), name, &current_include(), body);
    }
    plugin(folder.path(), "z_last", &current_include(), WRONG);
    let mut names: Vec<_> = bodies.iter().map(|(name, _, _)| *name).collect();
    names.push("z_last");
    let app = application(folder.path(), &names);
    let output = run_in(folder.path(), &["check", &app]);
    assert_eq!(output.status, Some(2), "{output:?}");
    for (name, _, reason) in bodies {
        let line = output
            .err
            .lines()
            .find(|line| line.contains(&format!("the plugin `{name}` cannot inspect it")));
        let line = line.unwrap_or_else(|| panic!("{name} is not in: {}", output.err));
        assert!(line.contains(reason), "`{reason}` is not in: {line}");
        let may_be_slow = reason.contains("did not end");
        assert_eq!(
            line.contains("correct the files"),
            !may_be_slow && reason != "modulation 9",
            "{line}"
        );
    }
    assert!(
        output
            .err
            .contains("`line` of schema `z_last`: there is no line 4"),
        "{}",
        output.err
    );
}

#[test]
fn a_failed_inspection_does_not_stop_a_run() {
    let folder = tempfile::tempdir().unwrap();
    plugin(
        folder.path(),
        "crashes",
        &current_include(),
        "*(volatile int *)8 = 1;",
    );
    let app = application(folder.path(), &["crashes"]);
    let run = run_in(folder.path(), &["run", &app, "--for", "100ms", "--lockstep"]);
    assert_eq!(run.status, Some(0), "{run:?}");
    assert!(
        run.err
            .contains("warning: schema `crashes`: the plugin `crashes` cannot inspect it"),
        "{run:?}"
    );
}

#[test]
fn an_inspection_writes_no_file_and_no_variable() {
    let folder = tempfile::tempdir().unwrap();
    let mark = folder.path().join("mark");
    fs::write(&mark, "as it was").unwrap();
    let body = format!(
        "int file = open({:?}, O_WRONLY | O_TRUNC);\n\
         void *room; if (host->loan(cx, 1u, &room) != JDE_REFUSED) return jde_failed(host, cx, \"it may write\");\n\
         if (file >= 0) return jde_failed(host, cx, \"it may open files\");",
        mark.display().to_string()
    );
    plugin(folder.path(), "driver", &current_include(), &body);
    let app = application(folder.path(), &["driver"]);
    let output = run_in(folder.path(), &["check", &app]);
    assert_eq!(
        (output.status, &*output.err),
        (Some(0), ""),
        "the kernel has landlock since Linux 5.13"
    );
    assert_eq!(fs::read_to_string(&mark).unwrap(), "as it was");
}

#[test]
fn a_plugin_without_the_inspect_ability_is_checked_and_runs() {
    let folder = tempfile::tempdir().unwrap();
    plugin(
        folder.path(),
        "old",
        &root().join("runtime/host/tests/abi/v1.0"),
        WRONG,
    );
    let app = application(folder.path(), &["old"]);
    let check = run_in(folder.path(), &["check", &app]);
    assert_eq!((check.status, &*check.err), (Some(0), ""));
    let run = run_in(folder.path(), &["run", &app, "--for", "100ms", "--lockstep"]);
    assert_eq!((run.status, &*run.err), (Some(0), ""));
}

#[test]
fn a_robot_that_is_not_in_the_world_is_reported_before_the_start() {
    for verb in ["check", "run"] {
        let output = output_of(&mut jde_with_plugins(&[
            verb,
            &app("room.toml"),
            "--set",
            "pioneer.robot=pionear",
        ]));
        assert_eq!(output.status, Some(2), "{output:?}");
        for part in [
            "--set pioneer.robot=pionear: `robot` of schema `pioneer`: ",
            "pioneer`",
        ] {
            assert!(output.err.contains(part), "`{part}` is not in: {}", output.err);
        }
    }
}

#[test]
fn an_entry_with_a_fault_is_not_reported_as_missing() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("app.toml");
    let text = "name = \"dock\"\nroots = [\"stop\"]\n[schemas.robot]\ntype = \"sim/robot\"\n\
        world = \"room.toml\"\n[schemas.stop]\ntype = \"stop/stop\"\nimports = { laser = \"robot.laser\" }\n\
        actuators = { base = \"robot.velocity\" }\n[schemas.services]\ntype = \"ros2/services\"\n\
        take_request.home = { as = \"home\", type = \"std_srvs/srv/Trigger_Request\" }\n";
    let check = |entry: &str| {
        fs::write(&file, format!("{text}{entry}\n")).unwrap();
        output_of(jde_with_plugins(&["check"]).arg(&file)).err
    };
    let missing = "`send_response` has no entry of this name";
    assert!(check("").contains(missing));
    let faulty = check("send_response.home = \"stop.nothing\"");
    assert!(
        faulty.contains("`stop` has no `nothing`") && !faulty.contains(missing),
        "{faulty}"
    );
}
