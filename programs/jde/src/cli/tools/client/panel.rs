//! `jde panel`: prints a schema's own panel as text, and operates its widgets from the command line.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_link::{PanelSample, Rate, Remote};
use jde_panel::{Button, Gesture, Item, List, Touch};
use jde_session::cli::print_json;
use jde_terminal::{self as terminal, FAINT, GOOD, TITLE};
use serde_json::json;

use super::{Context, Target};
use crate::complete;
use crate::failure::Failure;
use crate::inspect::first_paragraph;
use crate::remote::name::split_application;
use crate::remote::panel;

/// The longest time that a schema may take to draw its panel.
const DRAW_TIMEOUT: Duration = Duration::from_secs(5);

/// Show a schema's own panel as text, or touch its widgets. Without a name, list the schemas that have a
/// panel.
///
/// Each widget is a line with its label, value, range, and the name to touch it by. Pictures are described;
/// `jde view` draws them.
#[derive(Args)]
#[command(after_help = "Examples:
  jde panel
  jde panel example
  jde panel example --click field 4.5 2.0
  jde panel example --touch clear
  jde panel plan --touch width=0.6
  jde panel robot2:example --json")]
pub(crate) struct Panel {
    /// The schema, or APP:SCHEMA.
    #[arg(value_name = "SCHEMA", add = ArgValueCompleter::new(complete::panels))]
    schema: Option<String>,
    #[command(flatten)]
    target: Target,
    /// Press a button, switch a toggle (on, off, or without a value to the other state), move a slider or
    /// select a choice.
    #[arg(long, value_name = "WIDGET[=VALUE]", requires = "schema", conflicts_with_all = ["click", "json"],
          add = ArgValueCompleter::new(complete::widgets))]
    touch: Option<String>,
    /// Click on a plane or a space at a place in metres, or on an image at a pixel.
    #[arg(long, value_names = ["WIDGET", "X", "Y"], num_args = 3..=4, allow_negative_numbers = true, requires = "schema",
          conflicts_with = "json", add = ArgValueCompleter::new(complete::widgets))]
    click: Vec<String>,
    /// Print the whole panel as one line of JSON.
    #[arg(long)]
    json: bool,
}

impl Panel {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let Some(schema) = &self.schema else {
            return self.list(context);
        };
        let (named, schema) = split_application(schema);
        let remote = context.remote(&self.target, named)?;
        let sample = newest_panel(&remote, schema)?;
        if self.json {
            return Ok(print_json(&json!({
                "application": remote.about().name,
                "schema": schema,
                "number": sample.sequence,
                "time_s": sample.time as f64 / 1e9,
                "list": sample.list.as_ref().ok(),
                "reason": sample.list.as_ref().err(),
            }))?);
        }
        let list = sample.list.map_err(|reason| shows_nothing(schema, &reason))?;
        let gesture = match (&self.touch, self.click.as_slice()) {
            (Some(touched), _) => Some(parse_touch(&list, touched)?),
            (None, [widget, arguments @ ..]) => Some(parse_click(&list, widget, arguments)?),
            (None, []) => None,
        };
        let mut out = terminal::out();
        match gesture {
            Some(gesture) => {
                let widget = gesture.widget.clone();
                remote.touch(&jde_link::operator(), schema, gesture)?;
                writeln!(out, "{GOOD}{widget} of {schema} is touched{GOOD:#}")?;
            }
            None => panel::write(&list, &mut out)?,
        }
        out.flush()?;
        Ok(())
    }

    fn list(&self, context: &Context) -> Result<(), Failure> {
        let remote = context.remote(&self.target, None)?;
        let mut schemas = remote.schemas()?.schemas;
        schemas.retain(|schema| schema.panel);
        if self.json {
            let names: Vec<_> = schemas.iter().map(|schema| &schema.name).collect();
            return Ok(print_json(&names)?);
        }
        let mut out = terminal::out();
        if schemas.is_empty() {
            writeln!(out, "no schema of {} has a panel", remote.about().name)?;
        }
        for schema in schemas {
            let doc = first_paragraph(&schema.doc);
            writeln!(out, "{TITLE}{}{TITLE:#}  {FAINT}{doc}{FAINT:#}", schema.name)?;
        }
        out.flush()?;
        Ok(())
    }
}

/// Returns the newest drawing of a schema's panel. Waits for it for at most [`DRAW_TIMEOUT`].
///
/// # Errors
/// The schema has no panel, or draws nothing in time.
pub(crate) fn newest_panel(remote: &Remote, schema: &str) -> Result<PanelSample, Failure> {
    check_has_panel(remote, schema)?;
    wait_for_drawing(remote, schema)
}

