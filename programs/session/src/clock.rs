//! The options of verbs that run an application: its clock and its seed.

use clap::Args;

/// The clock and the seed of a run.
#[derive(Args)]
pub struct Time {
    /// Run in virtual time, as fast as the machine can; the same seed gives the same run to the bit.
    #[arg(long)]
    pub lockstep: bool,
    /// The seed of all randomness, instead of the application's.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Run this many times as fast as real time.
    #[arg(long, value_name = "FACTOR", value_parser = speed, default_value = "1x", conflicts_with = "lockstep")]
    pub speed: f64,
}

/// Parses a speed factor from 0.01 to 100: "4x" or "0.5".
pub fn speed(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('x').unwrap_or(text).trim().parse::<f64>();
    match number {
        Ok(speed) if (0.01..=100.0).contains(&speed) => Ok(speed),
        Ok(_) => Err(format!("`{text}` must be from 0.01x to 100x")),
        Err(_) => Err(format!(
            "`{text}` is not a speed; write a number such as 4x or 0.5x"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::speed;

    #[test]
    fn speeds_are_factors() {
        assert_eq!(speed("4x"), Ok(4.0));
        assert_eq!(speed("0.5"), Ok(0.5));
        for text in ["", "x", "0x", "-1", "nan", "1000x"] {
            assert!(speed(text).is_err(), "{text}");
        }
    }
}
