//! The costs of a command, and of granting and withdrawing the authority for it. Compared with nothing.

use anyhow::Result;
use jde_board::Access;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, interleave, see};
use jde_paths::variable;

use crate::scope::Scope;

/// The size of a velocity, in words of 8 bytes.
const TWIST: usize = 6;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let access = Access::Command {
        validity: 500_000_000,
    };
    let (commanded, granted) = (variable(TWIST, access, 1)?, variable(TWIST, access, 1)?);
    commanded.grant(1);
    let mut writer = commanded.writer(1, "writer")?;
    let _writer = granted.writer(1, "writer")?;
    let [command, grant] = interleave(
        scope.effort(),
        [
            &mut |times| {
                for time in 0..times {
                    writer.loan()[0] = time as u8;
                    see(writer.publish(time, time));
                }
            },
            &mut |times| {
                for _ in 0..times {
                    granted.grant(1);
                    granted.withdraw(1);
                }
            },
        ],
    );
    let line = |what: &str, rounds: &Rounds| Line::alone(what, Figure::Time(rounds.median()), Goal::Reported);
    Ok(vec![
        line("publish a command of 48 B", &command),
        line("grant authority and withdraw it", &grant),
    ])
}