/// Returns the failure of a panel without a list.
pub(crate) fn shows_nothing(schema: &str, reason: &str) -> Failure {
    Failure::broken(format!("the panel of {schema} shows nothing: {reason}"))
}

/// Checks that the schema has a panel.
fn check_has_panel(remote: &Remote, schema: &str) -> Result<(), Failure> {
    let schemas = remote.schemas()?.schemas;
    let with_panel = || {
        let with_panel = schemas.iter().filter(|schema| schema.panel);
        with_panel.map(|schema| schema.name.as_str())
    };
    match schemas.iter().find(|known| known.name == schema) {
        Some(known) if known.panel => Ok(()),
        None if with_panel().next().is_some() => Err(Failure::unknown("panel", schema, with_panel())),
        Some(_) | None => Err(Failure::usage(
            format!("`{schema}` has no panel of its own"),
            match with_panel().collect::<Vec<_>>().as_slice() {
                [] => "no schema of this application has one".to_owned(),
                names => format!("these have one: {}", names.join(", ")),
            },
        )),
    }
}

/// Returns the newest drawing of a panel. Waits for it for at most [`DRAW_TIMEOUT`].
fn wait_for_drawing(remote: &Remote, schema: &str) -> Result<PanelSample, Failure> {
    let (sender, receiver) = channel();
    let end_sender = sender.clone();
    remote.on_gone(move || drop(end_sender.send(None)));
    let _watching = remote.watch_panel(schema, Rate::Full, move |sample| {
        // The receiver is dropped after the first drawing.
        let _ = sender.send(Some(sample));
    })?;
    match receiver.recv_timeout(DRAW_TIMEOUT) {
        Ok(Some(sample)) => Ok(sample),
        Ok(None) | Err(RecvTimeoutError::Disconnected) => {
            Err(jde_link::Error::Disconnected(remote.about().name.clone()).into())
        }
        Err(RecvTimeoutError::Timeout) => Err(Failure::broken(format!(
            "{schema} drew nothing within {} s",
            DRAW_TIMEOUT.as_secs()
        ))),
    }
}

/// Returns the widget with this id.
fn find_widget<'l>(list: &'l List, id: &str) -> Result<&'l Item, Failure> {
    panel::find(list, id).ok_or_else(|| {
        let names = panel::touchable(list).filter_map(Item::id);
        Failure::unknown("widget", id, names)
    })
}

/// Returns the gesture of `WIDGET` or `WIDGET=VALUE`.
fn parse_touch(list: &List, text: &str) -> Result<Gesture, Failure> {
    let (id, value) = match text.split_once('=') {
        Some((id, value)) => (id.trim(), Some(value.trim())),
        None => (text, None),
    };
    let wrong = |message: String, help: String| Err(Failure::usage(message, help));
    let touch = match (find_widget(list, id)?, value) {
        (Item::Button { enabled: false, .. }, _) => {
            return wrong(
                format!("`{id}` cannot be pressed now"),
                "the panel shows when it can be".to_owned(),
            );
        }
        (Item::Button { .. }, None) => Touch::Pressed,
        (Item::Button { .. }, Some(_)) => {
            return wrong(
                format!("`{id}` is a button and takes no value"),
                format!("--touch {id}"),
            );
        }
        (Item::Toggle { on, .. }, None) => Touch::Toggled(!on),
        (Item::Toggle { .. }, Some("on" | "true")) => Touch::Toggled(true),
        (Item::Toggle { .. }, Some("off" | "false")) => Touch::Toggled(false),
        (Item::Toggle { .. }, Some(other)) => {
            return wrong(
                format!("`{id}` is on or off, not {other}"),
                format!("--touch {id}=on"),
            );
        }
        (
            Item::Slider {
                least,
                greatest,
                unit,
                ..
            },
            value,
        ) => {
            let number = value.and_then(|value| value.trim_end_matches(unit.as_str()).trim().parse().ok());
            match number {
                Some(number) if (*least..=*greatest).contains(&number) => Touch::Moved(number),
                _ => {
                    return wrong(
                        format!("`{id}` takes a number from {least} to {greatest} {unit}"),
                        format!("--touch {id}={greatest}"),
                    );
                }
            }
        }
        (Item::Choice { options, .. }, value) => {
            let index = options.iter().position(|option| Some(option.as_str()) == value);
            match index {
                Some(index) => Touch::Chose(index as u32),
                None => {
                    return Err(Failure::unknown(
                        &format!("choice of `{id}` called"),
                        value.unwrap_or_default(),
                        options.iter().map(String::as_str),
                    ));
                }
            }
        }
        _ => {
            return wrong(
                format!("`{id}` is a picture"),
                format!("--click {id} X Y clicks on it"),
            );
        }
    };
    Ok(Gesture {
        widget: id.to_owned(),
        touch,
    })
}

