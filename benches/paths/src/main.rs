//! Runs a hot path a given number of times, so that its instructions can be counted: `jde-paths NAME TIMES`.
//! Without arguments it prints the names of the paths.

use std::hint::black_box;

use anyhow::{Context as _, Result, bail, ensure};
use jde_loader::{Plugins, SearchPath};
use jde_paths::{Base, Drive, EXPORT, Level, Periods, SPEED, Watch, ends, surroundings, variable};
use jde_schema::derived::raw;
use jde_schema::prelude::*;

/// Is always ready, and does nothing.
#[derive(Describe)]
#[schema(motor, period = "1ms")]
struct Act {
    /// An import that keeps another schema awake.
    #[import(optional)]
    input: Import<f64>,
}

/// Exports its input.
#[derive(Describe)]
#[schema(perceptive, period = "1ms")]
struct Echo {
    /// The value to export.
    #[import(optional)]
    input: Import<f64>,
    /// The same value.
    #[export]
    out: Export<f64>,
}

impl Schema for Act {
    fn iterate(&mut self, _: &Context) -> jde_schema::Result {
        let _ = &self.input;
        Ok(())
    }
}

impl Schema for Echo {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        let value = self.input.get(cx).map(|value| *value);
        self.out.write(cx, value.unwrap_or_default());
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!(
    "paths",
    "Schemas on the hot paths.",
    [Act, Echo, Watch, Drive, Base]
);

/// A motor schema that always wins.
const MOTOR: &str = "roots = [\"act\"]\n[schemas.act]\ntype = \"paths/act\"\n";
/// Two perceptive schemas. The second exports the value of the first.
const ECHOES: &str = r#"
    roots = ["hub"]
    [schemas.hub]
    type = "paths/act"
    period = "3600s"
    imports = { input = "two.out" }
    [schemas.one]
    type = "paths/echo"
    [schemas.two]
    type = "paths/echo"
    imports = { input = "one.out" }
"#;

/// A base whose driver reads each command. `GUARD` is the guard of the commands, or nothing.
const DRIVE: &str = r#"
    roots = ["drive"]
    GUARD
    [schemas.watch]
    type = "paths/watch"
    [schemas.base]
    type = "paths/base"
    [schemas.drive]
    type = "paths/drive"
    actuators = { base = "base.velocity" }
"#;

/// The name of a path, and the function that runs it.
type Path = (&'static str, fn(u64) -> Result<()>);

const PATHS: &[Path] = &[
    ("read-64-bytes", read),
    ("publish-64-bytes", publish),
    ("pass-a-picture", picture),
    ("select-among-100", select),
    ("change-among-100", change),
    ("iterate-a-winner", winner),
    ("iterate-two-that-perceive", echoes),
    ("judge-by-720-points", judge),
    ("drive-a-base", |times| drive("", times)),
    ("drive-a-guarded-base", |times| {
        drive("root = { guard = \"watch\" }", times)
    }),
];

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(name) = arguments.next() else {
        PATHS.iter().for_each(|(name, _)| println!("{name}"));
        return Ok(());
    };
    let times = arguments
        .next()
        .context("the number of repetitions is missing")?
        .parse()?;
    let Some((_, pass)) = PATHS.iter().find(|(path, _)| *path == name) else {
        bail!("unknown path `{name}`");
    };
    pass(times)
}

fn read(times: u64) -> Result<()> {
    let (_writer, mut reader) = ends::<8>(EXPORT)?;
    for _ in 0..times {
        black_box(reader.get(0));
    }
    Ok(())
}

fn publish(times: u64) -> Result<()> {
    let (mut writer, _reader) = ends::<8>(EXPORT)?;
    for time in 0..times {
        black_box(writer.write(black_box([1; 8]), time, time))?;
    }
    Ok(())
}

fn picture(times: u64) -> Result<()> {
    let picture = variable(640 * 480 * 3 / 8, EXPORT, 1)?;
    let (mut writer, mut reader) = (picture.writer(1, "writer")?, picture.reader("reader"));
    for time in 0..times {
        writer.loan()[0] = 1;
        black_box(writer.publish(time, time))?;
        black_box(reader.latch(0).map(|latched| latched.bytes[0]));
        reader.release();
    }
    Ok(())
}

fn select(times: u64) -> Result<()> {
    let mut level = Level::new(100)?;
    (0..times).for_each(|_| level.iterate());
    Ok(())
}

fn change(times: u64) -> Result<()> {
    let mut level = Level::new(100)?;
    (0..times).for_each(|_| level.change());
    Ok(())
}

fn winner(times: u64) -> Result<()> {
    periods(MOTOR, times)
}

fn echoes(times: u64) -> Result<()> {
    periods(ECHOES, times)
}

fn judge(times: u64) -> Result<()> {
    let (around, command) = (surroundings(), Twist::planar(SPEED, 0.0));
    for _ in 0..times {
        let verdict = black_box(&around).judge(Duration::from_millis(25), black_box(&command));
        ensure!(verdict.is_ok(), "the command is refused");
    }
    Ok(())
}

fn drive(guard: &str, times: u64) -> Result<()> {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN)?;
    let mut periods = Periods::of(&DRIVE.replace("GUARD", guard), &plugins)?;
    periods.pass(times);
    let speed = periods.value("base.speed")?;
    ensure!(speed == Some(SPEED), "the base is commanded {speed:?} m/s");
    Ok(())
}

fn periods(text: &str, times: u64) -> Result<()> {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN)?;
    Periods::of(text, &plugins)?.pass(times);
    Ok(())
}
