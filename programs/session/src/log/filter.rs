//! Selects the shown lines of the log: `--log vff=debug,info`. Parses and decides; prints nothing.

use std::str::FromStr;

use tracing::Level;
use tracing::level_filters::LevelFilter;

/// The name of changes of state in a filter.
const STATE: &str = "state";
/// The tracing target of changes of state.
pub(crate) const STATE_TARGET: &str = "jde::state";
/// Levels, in the order of increasing output.
const LEVELS: [(&str, LevelFilter); 6] = [
    ("off", LevelFilter::OFF),
    ("error", LevelFilter::ERROR),
    ("warn", LevelFilter::WARN),
    ("info", LevelFilter::INFO),
    ("debug", LevelFilter::DEBUG),
    ("trace", LevelFilter::TRACE),
];

/// Selects lines of the log: a level for all schemas, and others for some of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Filter {
    default_level: LevelFilter,
    state_level: Option<LevelFilter>,
    schema_levels: Vec<(String, LevelFilter)>,
}

impl Default for Filter {
    fn default() -> Self {
        Self {
            default_level: LevelFilter::WARN,
            state_level: None,
            schema_levels: Vec::new(),
        }
    }
}

impl Filter {
    /// Returns the highest level of all, beyond which nothing is shown.
    pub fn max_level(&self) -> LevelFilter {
        let schemas = self.schema_levels.iter().map(|(_, level)| *level);
        schemas.chain(self.state_level).fold(self.default_level, Ord::max)
    }

    /// Whether a line is shown.
    pub fn is_enabled(&self, target: &str, schema: Option<&str>, level: Level) -> bool {
        // Below level debug, only the errors of libraries are shown. jde logs what they mean for the run.
        let own = target.starts_with("jde");
        if !own && level != Level::ERROR && self.default_level < LevelFilter::DEBUG {
            return false;
        }
        let own = schema.and_then(|name| self.schema_levels.iter().find(|(known, _)| known == name));
        let by_schema = own.map_or(self.default_level, |(_, level)| *level);
        let by_state = self.state_level.filter(|_| target == STATE_TARGET);
        by_state.map_or(by_schema, |state| {
            state.max(own.map_or(LevelFilter::OFF, |(_, level)| *level))
        }) >= level
    }

    /// Takes the loggers of a node of ROS 2 for what they log: that of the node for all schemas, and `NODE.SCHEMA` for one.
    #[must_use]
    pub fn with_loggers_of(mut self, node: &str) -> Self {
        for (name, level) in std::mem::take(&mut self.schema_levels) {
            match name.strip_prefix(node) {
                Some("") => self.default_level = level,
                Some(of_node) => {
                    let schema = of_node.strip_prefix('.').unwrap_or(&name);
                    self.schema_levels.push((schema.to_owned(), level));
                }
                None => self.schema_levels.push((name, level)),
            }
        }
        self
    }

    /// Checks that every schema in the filter exists.
    ///
    /// # Errors
    /// The first unknown schema, and the nearest known one.
    pub fn check<'n>(&self, known: impl Iterator<Item = &'n str> + Clone) -> Result<(), (String, String)> {
        for (name, _) in &self.schema_levels {
            if known.clone().any(|known| known == name) {
                continue;
            }
            let help = match jde_nearest::nearest(name, known.clone()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("its schemas: {}", known.collect::<Vec<_>>().join(", ")),
            };
            return Err((
                format!("--log names `{name}`, and the application has no such schema"),
                help,
            ));
        }
        Ok(())
    }
}

impl FromStr for Filter {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut filter = Self::default();
        for part in text.split(',').map(str::trim) {
            match part.split_once('=') {
                None => filter.default_level = parse_level(part)?,
                Some((STATE, level)) => filter.state_level = Some(parse_level(level)?),
                Some(("", _)) => return Err(format!("`{part}` names no schema; write schema=level")),
                Some((schema, level)) => filter
                    .schema_levels
                    .push((schema.trim().to_owned(), parse_level(level)?)),
            }
        }
        Ok(filter)
    }
}

