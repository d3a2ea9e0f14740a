//! `--ros-args`: what launch files and `ros2 run` pass to a node.

use clap::Args;
use jde_app::Override;

use crate::failure::Failure;
use crate::log::Filter;
use crate::session::RosNames;

/// What is accepted, for messages.
const ACCEPTED: &str = "-r __node:=NAME, -r __ns:=/NAMESPACE, -p SCHEMA.MODULATION:=VALUE, --log-level LEVEL";

/// The application as a node of ROS 2.
#[derive(Args)]
pub(crate) struct RosArgs {
    /// Be a node of ROS 2 over Zenoh: modulations are parameters, with services to stop and to release. Arguments
    /// up to `--`: -r __node:=NAME, -r __ns:=/NAMESPACE, -p SCHEMA.MODULATION:=VALUE, --log-level LEVEL.
    #[arg(long, value_name = "ARGUMENT", num_args = 0.., allow_hyphen_values = true, value_terminator = "--",
          conflicts_with = "lockstep")]
    ros_args: Option<Vec<String>>,
}

/// The arguments, parsed.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct ParsedRosArgs {
    /// The names of the node.
    pub(crate) names: RosNames,
    /// Initial values of modulations.
    pub(crate) parameters: Vec<Override>,
    /// What the log shows.
    pub(crate) filter: Option<Filter>,
}

impl RosArgs {
    /// Returns the arguments; `None` if the application is no node.
    ///
    /// # Errors
    /// An argument is not accepted.
    pub(crate) fn parse(self) -> Result<Option<ParsedRosArgs>, Failure> {
        let parse = |arguments: Vec<String>| parse(&arguments);
        let parsed = self.ros_args.map(parse).transpose();
        parsed
            .map_err(|error| Failure::usage(format!("--ros-args: {error}"), format!("it accepts {ACCEPTED}")))
    }
}

fn parse(arguments: &[String]) -> Result<ParsedRosArgs, String> {
    let mut parsed = ParsedRosArgs::default();
    let mut levels = Vec::new();
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
            "-r" | "--remap" => remap(value()?, &mut parsed.names)?,
            "-p" | "--param" => parsed.parameters.push(parameter(value()?)?),
            "--log-level" => levels.push(value()?.replace(":=", "=")),
            // Where the log goes: /rosout has it always, and so has standard error.
            "--enable-rosout-logs"
            | "--enable-stdout-logs"
            | "--enable-external-lib-logs"
            | "--disable-external-lib-logs" => {}
            "--params-file" => {
                return Err(
                    "it reads no file of parameters; state each with -p, or use an application file"
                        .to_owned(),
                );
            }
            other => return Err(format!("`{other}` is not accepted")),
        }
    }
    if !levels.is_empty() {
        // `fatal` is a level of ROS 2, and none here.
        let text = levels.join(",").replace("fatal", "error");
        parsed.filter = Some(text.parse()?);
    }
    Ok(parsed)
}

fn remap(rule: &str, names: &mut RosNames) -> Result<(), String> {
    match rule.split_once(":=") {
        Some(("__node" | "__name", name)) => names.node = Some(name.to_owned()),
        Some(("__ns", namespace)) => names.namespace = Some(namespace.to_owned()),
        Some((topic, _)) => {
            return Err(format!(
                "`{topic}` cannot be renamed here; the application file states the names of topics"
            ));
        }
        None => return Err(format!("`{rule}` is no rule; expected FROM:=TO")),
    }
    Ok(())
}

fn parameter(assignment: &str) -> Result<Override, String> {
    let (name, value) = assignment
        .split_once(":=")
        .ok_or_else(|| format!("`{assignment}` is no parameter; expected SCHEMA.MODULATION:=VALUE"))?;
    format!("{name}={value}").parse()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<ParsedRosArgs, String> {
        let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        parse(&words)
    }

    #[test]
    fn the_arguments_of_launch_files_are_accepted() {
        let text = "-r __node:=scout --ros-args -r __ns:=/fleet -p goon.fast:=0.3 --log-level info --log-level goon:=debug";
        let parsed = parsed(text).unwrap();
        let names = RosNames {
            node: Some("scout".to_owned()),
            namespace: Some("/fleet".to_owned()),
        };
        assert_eq!(parsed.names, names);
        assert_eq!(parsed.parameters[0].to_string(), "--set goon.fast=0.3");
        assert_eq!(parsed.filter, Some("info,goon=debug".parse().unwrap()));
        assert_eq!(super::parse(&[]), Ok(ParsedRosArgs::default()));
    }

    #[test]
    fn what_is_not_supported_is_refused_in_words() {
        for (text, expected) in [
            ("-r scan:=/front", "`scan` cannot be renamed here"),
            ("-r scan", "expected FROM:=TO"),
            ("-p", "a value is missing after -p"),
            ("-p goon.fast=1", "expected SCHEMA.MODULATION:=VALUE"),
            ("-p use_sim_time:=true", "write schema.variable=value"),
            ("--params-file p.yaml", "no file of parameters"),
            ("--log-level loud", "`loud` is not a level"),
            ("-e /enclave", "`-e` is not accepted"),
        ] {
            let error = parsed(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
