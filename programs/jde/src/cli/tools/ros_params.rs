//! Files of parameters, as `--params-file` names them: initial values of modulations, for the nodes that their keys name.

use std::path::Path;

use jde_app::{Faults, Override};
use jde_document::FaultReport;
use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

use crate::extensions::SIM_TIME;

/// The key of the parameters of a node.
const PARAMETERS: &str = "ros__parameters";

/// A parameter of a node.
#[derive(Debug)]
pub(super) enum Parameter {
    /// The initial value of a modulation.
    Initial(Override),
    /// Whether the time is that of `/clock`.
    SimTime(bool),
}

/// The parameters of a node in a file, in its order, and the faults of the file.
struct ParameterFile<'f> {
    report: FaultReport<'f>,
    /// The full name of the node.
    node: &'f str,
    parameters: Vec<Parameter>,
}

/// Returns the parameters that a file states for the node of that full name.
///
/// # Errors
/// All faults of the file.
pub(super) fn read(file: &Path, node: &str) -> Result<Vec<Parameter>, Faults> {
    let text = jde_document::read(file, "a file of parameters")?;
    parse(file, node, &text)
}

/// Returns the parameter `SCHEMA.MODULATION`, `SCHEMA.MODULATION.FIELD` or `use_sim_time`. `value` is TOML, or a text.
///
/// # Errors
/// It is no such parameter.
pub(super) fn parameter(name: &str, value: &str) -> Result<Parameter, String> {
    if name == SIM_TIME {
        let is_simulated = value.parse().map(Parameter::SimTime);
        return is_simulated.map_err(|_| format!("`{SIM_TIME}` is true or false, not {value}"));
    }
    let mut parts = name.split('.');
    let (Some(schema), Some(modulation)) = (parts.next(), parts.next()) else {
        return Err(format!("`{name}` is not a parameter; expected SCHEMA.MODULATION"));
    };
    let value = parts.rev().fold(value.to_owned(), |inner, field| {
        format!("{{ {field:?} = {inner} }}")
    });
    format!("{schema}.{modulation}={value}")
        .parse()
        .map(Parameter::Initial)
}

/// Returns the bool that an unquoted word is in a file of parameters or an argument: those of YAML 1.1, as `rcl` reads them
/// (`rcl_yaml_param_parser`, `get_value`).
pub(super) fn boolean(word: &str) -> Option<&'static str> {
    match word {
        "y" | "Y" | "yes" | "Yes" | "YES" | "true" | "True" | "TRUE" | "on" | "On" | "ON" => Some("true"),
        "n" | "N" | "no" | "No" | "NO" | "false" | "False" | "FALSE" | "off" | "Off" | "OFF" => Some("false"),
        _ => None,
    }
}

fn parse(file: &Path, node: &str, text: &str) -> Result<Vec<Parameter>, Faults> {
    let mut this = ParameterFile {
        report: FaultReport::new(file, text),
        node,
        parameters: Vec::new(),
    };
    match MarkedYaml::load_from_str(text) {
        Ok(documents) => documents.iter().for_each(|document| this.nodes("", document)),
        Err(error) => {
            let at = error.marker().index();
            let message = format!("this is not YAML: {}", error.info());
            this.report.fault(&this.report.in_bytes(&(at..at)), message);
        }
    }
    let parameters = this.parameters;
    this.report.finish().map(|_| parameters)
}

impl ParameterFile<'_> {
    /// Reads the nodes of a namespace.
    fn nodes(&mut self, namespace: &str, yaml: &MarkedYaml<'_>) {
        let expected = format!("expected names of nodes, each with `{PARAMETERS}`");
        let Some(map) = yaml.data.as_mapping() else {
            return self.fault(yaml, expected);
        };
        for (key, value) in map {
            match key.data.as_str() {
                None => self.fault(key, "a name is a text"),
                Some(PARAMETERS) if namespace.is_empty() => self.fault(key, expected.clone()),
                Some(PARAMETERS) if fits(namespace, self.node) => self.group("", value),
                Some(PARAMETERS) => {}
                Some(name) => self.nodes(&format!("{namespace}/{}", name.trim_matches('/')), value),
            }
        }
    }

    /// Reads parameters whose names begin with a prefix.
    fn group(&mut self, prefix: &str, yaml: &MarkedYaml<'_>) {
        let Some(map) = yaml.data.as_mapping() else {
            return self.fault(yaml, "expected parameters, as in `goon.fast: 0.3`");
        };
        for (key, value) in map {
            let Some(own) = key.data.as_str() else {
                self.fault(key, "a name is a text");
                continue;
            };
            let name = match prefix {
                "" => own.to_owned(),
                prefix => format!("{prefix}.{own}"),
            };
            if value.data.is_mapping() {
                self.group(&name, value);
                continue;
            }
            let Some(text) = toml_of(value) else {
                self.fault(value, "expected a bool, a number, a text or a list of them");
                continue;
            };
            let place = format!("{}:{}", self.report.file().display(), key.span.start.line());
            match parameter(&name, &text) {
                Err(error) => self.fault(key, error),
                Ok(Parameter::Initial(initial)) => self.parameters.push(Parameter::Initial(Override {
                    place: Some(place),
                    ..initial
                })),
                Ok(sim_time @ Parameter::SimTime(_)) => self.parameters.push(sim_time),
            }
        }
    }

    fn fault(&mut self, yaml: &MarkedYaml<'_>, message: impl Into<String>) {
        let characters = yaml.span.start.index()..yaml.span.end.index();
        self.report.fault(&self.report.in_bytes(&characters), message);
    }
}

