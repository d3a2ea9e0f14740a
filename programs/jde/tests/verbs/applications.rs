//! Applications that come with jde, in lockstep: they do what their first lines say.

use std::fs;

use serde_json::Value;

use crate::support::{jde_with_plugins, json, output_of, root};

/// Runs an application with options, and returns its result.
fn run(name: &str, options: &[&str]) -> Value {
    let file = root().join("apps").join(name).with_extension("toml");
    let mut command = jde_with_plugins(&["run"]);
    command.arg(file).args(["--lockstep", "--json"]).args(options);
    let result = json(&output_of(&mut command).out);
    // A recorded drive counts none.
    assert!(
        [0.into(), Value::Null].contains(&result["collisions"]),
        "{result}"
    );
    result
}

#[test]
fn navigate_reaches_targets_in_a_building_that_it_does_not_know() {
    let route = "navigate.route={poses=[[9.55, 2.75, 0], [3.55, 2.6, 0]]}";
    let result = run("navigate", &["--for", "300s", "--set", route]);
    assert_eq!(
        (&result["outcome"], &result["reached"]),
        (&"done".into(), &2.into()),
        "{result}"
    );
}

#[test]
fn navigate_gives_up_a_target_in_a_wall_and_touches_nothing() {
    let set = ["navigate.route={poses=[[6.0, 3.0, 0]]}", "navigate.patience=10 s"];
    let result = run("navigate", &["--for", "300s", "--set", set[0], "--set", set[1]]);
    assert_eq!(result["outcome"], "failed", "{result}");
}

#[test]
fn navigate_gets_out_of_where_it_is_stuck_or_gives_up_in_words() {
    for (place, drive, arrives) in [
        ("a dead end", 0, true),
        ("three walls", 20, true),
        ("a box", 40, false),
        ("a door", 60, true),
    ] {
        let drive = drive.to_string();
        let mut command = jde_with_plugins(&["experiment", "recover", "--drive", &drive]);
        let output = output_of(command.current_dir(root()));
        assert_eq!(output.status, Some(0), "{place}: {output:?}");
        let measured = |line: &str| output.out.lines().any(|other| other.trim() == line);
        let arrived = if arrives {
            "1.0000      arrived"
        } else {
            "0.0000      arrived"
        };
        assert!(measured(arrived), "{place}: {output:?}");
        let words = "gives up the target at 9.00, 4.00: no way leads to the goal";
        assert_eq!(output.err.contains(words), !arrives, "{place}: {output:?}");
    }
}

#[test]
fn barn_crosses_narrow_worlds_that_it_does_not_know_at_more_than_1_m_per_second() {
    for world in ["000", "190", "264", "282"] {
        let result = run("barn", &["--set", &barn(world)]);
        assert_eq!(result["outcome"], "done", "{world}: {result}");
        assert!(
            result["sim_seconds"].as_f64().is_some_and(|time| time < 10.0),
            "{world}: {result}"
        );
    }
}

#[test]
fn barn_dwa_crosses_an_easy_world() {
    let result = run("barn-dwa", &["--set", &barn("108")]);
    assert_eq!(result["outcome"], "done", "{result}");
}

/// The option that takes a world of BARN.
fn barn(world: &str) -> String {
    let file = root().join("worlds/barn").join(world).with_extension("toml");
    format!("robot.world={}", file.display())
}

#[test]
fn line_keeps_to_its_track_and_stands_before_a_crate() {
    let mut command = jde_with_plugins(&["experiment", "line", "--drive", "0"]);
    let output = output_of(command.current_dir(root()));
    assert_eq!(output.status, Some(0), "{output:?}");
}

#[test]
fn patrol_skips_the_place_under_a_table_that_its_map_does_not_know() {
    let result = run("patrol", &["--for", "60s"]);
    assert!(result["reached"].as_u64() >= Some(3), "{result}");
    assert_eq!(result["outcome"], "time-up", "{result}");
}

#[test]
fn localize_finds_out_where_it_is_and_does_so_again_after_it_was_carried() {
    let mut command = jde_with_plugins(&["experiment", "lost", "--drive", "4", "--limit", "30min"]);
    let output = output_of(command.current_dir(root()));
    assert_eq!(output.status, Some(0), "{output:?}");
}

