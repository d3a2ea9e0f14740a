//! What a board states of itself: the line `hello`, read and checked.

use jde_motion::BaseDynamics;
use jde_schema::prelude::Twist;

use crate::line::Fields;

/// The version of the protocol.
const VERSION: &str = "1";
/// The watchdogs that the driver accepts, ms. A base drives on for this time if the driver is killed, and four commands
/// must arrive in it.
const WATCHDOGS: core::ops::RangeInclusive<u16> = 100..=1000;
/// Shortest distance of wheels, m: less was not stated in µm.
const MIN_TRACK: f64 = 0.01;
/// Longest and shortest time between two lines of its state, ms.
const PERIODS: core::ops::RangeInclusive<u16> = 5..=100;

/// A board, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hello {
    pub(crate) kind: Kind,
    pub(crate) firmware: String,
    pub(crate) serial_number: String,
    /// After this time without a valid command it stops, ms.
    pub(crate) watchdog: u16,
    /// Time between two lines of its state, ms.
    pub(crate) period: u16,
    /// The greatest speeds.
    pub(crate) limits: Twist,
    /// How it follows commands; 0 is unknown.
    pub(crate) dynamics: BaseDynamics,
    /// The voltages of an empty and a full battery.
    pub(crate) battery: Option<[f32; 2]>,
}

/// How a base moves, and what its board measures of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// Two driven wheels, whose ticks it counts.
    Differential {
        /// Their distance, m.
        track: f64,
        ticks_per_metre: f64,
        /// The counts wrap after so many bits.
        bits: u32,
    },
    /// In any direction. It measures its speeds.
    Omnidirectional,
}

impl Hello {
    /// Reads the words behind `hello`, and which greeting it replies to: 0 for none.
    ///
    /// # Errors
    /// What the board lacks, in words.
    pub(crate) fn read<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<(u16, Self), String> {
        let version = words.next().unwrap_or("");
        if version != VERSION {
            return Err(format!(
                "it has version `{version}` of the protocol, and this driver version {VERSION}: load its sketch anew"
            ));
        }
        let fields = Fields::read(words).ok_or("a field has no value, or occurs twice")?;
        let reply = fields.number("for")?.unwrap_or(0);
        let text = |key: &str| {
            let text = fields.text(key).filter(|text| !text.is_empty());
            text.map(str::to_owned)
                .ok_or_else(|| format!("`{key}` is missing"))
        };
        // Thousandths, which are 0 if they are missing.
        let number = |key: &str| -> Result<f64, String> {
            Ok(f64::from(fields.number::<u32>(key)?.unwrap_or(0)) / 1000.0)
        };
        let kind = match &*text("kind")? {
            "differential" => Kind::Differential {
                // µm, and ticks for a kilometre.
                track: Some(number("track")? / 1000.0)
                    .filter(|track| *track >= MIN_TRACK)
                    .ok_or("`track` must be 10000 µm or more")?,
                ticks_per_metre: positive("ticks", number("ticks")?)?,
                bits: fields
                    .number("bits")?
                    .filter(|bits| (8..=32).contains(bits))
                    .ok_or("`bits` must be 8 to 32")?,
            },
            "omnidirectional" => Kind::Omnidirectional,
            other => {
                return Err(format!(
                    "its kind is `{other}`; it can be differential or omnidirectional"
                ));
            }
        };
        let watchdog = fields.number("watchdog")?.unwrap_or(0);
        if !WATCHDOGS.contains(&watchdog) {
            return Err(format!(
                "it states a watchdog of {watchdog} ms instead of {} to {}: without one it would drive on without this \
                 program",
                WATCHDOGS.start(),
                WATCHDOGS.end()
            ));
        }
        let period = fields.number("period")?.unwrap_or(0);
        if !PERIODS.contains(&period) {
            return Err(format!(
                "it states its senses every {period} ms instead of every {} to {}",
                PERIODS.start(),
                PERIODS.end()
            ));
        }
        let mut limits = Twist::planar(
            positive("speed", number("speed")?)?,
            positive("turn", number("turn")?)?,
        );
        limits.linear.y = match kind {
            Kind::Differential { .. } => 0.0,
            Kind::Omnidirectional => positive("side", number("side")?)?,
        };
        let battery = [number("empty")? as f32, number("full")? as f32];
        let hello = Self {
            kind,
            firmware: text("firmware")?,
            serial_number: text("serial")?,
            watchdog,
            period,
            limits,
            dynamics: BaseDynamics {
                acceleration: number("up")?,
                deceleration: number("down")?,
                turn_acceleration: number("turn_up")?,
                turn_deceleration: number("turn_down")?,
                lag: number("lag")?,
            },
            battery: (battery[1] > battery[0]).then_some(battery),
        };
        Ok((reply, hello))
    }

