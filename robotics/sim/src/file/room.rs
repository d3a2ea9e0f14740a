//! Checks that loose things have room where the file puts them.
//!
//! It ignores robots: they are added later, and are refused where a thing lies.

use super::loose::PlacedBody;
use crate::loose::CONTACT_GAP;
use crate::mover::Mover;
use crate::scene::Scene;
use jde_document::FaultReport;

/// Records a fault for every loose thing that lies in a fixed thing, in a mover at its start, or in another
/// loose thing. Returns whether there is none.
pub(crate) fn check(
    report: &mut FaultReport<'_>,
    scene: &Scene,
    movers: &[Mover],
    loose: &[PlacedBody],
) -> bool {
    let mut is_valid = true;
    for (index, (body, span)) in loose.iter().enumerate() {
        let fixed = scene.near(body.solid(), CONTACT_GAP);
        let moving = movers
            .iter()
            .filter(|mover| mover.solid().distance_to_solid(body.solid()) < CONTACT_GAP)
            .map(|mover| mover.shape().name);
        let before = loose[..index]
            .iter()
            .filter(|(other, _)| other.solid().distance_to_solid(body.solid()) < CONTACT_GAP)
            .map(|(other, _)| other.name.as_str());
        if let Some(by) = fixed.chain(moving).chain(before).next() {
            let text = format!("`{}` lies in `{by}`: move it to free ground", body.name);
            report.fault(span, text);
            is_valid = false;
        }
    }
    is_valid
}