#[test]
fn explore_closes_the_map_of_two_rooms() {
    let world = root().join("worlds/rooms.toml");
    let world = format!("robot.world={}", world.display());
    let result = run("explore", &["--set", &world, "--set", "robot.start=[[1, 1, 0]]"]);
    assert_eq!(result["outcome"], "done", "{result}");
}

#[test]
fn follow_person_goes_through_doors_and_around_corners_after_somebody() {
    let mut command = jde_with_plugins(&["experiment", "follow-person", "--drive", "0"]);
    let output = output_of(command.current_dir(root()));
    assert_eq!(output.status, Some(0), "{output:?}");
}

#[test]
fn navigate_goes_where_it_shall_although_its_wheels_drift() {
    let route = "navigate.route={poses=[[9.55, 7.1, 0], [3.55, 2.6, 0]]}";
    let wheels = "robot.wheel_error=0.01";
    let result = run("navigate", &["--for", "300s", "--set", wheels, "--set", route]);
    assert_eq!(
        (&result["outcome"], &result["reached"]),
        (&"done".into(), &2.into()),
        "{result}"
    );
}

#[test]
fn fused_stays_near_its_path_with_bad_wheels_by_its_gyro() {
    let mut command = jde_with_plugins(&["experiment", "fused", "--drive", "0"]);
    let output = output_of(command.current_dir(root()));
    assert_eq!(output.status, Some(0), "{output:?}");
}

#[test]
fn slam_log_saves_the_map_of_the_whole_recorded_drive() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hall.yaml");
    let set = format!("slam.map_file_name={}", file.display());
    let result = run("slam-log", &["--set", &set]);
    assert_eq!(result["outcome"], "done", "{result}");
    let files = std::fs::read_dir(folder.path()).unwrap();
    let names: Vec<_> = files
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    let is_whole = |name: &String| [".yaml", ".pgm"].iter().any(|end| name.ends_with(end));
    assert!(
        file.exists() && names.iter().all(is_whole),
        "it is not saved to its end: {names:?}"
    );
}

#[test]
fn localize_log_finds_the_robot_of_the_recorded_drive_on_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let test = folder.path().join("found.toml");
    // The odometry of the recording is in the frame of the map, and hardly drifts.
    let away = |axis: &str| {
        let [pose, truth] =
            ["localize.pose", "log.odometry"].map(|of| format!("{of}.pose.pose.position.{axis}"));
        format!("math.abs({pose} - {truth}) < 0.2")
    };
    let near = format!("{} and {}", away("x"), away("y"));
    let text = format!(
        "name = 'it is found'\napplication = '{}'\nfor = '60s'\nmission = 'ignored'\n\
         must.found = {{ eventually = '{near}' }}\nmust.right = {{ always = '{near}' }}\n",
        root().join("apps/localize-log.toml").display()
    );
    std::fs::write(&test, &text).unwrap();
    let output = output_of(jde_with_plugins(&["test"]).arg(&test));
    assert_eq!(output.status, Some(0), "{output:?}");
}

/// A box that no map has stands in the corridor, with 0.6 m free on each side of it, or closes it.
#[test]
fn robots_drive_around_what_is_on_no_map_or_take_another_way() {
    let office = fs::read_to_string(root().join("worlds/office.toml")).expect("the world exists");
    let folder = tempfile::tempdir().expect("a folder");
    for (width, applications) in [
        (1.0, &["localize", "navigate"][..]),
        (2.4, &["localize", "navigate"]),
    ] {
        let blockade =
            format!("boxes = [\n  {{ name = \"box\", center = [12, 7.1], size = [0.6, {width}] }},");
        let world = folder.path().join(format!("{width}.toml"));
        let blocked = office.replace("boxes = [", &blockade);
        assert_ne!(blocked, office, "the world has a list of boxes");
        fs::write(&world, blocked).expect("the folder is writable");
        let world = format!("robot.world={}", world.display());
        for application in applications {
            let route = "navigate.route={poses=[[16.75, 7.1, 0]]}";
            let result = run(application, &["--for", "200s", "--set", &world, "--set", route]);
            assert_eq!(result["outcome"], "done", "{application} {width}: {result}");
        }
    }
}

