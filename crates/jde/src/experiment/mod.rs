//! Experiments on the terminal. It runs no drive.

#[cfg_attr(
    not(test),
    expect(dead_code, reason = "only its tests use it until the verb does")
)]
mod table;
