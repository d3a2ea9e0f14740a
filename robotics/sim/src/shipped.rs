//! The robots of the project's `robots/`, as the texts of their files.

/// The names of the shipped robots and the texts of their files, in the order of the names.
pub const SHIPPED_ROBOTS: [(&str, &str); 15] = [
    ("jackal", include_str!("../../../robots/jackal.toml")),
    ("jackal-late", include_str!("../../../robots/jackal-late.toml")),
    ("low-cost", include_str!("../../../robots/low-cost.toml")),
    ("omni", include_str!("../../../robots/omni.toml")),
    ("pioneer-3dx", include_str!("../../../robots/pioneer-3dx.toml")),
    ("racecar", include_str!("../../../robots/racecar.toml")),
    (
        "realistic-jackal",
        include_str!("../../../robots/realistic-jackal.toml"),
    ),
    (
        "realistic-omni",
        include_str!("../../../robots/realistic-omni.toml"),
    ),
    (
        "realistic-pioneer-3dx",
        include_str!("../../../robots/realistic-pioneer-3dx.toml"),
    ),
    (
        "realistic-racecar",
        include_str!("../../../robots/realistic-racecar.toml"),
    ),
    (
        "realistic-turtlebot3-burger",
        include_str!("../../../robots/realistic-turtlebot3-burger.toml"),
    ),
    (
        "realistic-turtlebot4",
        include_str!("../../../robots/realistic-turtlebot4.toml"),
    ),
    (
        "turtlebot3-burger",
        include_str!("../../../robots/turtlebot3-burger.toml"),
    ),
    (
        "turtlebot3-line",
        include_str!("../../../robots/turtlebot3-line.toml"),
    ),
    ("turtlebot4", include_str!("../../../robots/turtlebot4.toml")),
];
