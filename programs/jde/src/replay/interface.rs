//! The interface of a played recording to tools: an application that can be inspected like a running one. Its
//! schema `replay` controls playback by its modulations.

use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::value::Value;
use jde_board::{Access, Board, Declaration, LASTING, Nanos, Variable};
use jde_link::message::{Action, Range, Refusal, SchemaInfo, Schemas};
use jde_link::value::from_json;
use jde_link::{OnDrawn, PanelViewer, Subject, SubjectInfo};
use jde_records::snapshot::Snapshot;
use jde_timeline::Timeline;
use jde_types::{Flag, Text, Value as _};

use super::hierarchy;
use super::panel_store::PanelStore;
use super::player::Player;

/// The schema that controls playback.
pub(super) const CONTROL_SCHEMA: &str = "replay";

/// A recording that is being played.
pub(super) struct PlayedRecording {
    player: Arc<Player>,
    board: Arc<Board>,
    panel_store: Arc<PanelStore>,
    info: SubjectInfo,
}

/// The description of a file's damage, at most 256 bytes.
type DamageText = Text<256>;
/// The lines of what is left out, as many as fit.
type LeftOutText = Text<1020>;

/// The controls, with unit and documentation.
const CONTROLS: [(&str, &str, &str); 5] = [
    ("paused", "", "Whether playback is paused."),
    ("speed", "", "Seconds of the recording per second."),
    ("position", "s", "The position; write it to continue from there."),
    ("loop", "", "Whether playback starts again at the end."),
    (
        "step",
        "",
        "Write true to play to the next takeover and pause there.",
    ),
];

impl PlayedRecording {
    /// Creates the interface of a player whose variables are on the board, with the schema that controls playback.
    pub(super) fn new(
        player: Arc<Player>,
        board: Arc<Board>,
        panel_store: Arc<PanelStore>,
        file: String,
    ) -> Self {
        let playing = Self::standing(player, board, panel_store, file);
        playing.declare_controls();
        playing
    }

    /// As [`Self::new`], for a recording that stands still: nothing controls it.
    pub(super) fn standing(
        player: Arc<Player>,
        board: Arc<Board>,
        panel_store: Arc<PanelStore>,
        file: String,
    ) -> Self {
        let info = SubjectInfo {
            application: player.index.application.clone(),
            file,
            executor: "replay".to_owned(),
            speed: player.controls().speed,
        };
        Self {
            player,
            board,
            panel_store,
            info,
        }
    }

    /// Declares the variables of [`CONTROL_SCHEMA`].
    fn declare_controls(&self) {
        let (player, board) = (&self.player, &self.board);
        let declare = |name: &str, unit: &str, doc: &str, access, value_type: Type, initial: Vec<u8>| {
            // If the recording has a schema of this name, its variables stay.
            let _ = board.declare(Declaration {
                owner: CONTROL_SCHEMA.to_owned(),
                name: name.to_owned(),
                doc: doc.to_owned(),
                unit: unit.to_owned(),
                access,
                limits: jde_abi::describe::Limits::default(),
                initial: Some(initial),
                value_type: value_type.into(),
                writers: 1,
                readers: 1,
            });
        };
        for (name, unit, doc) in CONTROLS {
            let value_type = match name {
                "speed" | "position" => f64::describe(),
                _ => Flag::describe(),
            };
            let zeros = vec![0; value_type.bytes];
            declare(name, unit, doc, Access::Modulation, value_type, zeros);
        }
        let damage = DamageText::truncated(&player.index.damage().unwrap_or_default());
        let doc = "What is wrong with the file; empty if it is complete.";
        let bytes = damage.as_bytes().to_vec();
        declare(
            "damage",
            "",
            doc,
            Access::Export { validity: LASTING },
            DamageText::describe(),
            bytes,
        );
        let lines: Vec<_> = player.index.left_out.lines().collect();
        declare(
            "left_out",
            "",
            "Files, topics and messages that are not played, each with the reason, in lines.",
            Access::Export { validity: LASTING },
            LeftOutText::describe(),
            LeftOutText::truncated(&lines.join("\n")).as_bytes().to_vec(),
        );
    }

    /// Writes the state of the player to the variables of [`CONTROL_SCHEMA`].
    pub(super) fn publish_state(&self) {
        let controls = self.player.controls();
        let number = |number: f64| number.to_ne_bytes().to_vec();
        let values = [
            ("paused", vec![u8::from(controls.paused)]),
            ("speed", number(controls.speed)),
            ("position", number(self.player.position() as f64 / 1e9)),
            ("loop", vec![u8::from(controls.looping)]),
        ];
        for (name, bytes) in values {
            if let Some(variable) = self.board.find(&format!("{CONTROL_SCHEMA}.{name}")) {
                let same = variable
                    .reader("replay")
                    .latch(0)
                    .is_some_and(|shown| shown.bytes == bytes);
                if same {
                    continue;
                }
                // A variable of the recording with the same name may have another size.
                let _ = variable.put(0, &bytes, self.player.position(), Nanos::MAX);
            }
        }
    }