    /// Returns a command within its limits. All parts are lessened by the same ratio: an arc stays its arc.
    pub(crate) fn within_limits(&self, command: &Twist) -> Twist {
        let Twist { linear, angular } = self.limits;
        let left = match self.kind {
            Kind::Differential { .. } => 0.0,
            Kind::Omnidirectional => command.linear.y,
        };
        let parts = [
            (command.linear.x, linear.x),
            (left, linear.y),
            (command.angular.z, angular.z),
        ];
        let too_fast = parts.into_iter().filter(|(value, limit)| value.abs() > *limit);
        let ratio = too_fast.fold(1.0, |ratio, (value, limit)| f64::min(ratio, limit / value.abs()));
        let mut within = Twist::planar(command.linear.x * ratio, command.angular.z * ratio);
        within.linear.y = left * ratio;
        within
    }

    /// Whether a command within these limits, of which 0 limits nothing, can be more than the board's own permit.
    pub(crate) fn is_slower_than(&self, limits: &Twist) -> bool {
        let Twist { linear, angular } = self.limits;
        let exceeds = |stated: f64, own: f64| stated == 0.0 || stated.abs() > own + 1e-6;
        exceeds(limits.linear.x, linear.x)
            || exceeds(limits.angular.z, angular.z)
            || (self.kind == Kind::Omnidirectional && exceeds(limits.linear.y, linear.y))
    }

    /// Returns what `connection` says of it.
    pub(crate) fn name(&self) -> String {
        let kind = match self.kind {
            Kind::Differential { .. } => "differential",
            Kind::Omnidirectional => "omnidirectional",
        };
        let (number, firmware, watchdog) = (&self.serial_number, &self.firmware, self.watchdog);
        format!("{number}, a {kind} base, firmware {firmware}, watchdog {watchdog} ms")
    }
}

fn positive(key: &str, value: f64) -> Result<f64, String> {
    (value > 0.0)
        .then_some(value)
        .ok_or_else(|| format!("`{key}` must be above 0"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "1 for=7 kind=differential firmware=jde-base/1 serial=kit-07 watchdog=300 period=20 speed=500 \
                        turn=2000 up=800 lag=80 track=230000 ticks=5200500 bits=32 empty=9900 full=12600 news=1";

    fn read(text: &str) -> Result<(u16, Hello), String> {
        Hello::read(text.split(' '))
    }

    #[test]
    fn a_board_states_itself_in_thousandths() {
        let (reply, hello) = read(GOOD).expect("it is complete");
        assert_eq!(
            (reply, hello.watchdog, hello.battery),
            (7, 300, Some([9.9, 12.6]))
        );
        assert_eq!((hello.limits.linear.x, hello.limits.angular.z), (0.5, 2.0));
        assert_eq!(
            (hello.dynamics.acceleration, hello.dynamics.deceleration),
            (0.8, 0.0)
        );
        let kind = Kind::Differential {
            track: 0.23,
            ticks_per_metre: 5200.5,
            bits: 32,
        };
        assert_eq!(hello.kind, kind);
        assert_eq!(
            hello.name(),
            "kit-07, a differential base, firmware jde-base/1, watchdog 300 ms"
        );
    }

    #[test]
    fn a_command_above_the_limits_of_a_board_is_lessened_in_all_its_parts() {
        let (_, hello) = read(GOOD).expect("it is complete");
        let mut command = Twist::planar(1.0, 2.0);
        command.linear.y = 9.0;
        assert_eq!(hello.within_limits(&command), Twist::planar(0.5, 1.0));
        assert_eq!(
            hello.within_limits(&Twist::planar(-0.5, -4.0)),
            Twist::planar(-0.25, -2.0)
        );
        for (limits, is_slower) in [
            (Twist::planar(0.5, 2.0), false),
            (Twist::planar(0.6, 2.0), true),
            (Twist::planar(0.5, 0.0), true),
        ] {
            assert_eq!(hello.is_slower_than(&limits), is_slower, "{limits:?}");
        }
    }

    #[test]
    fn what_a_board_must_state_is_named_when_it_is_missing_or_wrong() {
        for (old, new, words) in [
            ("1 for", "2 for", "version `2`"),
            ("watchdog=300", "watchdog=0", "it would drive on"),
            ("watchdog=300 ", "", "a watchdog of 0 ms"),
            ("watchdog=300", "watchdog=5000", "5000 ms instead of 100 to 1000"),
            ("watchdog=300", "watchdog=1", "a watchdog of 1 ms"),
            ("period=20", "period=500", "every 500 ms"),
            ("speed=500", "speed=0", "`speed`"),
            ("turn=2000", "turn=-3", "`turn=-3`"),
            ("track=230000", "track=230", "`track`"),
            ("bits=32", "bits=64", "`bits`"),
            ("kind=differential", "kind=boat", "`boat`"),
            ("kind=differential", "kind=omnidirectional", "`side`"),
            ("serial=kit-07 ", "", "`serial` is missing"),
            ("news=1", "news", "has no value"),
        ] {
            assert!(GOOD.contains(old));
            let reason = read(&GOOD.replace(old, new)).expect_err(new);
            assert!(reason.contains(words), "{reason}");
        }
    }
}
