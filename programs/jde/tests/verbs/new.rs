//! The projects that `jde new` writes build without warnings, pass their own tests and run, outside this
//! workspace.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use jde_watchdog::Watchdog;

use crate::support::{RunOutput, jde, jde_with_plugins, json, output_of, root};

/// A project that `jde new` wrote.
struct Project {
    folder: PathBuf,
    /// What `jde new` printed.
    printed: String,
}

impl Project {
    /// Creates the project. All projects share their builds of the SDK, which later runs of the tests use again.
    /// So each project has the same path in every run: cargo would keep a build for every path.
    fn new(kind: &[&str], name: &str) -> Self {
        static LOCK: OnceLock<File> = OnceLock::new();
        let all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("new");
        let parent = all.join(kind.concat());
        let folder = parent.join(name);
        let target = all.join("target");
        std::fs::create_dir_all(&target).unwrap();
        // Another run of these tests waits until this process ends.
        LOCK.get_or_init(|| {
            let file = File::create(all.join("lock")).unwrap();
            file.lock().unwrap();
            file
        });
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&parent).unwrap();
        let path = parent.to_str().unwrap();
        let created = output_of(&mut jde(&[&["new"], kind, &[name, "--path", path]].concat()));
        assert_eq!(created.status, Some(0), "{}", created.err);
        symlink(target, folder.join("target")).unwrap();
        Self {
            folder,
            printed: created.out,
        }
    }

    /// Builds and tests the project.
    fn build(&self) {
        for verb in ["build", "test"] {
            let (success, err) = self.cargo(verb);
            assert!(success && !err.contains("warning"), "cargo {verb}: {err}");
        }
    }

    /// Returns whether cargo succeeds, and its standard error.
    fn cargo(&self, verb: &str) -> (bool, String) {
        let output = Command::new(env!("CARGO"))
            .args([verb, "--offline"])
            .current_dir(&self.folder)
            .env_remove("CARGO_TARGET_DIR")
            .output()
            .expect("cargo starts");
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.success(), err)
    }

    /// Builds and tests a project of CMake.
    fn build_with_cmake(&self) {
        for command in [
            "cmake -B build -DCMAKE_CXX_FLAGS=-Werror -DCMAKE_C_FLAGS=-Werror",
            "cmake --build build",
            "ctest --test-dir build --output-on-failure",
        ] {
            let mut words = command.split(' ');
            let output = Command::new(words.next().unwrap())
                .args(words)
                .current_dir(&self.folder)
                .output()
                .expect("CMake is installed");
            let text = [output.stdout, output.stderr].concat();
            let text = String::from_utf8_lossy(&text);
            assert!(output.status.success(), "{command}: {text}");
        }
    }

    /// Replaces the first occurrence of `from` in a file.
    fn replace(&self, file: &str, from: &str, to: &str) {
        let path = self.folder.join(file);
        let old = std::fs::read_to_string(&path).unwrap();
        assert!(old.contains(from), "{file}: {from}");
        std::fs::write(path, old.replacen(from, to, 1)).unwrap();
    }

    /// Runs the application of the project in lockstep.
    fn run(&self, args: &[&str]) -> RunOutput {
        let args = [&["run", "app.toml", "--lockstep"], args].concat();
        let run = output_of(jde_with_plugins(&args).current_dir(&self.folder));
        assert_eq!(run.status, Some(0), "{}\n{}", run.out, run.err);
        run
    }
}

/// Whether CMake is installed, as it is in CI.
fn has_cmake() -> bool {
    let found = Command::new("cmake").arg("--version").output().is_ok();
    let missing = "CMake is missing, so nothing in C or C++ is built (apt install cmake make)";
    assert!(found || std::env::var_os("CI").is_none(), "{missing}");
    if !found {
        eprintln!("{missing}");
    }
    found
}

#[test]
fn a_new_schema_builds_passes_its_test_and_drives() {
    let project = Project::new(&["schema"], "follow-wall");
    for next in ["cargo build", "run app.toml"] {
        assert!(project.printed.contains(next), "{}", project.printed);
    }
    project.build();
    let run = project.run(&["--for", "30s", "--json"]);
    assert!(run.err.contains("nobody -> follow-wall"), "{}", run.err);
    let summary = json(&run.out);
    let clearance = summary["min_clearance_m"].as_f64().unwrap();
    assert!(
        summary["collisions"] == 0 && clearance < 0.6,
        "the robot follows the wall without touching it: {summary}"
    );
}

