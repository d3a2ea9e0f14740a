//! How long the schemas believe what the finder says of the ball. The value itself is the crate jde-ball's, which other plugins share.

pub use jde_ball::Ball;
use jde_schema::prelude::*;

/// The oldest picture that anybody steers by.
const STALE: Duration = Duration::from_secs(1);

/// What the finder says; nothing if it sees nothing any more, or its picture is too old to steer by.
pub(crate) fn read(port: &Import<Ball>, cx: &Context) -> Option<Ball> {
    let ball = port.get(cx)?;
    (ball.age(cx) <= STALE).then_some(*ball)
}
