//! Plays a CARMEN log as laser and odometry.
