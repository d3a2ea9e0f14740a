//! Tests with independent programs, which contain no code of jde: clients of the Pioneer protocol drive the
//! simulated robot, the libraries of MCAP and ROS 2 read recordings and write a bag for jde, the programs of `docs/protocol.md`
//! inspect a running application, ROS 2 and jde drive each other's robots, schemas drive a robot of Stage, and an agent diagnoses
//! a recording.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result, bail, ensure};

use crate::agents;
use crate::clients;
use crate::player;
use crate::python::Environment;
use crate::ros2;
use crate::shell::{self, ChildGuard};
use crate::step::StepOutcome;
use crate::test::Context;

/// The programs' Python environment.
const ENVIRONMENT: Environment = Environment {
    folder: "peers",
    packages: &[
        "Soar==1.5.2",
        "cbor2==6.2.1",
        "cryptography==50.0.2",
        "mcap==1.6.0",
        "mcap-ros2-support==0.6.0",
        "rosbags==0.11.9",
        ros2::PACKAGE,
    ],
    imports: &[
        "soar.robot.arcos",
        "cbor2",
        "cryptography",
        "zenoh",
        "mcap.reader",
        "mcap_ros2.decoder",
        "rosbags.highlevel",
        ros2::IMPORT,
    ],
};
/// Reads a recording of the demonstration and compares its numbers with those that jde reads.
const READER: &str = "observe/log/tests/peers/read_mcap.py";
/// Reads the panels of a recording.
const PANELS: &str = "observe/log/tests/peers/read_panels.py";
/// Decodes every message of a recording, and compares the selections with those that the run reported.
const ALL_READER: &str = "observe/log/tests/peers/read_all.py";
/// Writes a bag of ROS 2.
const BAG_WRITER: &str = "observe/log/tests/peers/write_bag.py";
/// The page with an application that plays a bag.
const BAG_PAGE: &str = "docs/replays.md";
/// Drives ahead, turns and stops. Fails if the robot does not follow.
const CLIENT: &str = "devices/p2os-server/tests/peers/soar_client.py";
/// A client from outside the repository, used if the file exists. It drives ahead and prints.
const EXTERNAL_CLIENT: &str = "../shared/p2os/soar_client.py";
/// The time after which the server ends, and with it the client's serial line.
const LIMIT: &str = "90s";
/// The command that installs what the step lacks.
const INSTALL: &str = "sudo apt-get install python3-venv python3-tk";

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(Command::new("python3").args(["-c", "import ensurepip, tkinter"])) {
        return context.missing_tool("Python with venv and tkinter", INSTALL);
    }
    let python = ENVIRONMENT.interpreter(&context.target, context.paint)?;
    let client = context.root.join(CLIENT);
    drive(context, &python, &client)?;
    let external = context.root.join(EXTERNAL_CLIENT);
    if external.is_file() {
        let output = drive(context, &python, &external)?;
        ensure!(
            output.contains("connected in"),
            "the client at {EXTERNAL_CLIENT} did not connect: {output}"
        );
    }
    read_recording(context, &python)?;
    read_panels(context, &python)?;
    play_bag(context, &python)?;
    clients::run(context, &python)?;
    ros2::run(context, &python)?;
    player::run(context)?;
    agents::run(context)?;
    Ok(StepOutcome::Passed)
}