    /// Returns a schema's current period, if it was recorded.
    fn period(&self, schema: &str) -> Option<Nanos> {
        let variable = self.board.find(&format!("{schema}.period"))?;
        let mut reader = variable.reader("recording");
        let seconds = f64::from_bytes(reader.latch(0)?.bytes)?;
        (seconds.is_finite() && seconds >= 0.0).then_some((seconds * 1e9) as Nanos)
    }

    /// Returns the beginning and the end, in s since the application's start.
    fn time_range(&self) -> (f64, f64) {
        let index = &self.player.index;
        (index.begin as f64 / 1e9, index.end as f64 / 1e9)
    }

    fn set_control(&self, name: &str, setting: &Value) -> Result<(), Refusal> {
        let flag = || match setting {
            Value::Bool(flag) => Ok(*flag),
            _ => Err(refusal(format!("`{CONTROL_SCHEMA}.{name}` is true or false"))),
        };
        let number = || {
            let number = setting.as_number().filter(|number| number.is_finite());
            number.ok_or_else(|| refusal(format!("`{CONTROL_SCHEMA}.{name}` is a number")))
        };
        match name {
            "paused" => self.player.set_paused(flag()?),
            "loop" => self.player.set_looping(flag()?),
            "step" if flag()? => self.player.step(),
            "step" => {}
            "speed" => match number()? {
                speed if (0.01..=100.0).contains(&speed) => self.player.set_speed(speed),
                speed => {
                    return Err(refusal(format!(
                        "`{CONTROL_SCHEMA}.speed` takes 0.01 to 100, not {speed}"
                    )));
                }
            },
            "position" => {
                let (position, (begin, end)) = (number()?, self.time_range());
                if !(begin..=end).contains(&position) {
                    return Err(refusal(format!(
                        "`{CONTROL_SCHEMA}.position` takes {begin} s to {end} s, not {position}"
                    )));
                }
                self.player.seek((position * 1e9) as Nanos);
            }
            other => {
                let known = CONTROLS.iter().map(|(name, ..)| *name);
                return Err(Refusal {
                    error: format!("`{CONTROL_SCHEMA}` has no modulation `{other}`"),
                    nearest: jde_nearest::nearest(other, known).map(str::to_owned),
                });
            }
        }
        Ok(())
    }
}

impl Subject for PlayedRecording {
    fn info(&self) -> SubjectInfo {
        self.info.clone()
    }

    fn schemas(&self) -> Schemas {
        let mut schemas = self
            .player
            .timeline(|timeline| hierarchy::schemas(timeline.hierarchy()));
        for name in self.panel_store.schemas() {
            match schemas.schemas.iter_mut().find(|schema| schema.name == name) {
                Some(schema) => schema.panel = true,
                // Only its panel was recorded, neither its type nor its decisions.
                None => schemas.schemas.push(SchemaInfo {
                    panel: true,
                    ..hierarchy::unknown_schema(&name)
                }),
            }
        }
        schemas
    }

    fn view_panel(&self, schema: &str, _: f64, on_drawn: OnDrawn) -> Result<Box<dyn PanelViewer>, Refusal> {
        let not_recorded = || refusal(format!("nothing of a panel of `{schema}` was recorded"));
        self.panel_store
            .add_viewer(schema, on_drawn)
            .ok_or_else(not_recorded)
    }

    fn board(&self) -> &Board {
        &self.board
    }

    fn range(&self, variable: &Variable) -> Range {
        let declared = variable.describe();
        match (declared.owner.as_str(), declared.name.as_str()) {
            (CONTROL_SCHEMA, "position") => {
                let (begin, end) = self.time_range();
                Range {
                    least: Some(begin),
                    greatest: Some(end),
                    ..Range::default()
                }
            }
            _ => Range::default(),
        }
    }

    fn writer(&self, _: u32) -> String {
        "recording".to_owned()
    }

    fn now(&self) -> Nanos {
        self.player.position()
    }

    fn snapshot(&self) -> Snapshot {
        let mut snapshot = self.player.timeline(Timeline::snapshot);
        snapshot.time = self.player.position();
        for schema in &mut snapshot.schemas {
            schema.period = self.period(&schema.name).unwrap_or(0);
        }
        snapshot
    }

    fn act(&self, _: &str, action: &Action) -> Result<(), Refusal> {
        match action {
            Action::Modulate {
                schema,
                variable,
                value,
            } if schema == CONTROL_SCHEMA => {
                let setting = from_json(value).map_err(refusal)?;
                self.set_control(variable, &setting)
            }
            Action::Touch { schema, .. } => Err(refusal(format!(
                "this is a recording: the panel of `{schema}` can be seen and not touched"
            ))),
            Action::StopAll | Action::ReleaseAll | Action::Continue | Action::Step => {
                Err(refusal("this is a recording: nothing moves".to_owned()))
            }
            other => Err(refusal(format!(
                "this is a recording, and what `{}` did cannot be changed; `jde set {CONTROL_SCHEMA}.paused true` and the other modulations of `{CONTROL_SCHEMA}` control the playback",
                other.schema()
            ))),
        }
    }
}

fn refusal(error: String) -> Refusal {
    Refusal { error, nearest: None }
}