fn parse_level(text: &str) -> Result<LevelFilter, String> {
    let text = text.trim();
    let found = LEVELS.iter().find(|(name, _)| name.eq_ignore_ascii_case(text));
    found.map(|(_, level)| *level).ok_or_else(|| {
        let names: Vec<_> = LEVELS.iter().map(|(name, _)| *name).collect();
        format!(
            "`{text}` is not a level; write {}, or schema=level",
            names.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filter(text: &str) -> Filter {
        text.parse().unwrap()
    }

    #[test]
    fn a_schema_has_its_own_level_and_others_the_common_level() {
        let filter = filter("vff=debug,info");
        assert!(filter.is_enabled("jde::schema", Some("vff"), Level::DEBUG));
        assert!(!filter.is_enabled("jde::schema", Some("goon"), Level::DEBUG));
        assert!(filter.is_enabled("jde::schema", Some("goon"), Level::INFO));
        assert_eq!(filter.max_level(), LevelFilter::DEBUG);
    }

    #[test]
    fn changes_of_state_are_shown_on_request() {
        assert!(filter("state=trace").is_enabled(STATE_TARGET, Some("goon"), Level::TRACE));
        assert!(!filter("state=trace").is_enabled("jde::schema", Some("goon"), Level::TRACE));
        assert!(!filter("info").is_enabled(STATE_TARGET, Some("goon"), Level::TRACE));
        assert!(filter("goon=trace").is_enabled(STATE_TARGET, Some("goon"), Level::TRACE));
        assert!(!filter("goon=trace").is_enabled(STATE_TARGET, Some("vff"), Level::TRACE));
        assert!(filter("trace,state=off").is_enabled("jde::schema", Some("goon"), Level::TRACE));
        assert!(!filter("trace,state=off").is_enabled(STATE_TARGET, Some("goon"), Level::TRACE));
    }

    #[test]
    fn by_default_warnings_and_errors_are_shown() {
        let filter = Filter::default();
        assert!(filter.is_enabled("jde_host", None, Level::WARN));
        assert!(!filter.is_enabled("jde_host", None, Level::INFO));
        for library in ["zenoh_transport::common", "winit::platform_impl"] {
            assert!(!filter.is_enabled(library, None, Level::WARN), "{library}");
            assert!(filter.is_enabled(library, None, Level::ERROR), "{library}");
            assert!(
                self::filter("debug").is_enabled(library, None, Level::WARN),
                "{library}"
            );
        }
        assert!(!self::filter("off").is_enabled("jde_host", None, Level::ERROR));
    }

    #[test]
    fn an_unknown_level_is_refused_with_all_levels() {
        let error = "goon=dbug".parse::<Filter>().unwrap_err();
        assert_eq!(
            error,
            "`dbug` is not a level; write off, error, warn, info, debug, trace, or schema=level"
        );
        assert_eq!(
            "=info".parse::<Filter>().unwrap_err(),
            "`=info` names no schema; write schema=level"
        );
    }

    #[test]
    fn the_loggers_of_a_node_are_its_schemas_and_all_of_them() {
        let of_node = |text: &str| filter(text).with_loggers_of("fleet.scout");
        assert_eq!(of_node("fleet.scout=debug,vff=info"), filter("debug,vff=info"));
        assert_eq!(of_node("fleet.scout.goon=debug"), filter("goon=debug"));
        assert_eq!(of_node("fleet.scouts=debug"), filter("fleet.scouts=debug"));
    }

    #[test]
    fn an_unknown_schema_is_refused_with_the_nearest() {
        let known = ["goon", "vff"];
        assert_eq!(filter("goon=debug").check(known.into_iter()), Ok(()));
        let (message, help) = filter("gonn=debug").check(known.into_iter()).unwrap_err();
        assert!(message.contains("`gonn`"), "{message}");
        assert_eq!(help, "did you mean `goon`?");
        let (_, help) = filter("wheels=debug").check(known.into_iter()).unwrap_err();
        assert_eq!(help, "its schemas: goon, vff");
    }
}
