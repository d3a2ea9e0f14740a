//! What a process of its own costs: the same schema in lockstep, here and apart, and the time of the machine that an iteration takes.
//!
//! `cargo run --release -p jde-host --example apart`

use std::path::Path;
use std::time::Instant;

use jde_abi::raw;
use jde_app::parse;
use jde_host::{Lockstep, Options};
use jde_isolation::{Program, serve};
use jde_loader::{Plugins, SearchPath};
use jde_schema::prelude::*;

/// What this program is called with to be the process of a schema.
const SERVE: &str = "serve";

/// Looks at a scan and commands a speed: what a behaviour does in an iteration.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Follow {
    /// What a laser sees.
    #[import(optional)]
    laser: Import<LaserScan>,
    /// Speeds of the base.
    #[actuator(optional)]
    base: Actuator<Twist>,
}

impl Schema for Follow {
    fn iterate(&mut self, cx: &Context) -> Result {
        let mut twist = Twist::ZERO;
        twist.linear.x = self.laser.get(cx).map_or(0.0, |laser| f64::from(laser.range_max));
        self.base.command(cx, twist);
        Ok(())
    }
}

/// A base with a laser.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
struct Base {
    /// What the laser sees.
    #[export]
    laser: Export<LaserScan>,
    /// Speeds.
    #[command(neutral = Twist::ZERO, validity = "100ms")]
    velocity: Command<Twist>,
}

impl Schema for Base {
    fn iterate(&mut self, cx: &Context) -> Result {
        let mut laser = self.laser.loan(cx);
        laser.range_max = 8.0;
        laser.publish();
        let _ = self.velocity.get(cx);
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("cost", "What an iteration costs.", [Follow, Base]);

const APPLICATION: &str = r#"
    roots = ["follow"]
    [schemas.base]
    type = "cost/base"
    [schemas.follow]
    type = "cost/follow"
    imports = { laser = "base.laser" }
    actuators = { base = "base.velocity" }
"#;

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN)?;
    if std::env::args().nth(1).as_deref() == Some(SERVE) {
        return Ok(serve(&plugins)?);
    }
    let here = median(APPLICATION, &plugins)?;
    let apart = median(
        &APPLICATION.replace("\"cost/follow\"", "\"cost/follow\"\nisolate = \"process\""),
        &plugins,
    )?;
    println!("here  {here:8.2} us for a period of both schemas");
    println!("apart {apart:8.2} us");
    println!(
        "so {:.2} us more for an iteration that reads a scan of {} bytes and commands a speed",
        apart - here,
        size_of::<LaserScan>()
    );
    Ok(())
}

/// Median time of the machine for a period of the application, us.
fn median(text: &str, plugins: &Plugins) -> std::result::Result<f64, Box<dyn std::error::Error>> {
    let application = parse(text, Path::new("cost.toml"), &[], plugins)?;
    let options = Options {
        isolation_program: Some(Program {
            path: std::env::current_exe()?,
            arguments: vec![SERVE.into()],
        }),
        ..Options::default()
    };
    let mut run = Lockstep::start(application, plugins, options)?;
    let period = 10_000_000;
    let mut times: Vec<f64> = (1..=5000)
        .map(|turn| {
            let start = Instant::now();
            run.run_until(turn * period);
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}
