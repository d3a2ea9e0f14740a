//! Round numbers for grids and axes.

/// Rounds up to 1, 2 or 5 times a power of ten.
#[must_use]
pub fn round_up(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0]
        .map(|digit| digit * power)
        .into_iter()
        .find(|step| *step >= least)
        .unwrap_or(10.0 * power)
}
