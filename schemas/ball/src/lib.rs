//! A robot with a camera: a perceptive schema finds a ball in the pictures of a camera, motor schemas of two
//! groups turn the head to it and drive to it, and a father leads both groups. The schemas depend on no
//! particular robot, world or map.

mod approach;
mod ball;
mod finder;
mod follower;
mod roam;
mod search;
mod track;
mod turn;

pub use approach::Approach;
pub use ball::Ball;
pub use finder::Finder;
pub use follower::Follower;
pub use roam::Roam;
pub use search::Search;
pub use track::Track;
pub use turn::Turn;

jde_schema::export!(
    "ball",
    "Finds a ball, follows it with the head and drives to it.",
    [Finder, Follower, Track, Search, Turn, Approach, Roam]
);

#[cfg(test)]
mod tests;
