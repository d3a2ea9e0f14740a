//! Whether what can be pushed has room where the file puts it.
//!
//! Knows nothing of robots: they enter later, and are refused where something lies.

use super::document::Document;
use super::loose::Placed;
use crate::loose::SKIN;
use crate::mover::Mover;
use crate::scene::Scene;

/// Notes a fault for everything loose that lies in a thing, in a mover where it starts, or in another loose thing.
pub(crate) fn check(document: &Document<'_>, scene: &Scene, movers: &[Mover], loose: &[Placed]) -> bool {
    let mut sound = true;
    for (index, (body, span)) in loose.iter().enumerate() {
        let fixed = scene.near(body.solid(), SKIN);
        let moving = movers
            .iter()
            .filter(|mover| mover.solid().distance_to_solid(body.solid()) < SKIN)
            .map(|mover| mover.shape().name);
        let before = loose[..index]
            .iter()
            .filter(|(other, _)| other.solid().distance_to_solid(body.solid()) < SKIN)
            .map(|(other, _)| other.name.as_str());
        if let Some(by) = fixed.chain(moving).chain(before).next() {
            let text = format!("`{}` lies in `{by}`: move it to free ground", body.name);
            document.fault(span, text);
            sound = false;
        }
    }
    sound
}
