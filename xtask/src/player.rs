//! Tests the Player driver against Player and Stage: the hierarchy of `apps/navigate.toml`, with no other change
//! than its robot, drives a robot of Stage to some goals. A part of the step `peers`.

use std::fs;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result, ensure};

use crate::shell::{self, ChildGuard};
use crate::test::Context;

/// The world, and the devices of its robot. Relative names in the configuration are relative to its folder.
const FOLDER: &str = "drivers/player/tests/peers";
const CONFIGURATION: &str = "office.cfg";
/// The application, and the lines of its robot.
const APPLICATION: &str = "apps/navigate.toml";
const ROBOT: &str = "\
type  = \"sim/robot\"
model = \"turtlebot4\"
world = \"../worlds/office.toml\"
start = [[3.55, 1.6, \"90 deg\"]]
";
/// The same place in Stage.
const PLAYER_ROBOT: &str = "\
type  = \"player/robot\"
start = [3.55, 1.6, \"90 deg\"]
";
/// Through a door into the corridor, along it, and into another room.
const GOALS: &str = "navigate.route={poses=[[1.8, 7.1, 0], [9.55, 7.1, 0], [9.55, 2.75, 0]]}";
/// The limit for the drive, which takes a minute.
const LIMIT: &str = "300s";

pub(crate) fn run(context: &Context) -> Result<()> {
    if !shell::succeeds(Command::new("sh").args(["-c", "command -v player"])) {
        println!(
            "SKIPPED: no `player` on the PATH, so the driver of Player robots is tested only with the server of \
             its own tests; build github.com/playerproject/player and github.com/rtv/Stage to try it with Stage"
        );
        return Ok(());
    }
    let folder = context.target.join("peers");
    let application = write_application(context, &folder)?;
    let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
    let mut server = Command::new("player");
    server
        .args(["-p", &port.to_string(), CONFIGURATION])
        .current_dir(context.root.join(FOLDER));
    shell::show(&server, context.paint);
    let server = server
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .context("cannot start `player`")?;
    let mut server = ChildGuard(server);
    let stalls = folder.join("stalls.mcap");
    let mut drive = Command::new(context.target.join("debug/jde"));
    drive
        .arg("run")
        .arg(&application)
        .args(["--plain", "--for", LIMIT, "--set", GOALS, "--set"])
        .arg(format!("robot.port=tcp:127.0.0.1:{port}"))
        .args(["--when", "robot.bumpers.stalled", "--overwrite", "--record"])
        .arg(&stalls)
        .current_dir(&context.root);
    shell::show(&drive, context.paint);
    // It succeeds if the robot has reached all its goals.
    let output = shell::read(&mut drive).context("the robot of Stage was not driven to its goals")?;
    let outcome = output.lines().find(|line| line.starts_with("navigate: "));
    println!("{}", outcome.unwrap_or_default());
    ensure!(
        server.0.try_wait()?.is_none(),
        "`player` ended during the drive; has it Stage's plugin `stageplugin`?"
    );
    ensure!(
        !folder.join("stalls-001.mcap").exists(),
        "the robot of Stage ran into something: see target/peers/stalls-001.mcap"
    );
    Ok(())
}

/// Writes the application with the robot of Player into a folder. The application names no other file.
fn write_application(context: &Context, folder: &Path) -> Result<std::path::PathBuf> {
    let text = fs::read_to_string(context.root.join(APPLICATION))?;
    ensure!(
        text.contains(ROBOT),
        "{APPLICATION} has other lines for its robot: correct ROBOT in xtask/src/player.rs"
    );
    fs::create_dir_all(folder)?;
    // Recordings of an earlier run.
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path
            .file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with("stalls"))
        {
            fs::remove_file(path)?;
        }
    }
    let file = folder.join("player.toml");
    fs::write(&file, text.replace(ROBOT, PLAYER_ROBOT))?;
    Ok(file)
}
