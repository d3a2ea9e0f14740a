//! The examples in C++ build without warnings, pass their tests and drive.

use std::path::Path;
use std::process::Command;

use crate::support::{jde_with_plugins, json, output_of, plugins, root};

/// Builds an example, tests it and runs its application in lockstep. Returns the summary; `None` if CMake or the
/// library is missing, which is so in no CI.
fn run(example: &str, header: &str) -> Option<serde_json::Value> {
    let found = Command::new("cmake").arg("--version").output().is_ok() && Path::new(header).exists();
    let missing = format!("CMake or {header} is missing, so the example `{example}` is not built");
    assert!(found || std::env::var_os("CI").is_none(), "{missing}");
    if !found {
        println!("{missing}");
        return None;
    }
    let source = root().join("examples").join(example);
    let build = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("examples")
        .join(example);
    cmake(
        Command::new("cmake")
            .arg("-S")
            .arg(&source)
            .arg("-B")
            .arg(&build)
            .arg("-DCMAKE_CXX_FLAGS=-Werror"),
    );
    cmake(Command::new("cmake").arg("--build").arg(&build));
    cmake(
        Command::new("ctest")
            .arg("--output-on-failure")
            .arg("--test-dir")
            .arg(&build),
    );
    let folders = std::env::join_paths([&*build, plugins()]).unwrap();
    let mut command = jde_with_plugins(&["run", "app.toml", "--lockstep", "--for", "20s", "--json"]);
    let run = output_of(command.current_dir(&source).env("JDE_PLUGIN_PATH", folders));
    assert_eq!(run.status, Some(0), "{}\n{}", run.out, run.err);
    Some(json(&run.out))
}

fn cmake(command: &mut Command) {
    let output = command.output().expect("CMake is installed");
    let text = [output.stdout, output.stderr].concat();
    assert!(
        output.status.success(),
        "{command:?}: {}",
        String::from_utf8_lossy(&text)
    );
}

#[test]
fn a_robot_turns_to_what_opencv_sees() {
    let Some(summary) = run("opencv", "/usr/include/opencv4/opencv2/imgproc.hpp") else {
        return;
    };
    let winner = &summary["groups"][0]["winners"][0];
    assert_eq!(
        (&winner["schema"], &summary["collisions"]),
        (&"chase".into(), &0.into()),
        "{summary}"
    );
    assert!(
        winner["seconds"].as_f64().unwrap() > 15.0,
        "it sees the ball all the time: {summary}"
    );
}

#[test]
fn a_robot_drives_along_a_wall_that_eigen_fits() {
    let Some(summary) = run("eigen", "/usr/include/eigen3/Eigen/Core") else {
        return;
    };
    assert_eq!(summary["collisions"], 0, "{summary}");
    let clearance = summary["min_clearance_m"].as_f64().unwrap();
    assert!(
        (0.5..0.7).contains(&clearance),
        "it goes to the wall and keeps a distance from it: {summary}"
    );
}
