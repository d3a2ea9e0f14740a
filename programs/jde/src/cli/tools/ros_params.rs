//! Files of parameters, as `--params-file` names them: initial values of modulations, for the nodes that their keys name.

use std::path::Path;

use jde_app::Override;
use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

use crate::session::SIM_TIME;

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

/// The largest file of parameters, bytes: thousands of nodes.
const MAX_FILE: u64 = 1 << 20;

/// The parameters of a node in a file, in its order.
struct ParameterFile<'f> {
    file: &'f Path,
    /// The full name of the node.
    node: &'f str,
    parameters: Vec<Parameter>,
}

/// Returns the parameters that a file states for the node of that full name.
///
/// # Errors
/// The file cannot be read, or is no file of parameters: where, and why.
pub(super) fn read(file: &Path, node: &str) -> Result<Vec<Parameter>, String> {
    let text =
        jde_files::read_text(file, MAX_FILE).map_err(|error| format!("{}: {error}", file.display()))?;
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
        return Err(format!("`{name}` is no parameter; expected SCHEMA.MODULATION"));
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

fn parse(file: &Path, node: &str, text: &str) -> Result<Vec<Parameter>, String> {
    let mut this = ParameterFile {
        file,
        node,
        parameters: Vec::new(),
    };
    let documents = MarkedYaml::load_from_str(text)
        .map_err(|error| this.wrong(error.marker().line(), &format!("invalid YAML: {}", error.info())))?;
    for document in &documents {
        this.nodes("", document)?;
    }
    Ok(this.parameters)
}

impl ParameterFile<'_> {
    /// Reads the nodes of a namespace.
    fn nodes(&mut self, namespace: &str, yaml: &MarkedYaml<'_>) -> Result<(), String> {
        let expected = format!("expected names of nodes, each with `{PARAMETERS}`");
        let map = yaml
            .data
            .as_mapping()
            .ok_or_else(|| self.wrong_at(yaml, &expected))?;
        for (key, value) in map {
            let key_text = key
                .data
                .as_str()
                .ok_or_else(|| self.wrong_at(key, "a name is a text"))?;
            if key_text == PARAMETERS {
                if namespace.is_empty() {
                    return Err(self.wrong_at(key, &expected));
                }
                if fits(namespace, self.node) {
                    self.group("", value)?;
                }
            } else {
                self.nodes(&format!("{namespace}/{}", key_text.trim_matches('/')), value)?;
            }
        }
        Ok(())
    }

    /// Reads parameters whose names begin with a prefix.
    fn group(&mut self, prefix: &str, yaml: &MarkedYaml<'_>) -> Result<(), String> {
        let Some(map) = yaml.data.as_mapping() else {
            return Err(self.wrong_at(yaml, "expected parameters, as in `goon.fast: 0.3`"));
        };
        for (key, value) in map {
            let own = key
                .data
                .as_str()
                .ok_or_else(|| self.wrong_at(key, "a name is a text"))?;
            let name = match prefix {
                "" => own.to_owned(),
                prefix => format!("{prefix}.{own}"),
            };
            if value.data.is_mapping() {
                self.group(&name, value)?;
                continue;
            }
            let text = self.value(value).map_err(|error| self.wrong_at(value, &error))?;
            let parameter = parameter(&name, &text).map_err(|error| self.wrong_at(key, &error))?;
            let place = format!("{}:{}", self.file.display(), key.span.start.line());
            self.parameters.push(match parameter {
                Parameter::Initial(initial) => Parameter::Initial(Override {
                    place: Some(place),
                    ..initial
                }),
                sim_time @ Parameter::SimTime(_) => sim_time,
            });
        }
        Ok(())
    }

    /// Returns a value as TOML.
    fn value(&self, yaml: &MarkedYaml<'_>) -> Result<String, String> {
        Ok(match &yaml.data {
            YamlData::Value(Scalar::Boolean(value)) => value.to_string(),
            YamlData::Value(Scalar::Integer(value)) => value.to_string(),
            YamlData::Value(Scalar::FloatingPoint(value)) => format!("{:?}", value.0).to_lowercase(),
            // Quotes would make it longer than its text.
            YamlData::Value(Scalar::String(text))
                if yaml.span.len() == text.len() && boolean(text).is_some() =>
            {
                boolean(text).unwrap_or_default().to_owned()
            }
            // A text in JSON is one in TOML.
            YamlData::Value(Scalar::String(text)) => serde_json::Value::from(&**text).to_string(),
            YamlData::Sequence(elements) => {
                let elements = elements.iter().map(|element| self.value(element));
                format!("[{}]", elements.collect::<Result<Vec<_>, _>>()?.join(", "))
            }
            _ => return Err("expected a bool, a number, a text or a list of them".to_owned()),
        })
    }

    fn wrong_at(&self, yaml: &MarkedYaml<'_>, reason: &str) -> String {
        self.wrong(yaml.span.start.line(), reason)
    }

    fn wrong(&self, line: usize, reason: &str) -> String {
        format!("{}:{line}: {reason}", self.file.display())
    }
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

    fn read_text(text: &str) -> Result<Vec<String>, String> {
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
            ("a: [", "invalid YAML"),
            ("- a", "p.yaml:1: expected names of nodes"),
            ("scout:\n  goon.fast: 1", "p.yaml:2: expected names of nodes"),
            (
                "ros__parameters:\n  goon.fast: 1",
                "p.yaml:1: expected names of nodes",
            ),
            ("/**:\n  ros__parameters: 1", "p.yaml:2: expected parameters"),
            (
                "/**:\n  ros__parameters:\n    fast: 1",
                "p.yaml:3: `fast` is no parameter",
            ),
            (
                "/**:\n  ros__parameters:\n    a.b:\n",
                "expected a bool, a number",
            ),
            (
                "/**:\n  ros__parameters:\n    use_sim_time: maybe",
                "p.yaml:3: `use_sim_time` is true or false",
            ),
        ] {
            let error = read_text(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