#[test]
fn a_new_schema_in_cplusplus_or_c_builds_passes_its_test_and_drives() {
    if !has_cmake() {
        return;
    }
    for (language, name) in [("--cpp", "follow-wall"), ("--c", "creep")] {
        let project = Project::new(&["schema", language], name);
        for next in ["cmake -B build", "run app.toml"] {
            assert!(project.printed.contains(next), "{}", project.printed);
        }
        project.build_with_cmake();
        let run = project.run(&["--for", "30s", "--json"]);
        assert!(run.err.contains(&format!("nobody -> {name}")), "{}", run.err);
        let summary = json(&run.out);
        let clearance = summary["min_clearance_m"].as_f64().unwrap();
        assert!(
            summary["collisions"] == 0 && clearance < 0.6,
            "the robot stops before the wall: {summary}"
        );
    }
}

#[test]
fn a_new_perceptive_schema_in_cplusplus_builds_passes_its_test_and_is_used() {
    if !has_cmake() {
        return;
    }
    let project = Project::new(&["schema", "--cpp", "--perceptive"], "find-near");
    project.build_with_cmake();
    let run = project.run(&["--for", "10s", "--json"]);
    assert!(run.err.contains("nobody -> face"), "{}", run.err);
}

#[test]
fn a_new_father_in_cplusplus_builds_passes_its_test_and_drives_to_its_targets() {
    if !has_cmake() {
        return;
    }
    let project = Project::new(&["schema", "--cpp", "--father"], "patrol");
    project.build_with_cmake();
    let run = project.run(&["--for", "60s", "--log", "patrol=info", "--json"]);
    for part in ["nobody -> goon", "reached 4.50, 1.50", "reached 1.50, 1.50"] {
        assert!(run.err.contains(part), "{}", run.err);
    }
    assert_eq!(json(&run.out)["collisions"], 0);
}

#[test]
fn an_error_of_a_macro_is_the_only_error_of_a_build() {
    let project = Project::new(&["schema"], "mistaken");
    let values = [
        ("Value", "struct Door { width: f64 }", "add `#[repr(C)]`"),
        ("Choice", "enum Gait { Slow }", "add `#[repr(u8)]`"),
    ];
    for (derive, item, error) in values {
        let path = project.folder.join("src/lib.rs");
        let original = std::fs::read_to_string(&path).unwrap();
        let code = format!("#[derive(Clone, Copy, {derive})]\npub {item}\n/// Drives");
        project.replace("src/lib.rs", "/// Drives", &code);
        let name = item.split(' ').nth(1).unwrap();
        let field = match derive {
            "Value" => format!("#[import]\n    more: Import<{name}>,\n    #[actuator]"),
            _ => format!(
                "#[modulation(default = {name}::Slow)]\n    more: Modulation<{name}>,\n    #[actuator]"
            ),
        };
        project.replace("src/lib.rs", "#[actuator]", &field);
        check_only_error(&project, error);
        std::fs::write(path, original).unwrap();
    }
    project.replace("src/lib.rs", "#[import(trigger)]", "#[import(triger)]");
    check_only_error(&project, "expected one of trigger, optional");
}

fn check_only_error(project: &Project, error: &str) {
    let (success, err) = project.cargo("build");
    assert!(!success && err.contains(error), "{err}");
    assert!(err.contains("due to 1 previous error"), "{err}");
}

#[test]
fn the_first_schema_of_the_readme_builds_and_alternates_with_ahead() {
    let project = Project::new(&["schema"], "shy");
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let block = readme.split("```rust\n").nth(1).unwrap();
    let code = block.split("```").next().unwrap();
    std::fs::write(project.folder.join("src/lib.rs"), code).unwrap();
    project.build();
    let run = project.run(&["--for", "20s", "--json"]);
    let wins: Vec<&str> = run.err.lines().filter(|line| line.contains(" -> ")).collect();
    for (line, win) in wins.iter().zip(["nobody -> shy", "shy -> ahead", "ahead -> shy"]) {
        assert!(line.contains(win), "{}", run.err);
    }
    assert!(wins.len() > 2, "{}", run.err);
    assert_eq!(json(&run.out)["collisions"], 0);
}

#[test]
fn a_new_perceptive_schema_builds_passes_its_test_and_is_used() {
    let project = Project::new(&["schema", "--perceptive"], "find-near");
    project.build();
    let run = project.run(&["--for", "10s", "--json"]);
    assert!(run.err.contains("nobody -> face"), "{}", run.err);
}

