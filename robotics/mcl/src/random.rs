//! Draws from a seeded generator.

use core::f32::consts::TAU;

/// Returns a number of the uniform distribution from -1 to 1.
pub(crate) fn around_zero(random: &mut fastrand::Rng) -> f32 {
    2.0 * random.f32() - 1.0
}

/// Returns two independent numbers of the standard normal distribution (Box and Muller, "A note on the generation of
/// random normal deviates", 1958).
pub(crate) fn normals(random: &mut fastrand::Rng) -> [f32; 2] {
    // In (0, 1], so that the logarithm is finite.
    let radius = libm::sqrtf(-2.0 * libm::logf(1.0 - random.f32()));
    let (sin, cos) = libm::sincosf(TAU * random.f32());
    [radius * cos, radius * sin]
}