/// No way leads to a place off the map, and the robot says so without driving.
#[test]
fn a_target_off_the_map_is_given_up_soon() {
    let result = run("localize", &["--set", "navigate.route={poses=[[1000, 1000, 0]]}"]);
    assert_eq!(result["outcome"], "failed", "{result}");
    let seconds = result["sim_seconds"].as_f64();
    assert!(seconds.is_some_and(|seconds| seconds < 5.0), "{result}");
}

#[test]
fn vacuum_covers_two_rooms_around_a_table_that_its_map_does_not_know() {
    let world = format!("robot.world={}", root().join("worlds/rooms.toml").display());
    let map = format!("map.file={}", root().join("worlds/map/rooms.yaml").display());
    let starts = ["robot.start=[[1, 1, 0]]", "localize.initial_pose=[[1, 1, 0]]"];
    let result = run(
        "vacuum",
        &[
            "--set", &world, "--set", &map, "--set", starts[0], "--set", starts[1],
        ],
    );
    assert_eq!(result["outcome"], "done", "{result}");
    let share = result["note"]
        .as_str()
        .and_then(|note| note.split(' ').next()?.parse::<f64>().ok());
    // Of 20.1 m², the table and 20 cm around it take 1.2 m by 1.0 m; 98 % of the rest.
    assert!(share > Some(98.0 * (20.1 - 1.2 * 1.0) / 20.1), "{result}");
}

#[test]
fn guide_leaves_its_map_for_the_dock_when_the_battery_is_low_and_goes_on_afterwards() {
    let result = run(
        "guide",
        &["--for", "120s", "--set", "robot.battery_capacity=0.03"],
    );
    let groups = result["groups"].as_array().expect("a list");
    let tasks = groups.iter().find(|group| group["group"] == "guide/base");
    let takeovers = |task: &str| {
        let mut winners = tasks.expect("it is a group")["winners"]
            .as_array()
            .expect("a list")
            .iter();
        let winner = winners.find(|winner| winner["schema"] == task);
        winner.expect("it is a task")["takeovers"].as_u64()
    };
    assert!(takeovers("map") >= Some(2), "{result}");
    assert!(
        takeovers("approach") >= Some(1) && takeovers("dock") >= Some(1),
        "{result}"
    );
    assert_eq!(takeovers("lead"), Some(0), "{result}");
}

#[test]
fn guide_goes_through_the_door_in_which_somebody_waved_and_went_out_of_sight() {
    let mut command = jde_with_plugins(&["experiment", "guide-door", "--drive", "0"]);
    let output = output_of(command.current_dir(root()));
    assert_eq!(output.status, Some(0), "{output:?}");
}

#[test]
fn colors_drives_to_a_blue_thing_and_stands_before_it() {
    let result = run("colors", &["--for", "40s"]);
    let roots = &result["groups"][0];
    let driven = roots["winners"].as_array().expect("a list");
    let driven = driven.iter().find(|winner| winner["schema"] == "approach");
    assert!(
        driven.expect("it is a root")["seconds"].as_f64() > Some(10.0),
        "{result}"
    );
    assert!(roots["nobody_seconds"].as_f64() > Some(10.0), "{result}");
}

#[test]
fn r18_a_guarded_robot_that_is_driven_at_random_touches_nothing_wherever_its_schema_runs() {
    let options = ["--for", "40s", "--seed", "3"];
    let result = run("guard", &options);
    let roots = &result["groups"][0];
    assert!(roots["nobody_seconds"].as_f64() > Some(5.0), "refused: {result}");
    assert!(
        roots["winners"][1]["seconds"].as_f64() > Some(5.0),
        "it drives: {result}"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("isolated.toml");
    let text = std::fs::read_to_string(root().join("apps/guard.toml")).expect("it exists");
    let worlds = root().join("worlds").display().to_string();
    let isolated = text
        .replace("../worlds", &worlds)
        .replace("\"fault/motor\"\n", "\"fault/motor\"\nisolate = \"process\"\n");
    std::fs::write(&file, isolated).expect("it is written");
    let mut command = jde_with_plugins(&["run"]);
    command.arg(&file).args(["--lockstep", "--json"]).args(options);
    let isolated = json(&output_of(&mut command).out);
    assert_eq!(
        isolated["decisions_sha256"], result["decisions_sha256"],
        "{isolated}"
    );
}