/// Returns a value as TOML; `None` if it is no value of a parameter.
fn toml_of(yaml: &MarkedYaml<'_>) -> Option<String> {
    Some(match &yaml.data {
        YamlData::Value(Scalar::Boolean(value)) => value.to_string(),
        YamlData::Value(Scalar::Integer(value)) => value.to_string(),
        YamlData::Value(Scalar::FloatingPoint(value)) => format!("{:?}", value.0).to_lowercase(),
        // Quotes would make it longer than its text.
        YamlData::Value(Scalar::String(text)) if yaml.span.len() == text.len() && boolean(text).is_some() => {
            boolean(text).unwrap_or_default().to_owned()
        }
        // A text in JSON is one in TOML.
        YamlData::Value(Scalar::String(text)) => serde_json::Value::from(&**text).to_string(),
        YamlData::Sequence(elements) => {
            let elements: Option<Vec<_>> = elements.iter().map(toml_of).collect();
            format!("[{}]", elements?.join(", "))
        }
        _ => return None,
    })
}

/// Whether a pattern is the full name of a node. In it, `*` is any name, and `**` any number of them.
fn fits(pattern: &str, node: &str) -> bool {
    let [pattern, node] = [pattern, node].map(|name| name.trim_matches('/').split('/').collect::<Vec<_>>());
    tokens_fit(&pattern, &node)
}

fn tokens_fit(pattern: &[&str], node: &[&str]) -> bool {
    match pattern {
        [] => node.is_empty(),
        ["**", rest @ ..] => (0..=node.len()).any(|taken| tokens_fit(rest, &node[taken..])),
        [first, rest @ ..] => {
            let fits = |own: &&str| *first == "*" || first == own;
            node.first().is_some_and(fits) && tokens_fit(rest, &node[1..])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Vec<String>, Faults> {
        let parameters = parse(Path::new("p.yaml"), "/fleet/scout", text)?;
        let text = |parameter: &Parameter| match parameter {
            Parameter::Initial(initial) => initial.to_string(),
            Parameter::SimTime(is_simulated) => format!("{SIM_TIME}={is_simulated}"),
        };
        Ok(parameters.iter().map(text).collect())
    }

    #[test]
    fn parameters_of_the_node_are_read_in_order() {
        let text = "\
/**:
  ros__parameters:
    use_sim_time: false
    goon: { fast: 0.3, names: [a, \"b\"] }
/other:
  ros__parameters: { goon.fast: 9 }
fleet:
  scout:
    ros__parameters:
      goon.fast: 1
      vff.place.x: -1.5e-3
      vff.on: true
      vff.off: [no, 'no', Off]
/*/scout:
  ros__parameters:
    vff.text: 0.3 m/s
";
        assert_eq!(
            read_text(text).unwrap(),
            [
                "use_sim_time=false",
                "p.yaml:4: goon.fast=0.3",
                "p.yaml:4: goon.names=[\"a\", \"b\"]",
                "p.yaml:10: goon.fast=1",
                "p.yaml:11: vff.place={ \"x\" = -0.0015 }",
                "p.yaml:12: vff.on=true",
                "p.yaml:13: vff.off=[false, \"no\", false]",
                "p.yaml:16: vff.text=\"0.3 m/s\"",
            ]
        );
        assert_eq!(read_text(""), Ok(Vec::new()));
    }

    #[test]
    fn wildcards_are_names_of_nodes() {
        for (pattern, expected) in [
            ("/**", true),
            ("**", true),
            ("/fleet/**", true),
            ("/fleet/*", true),
            ("/**/scout", true),
            ("/fleet/scout/**", true),
            ("*", false),
            ("/scout", false),
            ("/fleet", false),
            ("/other/**", false),
        ] {
            assert_eq!(fits(pattern, "/fleet/scout"), expected, "{pattern}");
        }
        assert!(fits("*", "/scout") && fits("scout", "/scout"));
    }

    #[test]
    fn what_is_no_parameter_is_refused_with_its_line() {
        for (text, expected) in [
            ("a: [", "p.yaml:1:5: this is not YAML"),
            ("- a", "p.yaml:1:1: expected names of nodes"),
            ("scout:\n  goon.fast: 1", "p.yaml:2:14: expected names of nodes"),
            (
                "ros__parameters:\n  goon.fast: 1",
                "p.yaml:1:1: expected names of nodes",
            ),
            ("/**:\n  ros__parameters: 1", "p.yaml:2:20: expected parameters"),
            (
                "/**:\n  ros__parameters:\n    fast: 1",
                "p.yaml:3:5: `fast` is not a parameter",
            ),
            (
                "/**:\n  ros__parameters:\n    a.b:\n",
                "expected a bool, a number",
            ),
            (
                "/**:\n  ros__parameters:\n    use_sim_time: maybe",
                "p.yaml:3:5: `use_sim_time` is true or false",
            ),
        ] {
            let error = read_text(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