#[test]
fn a_new_father_builds_passes_its_test_and_drives_to_its_targets() {
    let project = Project::new(&["schema", "--father"], "patrol");
    project.build();
    let run = project.run(&["--for", "60s", "--log", "patrol=info", "--json"]);
    for part in ["nobody -> goon", "reached 4.50, 1.50", "reached 1.50, 1.50"] {
        assert!(run.err.contains(part), "{}", run.err);
    }
    assert_eq!(json(&run.out)["collisions"], 0);
}

#[test]
fn a_new_driver_builds_passes_its_test_and_moves() {
    let project = Project::new(&["driver"], "gripper");
    project.build();
    let run = project.run(&["--for", "5s", "--log", "exercise=info"]);
    for line in ["closing at 0.0", "opening at 0.0"] {
        assert!(run.err.contains(line), "{}", run.err);
    }
}

#[test]
fn a_new_driver_of_a_device_builds_passes_its_test_and_reads_the_emulator() {
    let project = Project::new(&["driver", "--device"], "outdoor-thermometer");
    project.build();
    let _watchdog = Watchdog::for_test();
    // The emulator ends when its standard input is closed.
    let mut emulator = Command::new(project.folder.join("target/debug/examples/emulator"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = emulator.stdout.take().unwrap();
    let line = line_with("run app.toml", &mut out);
    let args = line.split(' ').skip_while(|word| *word != "run");
    let mut run = jde_with_plugins(&args.collect::<Vec<_>>())
        .current_dir(&project.folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    line_with("temperature: 21.5 degrees Celsius", run.stderr.take().unwrap());
    run.kill().unwrap();
    run.wait().unwrap();
    drop(emulator.stdin.take());
    emulator.wait().unwrap();
}

/// Reads until a line contains `part`, and returns the line.
fn line_with(part: &str, from: impl Read) -> String {
    let mut lines = BufReader::new(from).lines().map(Result::unwrap);
    lines
        .find(|line| line.contains(part))
        .unwrap_or_else(|| panic!("no line contains `{part}`"))
}

#[test]
fn a_plugin_exports_a_value_type_of_a_new_types_crate() {
    let types = Project::new(&["types"], "doors-seen");
    types.build();
    let plugin = Project::new(&["schema", "--perceptive"], "find-doors");
    let dependency = format!("[dependencies]\ndoors-seen = {{ path = {:?} }}", types.folder);
    plugin.replace("Cargo.toml", "[dependencies]", &dependency);
    let field = "    #[export]\n    doors: Export<doors_seen::DoorsSeen>,\n}\n\nimpl Schema";
    plugin.replace("src/lib.rs", "}\n\nimpl Schema", field);
    let first = "let Some(laser)";
    plugin.replace(
        "src/lib.rs",
        first,
        &format!("self.doors.retract(cx);\n        {first}"),
    );
    plugin.build();
    let built = plugin.folder.join("target/debug");
    let described = output_of(jde(&["describe", "DoorsSeen"]).env("JDE_PLUGIN_PATH", built));
    assert!(
        described.out.contains("find-doors/find-doors  doors"),
        "{described:?}"
    );
}

#[test]
fn a_new_application_is_checked_and_runs() {
    let project = Project::new(&["app"], "patrol");
    let check = output_of(jde_with_plugins(&["check", "app.toml"]).current_dir(&project.folder));
    assert_eq!(check.status, Some(0), "{}", check.err);
    let run = project.run(&["--seed", "1"]);
    for part in ["4 of 4 targets", "no contact"] {
        assert!(run.out.contains(part), "{}", run.out);
    }
}

#[test]
fn new_refuses_an_existing_folder() {
    let folder = tempfile::tempdir().unwrap();
    let existing = folder.path().join("patrol");
    std::fs::create_dir(&existing).unwrap();
    let created = output_of(&mut jde(&[
        "new",
        "app",
        "patrol",
        "--path",
        folder.path().to_str().unwrap(),
    ]));
    assert_eq!(created.status, Some(2));
    assert!(created.err.contains("already exists"), "{}", created.err);
    assert_eq!(std::fs::read_dir(&existing).unwrap().count(), 0);
}

#[test]
fn a_new_world_is_a_room_or_is_converted_and_never_replaces_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let list = folder.path().join("list.txt");
    std::fs::write(&list, "3 -2.25,8\n4 -2.25,9\n").unwrap();
    let sdf = folder.path().join("lab.sdf");
    std::fs::write(&sdf, "<sdf>\n<world name='lab'/></sdf>").unwrap();
    let new = |name: &str, from: Option<&Path>| {
        let mut command = jde(&["new", "world", name, "--path"]);
        command.arg(folder.path());
        if let Some(file) = from {
            command.arg("--from").arg(file);
        }
        output_of(&mut command)
    };
    let stage = folder.path().join("cave.world");
    std::fs::write(&stage, "model ( bitmap \"cave.pgm\" size [ 2 1 1 ] )").unwrap();
    std::fs::write(folder.path().join("cave.pgm"), "P2\n2 1\n255\n0 0\n").unwrap();
    let text = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap();

    assert_eq!(new("hall", None).status, Some(0));
    assert!(text("hall.toml").contains("\"hall\""), "{}", text("hall.toml"));
    let again = new("hall", None);
    assert_eq!(again.status, Some(2));
    assert!(again.err.contains("already exists"), "{}", again.err);

    assert_eq!(new("narrow", Some(&list)).status, Some(0));
    assert!(text("narrow/003.toml").contains("[-2.25, 8]"));
    assert!(text("narrow/004.toml").contains("[-2.25, 9]"));

    let map = folder.path().join("rock-map.pgm");
    std::fs::write(&map, "mine").unwrap();
    let taken = new("rock", Some(&stage));
    assert_eq!(
        taken.status,
        Some(2),
        "the map would replace a file: {}",
        taken.err
    );
    assert!(taken.err.contains("choose another name"), "{}", taken.err);
    assert!(!folder.path().join("rock.toml").exists() && text("rock-map.pgm") == "mine");
    assert_eq!(
        new("cave", Some(&stage)).status,
        Some(0),
        "the bitmap beside it stays"
    );
    assert!(text("cave.toml").contains("map = \"cave-map.yaml\""));
    assert!(text("cave-map.yaml").contains("cave-map.pgm") && text("cave.pgm").starts_with("P2"));
    let copied = new("copy", Some(&folder.path().join("cave-map.yaml")));
    assert_eq!(copied.status, Some(0), "{}", copied.err);
    assert!(text("copy.toml").contains("map = \"copy-map.yaml\""));

    let empty = new("lab", Some(&sdf));
    assert_eq!(empty.status, Some(0), "{}", empty.err);
    assert!(text("lab.toml").contains("\"lab\""), "{}", text("lab.toml"));
    std::fs::write(&sdf, "<sdf>\n<world name='lab'></sdf>").unwrap();
    let faulty = new("broken", Some(&sdf));
    assert_eq!(faulty.status, Some(1));
    assert!(faulty.err.contains("lab.sdf:2: "), "{}", faulty.err);
    assert!(!folder.path().join("broken.toml").exists());
}

#[test]
fn a_new_robot_is_small_or_a_copy_and_never_replaces_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let new = |name: &str, from: &[&str]| {
        let mut command = jde(&["new", "robot", name, "--path"]);
        command.arg(folder.path()).args(from);
        output_of(&mut command)
    };
    let model = |name: &str| {
        let path = folder.path().join(name).with_extension("toml");
        jde_sim::RobotModel::load(path).unwrap_or_else(|error| panic!("{error}"))
    };

    let created = new("trolley", &[]);
    assert_eq!(created.status, Some(0), "{}", created.err);
    assert!(
        created.out.contains("model = \"trolley.toml\""),
        "{}",
        created.out
    );
    assert_eq!(model("trolley").name, "trolley");

    assert_eq!(new("scout", &["--from", "pioneer-3dx"]).status, Some(0));
    let (scout, pioneer) = (model("scout"), jde_sim::RobotModel::find("pioneer-3dx").unwrap());
    assert_eq!(scout.name, "scout");
    assert_eq!((&scout.config, &scout.sonars), (&pioneer.config, &pioneer.sonars));

    let again = new("scout", &[]);
    assert_eq!(again.status, Some(2));
    assert!(again.err.contains("already exists"), "{}", again.err);
    let unknown = new("rover", &["--from", "pioneer"]);
    assert_eq!(unknown.status, Some(2));
    assert!(unknown.err.contains("pioneer-3dx"), "{}", unknown.err);
    assert!(!folder.path().join("rover.toml").exists());
}