/// Records the demonstration in lockstep. Independent libraries read the recording.
fn read_recording(context: &Context, python: &Path) -> Result<()> {
    let folder = context.target.join("peers");
    let (recording, numbers) = (folder.join("demo.mcap"), folder.join("numbers.jsonl"));
    let mut record = Command::new(context.target.join("debug/jde"));
    record
        .args(["run", "safe-navigation", "--lockstep"])
        .args(["--seed", "1", "--for", "30s", "--overwrite", "--record"])
        .arg(&recording)
        .current_dir(&context.root);
    shell::show(&record, context.paint);
    // 30 s are too short for the mission, so the exit status is 1. The reader checks the recording.
    let output = record.output().context("cannot start `jde run`")?;
    let summary = String::from_utf8_lossy(&output.stdout).into_owned();
    ensure!(
        summary.contains("nothing lost"),
        "the run was not recorded completely: {summary}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    // As the first step has built it: for this package alone cargo would build the libraries again.
    let mut printer = Command::new(context.target.join("debug/examples/numbers"));
    printer.arg(&recording).current_dir(&context.root);
    std::fs::write(&numbers, shell::read(&mut printer)?)?;
    let mut reader = Command::new(python);
    reader
        .arg(context.root.join(READER))
        .arg(&recording)
        .arg(&numbers);
    shell::show(&reader, context.paint);
    print!("{}", shell::read(&mut reader).context("the reader failed")?);
    Ok(())
}

/// Records a drive with its panels. Independent libraries decode every message and read the panels.
fn read_panels(context: &Context, python: &Path) -> Result<()> {
    let folder = context.target.join("peers");
    let (recording, decisions) = (folder.join("panels.mcap"), folder.join("decisions.jsonl"));
    let mut record = Command::new(context.target.join("debug/jde"));
    record
        .args(["run", "safe-navigation", "--plain", "--panels", "--overwrite"])
        .args(["--for", "3s", "--decisions"])
        .arg(&decisions)
        .arg("--record")
        .arg(&recording)
        .current_dir(&context.root);
    shell::show(&record, context.paint);
    // A few seconds are too short for the mission, so the exit status is 1. The reader checks the recording.
    record.output().context("cannot start `jde run`")?;
    let mut reader = Command::new(python);
    reader
        .arg(context.root.join(PANELS))
        .arg(&recording)
        .args(["example", "goon", "vff", "stop"]);
    shell::show(&reader, context.paint);
    print!(
        "{}",
        shell::read(&mut reader).context("the reader of panels failed")?
    );
    let mut reader = Command::new(python);
    reader
        .arg(context.root.join(ALL_READER))
        .args([&recording, &decisions])
        .args(["/jde/decisions", "/jde/states", "/jde/events", "/jde/turns"])
        .args(["/panels/example", "/pioneer/laser"]);
    shell::show(&reader, context.paint);
    print!(
        "{}",
        shell::read(&mut reader).context("the reader of all messages failed")?
    );
    Ok(())
}

/// Lets the application of `docs/replays.md` decide on a bag of ROS 2, and decides that run again.
fn play_bag(context: &Context, python: &Path) -> Result<()> {
    let page = std::fs::read_to_string(context.root.join(BAG_PAGE))?;
    let is_of_bag = |block: &&str| block.contains("\"office\"");
    let block = page.split("```").find(is_of_bag);
    let text = block.and_then(|block| block.strip_prefix("toml\n"));
    let text = text.with_context(|| format!("{BAG_PAGE} has no application with a bag"))?;
    let folder = context.target.join("peers");
    // The application names the bag relative to its own folder.
    std::fs::write(folder.join("office.toml"), text)?;
    if folder.join("office").exists() {
        std::fs::remove_dir_all(folder.join("office"))?;
    }
    let mut writer = Command::new(python);
    writer.arg(context.root.join(BAG_WRITER)).arg("office");
    let mut run = Command::new(context.target.join("debug/jde"));
    run.args(["run", "office.toml", "--lockstep", "--overwrite"])
        .args(["--record", "decided.mcap"]);
    let mut again = Command::new(context.target.join("debug/jde"));
    again.args(["replay", "--decide", "decided.mcap"]);
    let mut printed = String::new();
    for command in [&mut writer, &mut run, &mut again] {
        command
            .current_dir(&folder)
            .env("JDE_PLUGIN_PATH", context.target.join("debug"));
        shell::show(command, context.paint);
        let output = shell::read(command).context("the schemas did not decide on the bag twice alike")?;
        print!("{output}");
        printed += &output;
    }
    // The robot of the bag drives towards a wall.
    ensure!(printed.contains("nobody -> stop"), "`stop` did not take over");
    Ok(())
}

/// Serves a world, runs a client that drives its robot, and checks the results of both.
fn drive(context: &Context, python: &Path, client: &Path) -> Result<String> {
    let mut server = Server::start(context)?;
    let mut command = Command::new(python);
    command.arg(client).arg(&server.line);
    shell::show(&command, context.paint);
    let output = shell::read(&mut command).context("the client failed")?;
    print!("{output}");
    let summary = server.end()?;
    ensure!(
        summary.contains("\"sessions\":1"),
        "the server counted no session: {summary}"
    );
    ensure!(
        !summary.contains("\"travelled_m\":0.0"),
        "the robot did not move: {summary}"
    );
    Ok(output)
}

/// A running `jde sim`; killed when dropped.
struct Server {
    process: ChildGuard,
    /// The serial line of the robot.
    line: String,
}

impl Server {
    fn start(context: &Context) -> Result<Self> {
        let program = context.target.join("debug/jde");
        let mut command = Command::new(program);
        command
            .args(["sim", "worlds/office.toml", "--pty", "--json", "--for", LIMIT])
            .current_dir(&context.root);
        shell::show(&command, context.paint);
        let mut process = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .context("cannot start `jde sim`")?;
        let messages = process.stderr.take().context("it has no standard error")?;
        let mut lines = BufReader::new(messages).lines();
        let line = lines.by_ref().find_map(|line| {
            let line = line.ok()?;
            Some(line.split_once("serial:")?.1.trim().to_owned())
        });
        // A full pipe would block the server.
        std::thread::spawn(move || lines.for_each(drop));
        let Some(line) = line else {
            // Standard error ended without the line, so the server ended by itself.
            let _ = process.kill();
            bail!("`jde sim` reported no serial line");
        };
        Ok(Self {
            process: ChildGuard(process),
            line,
        })
    }

    /// Ends the server. Returns its standard output.
    fn end(&mut self) -> Result<String> {
        self.process.terminate()?;
        let output = self.process.0.stdout.take().context("it was read before")?;
        let summary = std::io::read_to_string(output)?;
        let status = self.process.0.wait()?;
        ensure!(status.success(), "`jde sim` ended with {status}");
        Ok(summary)
    }
}
