//! Drives rotating lidars at serial lines. The modules of the protocols and of turns do no I/O; `scanner` connects
//! them to a port, a clock and the exports.

#[cfg(test)]
mod checks;
mod ld;
mod rplidar;
mod scanner;
mod turn;
mod watch;

use ld::Ld;
use rplidar::Rplidar;

jde_schema::export!("lidar", "Drives rotating lidars at serial lines.", [Ld, Rplidar]);

#[cfg(test)]
mod tests;
