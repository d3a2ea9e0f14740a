//! The one executable: it wires the rest, owns the command line and prints errors.

fn main() {}
