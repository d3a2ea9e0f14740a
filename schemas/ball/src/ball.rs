//! How long the schemas use the finder's last ball. The type is defined by the crate jde-ball, which other
//! plugins share.

pub use jde_ball::Ball;
use jde_schema::prelude::*;

/// Oldest picture that a schema may steer by.
const MAX_AGE: Duration = Duration::from_secs(1);

/// Returns the finder's ball; `None` if there is none, or if its picture is too old to steer by.
pub(crate) fn read(port: &Import<Ball>, cx: &Context) -> Option<Ball> {
    let ball = port.get(cx)?;
    (ball.age(cx) <= MAX_AGE).then_some(*ball)
}
