//! `--ros-args`: what launch files and `ros2 run` pass to a node.

use std::path::{Path, PathBuf};

use clap::Args;
use jde_abi::describe::{Port, Role};
use jde_app::{Application, Binding, Override};
use jde_board::value::{Value, decode, encode};
use jde_ros_node::Remaps;
use jde_session::log::Filter;
use jde_session::paths;

use super::ros_params::{self, Parameter, parameter};
use crate::extensions::{CLOCK, SimTime, ros_node_name};
use crate::failure::Failure;

/// What is accepted, for messages.
const ACCEPTED: &str = "-r __node:=NAME, -r __ns:=/NAMESPACE, -r FROM:=TO, -p SCHEMA.MODULATION:=VALUE, \
                        --params-file FILE, --log-level LEVEL";
/// The modulation of a schema that takes rules for names.
const REMAP: &str = "remap";
/// The choice of `/clock`.
const FOLLOW: &str = "follow";

/// The application as a node of ROS 2.
#[derive(Args)]
pub(crate) struct RosArgs {
    /// Be a node of ROS 2 over Zenoh: modulations are parameters, with services to stop and to release. Arguments
    /// up to `--`: -r __node:=NAME, -r __ns:=/NAMESPACE, -r FROM:=TO, -p SCHEMA.MODULATION:=VALUE, --params-file FILE,
    /// --log-level LEVEL.
    #[arg(long, value_name = "ARGUMENT", num_args = 0.., allow_hyphen_values = true, value_terminator = "--",
          conflicts_with = "lockstep")]
    ros_args: Option<Vec<String>>,
}

/// The arguments, parsed.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct ParsedRosArgs {
    /// The names of the node, and other names of topics and services.
    pub(crate) remaps: Remaps,
    /// Initial values of modulations.
    pub(crate) parameters: Vec<Override>,
    /// Whether the time is that of `/clock`.
    sim_time: bool,
    /// What the log shows.
    pub(crate) filter: Option<Filter>,
}

impl RosArgs {
    /// Returns the arguments; `None` if the application, given as a file or by name, is no node.
    ///
    /// # Errors
    /// An argument is not accepted.
    pub(crate) fn parse(self, application: &Path) -> Result<Option<ParsedRosArgs>, Failure> {
        let parse = |arguments: Vec<String>| parse(&arguments, || application_name(application));
        let parsed = self.ros_args.map(parse).transpose();
        parsed
            .map_err(|error| Failure::usage(format!("--ros-args: {error}"), format!("it accepts {ACCEPTED}")))
    }
}

impl ParsedRosArgs {
    /// Gives the rules to each schema of the plugin `ros2`, before those that the application states, and the clock to each
    /// that states none. Returns these.
    ///
    /// # Errors
    /// The rules are too long.
    pub(crate) fn apply(&self, application: &mut Application) -> Result<SimTime, Failure> {
        self.remap(application)?;
        Ok(SimTime {
            is_simulated: self.sim_time,
            schemas: choose_clock(application, self.sim_time),
        })
    }

    fn remap(&self, application: &mut Application) -> Result<(), Failure> {
        let rules = self.remaps.without_names_of_all().to_string();
        if rules.is_empty() {
            return Ok(());
        }
        for (schema, port, initial, set) in modulations(application, REMAP) {
            let text = match decode(&port.value_type, initial).into_only_field() {
                Value::Text(stated) if !stated.is_empty() => format!("{rules},{stated}"),
                _ => rules.clone(),
            };
            encode(&port.value_type, &Value::Text(text), initial).map_err(|error| {
                Failure::usage(
                    format!("--ros-args: {schema}.{REMAP}: {error}"),
                    "state fewer rules, or rename the topics in the application file",
                )
            })?;
            *set = true;
        }
        Ok(())
    }
}

/// Returns the schemas of the plugin `ros2` that can follow `/clock` and state no clock. They do if the time is simulated.
fn choose_clock(application: &mut Application, is_simulated: bool) -> Vec<String> {
    let mut schemas = Vec::new();
    for (schema, port, initial, set) in modulations(application, CLOCK) {
        let Role::Modulation { limits, .. } = &port.role else {
            continue;
        };
        let follow = limits.choices.iter().position(|choice| choice == FOLLOW);
        if let Some(number) = follow.filter(|_| !*set) {
            schemas.push(schema.to_owned());
            // The number of a choice fits its type.
            *set = is_simulated && encode(&port.value_type, &Value::UInt(number as u64), initial).is_ok();
        }
    }
    schemas
}

