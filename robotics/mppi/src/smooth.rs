//! The smoothing of a sequence of commands: the filter of Savitzky and Golay ("Smoothing and differentiation of
//! data by simplified least squares procedures", 1964), a parabola through nine values.

use crate::Command;

/// The weights of the value in the middle, and of the next ones to both sides.
const WEIGHTS: [f32; 5] = [
    59.0 / 231.0,
    54.0 / 231.0,
    39.0 / 231.0,
    14.0 / 231.0,
    -21.0 / 231.0,
];
/// How many commands before the sequence count.
pub(crate) const PAST: usize = 4;

/// Writes the smoothed `sequence`, before which `past` was commanded, the newest last. After its end the last
/// command counts on.
pub(crate) fn smooth(past: &[Command; PAST], sequence: &[Command], smoothed: &mut [Command]) {
    let Some(last) = sequence.last() else { return };
    let at = |place: isize| match usize::try_from(place) {
        Ok(place) => sequence.get(place).unwrap_or(last),
        Err(_) => &past[place.saturating_add_unsigned(PAST) as usize],
    };
    for (place, smoothed) in smoothed.iter_mut().enumerate() {
        let place = place as isize;
        *smoothed = core::array::from_fn(|part| {
            let sides = WEIGHTS.iter().zip(0..).skip(1);
            let middle = WEIGHTS[0] * at(place)[part];
            sides.fold(middle, |sum, (weight, away)| {
                sum + weight * (at(place - away)[part] + at(place + away)[part])
            })
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_stays_and_noise_shrinks() {
        let parabola = |at: i32| [(at * at) as f32, at as f32, 1.0];
        let past = [-4, -3, -2, -1].map(parabola);
        let sequence: Vec<Command> = (0..20).map(parabola).collect();
        let mut smoothed = vec![[0.0; 3]; 20];
        smooth(&past, &sequence, &mut smoothed);
        for (before, after) in sequence.iter().zip(&smoothed).take(16) {
            assert!((before[0] - after[0]).abs() < 1e-3 && (before[1] - after[1]).abs() < 1e-4);
        }
        let zigzag: Vec<Command> = (0..20)
            .map(|at| [if at % 2 == 0 { 1.0 } else { -1.0 }; 3])
            .collect();
        smooth(&[[0.0; 3]; PAST], &zigzag, &mut smoothed);
        assert!(smoothed.iter().take(16).all(|command| command[0].abs() < 0.4));
        smooth(&past, &[], &mut []);
    }
}