/// Returns the gesture of a click at a place.
fn parse_click(list: &List, id: &str, arguments: &[String]) -> Result<Gesture, Failure> {
    let wants = match find_widget(list, id)? {
        Item::Canvas { wants, .. } | Item::Scene { wants, .. } | Item::Image { wants, .. } => wants,
        _ => {
            return Err(Failure::usage(
                format!("`{id}` is not a picture"),
                format!("--touch {id} presses, switches or moves it"),
            ));
        }
    };
    if !wants.clicks {
        return Err(Failure::usage(
            format!("`{id}` takes no clicks"),
            "the panel only shows it",
        ));
    }
    let mut at = [0.0; 3];
    for (number, text) in at.iter_mut().zip(arguments) {
        *number = text
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
            .ok_or_else(|| {
                Failure::usage(
                    format!("`{text}` is not a number"),
                    format!("--click {id} X Y, in metres or pixels"),
                )
            })?;
    }
    Ok(Gesture {
        widget: id.to_owned(),
        touch: Touch::Clicked {
            at,
            button: Button::Primary,
        },
    })
}

#[cfg(test)]
mod tests {
    use jde_panel::Wants;

    use super::*;

    fn list() -> List {
        let id = |id: &str| id.to_owned();
        List {
            time: 0,
            items: vec![
                Item::Button {
                    id: id("clear"),
                    label: id("Clear"),
                    enabled: true,
                },
                Item::Button {
                    id: id("later"),
                    label: id("Later"),
                    enabled: false,
                },
                Item::Toggle {
                    id: id("hold"),
                    label: id("Hold"),
                    on: true,
                },
                Item::Slider {
                    id: id("ahead"),
                    label: id("Ahead"),
                    value: 1.0,
                    least: 0.0,
                    greatest: 3.0,
                    unit: id("m"),
                },
                Item::Choice {
                    id: id("gait"),
                    label: id("Gait"),
                    options: vec![id("walk"), id("run")],
                    chosen: 0,
                },
                Item::Canvas {
                    id: id("field"),
                    area: None,
                    forward_up: false,
                    shapes: Vec::new(),
                    wants: Wants {
                        clicks: true,
                        ..Wants::default()
                    },
                },
            ],
        }
    }

    #[test]
    fn a_touch_is_parsed_for_each_kind_of_widget() {
        let touched = |text: &str| parse_touch(&list(), text).map(|gesture| gesture.touch).unwrap();
        assert_eq!(touched("clear"), Touch::Pressed);
        assert_eq!(touched("hold"), Touch::Toggled(false), "to the other state");
        assert_eq!(touched("hold=on"), Touch::Toggled(true));
        assert_eq!(touched("ahead=2.5"), Touch::Moved(2.5));
        assert_eq!(touched("ahead = 2.5 m"), Touch::Moved(2.5));
        assert_eq!(touched("gait=run"), Touch::Chose(1));
        let arguments = ["-1.5", "2"].map(str::to_owned);
        let clicked = parse_click(&list(), "field", &arguments).unwrap();
        let at = [-1.5, 2.0, 0.0];
        let button = Button::Primary;
        assert_eq!(clicked.touch, Touch::Clicked { at, button });
    }

    #[test]
    fn an_invalid_touch_is_reported_before_it_is_sent() {
        let error = |text: &str| match parse_touch(&list(), text).unwrap_err() {
            Failure::Run(crate::failure::RunFailure::Usage { message, help }) => format!("{message}; {help}"),
            other => other.to_string(),
        };
        assert!(error("claer").contains("did you mean `clear`?"));
        assert!(error("later").contains("cannot be pressed now"));
        assert!(error("clear=1").contains("takes no value"));
        assert!(error("hold=maybe").contains("on or off"));
        assert!(error("ahead=4").contains("from 0 to 3 m"));
        assert!(error("ahead").contains("from 0 to 3 m"));
        assert!(error("gait=rum").contains("did you mean `run`?"));
        assert!(error("field").contains("--click"));
        let arguments = ["x", "2"].map(str::to_owned);
        assert!(parse_click(&list(), "field", &arguments).is_err());
        assert!(parse_click(&list(), "clear", &arguments).is_err());
    }
}