/// A modulation: its schema, its port, its initial value, and whether the application states that.
type InitialModulation<'a> = (&'a str, &'a Port, &'a mut [u8], &'a mut bool);

/// Returns the modulation of that name of each schema of the plugin `ros2` that has it.
fn modulations<'a>(
    application: &'a mut Application,
    name: &'static str,
) -> impl Iterator<Item = InitialModulation<'a>> {
    let plugins = &application.plugins;
    let drivers = application.instances.iter_mut();
    let drivers = drivers.filter(|instance| plugins[instance.plugin].name == "ros2");
    drivers.flat_map(move |instance| {
        let ports = instance.schema.ports.iter().zip(&mut instance.bindings);
        let schema = instance.name.as_str();
        ports.filter_map(move |(port, binding)| match binding {
            Binding::Modulation { initial, set, .. } if port.name == name => {
                Some((schema, port, initial.as_mut_slice(), set))
            }
            _ => None,
        })
    })
}

/// The largest application file, bytes.
const MAX_FILE: u64 = 2 << 20;

/// Returns the name of an application, which is that of its node. The faults of its file are found later.
fn application_name(given: &Path) -> String {
    let file = paths::find_application(given).unwrap_or_else(|_| given.to_owned());
    let text = jde_files::read_text(&file, MAX_FILE).unwrap_or_default();
    let stated = toml::from_str::<toml::Table>(&text).ok();
    let stated = stated.and_then(|table| Some(table.get("name")?.as_str()?.to_owned()));
    let stem = file.file_stem().unwrap_or_default();
    stated.unwrap_or_else(|| stem.to_string_lossy().into_owned())
}

/// Where initial values come from, in the order of the arguments.
enum Stated {
    One(Parameter),
    File(PathBuf),
}

fn parse(arguments: &[String], application: impl FnOnce() -> String) -> Result<ParsedRosArgs, String> {
    let mut parsed = ParsedRosArgs::default();
    let (mut levels, mut stated) = (Vec::new(), Vec::new());
    let mut arguments = arguments.iter();
    while let Some(flag) = arguments.next() {
        let mut value = || {
            arguments
                .next()
                .ok_or_else(|| format!("a value is missing after {flag}"))
        };
        match flag.as_str() {
            // launch files separate groups of arguments by repeating it.
            "--ros-args" => {}
            "-r" | "--remap" => parsed.remaps.extend(value()?.parse()?),
            "-p" | "--param" => stated.push(Stated::One(assignment(value()?)?)),
            "--params-file" => stated.push(Stated::File(value()?.into())),
            "--log-level" => levels.push(level(value()?)),
            // Where the log goes: /rosout has it always, and so has standard error.
            "--enable-rosout-logs"
            | "--enable-stdout-logs"
            | "--enable-external-lib-logs"
            | "--disable-external-lib-logs" => {}
            other => return Err(format!("`{other}` is not accepted")),
        }
    }
    let has_file = stated.iter().any(|stated| matches!(stated, Stated::File(_)));
    let needs_name = has_file || !levels.is_empty();
    let node = if needs_name {
        ros_node_name(&parsed.remaps, &application())?.full()
    } else {
        String::new()
    };
    if !levels.is_empty() {
        let filter: Filter = levels.join(",").parse()?;
        let logger = node.trim_start_matches('/').replace('/', ".");
        parsed.filter = Some(filter.with_loggers_of(&logger));
    }
    for stated in stated {
        let parameters = match stated {
            Stated::One(parameter) => vec![parameter],
            Stated::File(file) => ros_params::read(&file, &node).map_err(|faults| format!("{faults:#}"))?,
        };
        for parameter in parameters {
            match parameter {
                Parameter::Initial(initial) => parsed.parameters.push(initial),
                Parameter::SimTime(is_simulated) => parsed.sim_time = is_simulated,
            }
        }
    }
    Ok(parsed)
}

/// Returns a level for all loggers or for one, as a filter has it. `FATAL` is a level of ROS 2, in any case, and none here.
fn level(text: &str) -> String {
    let (logger, level) = match text.rsplit_once(":=") {
        Some((logger, level)) => (format!("{logger}="), level),
        None => (String::new(), text),
    };
    let level = if level.eq_ignore_ascii_case("fatal") {
        "error"
    } else {
        level
    };
    logger + level
}

fn assignment(text: &str) -> Result<Parameter, String> {
    let (name, value) = text
        .split_once(":=")
        .ok_or_else(|| format!("`{text}` is not a parameter; expected SCHEMA.MODULATION:=VALUE"))?;
    parameter(name, ros_params::boolean(value).unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<ParsedRosArgs, String> {
        let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        parse(&words, || "robot".to_owned())
    }

    #[test]
    fn the_arguments_of_launch_files_are_accepted() {
        let text = "-r __node:=scout --ros-args -r __ns:=/fleet -r scan:=front -p goon.fast:=0.3 --log-level fleet.scout:=info --log-level fleet.scout.goon:=debug";
        let parsed = parsed(text).unwrap();
        assert_eq!(
            parsed.remaps.to_string(),
            "__node:=scout,__ns:=/fleet,scan:=front"
        );
        assert_eq!(parsed.parameters[0].to_string(), "--set goon.fast=0.3");
        assert_eq!(parsed.filter, Some("info,goon=debug".parse().unwrap()));
        assert_eq!(super::parse(&[], String::new), Ok(ParsedRosArgs::default()));
        let filter = |text: &str| super::tests::parsed(text).unwrap().filter;
        for level in ["FATAL", "fatal", "Error", "robot:=FATAL"] {
            assert_eq!(
                filter(&format!("--log-level {level}")),
                Some("error".parse().unwrap()),
                "{level}"
            );
        }
        assert_eq!(
            filter("--log-level robot.fatal:=DEBUG"),
            Some("fatal=debug".parse().unwrap())
        );
        for (value, expected) in [
            ("True", "true"),
            ("yes", "true"),
            ("on", "true"),
            ("N", "false"),
            ("OFF", "false"),
        ] {
            let parsed = super::tests::parsed(&format!("-p goon.fast:={value}")).unwrap();
            assert_eq!(
                parsed.parameters[0].to_string(),
                format!("--set goon.fast={expected}")
            );
        }
        let sim_time = |text: &str| super::tests::parsed(text).unwrap().sim_time;
        assert!(sim_time("-p use_sim_time:=true") && sim_time("-p use_sim_time:=on"));
        assert!(
            !sim_time("-p use_sim_time:=true -p use_sim_time:=false"),
            "the last counts"
        );
    }

    #[test]
    fn files_of_parameters_are_of_the_node_and_in_the_order_of_the_arguments() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("p.yaml");
        std::fs::write(
            &file,
            "/fleet/robot: { ros__parameters: { goon.fast: 0.2 } }\nscout: { ros__parameters: { goon.fast: 0.1 } }",
        )
        .unwrap();
        let file = file.display();
        let said = |text: &str| {
            let parsed = parsed(text).unwrap();
            let values = parsed.parameters.iter().map(|parameter| parameter.value.clone());
            values.collect::<Vec<_>>()
        };
        let arguments = format!("-p goon.fast:=0.3 --params-file {file} -p goon.fast:=0.4");
        assert_eq!(
            said(&format!("{arguments} -r __ns:=/fleet")),
            ["0.3", "0.2", "0.4"]
        );
        assert_eq!(
            said(&format!("{arguments} -r __node:=scout")),
            ["0.3", "0.1", "0.4"]
        );
        assert_eq!(said(&arguments), ["0.3", "0.4"]);
    }

    #[test]
    fn what_is_not_supported_is_refused_in_words() {
        for (text, expected) in [
            ("-r scan:=/front/", "not a valid name"),
            ("-r scan", "expected FROM:=TO"),
            ("-p", "a value is missing after -p"),
            ("-p goon.fast=1", "expected SCHEMA.MODULATION:=VALUE"),
            ("-p use_sim_time:=1", "`use_sim_time` is true or false"),
            ("-p fast:=1", "`fast` is not a parameter"),
            ("--params-file no-such-file.yaml", "no-such-file.yaml: "),
            ("--log-level loud", "`loud` is not a level"),
            ("-e /enclave", "`-e` is not accepted"),
        ] {
            let error = parsed(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
